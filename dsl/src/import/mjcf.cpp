// Sections of an MJCF file, the files that it includes, and its settings.
#include "import/mjcf_reader.h"

#include <fmt/format.h>

#include <set>
#include <string_view>

#include "import/settings.h"

namespace cogrsim::dsl::import {

RobotModel MjcfReader::read(XmlElement& root) {
  include(root, 0);
  if (const std::string* name = root.find("model")) robot_.name = *name;
  for (const auto& e : root.children)
    if (e->name == "compiler") compiler(*e);
  settings(root);
  for (const auto& e : root.children)
    if (e->name == "worldbody") replicate(*e, root, 0);
  classes_["main"];
  for (const auto& e : root.children)
    if (e->name == "default") default_class(*e, "main", true);
  robot_.step = 0.002;  // MuJoCo's own
  for (const auto& e : root.children) {
    if (e->name == "option") option(*e);
    if (e->name == "asset") assets(*e);
  }
  for (const auto& e : root.children)
    if (e->name != "worldbody") note_joints(*e, 0);
  if (touching_by_ == "dynamic") paired_geoms_.clear();
  for (const auto& e : root.children)
    if (e->name == "worldbody") world(*e, "");
  set_total_mass();
  for (const auto& e : root.children)
    if (e->name == "tendon")
      for (const auto& c : e->children) tendon(*c);
  for (const auto& e : root.children)
    if (e->name == "equality")
      for (const auto& c : e->children) equality(*c);
  for (Tendon& t : tendons_) tendon_passive(t);
  for (const auto& e : root.children) section(*e);
  make_gimbals();
  surfaces();
  write_softness();
  keyframes(root);
  start_at_welds();
  if (robot_.links.empty()) context_.refuse(root.at, "CG1405", "the model has no body");
  return std::move(robot_);
}

void MjcfReader::include(XmlElement& in, int depth) {
  if (depth > 80)
    context_.refuse(in.at, "CG1402", "files include each other in a cycle, or are nested too deep");
  for (std::size_t i = 0; i < in.children.size(); ++i) {
    XmlElement& e = *in.children[i];
    if (e.name != "include") {
      include(e, depth + 1);
      continue;
    }
    context_.spend(100 + 2 * in.children.size(), e.at);
    const std::string* file = e.find("file");
    if (file == nullptr) context_.refuse(e.at, "CG1404", "<include> has no file");
    auto path = context_.locate(*file, e.at);
    if (!path) context_.refuse(e.at, "CG1412", path.error().message, path.error().hint);
    auto there = context_.parse(*path, e.at);
    include(*there, depth + 1);
    std::vector<std::unique_ptr<XmlElement>> list;
    for (std::size_t k = 0; k < in.children.size(); ++k) {
      if (k != i) {
        list.push_back(std::move(in.children[k]));
        continue;
      }
      for (auto& c : there->children) list.push_back(std::move(c));
    }
    i += there->children.size();
    in.children = std::move(list);
    --i;
  }
}

void MjcfReader::compiler(const XmlElement& e) {
  for (const auto& [key, value] : e.attributes) {
    if (key == "angle")
      degrees_ = value != "radian";
    else if (key == "eulerseq" && value.size() == 3)
      euler_ = value;
    else if (key == "meshdir" || (key == "assetdir" && e.find("meshdir") == nullptr))
      mesh_dir_ = value;
    else if (key == "strippath")
      strip_path_ = value == "true";
    else if (key == "autolimits")
      auto_limits_ = value != "false";
    else if (key == "exactmeshinertia")
      exact_meshes_ = value == "true";
    else if (key == "boundmass")
      bound_mass_ = context_.number(e, "boundmass", 0.0);
    else if (key == "boundinertia")
      bound_inertia_ = context_.number(e, "boundinertia", 0.0);
    else if (key == "inertiafromgeom")
      from_geoms_ = value;
    else if (key == "settotalmass")
      total_mass_ = context_.number(e, "settotalmass", -1.0);
    else if (key == "coordinate" && value == "global")
      context_.refuse(e.at, "CG1413", "global coordinates are not read",
                      "MuJoCo itself does not read them since version 2.3.4");
    else if (key == "inertiagrouprange") {
      const auto v = context_.numbers(e, value, 2, 2, "'inertiagrouprange'");
      if (v) {
        first_group_ = (*v)[0];
        last_group_ = (*v)[1];
      }
    }
  }
}

void MjcfReader::option(const XmlElement& e) {
  if (const auto step = context_.number(e, "timestep")) robot_.take_step(context_, *step, e.at);
  if (e.find("gravity") != nullptr) robot_.gravity = context_.vec3(e, "gravity", Vec3(0, 0, -9.81));
  for (const auto& [key, value] : e.attributes) {
    if (key == "timestep" || key == "gravity") continue;
    const std::string what = fmt::format("option {}", key);
    if (key == "density" || key == "viscosity" || key == "wind")
      context_.left_out(e.at, what, "forces of a fluid are not simulated");
    else if (key == "collision")
      touching_by_ = value;
    else
      solver_option(e, key, value);
  }
  for (const auto& c : e.children) {
    if (c->name != "flag") continue;
    for (const auto& [key, value] : c->attributes) flag(*c, key, value == "enable");
  }
}

void MjcfReader::solver_option(const XmlElement& e, const std::string& key,
                               const std::string& value) {
  const std::string what = fmt::format("option {}", key);
  struct Choice {
    std::string_view name, usual, values;
  };
  constexpr Choice kChoices[] = {{"integrator", "Euler", " Euler RK4 implicit "},
                                 {"solver", "Newton", " PGS CG Newton "},
                                 {"cone", "pyramidal", " pyramidal elliptic "},
                                 {"jacobian", "auto", " dense sparse auto "}};
  for (const Choice& c : kChoices) {
    if (key != c.name) continue;
    if (value == "implicitfast")
      of_mujoco(e.at, what, "integrator", "implicit", "Euler", "is 'implicit' here");
    else if (c.values.find(" " + value + " ") != std::string_view::npos)
      of_mujoco(e.at, what, key.c_str(), value, std::string(c.usual), "");
    else
      context_.left_out(e.at, what, "has no value '" + value + "'");
    return;
  }
  struct Number {
    const char *attribute, *name;
    double usual, least, most;
  };
  constexpr Number kNumbers[] = {{"iterations", "iterations", 100, 1, 1e5},
                                 {"tolerance", "tolerance", 1e-8, 0, 1},
                                 {"noslip_iterations", "noslip-iterations", 0, 0, 1e5},
                                 {"impratio", "impratio", 1, 1e-6, 1e6}};
  for (const Number& n : kNumbers) {
    if (key != n.attribute) continue;
    const auto v = context_.number(e, n.attribute);
    // The few that suffice with the line search of MuJoCo 3 do not with that before it.
    if (v && key == "iterations" && *v < n.usual && e.find("ls_iterations") != nullptr)
      context_.approximate(e.at, what,
                           fmt::format("is {} here: {} are for a solver with `ls_iterations`, and "
                                       "too few in one without",
                                       n.usual, *v));
    else if (v && *v >= n.least && *v <= n.most)
      of_mujoco(e.at, what, n.name, fmt::format("{}", *v), fmt::format("{}", n.usual), "");
    else if (v)
      context_.left_out(e.at, what, fmt::format("{} is not from {} to {}", *v, n.least, n.most));
    return;
  }
  context_.left_out(e.at, what, "is a setting of MuJoCo's solver");
}

void MjcfReader::flag(const XmlElement& e, const std::string& key, bool on) {
  const std::string what = fmt::format("flag {}", key);
  static const std::set<std::string> kOfMotion = {"constraint", "equality",  "frictionloss",
                                                  "limit",      "contact",   "passive",
                                                  "gravity",    "actuation", "clampctrl"};
  if (key == "multiccd") {
    of_mujoco(e.at, what, "multiccd", on ? "true" : "false", "false", "");
  } else if (kOfMotion.count(key) != 0) {
    if (on) return;
    disabled_.insert(key);
    if (key == "constraint") disabled_.insert({"equality", "frictionloss", "limit", "contact"});
    if (key == "gravity") robot_.gravity = Vec3::Zero();
    context_.exact(e.at, what, "what it switches off is not in the scene");
  } else if (key != "energy" && key != "midphase" && key != "warmstart" && key != "refsafe") {
    context_.left_out(e.at, what, "is a setting of MuJoCo");
  }
}

void MjcfReader::settings(const XmlElement& root) {
  constexpr std::string_view kContacts = "contacts of a scene are rigid",
                             kFluid = "forces of a fluid are not simulated";
  constexpr std::string_view kRigid = "limits, loops and couplings of a scene are rigid";
  report_settings(
      context_, root,
      {{"pair", "solref solimp solreffriction margin gap", kContacts, "0"},
       {"geom", "fluidshape fluidcoef", kFluid, "none"},
       {"geom", "fitscale", "primitives that are fitted to meshes are not read", "1"},
       {"geom mesh", "shellinertia", "masses are those of full shapes", "false"},
       {"mesh", "inertia", "masses are those of the mesh's volume", "exact"},
       {"tendon spatial fixed", "solreflimit solimplimit solreffriction solimpfriction margin",
        kRigid, "0"},
       {"joint", "margin", kRigid, "0"},
       {"equality weld", "torquescale", kRigid, "1"},
       {"joint", "springdamper", "a spring has the stiffness and damping as written", "0 0"},
       {"joint tendon", "actuatorgravcomp", "motors have their whole effort", "false"},
       {"compiler", "balanceinertia", "inertias become the nearest that a body can have",
        "false"}});
}

void MjcfReader::section(const XmlElement& e) {
  if (e.name == "actuator") {
    if (disabled_.count("actuation") != 0) return;
    for (const auto& c : e.children) actuator(*c);
  } else if (e.name == "contact") {
    for (const auto& c : e.children) contact(*c);
  } else if (e.name == "sensor") {
    for (const auto& c : e.children) sensor(*c);
  } else if (e.name != "compiler" && e.name != "option" && e.name != "default" &&
             e.name != "asset" && e.name != "worldbody" && e.name != "tendon" &&
             e.name != "equality" && e.name != "keyframe") {
    static const std::set<std::string> kSettings = {"size", "visual", "statistic", "custom",
                                                    "extension"};
    const std::string what = fmt::format("<{}>", e.name);
    if (kSettings.count(e.name) != 0)
      context_.left_aside(e.at, what, "concerns MuJoCo");
    else
      context_.left_out(e.at, what, "is not read");
  }
}

void MjcfReader::contact(const XmlElement& e) {
  const std::string *a = e.find("body1"), *b = e.find("body2");
  const std::string *one = e.find("geom1"), *two = e.find("geom2");
  if (e.name == "exclude" && a != nullptr && b != nullptr) {
    robot_.no_contact.emplace_back(*a, *b);
    context_.exact(e.at, fmt::format("no contact of '{}' and '{}'", *a, *b));
  } else if (e.name == "pair" && touching_by_ == "dynamic") {
    context_.exact(e.at, quoted_name(e), "is not in the scene, by the option collision");
  } else if (e.name == "pair" && one != nullptr && two != nullptr) {
    const std::string what = fmt::format("contact of '{}' and '{}'", *one, *two);
    for (const std::string* name : {one, two})
      if (read_geoms_.count(*name) == 0) {
        context_.left_out(e.at, what, fmt::format("there is no geom '{}'", *name));
        return;
      }
    robot_.touching.emplace_back(*one, *two);
    pairs_.push_back(with_defaults(e, ""));
  } else {
    context_.left_out(e.at, quoted_name(e), "names neither two bodies nor two geoms");
  }
}

RobotModel read_mjcf(Context& context, const XmlElement& root) {
  auto copy = root.copy();
  return MjcfReader(context).read(*copy);
}

}  // namespace cogrsim::dsl::import

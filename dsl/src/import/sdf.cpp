// SDF (sdformat.org, specification 1.4 to 1.11): models and worlds. Poses are resolved over the
// graph of `relative_to`.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "assets/mesh_file.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/geometry/convex_hull.h"
#include "import/gazebo.h"
#include "import/sdf_tree.h"
#include "import/settings.h"

namespace cogrsim::dsl::import {

namespace {

/// What poses, joints and plugins of a model or world refer to, by its name there, as "arm::hand".
struct Named {
  std::string relative_to;  ///< empty: the model or world
  Pose X;
  std::string follows;      ///< what it moves with, but for a link
  std::string link, joint;  ///< the robot's name for a link or joint
  bool busy = false, known = false;
  Pose X_M;  ///< in the model or world, once known
};
using Names = std::map<std::string, Named>;

/// What a model has for its links and the models in it.
struct ModelFlags {
  bool is_static = false, in_wind = false, self_collides = false;
  int index = 0;
};

constexpr unsigned kAllBits = 0xffff;  // of shapes without <collide_bitmask>

class SdfReader {
 public:
  explicit SdfReader(Context& context) : context_(context) {}

  RobotModel read(const XmlElement& source) {
    const std::unique_ptr<XmlElement> root = sdf_tree(context_, source);
    robot_.contact_rule = "self_collide and collide_bitmask";
    robot_.usual_bits = kAllBits;
    settings(*root);
    for (const auto& e : root->children) {
      if (e->name == "world")
        world(*e);
      else if (e->name == "model")
        model(*e, "", placed(*e, scope_of(*e, ""), 0), {}, 0);
      else if (e->name == "light")
        light(*e, pose(*e), false);
      else if (e->name == "actor")
        context_.left_aside(e->at, quoted_name(*e), "concerns appearance only");
      else
        left_out(*e);
    }
    if (robot_.links.empty()) context_.refuse(root->at, "CG1405", "there is no link in it");
    return std::move(robot_);
  }

 private:
  void settings(const XmlElement& root) {
    constexpr std::string_view kRigid = "contacts and limits of a scene are rigid";
    constexpr std::string_view kEven = "friction is the same in all directions";
    report_settings(
        context_, root,
        {{"ode", "kp kd soft_cfm soft_erp max_vel min_depth cfm erp cfm_damping", kRigid, "0"},
         {"limit", "stiffness dissipation cfm erp", kRigid, "0"},
         {"bullet", "soft_cfm soft_erp split_impulse split_impulse_penetration_threshold", kRigid,
          "0"},
         {"bounce", "threshold", "every impact bounces", "0"},
         {"ode", "slip1 slip2 fdir1", kEven, "0"},
         {"bullet", "fdir1", kEven, "0"},
         {"torsional", "surface_radius use_patch_radius", "the radius is that of the patch", "1"},
         {"contact", "collide_without_contact", "shapes that only notice are a <region>", "false"},
         {"contact", "category_bitmask", "shapes touch by collide_bitmask", "65535"},
         {"collision", "density", "without automatic inertia it has no use"},
         {"link", "kinematic", "a link moves by forces", "false"},
         {"model", "allow_auto_disable", "bodies at rest are simulated on", "true"}});
  }

  void left_out(const XmlElement& e) {
    context_.left_out(e.at, quoted_name(e), fmt::format("<{}> is not read", e.name));
  }

  static std::string name_of(const XmlElement& e) {
    const std::string* name = e.find("name");
    return name == nullptr ? "" : *name;
  }
  static std::string text(const XmlElement& in, const char* tag) { return child_text(in, tag); }
  std::optional<double> value(const XmlElement* in, const char* tag) {
    return child_number(context_, in, tag);
  }
  std::optional<Vec3> vector(const XmlElement* in, const char* tag) {
    return child_vector(context_, in, tag);
  }
  Pose pose(const XmlElement& in) {
    const auto [it, is_new] = poses_.try_emplace(&in);  // faults are reported once
    if (is_new) it->second = child_pose(context_, in);
    return it->second;
  }

  static std::string relative_to(const XmlElement& in) {
    const XmlElement* c = in.child("pose");
    if (c == nullptr) return "";
    const std::string* to = c->find("relative_to");
    if (to == nullptr) to = c->find("frame");
    return to == nullptr ? "" : *to;
  }

  // ---- names

  /// What stands before the names of a model's links: nothing in the first model, else the names of
  /// the models around them. `outer`: of the model around it; empty: none.
  const std::string& scope_of(const XmlElement& model, const std::string& outer) {
    const auto [it, is_new] = scopes_.try_emplace(&model);
    if (is_new && (!outer.empty() || models_++ > 0)) it->second = outer + model_name(model) + "_";
    return it->second;
  }
  static std::string model_name(const XmlElement& model) {
    return model.find("name") == nullptr ? "model" : *model.find("name");
  }
  /// What stands before the names in models inside of a model.
  static std::string inside(const XmlElement& model, const std::string& scope) {
    return scope.empty() ? model_name(model) + "_" : scope;
  }

  Names names_of(const XmlElement& model, const std::string& scope, int depth) {
    Names out;
    collect(model, "", scope, depth, out);
    if (model.name == "model") out.try_emplace(model_name(model), out["__model__"]);
    return out;
  }

  /// `prefix`: of the names in `out`, such as "arm::"; `scope`: of the robot's names.
  void collect(const XmlElement& e, const std::string& prefix, const std::string& scope, int depth,
               Names& out) {
    if (depth > 20) context_.refuse(e.at, "CG1402", "models are nested too deep");
    const bool is_world = e.name == "world";
    const auto full = [&](const std::string& name) {
      return name == "world" ? name : prefix + (name.empty() ? "__model__" : name);
    };
    std::string canonical = e.find("canonical_link") == nullptr ? "" : *e.find("canonical_link");
    for (const auto& c : e.children) {
      const std::string name = name_of(*c);
      const bool is_model = c->name == "model", is_link = c->name == "link",
                 is_joint = c->name == "joint";
      if (name.empty() || !(is_model || is_link || is_joint || c->name == "frame")) continue;
      // A model that is placed by a frame is read twice, with all models in it.
      context_.spend(500 + 16 * (3 * prefix.size() + name.size()), c->at);
      Named& n = out[prefix + name];
      std::string relative = relative_to(*c), follows;
      if (is_link) {
        n.link = scope + name;
        if (canonical.empty()) canonical = name;
      } else if (is_joint) {
        n.joint = scope + name;
        follows = text(*c, "child");
        if (relative.empty()) relative = follows;
      } else if (is_model) {
        follows = name + "::__model__";
      } else {
        if (const std::string* to = c->find("attached_to")) follows = *to;
        if (relative.empty()) relative = follows;
      }
      n.relative_to = full(relative);
      n.follows = full(follows);
      n.X = pose(*c);
      if (!is_model) continue;
      const std::string inner = scope_of(*c, is_world ? "" : inside(e, scope));
      collect(*c, prefix + name + "::", inner, depth + 1, out);
      out[prefix + name].X = placed(*c, inner, depth + 1);
    }
    if (canonical.empty())
      if (const XmlElement* m = e.child("model")) canonical = name_of(*m) + "::__model__";
    Named& self = out[prefix + "__model__"];
    self.relative_to = prefix.empty() ? "" : prefix.substr(0, prefix.size() - 2);
    self.follows = is_world || canonical.empty() ? "world" : prefix + canonical;
  }

  /// The pose of a model in what its <pose> is relative to.
  Pose placed(const XmlElement& model, const std::string& scope, int depth) {
    const std::string* frame = model.find("placement_frame");
    if (frame == nullptr || frame->empty()) return pose(model);
    Names own = names_of(model, scope, depth);
    return pose(model) * resolve(*frame, own, model, 0).inverse();
  }

  Pose resolve(const std::string& name, Names& names, const XmlElement& at, int depth) {
    if (name.empty() || name == "world") return {};
    const auto it = names.find(name);
    if (it == names.end()) {
      std::vector<std::string> known;
      for (const auto& [n, p] : names) known.push_back(n);
      const std::string near = context_.near(name, known);
      context_.error(at.at, "CG1408", fmt::format("there is no frame '{}'", name),
                     near.empty() ? "" : fmt::format("did you mean '{}'?", near));
      return {};
    }
    Named& p = it->second;
    if (p.known) return p.X_M;
    if (p.busy || depth > 200) {
      context_.error(at.at, "CG1410",
                     fmt::format("frame '{}' is defined relative to itself", name));
      return {};
    }
    p.busy = true;
    p.X_M = resolve(p.relative_to, names, at, depth + 1) * p.X;
    p.busy = false;
    p.known = true;
    return p.X_M;
  }

  /// The link that a name means: itself, or that of a frame, joint or model; -1: the world.
  int link_of(std::string name, const Names& names) const {
    for (int steps = 0; steps < 200; ++steps) {
      if (name == "world") return -1;
      const auto it = names.find(name);
      if (it == names.end()) return kNoLink;
      if (const std::string& link = it->second.link; !link.empty()) {
        const int index = robot_.link(link);
        return index < 0 ? kNoLink : index;
      }
      name = it->second.follows;
    }
    return kNoLink;
  }

  /// Of something on a link: in the link, whose pose in the model is `X_ML`.
  Pose pose_on(const XmlElement& e, const Pose& X_ML, Names& names) {
    const std::string to = relative_to(e);
    return to.empty() ? pose(e) : X_ML.inverse() * resolve(to, names, e, 0) * pose(e);
  }

  // ---- worlds and models

  void world(const XmlElement& e) {
    if (robot_.name.empty()) robot_.name = name_of(e);
    robot_.gravity = vector(&e, "gravity").value_or(Vec3(0.0, 0.0, -9.8));  // as SDF has it
    Names names = names_of(e, "", 0);
    for (const auto& c : e.children) {
      if (c->name == "physics") {
        if (const auto step = value(c.get(), "max_step_size"))
          robot_.take_step(context_, *step, c->at);
        context_.approximate(c->at, quoted_name(*c), "its step is taken");
      } else if (c->name == "model") {
        model(*c, "", resolve(name_of(*c), names, *c, 0), {}, 0);
      } else if (c->name == "light") {
        light(*c, pose_on(*c, Pose(), names), false);
      } else if (c->name == "wind") {
        robot_.wind = vector(c.get(), "linear_velocity");
        context_.exact(c->at, quoted_name(*c));
      } else if (c->name == "scene" || c->name == "gui" || c->name == "actor" ||
                 c->name == "atmosphere" || c->name == "magnetic_field" || c->name == "audio" ||
                 c->name == "spherical_coordinates") {
        context_.left_aside(c->at, quoted_name(*c), "concerns appearance or environment");
      } else if (c->name != "frame" && c->name != "gravity" && c->name != "joint" &&
                 c->name != "plugin") {
        left_out(*c);
      }
    }
    for (const auto& c : e.children)
      if (c->name == "joint") joint(*c, "", Pose(), names);
    for (const auto& c : e.children)
      if (c->name == "plugin") plugin(*c, names);
  }

  void model(const XmlElement& e, const std::string& outer, const Pose& X_WM, ModelFlags flags,
             int depth) {
    if (robot_.name.empty()) robot_.name = model_name(e);
    const std::string scope = scope_of(e, outer);
    flags.is_static = flags.is_static || child_is_true(e, "static");
    flags.in_wind = child_is_true(e, "enable_wind", flags.in_wind);
    flags.self_collides = child_is_true(e, "self_collide");
    flags.index = model_indices_++;
    Names names = names_of(e, scope, depth);
    for (const auto& c : e.children) {
      if (c->name != "link") continue;
      if (name_of(*c).empty())
        context_.error(c->at, "CG1404", "a <link> without a name");
      else
        link(*c, scope, X_WM, names, flags);
    }
    for (const auto& c : e.children)
      if (c->name == "model")
        model(*c, inside(e, scope), X_WM * resolve(name_of(*c), names, *c, 0), flags, depth + 1);
    for (const auto& c : e.children)
      if (c->name == "joint") joint(*c, scope, X_WM, names);
    static const std::set<std::string> kRead = {
        "link", "model",  "joint",       "plugin",       "frame",
        "pose", "static", "enable_wind", "self_collide", "allow_auto_disable"};
    for (const auto& c : e.children) {
      if (c->name == "plugin")
        plugin(*c, names);
      else if (kRead.count(c->name) == 0)
        left_out(*c);
    }
    context_.exact(e.at, quoted_name(e));
  }

  void plugin(const XmlElement& e, const Names& names) {
    context_.spend(4 * robot_.links.size(), e.at);
    const std::string system = gazebo_system(e);
    if (system == "buoyancy") return buoyancy(e, names);
    if (system == "windeffects") return wind_effects(e);
    add_gazebo_plugin(context_, e, robot_, [&](const std::string& joint) {
      const auto it = names.find(joint);
      return it == names.end() ? std::string() : it->second.joint;
    });
  }

  /// The force of the wind on a mass, m k (wind - v), is that of a drag.
  void wind_effects(const XmlElement& e) {
    const double factor =
        std::max(0.0, value(&e, "force_approximation_scaling_factor").value_or(1.0));
    for (RobotLink& l : robot_.links)
      if (l.in_wind && l.inertia && std::isfinite(factor)) l.drag = factor * l.inertia->mass;
    context_.approximate(e.at, plugin_element(e),
                         "is a <drag> of each link with enable_wind; the wind does not vary");
  }

  void buoyancy(const XmlElement& e, const Names& names) {
    constexpr double kNoSurface = 10000.0;  // [m]
    RobotFluid fluid;
    fluid.level = kNoSurface;
    fluid.density = value(&e, "uniform_fluid_density").value_or(1000.0);
    std::string differs;
    if (const XmlElement* graded = e.child("graded_buoyancy")) {
      fluid.density = value(graded, "default_density").value_or(1000.0);
      if (const XmlElement* change = graded->child("density_change"))
        fluid.level = value(change, "above_depth").value_or(0.0);
      differs = "the fluid ends where its density changes first";
    }
    if (!(fluid.density > 0.0) || !std::isfinite(fluid.density) || !std::isfinite(fluid.level)) {
      context_.left_out(e.at, plugin_element(e), "its fluid has no density");
      return;
    }
    std::vector<std::string> enabled;
    for (const auto& c : e.children)
      if (c->name == "enable") enabled.push_back(c->text);
    std::set<std::string> floats;
    for (const auto& [name, n] : names)
      if (!n.link.empty() &&
          (enabled.empty() ||
           std::any_of(enabled.begin(), enabled.end(), [&, &name = name](const std::string& of) {
             return name == of || name.rfind(of + "::", 0) == 0;
           })))
        floats.insert(n.link);
    for (RobotLink& l : robot_.links)
      if (!l.is_static && floats.count(l.name) != 0) l.fluid = fluid;
    if (differs.empty())
      context_.exact(e.at, plugin_element(e),
                     fmt::format("is <buoyancy>, up to a height of {} m", kNoSurface));
    else
      context_.approximate(e.at, plugin_element(e), "is <buoyancy>: " + differs);
  }

  void light(const XmlElement& e, const Pose& X_W, bool moves) {
    RobotLight out;
    const std::string* type = e.find("type");
    out.type = type == nullptr ? "" : *type;
    if (out.type != "directional" && out.type != "point" && out.type != "spot") {
      context_.left_out(e.at, quoted_name(e), fmt::format("there is no light '{}'", out.type));
      return;
    }
    out.name = name_of(e);
    out.at = e.at;
    out.position = X_W.p;
    Vec3 direction = vector(&e, "direction").value_or(Vec3(0.0, 0.0, -1.0));
    if (!(direction.norm() > 1e-12)) direction = Vec3(0.0, 0.0, -1.0);
    out.direction = X_W.q * direction.normalized();
    if (const auto c = color(e, "diffuse")) out.color = *c;
    if (const auto v = value(&e, "intensity"); v && *v >= 0.0 && std::isfinite(*v))
      out.intensity = *v;
    if (const auto angle = value(e.child("spot"), "outer_angle");
        angle && *angle > 0.0 && *angle < kPi)
      out.cone = 0.5 * *angle;
    out.shadows = child_is_true(e, "cast_shadows");
    context_.approximate(e.at, quoted_name(e),
                         std::string("its fading and gloss are the renderer's own") +
                             (moves ? "; it stays where it is at the start" : ""));
    robot_.lights.push_back(std::move(out));
  }

  std::optional<Color> color(const XmlElement& in, const char* tag) {
    const XmlElement* c = in.child(tag);
    if (c == nullptr) return std::nullopt;
    const auto v = context_.numbers(*c, c->text, 3, 4, fmt::format("<{}>", tag));
    if (!v) return std::nullopt;
    return Color{(*v)[0], (*v)[1], (*v)[2], v->size() > 3 ? (*v)[3] : 1.0};
  }

  void link(const XmlElement& e, const std::string& scope, const Pose& X_WM, Names& names,
            const ModelFlags& flags) {
    RobotLink out;
    out.name = scope + name_of(e);
    out.at = e.at;
    const Pose X_ML = resolve(name_of(e), names, e, 0);
    out.X = X_WM * X_ML;
    out.is_static = flags.is_static;
    out.in_wind = child_is_true(e, "enable_wind", flags.in_wind);
    out.model = flags.index;
    out.self_collides = child_is_true(e, "self_collide", flags.self_collides);
    if (robot_.link(out.name) >= 0) {
      context_.error(e.at, "CG1407", fmt::format("a second link '{}'", out.name));
      return;
    }
    RobotInertia inertia;
    inertia.mass = 1.0;  // the specification's default
    inertia.I = Mat3::Identity();
    if (const XmlElement* i = e.child("inertial")) {
      inertia.mass = value(i, "mass").value_or(1.0);
      if (!(inertia.mass >= 0.0) || !std::isfinite(inertia.mass))
        context_.error(i->at, "CG1406",
                       fmt::format("link '{}' has a mass of {} kg", out.name, inertia.mass),
                       "a mass is a number that is not negative");
      const Pose X = pose_on(*i, X_ML, names);
      inertia.com = X.p;
      if (const XmlElement* m = i->child("inertia")) {
        const auto v = [&](const char* tag, double otherwise) {
          return value(m, tag).value_or(otherwise);
        };
        Mat3 I;
        I << v("ixx", 1), v("ixy", 0), v("ixz", 0), v("ixy", 0), v("iyy", 1), v("iyz", 0),
            v("ixz", 0), v("iyz", 0), v("izz", 1);
        const Mat3 R = X.q.toRotationMatrix();
        inertia.I = R * I * R.transpose();
      }
      if (i->find("auto") != nullptr && *i->find("auto") == "true")
        context_.left_out(i->at, fmt::format("automatic inertia of link '{}'", out.name),
                          "is not computed");
    }
    if (inertia.mass > 0.0) out.inertia = inertia;
    SensorMount mount;
    for (const auto& c : e.children) mount.collisions += c->name == "collision" ? 1 : 0;
    for (const auto& c : e.children) {
      if (c->name == "visual" || c->name == "collision") {
        shape(*c, out, c->name == "visual", pose_on(*c, X_ML, names));
      } else if (c->name == "sensor") {
        mount.X = pose_on(*c, X_ML, names);
        if (auto made = gazebo_sensor(context_, *c, mount)) out.sensors.push_back(std::move(*made));
      } else if (c->name == "light") {
        light(*c, out.X * pose_on(*c, X_ML, names), !out.is_static);
      } else if (c->name == "gravity") {
        if (c->text == "false" || c->text == "0") out.gravity_scale = 0.0;
      } else if (c->name == "plugin") {
        plugin(*c, names);
      } else if (c->name != "pose" && c->name != "inertial" && c->name != "self_collide" &&
                 c->name != "kinematic" && c->name != "enable_wind" &&
                 c->name != "must_be_base_link") {
        left_out(*c);
      }
    }
    context_.exact(e.at, quoted_name(e));
    robot_.links.push_back(std::move(out));
  }

  /// False: the shape is left out, which was reported.
  bool geometry(const XmlElement& e, const XmlElement& s, const RobotLink& link, RobotShape& out) {
    Geometry& shape = out.geometry;
    using Type = Geometry::Type;
    bool good = true;
    if (s.name == "box") {
      shape.type = Type::box;
      shape.size = vector(&s, "size").value_or(Vec3::Ones());
      good = shape.size.minCoeff() > 0.0;
    } else if (s.name == "sphere") {
      shape.type = Type::sphere;
      shape.radius = value(&s, "radius").value_or(1.0);
      good = shape.radius > 0.0;
    } else if (s.name == "cylinder" || s.name == "capsule") {
      shape.type = s.name == "cylinder" ? Type::cylinder : Type::capsule;
      shape.radius = value(&s, "radius").value_or(1.0);
      shape.length = value(&s, "length").value_or(1.0);
      good = shape.radius > 0.0 && shape.length > 0.0;
    } else if (s.name == "ellipsoid") {
      shape.type = Type::ellipsoid;
      shape.size = vector(&s, "radii").value_or(Vec3::Ones());
      good = shape.size.minCoeff() > 0.0;
      context_.approximate(s.at, quoted_name(e), "is a hull of 720 triangles, within 0.6 %");
    } else if (s.name == "cone") {
      shape.type = Type::cone;
      shape.radius = value(&s, "radius").value_or(1.0);
      shape.length = value(&s, "length").value_or(1.0);
      good = shape.radius > 0.0 && shape.length > 0.0;
      context_.approximate(s.at, quoted_name(e), "is a pyramid of 32 sides, within 0.4 %");
    } else if (s.name == "polyline") {
      good = polyline(e, s, out);
    } else if (s.name == "plane") {
      shape.type = Type::plane;
      const Vec3 normal = vector(&s, "normal").value_or(Vec3::UnitZ());
      if (normal.norm() > 1e-12)
        out.X.q = (out.X.q * Quat::FromTwoVectors(Vec3::UnitZ(), normal)).normalized();
      if (!link.is_static) {
        context_.left_out(s.at, quoted_name(e), "a plane cannot move");
        return false;
      }
      if (out.collides) robot_.has_ground = true;
    } else if (s.name == "mesh") {
      shape.type = Type::mesh;
      shape.scale = vector(&s, "scale").value_or(Vec3::Ones());
      auto path = context_.locate(text(s, "uri"), s.at);
      if (!path) {
        context_.not_read(s.at, "mesh", text(s, "uri"), path.error());
        return false;
      }
      shape.mesh = *path;
      good = shape.scale.cwiseAbs().minCoeff() > 0.0;
      if (s.child("submesh") != nullptr)
        context_.approximate(s.at, quoted_name(e), "the whole mesh is taken, not its submesh");
    } else if (s.name == "heightmap") {
      const auto why = heightmap(s, out);
      if (!why) {
        context_.left_out(s.at, quoted_name(e), why.error().message);
        return false;
      }
      good = shape.size[0] > 0.0 && shape.size[1] > 0.0;
      if (good && link.is_static && out.collides) robot_.has_ground = true;
    } else {
      context_.left_out(s.at, quoted_name(e), fmt::format("there is no shape <{}>", s.name));
      return false;
    }
    if (!good) context_.left_out(s.at, quoted_name(e), "the shape has no volume");
    return good;
  }

  void shape(const XmlElement& e, RobotLink& link, bool visual, const Pose& X_LS) {
    const XmlElement* g = e.child("geometry");
    if (g == nullptr || g->children.empty()) {
      context_.left_out(e.at, quoted_name(e), "has no geometry");
      return;
    }
    const XmlElement& s = *g->children.front();
    RobotShape out;
    out.at = e.at;
    out.X = X_LS;
    out.visible = visual;
    out.collides = !visual;
    if (e.find("name") != nullptr) out.name = *e.find("name");
    if (!geometry(e, s, link, out)) return void(link.has_lost_shape = true);
    if (const XmlElement* m = e.child("material")) {
      out.color = color(*m, "diffuse");
      if (!out.color) out.color = color(*m, "ambient");
    }
    if (const auto t = value(&e, "transparency"); t && *t > 0.0 && *t <= 1.0) {
      if (!out.color) out.color = Color{1.0, 1.0, 1.0, 1.0};
      out.color->a *= 1.0 - *t;
    }
    out.contact_type = out.contact_affinity = kAllBits;
    // Gazebo's engines take the smaller friction of a pair, and multiply restitutions.
    if (!visual) out.friction = 1.0;
    out.friction_combine = CombineRule::min;
    out.restitution_combine = CombineRule::multiply;
    if (const XmlElement* surface = e.child("surface")) {
      if (const XmlElement* of = surface->child("friction")) friction(e, *of, out);
      if (const XmlElement* of = surface->child("contact"); of != nullptr)
        bitmask(*of, text(*of, "collide_bitmask"), out);
      if (const auto bounce = value(surface->child("bounce"), "restitution_coefficient"))
        out.restitution = std::clamp(*bounce, 0.0, 1.0);
    }
    context_.exact(e.at, quoted_name(e));
    link.shapes.push_back(std::move(out));
  }

  /// Heights by a picture whose brightest point is size.z high.
  Result<> heightmap(const XmlElement& s, RobotShape& out) {
    const std::string uri = text(s, "uri");
    if (uri.empty()) return fail("names no picture");
    auto path = context_.locate(uri, s.at);
    if (!path) return tl::unexpected(path.error());
    const auto brightest_is_one = [](HeightField& field) {
      const double most = *std::max_element(field.samples.begin(), field.samples.end());
      for (double& h : field.samples) h = most > 0.0 ? h / most : 0.0;
    };
    const auto& heights =
        height_files_.read(context_, *path, s.at, heights_of_picture, brightest_is_one);
    if (!heights) return tl::unexpected(heights.error());
    out.geometry.type = Geometry::Type::heightmap;
    out.geometry.heights = *heights;
    out.geometry.size = vector(&s, "size").value_or(Vec3::Ones());
    out.X = out.X * Pose(vector(&s, "pos").value_or(Vec3::Zero()), Quat::Identity());
    return {};
  }

  /// A prism on its outline, which is at z = 0; false: it has no volume.
  bool polyline(const XmlElement& e, const XmlElement& s, RobotShape& out) {
    std::vector<Eigen::Vector2d> outline;
    for (const auto& c : s.children) {
      if (c->name != "point") continue;
      const auto v = context_.numbers(*c, c->text, 2, 2, "<point>");
      if (v) outline.emplace_back((*v)[0], (*v)[1]);
    }
    const auto twice_area = [](const std::vector<Eigen::Vector2d>& of) {
      double sum = 0.0;
      for (std::size_t i = 0; i < of.size(); ++i) {
        const Eigen::Vector2d &a = of[i], &b = of[(i + 1) % of.size()];
        sum += a.x() * b.y() - a.y() * b.x();
      }
      return std::abs(sum);
    };
    const std::vector<Eigen::Vector2d> hull = geometry::convex_hull(outline);
    const double whole = twice_area(hull);
    if (std::abs(twice_area(outline) - whole) > 1e-9 * whole)
      context_.approximate(s.at, quoted_name(e), "is the convex hull of its outline");
    if (e.child("geometry")->children.size() > 1)
      context_.left_out(s.at, quoted_name(e), "outlines but the first");
    out.geometry.type = Geometry::Type::prism;
    out.geometry.length = value(&s, "height").value_or(1.0);
    for (const Eigen::Vector2d& p : hull) out.geometry.points.emplace_back(p.x(), p.y(), 0.0);
    out.X = out.X * Pose(Vec3(0.0, 0.0, 0.5 * out.geometry.length), Quat(1, 0, 0, 0));
    return whole > 0.0 && out.geometry.length > 0.0;
  }

  /// A number, also in hexadecimal digits.
  void bitmask(const XmlElement& e, const std::string& text, RobotShape& out) {
    if (text.empty()) return;
    char* end = nullptr;
    errno = 0;
    const unsigned long bits = std::strtoul(text.c_str(), &end, 0);
    if (*end != '\0' || errno != 0 || bits > 0xffffffff || text.front() == '-')
      context_.error(e.at, "CG1403", fmt::format("collide_bitmask is '{}'", text.substr(0, 60)),
                     "a number such as 65535 or 0x0f is expected");
    else
      out.contact_type = out.contact_affinity = static_cast<unsigned>(bits);
  }

  void friction(const XmlElement& shape, const XmlElement& e, RobotShape& out) {
    const auto get = [&](const char* tag, const char* what) {
      const auto v = value(e.child(tag), what);
      return v && *v >= 0.0 && *v < 1e6 ? v : std::nullopt;
    };
    if (const auto mu = get("ode", "mu")) out.friction = *mu;
    if (const auto mu2 = get("ode", "mu2"); mu2 && *mu2 != out.friction)
      context_.approximate(shape.at, fmt::format("friction of {}", quoted_name(shape)),
                           fmt::format("is mu in all directions, not the mu2 of {}", *mu2));
    out.rolling_friction = get("bullet", "rolling_friction").value_or(0.0);
    // Of a pressure on a patch of the radius R as Hertz has it: 3 pi / 16 mu R.
    out.spinning_friction = 3.0 * kPi / 16.0 * get("torsional", "coefficient").value_or(1.0) *
                            get("torsional", "patch_radius").value_or(0.0);
  }

  void joint(const XmlElement& e, const std::string& scope, const Pose& X_WM, Names& names) {
    using Type = RobotJoint::Type;
    const std::string* name = e.find("name");
    const std::string* type = e.find("type");
    if (name == nullptr || type == nullptr) {
      context_.error(e.at, "CG1404", "a <joint> needs name and type");
      return;
    }
    RobotJoint out;
    out.name = scope + *name;
    out.at = e.at;
    static const std::map<std::string, Type> kTypes = {
        {"revolute", Type::hinge},      {"continuous", Type::hinge}, {"prismatic", Type::slider},
        {"fixed", Type::fixed},         {"ball", Type::ball},        {"universal", Type::universal},
        {"revolute2", Type::universal}, {"screw", Type::screw}};
    const auto known = kTypes.find(*type);
    if (known == kTypes.end()) {
      context_.left_out(e.at, quoted_name(e), fmt::format("there is no joint of type '{}'", *type));
      return;
    }
    out.type = known->second;
    const std::string parent = text(e, "parent"), child = text(e, "child");
    out.child = link_of(child, names);
    out.parent = parent.empty() ? -1 : link_of(parent, names);
    if (out.child < 0 || parent.empty() || out.parent == kNoLink) {
      context_.error(e.at, "CG1408",
                     fmt::format("joint '{}' connects '{}' and '{}', of which one is no "
                                 "link of the model",
                                 *name, parent, child));
      return;
    }
    if (out.child == out.parent) {
      context_.error(e.at, "CG1410",
                     fmt::format("joint '{}' connects '{}' to itself", *name, child));
      return;
    }
    if (out.type != Type::fixed && robot_.stands(out.parent) && robot_.stands(out.child)) {
      context_.left_out(e.at, quoted_name(e), "joins what does not move");
      return;
    }
    const Pose X_WC = robot_.links[out.child].X;
    const Pose X_WP = out.parent < 0 ? Pose() : robot_.links[out.parent].X;
    out.X_PC = X_WP.inverse() * X_WC;
    const Pose X_CJ = X_WC.inverse() * (X_WM * resolve(*name, names, e, 0));
    out.anchor = X_CJ.p;
    const auto axis = [&](const XmlElement* a) {
      Vec3 v = vector(a, "xyz").value_or(Vec3::UnitZ());
      if (!(v.norm() > 1e-12)) v = Vec3::UnitZ();
      Quat q = X_CJ.q;  // the joint's frame, unless said
      if (const XmlElement* xyz = a == nullptr ? nullptr : a->child("xyz"))
        if (const std::string* in = xyz->find("expressed_in"); in != nullptr && !in->empty())
          q = X_WC.q.conjugate() * (X_WM * resolve(*in, names, e, 0)).q;
      return Vec3((q * v).normalized());
    };
    const XmlElement* a = e.child("axis");
    out.axis = axis(a);
    out.axis2 = axis(e.child("axis2"));
    if (a != nullptr && out.has_one_axis()) {
      axis_law(*a, *type != "continuous", out);
      mimic(*a, scope, names, out);
    }
    if (a != nullptr && out.type == Type::ball)
      out.damping = std::max(0.0, value(a->child("dynamics"), "damping").value_or(0.0));
    if (out.type == Type::universal) {
      if (a != nullptr) axis_law(*a, true, out);
      if (const XmlElement* b = e.child("axis2"); b != nullptr) axis_law(*b, true, out.second);
      for (const char* each : {"axis", "axis2"})
        if (const XmlElement* of = e.child(each); of != nullptr && of->child("mimic") != nullptr)
          context_.left_out(of->child("mimic")->at,
                            fmt::format("<mimic> of <{}> of joint '{}'", each, *name),
                            "only joints with one axis are coupled");
    }
    if (out.type == Type::screw) {
      // Since SDF 1.10 [m/turn]; before, [rad/m] of a left-handed thread.
      const auto travel = value(&e, "screw_thread_pitch");
      out.pitch = travel ? *travel : -2.0 * kPi / value(&e, "thread_pitch").value_or(1.0);
      if (out.pitch == 0.0 || !std::isfinite(out.pitch)) {
        out.type = Type::hinge;
        context_.approximate(e.at, quoted_name(e), "is a hinge, as its thread has no pitch");
      }
    }
    for (const auto& c : e.children) {
      if (c->name != "sensor") continue;
      SensorMount mount;
      mount.joint = out.name;
      if (auto made = gazebo_sensor(context_, *c, mount))
        robot_.links[out.child].sensors.push_back(std::move(*made));
    }
    if (*type == "revolute2") context_.exact(e.at, quoted_name(e), "is a universal joint");
    context_.exact(e.at, quoted_name(e));
    // A second joint on a link closes a loop, and one on an ancestor of its parent.
    parent_.resize(robot_.links.size(), kNoLink);
    int& parent_link = parent_[out.child];
    bool closes = parent_link != kNoLink;
    for (int up = out.parent; up >= 0 && !closes; up = parent_[up]) closes = up == out.child;
    if (!closes) parent_link = out.parent;
    (closes ? robot_.loops : robot_.joints).push_back(std::move(out));
  }

  /// Limits, damping, friction and spring of an axis.
  void axis_law(const XmlElement& axis, bool bounded, AxisLaw& out) {
    const XmlElement* limit = axis.child("limit");
    if (bounded) {
      const double low = value(limit, "lower").value_or(-1e16),
                   high = value(limit, "upper").value_or(1e16);
      if (low > -1e15) out.lower = low;
      if (high < 1e15) out.upper = high;
      if (out.lower > out.upper) std::swap(out.lower, out.upper);
    }
    if (const auto effort = value(limit, "effort"); effort && *effort > 0.0 && *effort < 1e15)
      out.max_effort = *effort;
    if (const auto speed = value(limit, "velocity"); speed && *speed > 0.0 && *speed < 1e15)
      out.max_speed = *speed;
    const XmlElement* dynamics = axis.child("dynamics");
    out.damping = std::max(0.0, value(dynamics, "damping").value_or(0.0));
    out.friction = std::max(0.0, value(dynamics, "friction").value_or(0.0));
    out.stiffness = std::max(0.0, value(dynamics, "spring_stiffness").value_or(0.0));
    out.rest = value(dynamics, "spring_reference").value_or(0.0);
  }

  void mimic(const XmlElement& axis, const std::string& scope, const Names& names,
             RobotJoint& out) {
    const XmlElement* of = axis.child("mimic");
    if (of == nullptr) return;
    const std::string leader = of->find("joint") == nullptr ? "" : *of->find("joint");
    const auto known = names.find(leader);
    RobotCoupling c;
    const bool is_joint = known != names.end() && !known->second.joint.empty();
    c.terms = {
        {is_joint ? known->second.joint : scope + leader, value(of, "multiplier").value_or(1.0)}};
    // follower = multiplier (leader - reference) + offset
    c.offset =
        value(of, "offset").value_or(0.0) - c.terms[0].ratio * value(of, "reference").value_or(0.0);
    out.coupling = c;
  }

  Context& context_;
  RobotModel robot_;
  std::map<const XmlElement*, Pose> poses_;
  std::map<const XmlElement*, std::string> scopes_;
  HeightFiles height_files_;
  static constexpr int kNoLink = -2;
  std::vector<int> parent_;  ///< of each link: the parent link of its joint, or the world (-1)
  int models_ = 0, model_indices_ = 0;
};

}  // namespace

RobotModel read_sdf(Context& context, const XmlElement& root) {
  return SdfReader(context).read(root);
}

}  // namespace cogrsim::dsl::import

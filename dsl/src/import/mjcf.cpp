// MJCF, MuJoCo's own format (mujoco.readthedocs.io, "XML reference"): default classes, bodies with
// several joints, geoms with and without masses, sites, loops by equalities, actuators, sensors.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "assets/mesh_file.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/model/mass_properties.h"
#include "import/robot.h"

namespace cogrsim::dsl::import {

namespace fs = std::filesystem;

namespace {

using Attributes = std::map<std::string, std::string>;
/// Attributes by element: "geom" → size, rgba, …
using Defaults = std::map<std::string, Attributes>;

class MjcfReader {
 public:
  explicit MjcfReader(Context& context) : context_(context) {}

  RobotModel read(XmlElement& root) {
    include(root, 0);
    if (const std::string* name = root.find("model")) robot_.name = *name;
    for (const auto& e : root.children)
      if (e->name == "compiler") compiler(*e);
    classes_["main"];
    for (const auto& e : root.children)
      if (e->name == "default") default_class(*e, "main", true);
    for (const auto& e : root.children) {
      if (e->name == "option") option(*e);
      if (e->name == "asset") assets(*e);
    }
    for (const auto& e : root.children)
      if (e->name != "worldbody") note_joints(*e, 0);
    for (const auto& e : root.children)
      if (e->name == "worldbody") world(*e);
    for (const auto& e : root.children) section(*e);
    if (robot_.links.empty()) context_.refuse(root.at, "CG1405", "the model has no body");
    contacts();
    return std::move(robot_);
  }

 private:
  // ---- files

  void include(XmlElement& in, int depth) {
    if (depth > 80)
      context_.refuse(in.at, "CG1402", "files include each other in a circle, or too deep");
    for (std::size_t i = 0; i < in.children.size(); ++i) {
      XmlElement& e = *in.children[i];
      if (e.name != "include") {
        include(e, depth + 1);
        continue;
      }
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

  // ---- settings

  void compiler(const XmlElement& e) {
    for (const auto& [key, value] : e.attributes) {
      if (key == "angle")
        degrees_ = value != "radian";
      else if (key == "eulerseq" && value.size() == 3)
        euler_ = value;
      else if (key == "meshdir")
        mesh_dir_ = value;
      else if (key == "assetdir" && e.find("meshdir") == nullptr)
        mesh_dir_ = value;
      else if (key == "autolimits")
        auto_limits_ = value != "false";
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

  void option(const XmlElement& e) {
    if (const auto step = context_.number(e, "timestep"); step && *step > 0.0) robot_.step = *step;
    if (e.find("gravity") != nullptr)
      robot_.gravity = context_.vec3(e, "gravity", Vec3(0, 0, -9.81));
    for (const auto& [key, value] : e.attributes) {
      if (key == "timestep" || key == "gravity") continue;
      if (key == "density" || key == "viscosity" || key == "wind")
        context_.left_out(e.at, fmt::format("option {}", key),
                          "forces of a fluid are not simulated");
      else
        context_.left_out(e.at, fmt::format("option {}", key), "is a setting of MuJoCo's solver");
    }
  }

  void default_class(const XmlElement& e, const std::string& parent, bool top) {
    std::string name = parent;
    if (const std::string* own = e.find("class")) name = *own;
    if (!top || name != "main") classes_[name] = classes_[parent];
    Defaults& d = classes_[name];
    for (const auto& c : e.children) {
      if (c->name == "default") continue;
      for (const auto& [key, value] : c->attributes) d[c->name][key] = value;
    }
    for (const auto& c : e.children)
      if (c->name == "default") default_class(*c, name, false);
  }

  void assets(const XmlElement& e) {
    for (const auto& c : e.children) {
      const XmlElement a = with_defaults(*c, "");
      const std::string* file = a.find("file");
      const std::string* name = a.find("name");
      std::string key = name != nullptr ? *name : "";
      if (key.empty() && file != nullptr) key = fs::path(*file).stem().string();
      if (c->name == "mesh") {
        Mesh mesh;
        mesh.at = c->at;
        mesh.scale = context_.vec3(a, "scale", Vec3::Ones());
        if (a.find("refpos") != nullptr || a.find("refquat") != nullptr)
          context_.approximate(c->at, quoted_name(*c), "its reference pose is not applied");
        if (file == nullptr) {
          context_.left_out(c->at, quoted_name(*c), "has no file");
          continue;
        }
        auto path = context_.locate(mesh_dir_.empty() ? *file : mesh_dir_ + "/" + *file, c->at);
        if (!path) {
          context_.left_out(c->at, quoted_name(*c), path.error().message);
          continue;
        }
        mesh.path = *path;
        meshes_[key] = mesh;
        context_.exact(c->at, quoted_name(*c));
      } else if (c->name == "material") {
        if (const std::string* rgba = a.find("rgba")) {
          const auto v = context_.numbers(*c, *rgba, 3, 4, "'rgba'");
          if (v) materials_[key] = Color{(*v)[0], (*v)[1], (*v)[2], v->size() > 3 ? (*v)[3] : 1.0};
        }
        context_.exact(c->at, quoted_name(*c), "its colour, without texture and gloss");
      } else if (c->name == "texture" || c->name == "skin") {
        context_.left_out(c->at, quoted_name(*c), "concerns appearance only");
      } else {
        context_.left_out(c->at, quoted_name(*c), fmt::format("<{}> is not read", c->name));
      }
    }
  }

  // ---- attributes with defaults

  /// The element with what its class, or the class of the bodies around it, says for it.
  XmlElement with_defaults(const XmlElement& e, const std::string& around) {
    XmlElement out;
    out.name = e.name;
    out.at = e.at;
    std::string name = around.empty() ? "main" : around;
    if (const std::string* own = e.find("class")) name = *own;
    auto known = classes_.find(name);
    if (known == classes_.end()) {
      std::vector<std::string> names;
      for (const auto& [n, d] : classes_) names.push_back(n);
      const std::string near = nearest_name(name, names);
      context_.error(e.at, "CG1408", fmt::format("there is no default class '{}'", name),
                     near.empty() ? "" : fmt::format("did you mean '{}'?", near));
      known = classes_.find("main");
    }
    Attributes all;
    if (const auto of = known->second.find(e.name); of != known->second.end()) all = of->second;
    for (const auto& [key, value] : e.attributes) {
      if (value.empty())
        all.erase(key);
      else
        all[key] = value;
    }
    for (auto& [key, value] : all) out.attributes.emplace_back(key, value);
    return out;
  }

  double angle(double value) const { return degrees_ ? value * kPi / 180.0 : value; }

  Quat orientation(const XmlElement& e) {
    if (const std::string* q = e.find("quat")) {
      const auto v = context_.numbers(e, *q, 4, 4, "'quat'");
      if (v) {
        const Quat out((*v)[0], (*v)[1], (*v)[2], (*v)[3]);
        if (out.norm() > 1e-9) return out.normalized();
      }
    } else if (const std::string* a = e.find("axisangle")) {
      const auto v = context_.numbers(e, *a, 4, 4, "'axisangle'");
      if (v && Vec3((*v)[0], (*v)[1], (*v)[2]).norm() > 1e-12)
        return Quat(
            Eigen::AngleAxisd(angle((*v)[3]), Vec3((*v)[0], (*v)[1], (*v)[2]).normalized()));
    } else if (const std::string* u = e.find("euler")) {
      const auto v = context_.numbers(e, *u, 3, 3, "'euler'");
      if (v) {
        Quat out = Quat::Identity();
        for (std::size_t i = 0; i < 3; ++i) {
          const char c = euler_[i];
          const Vec3 axis = c == 'x' || c == 'X'   ? Vec3::UnitX()
                            : c == 'y' || c == 'Y' ? Vec3::UnitY()
                                                   : Vec3::UnitZ();
          const Quat turn(Eigen::AngleAxisd(angle((*v)[i]), axis));
          out = c >= 'a' ? out * turn : turn * out;  // small: about the moving axes
        }
        return out.normalized();
      }
    } else if (const std::string* xy = e.find("xyaxes")) {
      const auto v = context_.numbers(e, *xy, 6, 6, "'xyaxes'");
      if (v) {
        Vec3 x((*v)[0], (*v)[1], (*v)[2]), y((*v)[3], (*v)[4], (*v)[5]);
        if (x.norm() > 1e-12) {
          x.normalize();
          y -= x * x.dot(y);
          if (y.norm() > 1e-12) {
            y.normalize();
            Mat3 R;
            R << x, y, x.cross(y);
            return Quat(R).normalized();
          }
        }
      }
    } else if (const std::string* z = e.find("zaxis")) {
      const auto v = context_.numbers(e, *z, 3, 3, "'zaxis'");
      if (v && Vec3((*v)[0], (*v)[1], (*v)[2]).norm() > 1e-12)
        return Quat::FromTwoVectors(Vec3::UnitZ(), Vec3((*v)[0], (*v)[1], (*v)[2])).normalized();
    }
    return Quat::Identity();
  }

  Pose pose(const XmlElement& e) { return {context_.vec3(e, "pos", Vec3::Zero()), orientation(e)}; }

  // ---- bodies

  /// Joints that actuators, equalities, tendons and sensors name: these keep their own axis.
  void note_joints(const XmlElement& e, int depth) {
    for (const char* key : {"joint", "joint1", "joint2"})
      if (const std::string* name = e.find(key)) used_joints_.insert(*name);
    if (depth < 90)
      for (const auto& c : e.children) note_joints(*c, depth + 1);
  }

  void world(const XmlElement& e) {
    for (const auto& c : e.children) {
      if (c->name == "body") {
        body(*c, -1, child_class(e, ""), 0);
      } else if (c->name == "geom") {
        const XmlElement g = with_defaults(*c, child_class(e, ""));
        RobotShape shape;
        double mass = 0.0;
        if (geom(*c, g, shape, mass, nullptr)) {
          if (shape.geometry.type == Geometry::Type::plane) robot_.has_ground = true;
          ground().shapes.push_back(std::move(shape));
        }
      } else if (c->name == "site") {
        ground().frames.push_back(
            {name_of(*c, "site"), pose(with_defaults(*c, child_class(e, "")))});
      } else {
        context_.left_out(c->at, quoted_name(*c), "concerns appearance only");
      }
    }
  }

  /// What is fixed to the world.
  RobotLink& ground() {
    const int known = robot_.link("world");
    if (known >= 0) return robot_.links[static_cast<std::size_t>(known)];
    RobotLink link;
    link.name = "world";
    link.is_static = true;
    robot_.links.push_back(std::move(link));
    return robot_.links.back();
  }

  static std::string child_class(const XmlElement& e, const std::string& around) {
    const std::string* own = e.find("childclass");
    return own != nullptr ? *own : around;
  }

  std::string name_of(const XmlElement& e, const char* kind) {
    if (const std::string* name = e.find("name"); name != nullptr && !name->empty()) return *name;
    return fmt::format("{}_{}", kind, ++unnamed_);
  }

  void body(const XmlElement& e, int parent, const std::string& around, int depth) {
    if (depth > 80) context_.refuse(e.at, "CG1402", "bodies are nested too deep");
    if (robot_.links.size() > 20000) context_.refuse(e.at, "CG1402", "more than 20000 bodies");
    const std::string inner = child_class(e, around);
    RobotLink link;
    link.name = name_of(e, "body");
    link.at = e.at;
    if (robot_.link(link.name) >= 0) {
      context_.error(e.at, "CG1407", fmt::format("a second body '{}'", link.name));
      return;
    }
    const Pose X_PB = pose(e);
    std::vector<std::pair<const XmlElement*, XmlElement>> joints;
    std::vector<RobotInertia> masses;
    const XmlElement* inertial = nullptr;
    bool is_free = false;
    for (const auto& c : e.children) {
      if (c->name == "body") continue;
      if (c->name == "freejoint") {
        is_free = true;
        free_names_[c->find("name") == nullptr ? "" : *c->find("name")] = link.name;
      } else if (c->name == "joint") {
        XmlElement j = with_defaults(*c, inner);
        const std::string* type = j.find("type");
        if (type != nullptr && *type == "free")
          is_free = true;
        else
          joints.emplace_back(c.get(), std::move(j));
      } else if (c->name == "inertial") {
        inertial = c.get();
      } else if (c->name == "geom") {
        const XmlElement g = with_defaults(*c, inner);
        RobotShape shape;
        double mass = 0.0;
        RobotInertia inertia;
        const bool made = geom(*c, g, shape, mass, &inertia);
        if (inertia.mass > 0.0) masses.push_back(inertia);
        if (made) link.shapes.push_back(std::move(shape));
      } else if (c->name == "site") {
        const XmlElement s = with_defaults(*c, inner);
        const std::string name = name_of(*c, "site");
        sites_[name] = {link.name, pose(s)};
        link.frames.push_back({name, pose(s)});
      } else if (c->name == "camera") {
        const XmlElement s = with_defaults(*c, inner);
        RobotSensor camera;
        camera.name = name_of(*c, "camera");
        camera.element = "camera";
        camera.at = c->at;
        // MuJoCo's cameras look along -z with y up, ours along x with z up.
        Mat3 R;
        R << 0, -1, 0, 0, 0, 1, -1, 0, 0;
        camera.X = pose(s) * Pose(Vec3::Zero(), Quat(R));
        if (s.find("mode") != nullptr && *s.find("mode") != "fixed")
          context_.approximate(c->at, quoted_name(*c), "it is fixed to its body");
        else
          context_.exact(c->at, quoted_name(*c));
        link.sensors.push_back(std::move(camera));
      } else {
        context_.left_out(c->at, fmt::format("<{}> of body '{}'", c->name, link.name),
                          c->name == "light" ? "concerns appearance only" : "is not read");
      }
    }
    if (inertial != nullptr && from_geoms_ != "true")
      link.inertia = given_inertia(*inertial);
    else if (!masses.empty() && from_geoms_ != "false")
      link.inertia = sum(masses);
    if (link.inertia) {
      link.inertia->mass = std::max(link.inertia->mass, bound_mass_);
      if (bound_inertia_ > 0.0)
        for (int i = 0; i < 3; ++i)
          link.inertia->I(i, i) = std::max(link.inertia->I(i, i), bound_inertia_);
    }
    for (const auto& [key, value] : e.attributes) {
      if (key == "mocap" && value == "true") {
        link.is_static = true;
        context_.approximate(e.at, quoted_name(e), "a mocap body is static: nothing moves it here");
      } else if (key == "gravcomp") {
        link.gravity_scale = 1.0 - context_.number(e, "gravcomp", 0.0);
      }
    }
    context_.exact(e.at, quoted_name(e));
    const int index = attach(e, std::move(link), parent, X_PB, joints, is_free);
    for (const auto& c : e.children)
      if (c->name == "body") body(*c, index, inner, depth + 1);
  }

  static RobotInertia sum(const std::vector<RobotInertia>& parts) {
    std::vector<MassProperties> all;
    for (const RobotInertia& p : parts) all.push_back({p.mass, p.com, p.I});
    const MassProperties m = combine(all);
    return {m.mass, m.com, m.inertia};
  }

  std::optional<RobotInertia> given_inertia(const XmlElement& e) {
    RobotInertia out;
    out.mass = context_.number(e, "mass", 0.0);
    if (!(out.mass > 0.0)) return std::nullopt;
    const Pose X = pose(e);
    out.com = X.p;
    Mat3 I = Mat3::Zero();
    if (const std::string* full = e.find("fullinertia")) {
      const auto v = context_.numbers(e, *full, 6, 6, "'fullinertia'");
      if (v) I << (*v)[0], (*v)[3], (*v)[4], (*v)[3], (*v)[1], (*v)[5], (*v)[4], (*v)[5], (*v)[2];
    } else {
      I.diagonal() = context_.vec3(e, "diaginertia", Vec3::Zero());
    }
    const Mat3 R = X.q.toRotationMatrix();
    out.I = R * I * R.transpose();
    return out;
  }

  /// Adds the link with its joints; several joints need links between them. Returns its index.
  int attach(const XmlElement& e, RobotLink link, int parent, const Pose& X_PB,
             const std::vector<std::pair<const XmlElement*, XmlElement>>& joints, bool is_free) {
    using Type = RobotJoint::Type;
    if (joints.empty()) {
      RobotJoint j;
      j.name = link.name + "_fixed";
      j.at = e.at;
      j.X_PC = X_PB;
      j.parent = parent;
      j.type = is_free ? Type::free : Type::fixed;
      robot_.links.push_back(std::move(link));
      j.child = static_cast<int>(robot_.links.size()) - 1;
      // A free body in the world needs no joint, but has a pose: the joint keeps it.
      if (is_free && parent >= 0) {
        context_.error(e.at, "CG1413", "a free joint belongs to a body of the world");
        return j.child;
      }
      robot_.joints.push_back(std::move(j));
      return static_cast<int>(robot_.links.size()) - 1;
    }
    std::vector<RobotJoint> made;
    for (const auto& [source, j] : joints) made.push_back(joint(*source, j));
    if (planar(made)) {
      RobotJoint j;
      j.type = Type::planar;
      j.name = made[0].name;
      j.at = made[0].at;
      for (const RobotJoint& k : made)
        if (k.type == Type::hinge) j.axis = k.axis;
      context_.exact(j.at, fmt::format("joints of body '{}'", link.name),
                     fmt::format("are one planar joint, '{}'", j.name));
      made = {j};
    }
    // The first joint moves the first link; the body is the last. All are in the body's frame.
    int from = parent;
    Pose X = X_PB;
    const std::string name = link.name;
    for (std::size_t i = 0; i < made.size(); ++i) {
      RobotLink next;
      if (i + 1 < made.size()) {
        next.name = fmt::format("{}_{}", name, i + 1);
        next.at = link.at;
      } else {
        next = std::move(link);
      }
      robot_.links.push_back(std::move(next));
      made[i].parent = from;
      made[i].X_PC = X;
      made[i].child = static_cast<int>(robot_.links.size()) - 1;
      from = made[i].child;
      X = Pose();
      robot_.joints.push_back(made[i]);
    }
    return from;
  }

  /// Two sliders and a hinge, each perpendicular to the others, without anything else.
  bool planar(const std::vector<RobotJoint>& joints) const {
    using Type = RobotJoint::Type;
    if (joints.size() != 3) return false;
    std::vector<Vec3> slides;
    Vec3 normal = Vec3::Zero();
    for (const RobotJoint& j : joints) {
      if (j.type == Type::slider)
        slides.push_back(j.axis);
      else if (j.type == Type::hinge && joints.back().name == j.name)
        normal = j.axis;
      if (used_joints_.count(j.name) != 0) return false;
      if (std::isfinite(j.lower) || std::isfinite(j.upper) || j.damping != 0.0 ||
          j.friction != 0.0 || j.stiffness != 0.0 || j.rotor_inertia != 0.0 ||
          j.anchor != Vec3::Zero())
        return false;
    }
    return slides.size() == 2 && std::abs(slides[0].dot(slides[1])) < 1e-9 && normal.norm() > 0.5 &&
           std::abs(slides[0].dot(normal)) < 1e-9 && std::abs(slides[1].dot(normal)) < 1e-9;
  }

  RobotJoint joint(const XmlElement& source, const XmlElement& e) {
    using Type = RobotJoint::Type;
    RobotJoint out;
    out.name = name_of(source, "joint");
    out.at = source.at;
    const std::string* type = e.find("type");
    const std::string kind = type == nullptr ? "hinge" : *type;
    if (kind == "hinge")
      out.type = Type::hinge;
    else if (kind == "slide")
      out.type = Type::slider;
    else if (kind == "ball")
      out.type = Type::ball;
    else
      context_.error(source.at, "CG1408",
                     fmt::format("joint '{}': there is no type '{}'", out.name, kind),
                     "hinge, slide, ball and free are");
    const bool turns = out.type == Type::hinge;
    const auto coordinate = [&](double v) { return turns ? angle(v) : v; };
    const Vec3 axis = context_.vec3(e, "axis", Vec3::UnitZ());
    if (axis.norm() > 1e-12)
      out.axis = axis.normalized();
    else if (out.type != Type::ball)
      context_.error(source.at, "CG1409",
                     fmt::format("joint '{}' has an axis of length 0", out.name));
    out.anchor = context_.vec3(e, "pos", Vec3::Zero());
    const double ref = coordinate(context_.number(e, "ref", 0.0));
    const std::string* limited = e.find("limited");
    const std::string* range = e.find("range");
    const bool bounded =
        range != nullptr &&
        (limited == nullptr ? auto_limits_
                            : *limited == "true" || (*limited == "auto" && auto_limits_));
    if (bounded) {
      const auto v = context_.numbers(source, *range, 2, 2, "'range'");
      if (v && out.type == Type::ball) {
        context_.left_out(source.at, fmt::format("range of joint '{}'", out.name),
                          "the cone of a ball joint is not taken over");
      } else if (v) {
        out.lower = coordinate((*v)[0]) - ref;
        out.upper = coordinate((*v)[1]) - ref;
        if (out.lower > out.upper) std::swap(out.lower, out.upper);
      }
    }
    out.damping = std::max(0.0, context_.number(e, "damping", 0.0));
    out.friction = std::max(0.0, context_.number(e, "frictionloss", 0.0));
    out.stiffness = std::max(0.0, context_.number(e, "stiffness", 0.0));
    out.rest = coordinate(context_.number(e, "springref", 0.0)) - ref;
    out.rotor_inertia = std::max(0.0, context_.number(e, "armature", 0.0));
    if (ref != 0.0)
      context_.exact(source.at, fmt::format("ref of joint '{}'", out.name),
                     fmt::format("its zero is MuJoCo's {}", ref));
    context_.exact(source.at, fmt::format("joint '{}'", out.name));
    return out;
  }

  // ---- geoms

  bool geom(const XmlElement& source, const XmlElement& e, RobotShape& out, double& mass,
            RobotInertia* inertia) {
    out.at = source.at;
    if (const std::string* name = source.find("name")) out.name = *name;
    const std::string* type = e.find("type");
    const std::string* mesh = e.find("mesh");
    const std::string kind = type != nullptr ? *type : mesh != nullptr ? "mesh" : "sphere";
    out.X = pose(e);
    std::vector<double> size;
    if (const std::string* text = e.find("size"))
      size = context_.numbers(source, *text, 1, 3, "'size'").value_or(std::vector<double>());
    const auto s = [&](std::size_t i) { return i < size.size() ? size[i] : 0.0; };
    double half = s(1);
    if (const std::string* text = e.find("fromto")) {
      const auto v = context_.numbers(source, *text, 6, 6, "'fromto'");
      if (!v) return false;
      const Vec3 a((*v)[0], (*v)[1], (*v)[2]), b((*v)[3], (*v)[4], (*v)[5]);
      half = 0.5 * (b - a).norm();
      out.X.p = 0.5 * (a + b);
      if (half > 1e-12) out.X.q = Quat::FromTwoVectors(Vec3::UnitZ(), a - b).normalized();
    }
    Geometry& g = out.geometry;
    const std::string what = out.name.empty() ? fmt::format("geom of type {}", kind)
                                              : fmt::format("geom '{}'", out.name);
    const bool fitted = mesh != nullptr && kind != "mesh" && kind != "plane";
    if (fitted)
      context_.approximate(source.at, what,
                           fmt::format("is the mesh itself, where MuJoCo fits a {} to it", kind));
    if (kind == "plane") {
      g.type = Geometry::Type::plane;
    } else if (kind == "mesh" || fitted) {
      const auto known = mesh == nullptr ? meshes_.end() : meshes_.find(*mesh);
      if (known == meshes_.end()) {
        context_.left_out(source.at, what, "its mesh could not be read");
        return false;
      }
      g.type = Geometry::Type::mesh;
      g.mesh = known->second.path;
      g.scale = known->second.scale;
    } else if (kind == "sphere") {
      g.type = Geometry::Type::sphere;
      g.radius = s(0);
    } else if (kind == "capsule" || kind == "cylinder") {
      g.type = kind == "capsule" ? Geometry::Type::capsule : Geometry::Type::cylinder;
      g.radius = s(0);
      g.length = 2.0 * half;
    } else if (kind == "box" || kind == "ellipsoid") {
      Vec3 h(s(0), s(1), s(2));
      if (e.find("fromto") != nullptr) h = Vec3(s(0), s(0), half);
      g.type = kind == "box" ? Geometry::Type::box : Geometry::Type::points;
      g.size = kind == "box" ? Vec3(2.0 * h) : h;
    } else {
      context_.left_out(source.at, what, fmt::format("there is no shape '{}'", kind));
      return false;
    }
    if (!fitted &&
        ((kind == "sphere" && !(g.radius > 0.0)) ||
         ((kind == "capsule" || kind == "cylinder") && (!(g.radius > 0.0) || !(g.length > 0.0))) ||
         ((kind == "box" || kind == "ellipsoid") && !(g.size.minCoeff() > 0.0)))) {
      context_.error(source.at, "CG1404", fmt::format("{} has no size", what));
      return false;
    }
    masses(source, e, out, mass, inertia, what);
    if (kind == "ellipsoid" && !fitted) {
      g.points = ellipsoid_points(g.size);
      context_.approximate(
          source.at, what,
          "touches as the hull of 242 points, up to 2 % inside; its mass is exact");
    }
    const auto bits = [&](const char* name) {
      return static_cast<unsigned>(context_.number(e, name, 1.0));
    };
    Bits b{bits("contype"), bits("conaffinity")};
    out.collides = b.type != 0 || b.affinity != 0;
    out.visible = true;
    if (const std::string* rgba = e.find("rgba")) {
      const auto v = context_.numbers(source, *rgba, 3, 4, "'rgba'");
      if (v) out.color = Color{(*v)[0], (*v)[1], (*v)[2], v->size() > 3 ? (*v)[3] : 1.0};
    } else if (const std::string* material = e.find("material")) {
      if (const auto known = materials_.find(*material); known != materials_.end())
        out.color = known->second;
    }
    if (out.color && out.color->a == 0.0) {
      out.visible = false;
      out.color.reset();
    }
    // By convention group 3 and above are collision shapes that are not drawn.
    if (context_.number(e, "group", 0.0) >= 3.0) out.visible = false;
    if (!out.visible && !out.collides) return false;
    out.friction = 1.0;
    if (const std::string* text = e.find("friction")) {
      const auto v = context_.numbers(source, *text, 1, 3, "'friction'");
      if (v) out.friction = std::max(0.0, (*v)[0]);
      if (v && v->size() > 1 && ((*v)[1] != 0.005 || (v->size() > 2 && (*v)[2] != 0.0001)))
        context_.left_out(source.at, fmt::format("torsional and rolling friction of {}", what),
                          "the scene language has sliding friction");
    }
    bits_.push_back(b);
    context_.exact(source.at, what);
    return true;
  }

  /// Of a mesh of density 1 kg/m^3, in its file's axes and after its scale.
  const Result<MassProperties>& mesh_mass(const Geometry& g, const std::string& what) {
    const std::string key = fmt::format("{}|{} {} {}", g.mesh, g.scale[0], g.scale[1], g.scale[2]);
    const auto known = mesh_masses_.find(key);
    if (known != mesh_masses_.end()) return known->second;
    const auto compute = [&]() -> Result<MassProperties> {
      auto mesh = load_mesh(g.mesh, what, context_.options.limits.asset_bytes);
      if (!mesh) return tl::unexpected(mesh.error());
      for (Vec3& v : mesh->vertices) v = v.cwiseProduct(g.scale);
      if (g.scale.prod() < 0.0)
        for (Eigen::Vector3i& t : mesh->triangles) std::swap(t[1], t[2]);
      Shape s;
      s.type = ShapeType::mesh;
      s.mesh = 0;
      const std::vector<TriangleMesh> meshes = {std::move(*mesh)};
      return shape_mass(s, meshes, shape_volume(s, meshes));
    };
    return mesh_masses_.emplace(key, compute()).first->second;
  }

  void masses(const XmlElement& source, const XmlElement& e, const RobotShape& shape, double& mass,
              RobotInertia* inertia, const std::string& what) {
    if (inertia == nullptr || shape.geometry.type == Geometry::Type::plane) return;
    const double group = context_.number(e, "group", 0.0);
    if (group < first_group_ || group > last_group_) return;
    const std::optional<double> given = context_.number(e, "mass");
    const double density = context_.number(e, "density", 1000.0);
    const Geometry& g = shape.geometry;
    MassProperties m;
    const double a = g.size[0], b = g.size[1], c = g.size[2];
    double volume = 0.0;
    switch (g.type) {
      case Geometry::Type::points:  // of an ellipsoid, see geom()
        volume = 4.0 / 3.0 * kPi * a * b * c;
        m.mass = given.value_or(density * volume);
        m.inertia.diagonal() = m.mass / 5.0 * Vec3(b * b + c * c, a * a + c * c, a * a + b * b);
        break;
      case Geometry::Type::mesh: {
        const auto& unit = mesh_mass(g, what);
        if (!unit) {
          context_.left_out(source.at, fmt::format("mass of {}", what), unit.error().message);
          return;
        }
        m = *unit;
        const double factor = given ? *given / m.mass : density;
        m.mass *= factor;
        m.inertia *= factor;
        if (!(m.mass > 0.0)) return;
        break;
      }
      default: {
        Shape s;
        s.type = g.type == Geometry::Type::box        ? ShapeType::box
                 : g.type == Geometry::Type::sphere   ? ShapeType::sphere
                 : g.type == Geometry::Type::cylinder ? ShapeType::cylinder
                                                      : ShapeType::capsule;
        s.size = g.size;
        s.radius = g.radius;
        s.length = g.length;
        volume = shape_volume(s, {});
        const double wanted = given.value_or(density * volume);
        if (!(wanted > 0.0)) return;
        auto found = shape_mass(s, {}, wanted);
        if (!found) return;
        m = *found;
      }
    }
    mass = m.mass;
    const Mat3 R = shape.X.q.toRotationMatrix();
    *inertia = {m.mass, shape.X * m.com, R * m.inertia * R.transpose()};
  }

  // ---- the rest

  void section(const XmlElement& e) {
    if (e.name == "actuator") {
      for (const auto& c : e.children) actuator(*c);
    } else if (e.name == "equality") {
      for (const auto& c : e.children) equality(*c);
    } else if (e.name == "contact") {
      for (const auto& c : e.children) {
        const std::string *a = c->find("body1"), *b = c->find("body2");
        if (c->name == "exclude" && a != nullptr && b != nullptr) {
          robot_.no_contact.emplace_back(*a, *b);
          context_.exact(c->at, fmt::format("no contact of '{}' and '{}'", *a, *b));
        } else {
          context_.left_out(c->at, quoted_name(*c), "contacts of single geoms are not read");
        }
      }
    } else if (e.name == "sensor") {
      for (const auto& c : e.children) sensor(*c);
    } else if (e.name == "keyframe") {
      for (const auto& c : e.children)
        context_.left_out(c->at, quoted_name(*c), "the robot starts at its zero");
    } else if (e.name == "tendon") {
      for (const auto& c : e.children)
        context_.left_out(c->at, quoted_name(*c), "the scene language has no tendons");
    } else if (e.name != "compiler" && e.name != "option" && e.name != "default" &&
               e.name != "asset" && e.name != "worldbody") {
      static const std::set<std::string> kSettings = {"size", "visual", "statistic", "custom",
                                                      "extension"};
      context_.left_out(e.at, fmt::format("<{}>", e.name),
                        kSettings.count(e.name) != 0 ? "concerns MuJoCo" : "is not read");
    }
  }

  void actuator(const XmlElement& source) {
    const XmlElement e = with_defaults(source, "");
    const std::string* of = e.find("joint");
    const int joint = of == nullptr ? -1 : robot_.joint(*of);
    if (joint < 0) {
      context_.left_out(source.at, quoted_name(source),
                        of == nullptr ? "drives no joint but a tendon, a site or a body"
                                      : fmt::format("there is no joint '{}'", *of));
      return;
    }
    RobotDrive out;
    out.name = name_of(source, "motor");
    out.joint = *of;
    out.at = source.at;
    double gear = 1.0;
    if (const std::string* text = e.find("gear")) {
      const auto v = context_.numbers(source, *text, 1, 6, "'gear'");
      if (v && !v->empty()) gear = (*v)[0];
    }
    double force = std::numeric_limits<double>::infinity();
    if (const std::string* text = e.find("forcerange")) {
      const auto v = context_.numbers(source, *text, 2, 2, "'forcerange'");
      if (v) force = std::max(std::abs((*v)[0]), std::abs((*v)[1]));
    }
    double control = std::numeric_limits<double>::infinity();
    if (const std::string* text = e.find("ctrlrange")) {
      const auto v = context_.numbers(source, *text, 2, 2, "'ctrlrange'");
      if (v) control = std::max(std::abs((*v)[0]), std::abs((*v)[1]));
    }
    const auto prm = [&](const char* name, std::size_t i, double otherwise) {
      const std::string* text = e.find(name);
      if (text == nullptr) return otherwise;
      const auto v = context_.numbers(source, *text, 0, 10, fmt::format("'{}'", name));
      return v && i < v->size() ? (*v)[i] : otherwise;
    };
    double kp = 0.0, kd = 0.0;
    std::string note;
    if (source.name == "motor") {
      out.mode = RobotDrive::Mode::torque;
      out.max_effort = std::min(force, control) * std::abs(gear);
      if (gear < 0.0) note = "its sign is turned: gear is negative";
    } else if (source.name == "position") {
      kp = context_.number(e, "kp", 1.0);
      kd = context_.number(e, "kv", 0.0);
    } else if (source.name == "velocity") {
      out.mode = RobotDrive::Mode::velocity;
      out.max_effort = force * std::abs(gear);
      note = "reaches its speed at once within its force, where MuJoCo's has the gain kv";
    } else if (source.name == "general") {
      const double gain = prm("gainprm", 0, 1.0);
      const std::string* bias = e.find("biastype");
      if (bias != nullptr && *bias == "affine" && prm("biasprm", 1, 0.0) < 0.0) {
        kp = gain;
        kd = -prm("biasprm", 2, 0.0);
        if (std::abs(prm("biasprm", 1, 0.0) + gain) > 1e-9 * std::abs(gain))
          note = "gain and bias differ: the gain is taken";
      } else if (bias == nullptr || *bias == "none") {
        out.mode = RobotDrive::Mode::torque;
        out.max_effort = std::min(force, control * std::abs(gain)) * std::abs(gear);
      } else {
        context_.left_out(source.at, quoted_name(source), "its law is none that a motor has");
        return;
      }
    } else {
      context_.left_out(source.at, quoted_name(source),
                        fmt::format("there is no drive like <{}>", source.name));
      return;
    }
    if (kp > 0.0) {
      out.mode = RobotDrive::Mode::position;
      out.kp = kp * gear * gear;
      out.kd = kd * gear * gear;
      out.max_effort = force * std::abs(gear);
    }
    if (note.empty())
      context_.exact(source.at, quoted_name(source));
    else
      context_.approximate(source.at, quoted_name(source), note);
    robot_.drives.push_back(std::move(out));
  }

  void equality(const XmlElement& source) {
    const XmlElement e = with_defaults(source, "");
    if (const std::string* active = e.find("active"); active != nullptr && *active == "false") {
      context_.left_out(source.at, quoted_name(source), "is not active");
      return;
    }
    if (source.name == "joint") {
      const std::string *a = e.find("joint1"), *b = e.find("joint2");
      const int one = a == nullptr ? -1 : robot_.joint(*a);
      const int two = b == nullptr ? -1 : robot_.joint(*b);
      if (one < 0 || two < 0) {
        context_.left_out(source.at, quoted_name(source), "needs two joints of the model");
        return;
      }
      std::vector<double> poly = {0.0, 1.0};
      if (const std::string* text = e.find("polycoef"))
        poly = context_.numbers(source, *text, 1, 5, "'polycoef'").value_or(poly);
      poly.resize(5, 0.0);
      robot_.joints[static_cast<std::size_t>(one)].coupling = RobotCoupling{*b, poly[1], poly[0]};
      if (poly[2] != 0.0 || poly[3] != 0.0 || poly[4] != 0.0)
        context_.approximate(source.at, quoted_name(source), "only its linear part is taken");
      else
        context_.exact(source.at, quoted_name(source));
      return;
    }
    if (source.name == "connect" || source.name == "weld") {
      const std::string *a = e.find("body1"), *b = e.find("body2");
      const int one = a == nullptr ? -1 : robot_.link(*a);
      const int two = b == nullptr ? -1 : robot_.link(*b);
      if (one < 0 || (b != nullptr && two < 0)) {
        context_.left_out(source.at, quoted_name(source), "needs bodies of the model");
        return;
      }
      RobotJoint j;
      j.type = source.name == "connect" ? RobotJoint::Type::ball : RobotJoint::Type::fixed;
      j.name = name_of(source, source.name.c_str());
      j.at = source.at;
      // The anchor is given in body 1, which is the child here.
      j.parent = two;
      j.child = one;
      j.anchor = context_.vec3(e, "anchor", Vec3::Zero());
      robot_.loops.push_back(std::move(j));
      context_.approximate(source.at, quoted_name(source), "is rigid, where MuJoCo's is soft");
      return;
    }
    context_.left_out(source.at, quoted_name(source), "constraints of tendons are not read");
  }

  void sensor(const XmlElement& e) {
    const std::string* site = e.find("site");
    const std::string* joint = e.find("joint");
    RobotSensor out;
    out.name = name_of(e, e.name.c_str());
    out.at = e.at;
    const std::string& kind = e.name;
    if ((kind == "jointpos" || kind == "jointvel") && joint != nullptr &&
        robot_.joint(*joint) >= 0) {
      if (!encoders_.insert(*joint).second) {
        context_.exact(e.at, quoted_name(e), "the joint's encoder reads both");
        return;
      }
      out.element = "encoder";
      out.joint = *joint;
      const RobotJoint& j = robot_.joints[static_cast<std::size_t>(robot_.joint(*joint))];
      RobotLink& link = robot_.links[static_cast<std::size_t>(j.child)];
      context_.exact(e.at, quoted_name(e));
      link.sensors.push_back(std::move(out));
      return;
    }
    const auto known = site == nullptr ? sites_.end() : sites_.find(*site);
    if (known != sites_.end() && (kind == "gyro" || kind == "accelerometer" || kind == "touch" ||
                                  kind == "framequat" || kind == "framepos")) {
      out.element = kind == "touch" ? "contact" : kind[0] == 'f' ? "pose" : "imu";
      if (!at_site_.insert(out.element + *site).second) {
        context_.exact(e.at, quoted_name(e),
                       fmt::format("the {} at its site reads both", out.element));
        return;
      }
      out.X = known->second.second;
      RobotLink& link = robot_.links[static_cast<std::size_t>(robot_.link(known->second.first))];
      if (kind == "touch")
        context_.approximate(e.at, quoted_name(e), "reads all contacts of its body");
      else
        context_.exact(e.at, quoted_name(e));
      link.sensors.push_back(std::move(out));
      return;
    }
    context_.left_out(e.at, quoted_name(e), fmt::format("there is no sensor like <{}>", kind));
  }

  void contacts() {
    // Bits that are the same on all geoms need no pairs.
    bool differ = false;
    for (const Bits& b : bits_)
      if (b.type != 0 || b.affinity != 0)
        differ = differ || b.type != bits_.front().type || b.affinity != bits_.front().affinity;
    if (differ)
      context_.approximate(
          {}, "contype and conaffinity",
          "shapes whose bits are all 0 touch nothing; else all shapes touch each other");
    if (total_mass_ > 0.0)
      context_.left_out({}, "settotalmass", "masses are as the bodies have them");
  }

  struct Mesh {
    std::string path;
    Vec3 scale = Vec3::Ones();
    Source at;
  };
  struct Bits {
    unsigned type = 1, affinity = 1;
  };

  Context& context_;
  RobotModel robot_;
  std::map<std::string, Defaults> classes_;
  std::map<std::string, Mesh> meshes_;
  std::map<std::string, Result<MassProperties>> mesh_masses_;
  std::map<std::string, Color> materials_;
  std::map<std::string, std::pair<std::string, Pose>> sites_;  // link and pose
  std::map<std::string, std::string> free_names_;
  std::set<std::string> encoders_, at_site_, used_joints_;
  std::vector<Bits> bits_;
  bool degrees_ = true, auto_limits_ = true;
  std::string euler_ = "xyz", mesh_dir_, from_geoms_ = "auto";
  double bound_mass_ = 0.0, bound_inertia_ = 0.0, total_mass_ = -1.0;
  double first_group_ = 0.0, last_group_ = 5.0;
  int unnamed_ = 0;
};

}  // namespace

RobotModel read_mjcf(Context& context, const XmlElement& root) {
  auto copy = root.copy();
  return MjcfReader(context).read(*copy);
}

}  // namespace cogrsim::dsl::import

// SDF (sdformat.org, specification 1.4 to 1.11): models and worlds. Poses are resolved over the
// graph of `relative_to`; plugins are reported and left out.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "cogrsim/core/parameter.h"
#include "cogrsim/geometry/convex_hull.h"
#include "import/robot.h"

namespace cogrsim::dsl::import {

namespace {

/// Links, joints, frames and models by name, each with its pose relative to another.
struct RelativePose {
  std::string relative_to;  ///< empty: the model
  Pose X;
  bool busy = false, known = false;
  Pose X_M;  ///< in the model, once known
};

class SdfReader {
 public:
  explicit SdfReader(Context& context) : context_(context) {}

  RobotModel read(const XmlElement& root) {
    for (const auto& e : root.children) {
      if (e->name == "world")
        world(*e);
      else if (e->name == "model")
        model(*e, "", Pose(), 0);
      else if (e->name == "include")
        include(*e, "", Pose(), 0);
      else if (e->name == "light" || e->name == "actor")
        context_.left_out(e->at, quoted_name(*e), "concerns appearance only");
      else
        left_out(*e);
    }
    if (robot_.links.empty()) context_.refuse(root.at, "CG1405", "there is no link in it");
    return std::move(robot_);
  }

 private:
  void left_out(const XmlElement& e) {
    if (e.name == "plugin") {
      const std::string* file = e.find("filename");
      context_.left_out(e.at, fmt::format("plugin '{}'", file == nullptr ? "" : *file),
                        "what Gazebo's plugins do is not imported");
    } else {
      context_.left_out(e.at, quoted_name(e), fmt::format("<{}> is not read", e.name));
    }
  }

  static std::string text(const XmlElement& in, const char* tag) {
    const XmlElement* c = in.child(tag);
    return c == nullptr ? "" : c->text;
  }

  std::optional<double> value(const XmlElement* in, const char* tag) {
    const XmlElement* c = in == nullptr ? nullptr : in->child(tag);
    if (c == nullptr) return std::nullopt;
    if (c->text == "inf" || c->text == "INF" || c->text == "infinity")
      return std::numeric_limits<double>::infinity();
    if (c->text == "-inf" || c->text == "-INF" || c->text == "-infinity")
      return -std::numeric_limits<double>::infinity();
    const auto v = context_.numbers(*c, c->text, 1, 1, fmt::format("<{}>", tag));
    if (!v) return std::nullopt;
    return v->front();
  }

  std::optional<Vec3> vector(const XmlElement* in, const char* tag) {
    const XmlElement* c = in == nullptr ? nullptr : in->child(tag);
    if (c == nullptr) return std::nullopt;
    const auto v = context_.numbers(*c, c->text, 3, 3, fmt::format("<{}>", tag));
    if (!v) return std::nullopt;
    return Vec3((*v)[0], (*v)[1], (*v)[2]);
  }

  Pose pose(const XmlElement& in) {
    const XmlElement* c = in.child("pose");
    if (c == nullptr || c->text.empty()) return {};
    const std::string* format = c->find("rotation_format");
    const std::string* degrees = c->find("degrees");
    const bool quaternion = format != nullptr && *format == "quat_xyzw";
    const auto v = context_.numbers(*c, c->text, quaternion ? 7 : 6, quaternion ? 7 : 6, "<pose>");
    if (!v) return {};
    Pose out;
    out.p = Vec3((*v)[0], (*v)[1], (*v)[2]);
    if (quaternion) {
      const Quat q((*v)[6], (*v)[3], (*v)[4], (*v)[5]);
      if (q.norm() > 1e-9) out.q = q.normalized();
    } else {
      const double unit = degrees != nullptr && *degrees == "true" ? kPi / 180.0 : 1.0;
      out.q = from_rpy(unit * Vec3((*v)[3], (*v)[4], (*v)[5]));
    }
    return out;
  }

  static std::string relative_to(const XmlElement& in) {
    const XmlElement* c = in.child("pose");
    if (c == nullptr) return "";
    const std::string* to = c->find("relative_to");
    if (to == nullptr) to = c->find("frame");
    return to == nullptr ? "" : *to;
  }

  void world(const XmlElement& e) {
    if (robot_.name.empty() && e.find("name") != nullptr) robot_.name = *e.find("name");
    std::map<std::string, RelativePose> poses;
    for (const auto& c : e.children)
      if (c->name == "model" || c->name == "include" || c->name == "frame") {
        std::string name = c->find("name") != nullptr ? *c->find("name") : text(*c, "name");
        if (!name.empty()) poses[name] = {relative_to(*c), pose(*c), false, false, {}};
      }
    for (const auto& c : e.children) {
      if (c->name == "physics") {
        if (const auto step = value(c.get(), "max_step_size"); step && *step > 0.0)
          robot_.step = *step;
        context_.approximate(c->at, quoted_name(*c), "its step is taken");
      } else if (c->name == "gravity") {
        robot_.gravity = vector(&e, "gravity");
      } else if (c->name == "model") {
        model(*c, "", in_world(*c, poses), 0);
      } else if (c->name == "include") {
        include(*c, "", in_world(*c, poses), 0);
      } else if (c->name == "light" || c->name == "scene" || c->name == "gui" ||
                 c->name == "actor" || c->name == "atmosphere" || c->name == "magnetic_field" ||
                 c->name == "wind" || c->name == "audio" || c->name == "spherical_coordinates") {
        context_.left_out(c->at, quoted_name(*c), "concerns appearance or environment");
      } else if (c->name != "frame") {
        left_out(*c);
      }
    }
  }

  Pose in_world(const XmlElement& e, std::map<std::string, RelativePose>& poses) {
    const std::string to = relative_to(e);
    return to.empty() || to == "world" ? pose(e) : resolve(to, poses, e, 0) * pose(e);
  }

  Pose resolve(const std::string& name, std::map<std::string, RelativePose>& poses,
               const XmlElement& at, int depth) {
    if (name.empty() || name == "__model__" || name == "world") return {};
    const auto it = poses.find(name);
    if (it == poses.end()) {
      std::vector<std::string> known;
      for (const auto& [n, p] : poses) known.push_back(n);
      const std::string near = nearest_name(name, known);
      context_.error(at.at, "CG1408", fmt::format("there is no frame '{}'", name),
                     near.empty() ? "" : fmt::format("did you mean '{}'?", near));
      return {};
    }
    RelativePose& p = it->second;
    if (p.known) return p.X_M;
    if (p.busy || depth > 200) {
      context_.error(at.at, "CG1410",
                     fmt::format("frame '{}' is defined relative to itself", name));
      return {};
    }
    p.busy = true;
    p.X_M = resolve(p.relative_to, poses, at, depth + 1) * p.X;
    p.busy = false;
    p.known = true;
    return p.X_M;
  }

  void include(const XmlElement& e, const std::string& prefix, const Pose& X_W, int depth) {
    if (depth > 20)
      context_.refuse(e.at, "CG1402", "models include each other in a circle, or too deep");
    const std::string uri = text(e, "uri");
    std::string href = uri;
    auto path = context_.locate(href, e.at);
    if (!path)
      path = context_.locate(href + (href.empty() || href.back() == '/' ? "" : "/") + "model.sdf",
                             e.at);
    if (!path) {
      context_.left_out(e.at, fmt::format("include '{}'", uri), path.error().message);
      return;
    }
    auto root = context_.parse(*path, e.at);
    kept_.push_back(std::move(root));
    for (const auto& c : kept_.back()->children) {
      if (c->name != "model") continue;
      XmlElement& m = *c;
      const std::string name = text(e, "name");
      if (!name.empty())
        for (auto& [key, v] : m.attributes)
          if (key == "name") v = name;
      // The include's own pose replaces that of the model.
      const bool placed = e.child("pose") != nullptr;
      model(m, prefix, placed ? X_W : X_W * pose(m), depth + 1);
      return;
    }
    context_.left_out(e.at, fmt::format("include '{}'", uri), "there is no model in it");
  }

  void model(const XmlElement& e, const std::string& prefix, const Pose& X_given, int depth) {
    if (depth > 20) context_.refuse(e.at, "CG1402", "models are nested too deep");
    const std::string own = e.find("name") == nullptr ? "model" : *e.find("name");
    if (robot_.name.empty()) robot_.name = own;
    const Pose X_WM =
        depth == 0 && prefix.empty() && X_given.p == Vec3::Zero() && e.child("pose") != nullptr
            ? pose(e)
            : X_given;
    // One model keeps its names; several get those of their models before them.
    const std::string scope = prefix.empty() && models_++ == 0 ? "" : prefix + own + "_";
    const bool is_static = text(e, "static") == "true" || text(e, "static") == "1";
    std::map<std::string, RelativePose> poses;
    std::vector<const XmlElement*> links, joints;
    for (const auto& c : e.children) {
      const std::string name = c->find("name") == nullptr ? "" : *c->find("name");
      if (c->name == "link" && name.empty()) {
        context_.error(c->at, "CG1404", "a <link> without a name");
      } else if (c->name == "link") {
        poses[name] = {relative_to(*c), pose(*c), false, false, {}};
        links.push_back(c.get());
      } else if (c->name == "frame") {
        const std::string* to = c->find("attached_to");
        std::string relative = relative_to(*c);
        if (relative.empty() && to != nullptr) relative = *to;
        poses[name] = {relative, pose(*c), false, false, {}};
      } else if (c->name == "joint") {
        const std::string relative = relative_to(*c);
        poses[name] = {relative.empty() ? text(*c, "child") : relative, pose(*c), false, false, {}};
        joints.push_back(c.get());
      } else if (c->name == "model") {
        poses[name] = {relative_to(*c), pose(*c), false, false, {}};
      } else if (c->name == "plugin") {
        left_out(*c);
      }
    }
    for (const XmlElement* l : links)
      link(*l, scope, X_WM * resolve(*l->find("name"), poses, *l, 0), is_static);
    for (const auto& c : e.children) {
      if (c->name == "model")
        model(*c, scope.empty() ? own + "_" : scope,
              X_WM * resolve(c->find("name") == nullptr ? "" : *c->find("name"), poses, *c, 0),
              depth + 1);
      if (c->name == "include")
        include(*c, scope.empty() ? own + "_" : scope, X_WM * pose(*c), depth + 1);
    }
    for (const XmlElement* j : joints) joint(*j, scope, X_WM, poses);
    context_.exact(e.at, quoted_name(e));
  }

  void link(const XmlElement& e, const std::string& scope, const Pose& X_W, bool is_static) {
    RobotLink out;
    out.name = scope + *e.find("name");
    out.at = e.at;
    out.X = X_W;
    out.is_static = is_static;
    if (robot_.link(out.name) >= 0) {
      context_.error(e.at, "CG1407", fmt::format("a second link '{}'", out.name));
      return;
    }
    RobotInertia inertia;
    inertia.mass = 1.0;  // the specification's default
    inertia.I = Mat3::Identity();
    if (const XmlElement* i = e.child("inertial")) {
      inertia.mass = value(i, "mass").value_or(1.0);
      const Pose X = pose(*i);
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
    for (const auto& c : e.children) {
      if (c->name == "visual" || c->name == "collision") {
        shape(*c, out, c->name == "visual");
      } else if (c->name == "sensor") {
        context_.left_out(c->at, quoted_name(*c), "sensors of SDF are not read yet");
      } else if (c->name == "gravity") {
        if (c->text == "false" || c->text == "0") out.gravity_scale = 0.0;
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
        context_.left_out(s.at, fmt::format("mesh '{}'", text(s, "uri")), path.error().message);
        return false;
      }
      shape.mesh = *path;
      good = shape.scale.cwiseAbs().minCoeff() > 0.0;
      if (s.child("submesh") != nullptr)
        context_.approximate(s.at, quoted_name(e), "the whole mesh is taken, not its submesh");
    } else {
      context_.left_out(s.at, quoted_name(e), fmt::format("there is no shape <{}>", s.name));
      return false;
    }
    if (!good) context_.left_out(s.at, quoted_name(e), "the shape has no volume");
    return good;
  }

  void shape(const XmlElement& e, RobotLink& link, bool visual) {
    const XmlElement* g = e.child("geometry");
    if (g == nullptr || g->children.empty()) {
      context_.left_out(e.at, quoted_name(e), "has no geometry");
      return;
    }
    const XmlElement& s = *g->children.front();
    RobotShape out;
    out.at = e.at;
    out.X = pose(e);
    out.visible = visual;
    out.collides = !visual;
    if (e.find("name") != nullptr) out.name = *e.find("name");
    if (!geometry(e, s, link, out)) return;
    if (const XmlElement* m = e.child("material"))
      if (const XmlElement* d = m->child("diffuse")) {
        const auto v = context_.numbers(*d, d->text, 3, 4, "<diffuse>");
        if (v) out.color = Color{(*v)[0], (*v)[1], (*v)[2], v->size() > 3 ? (*v)[3] : 1.0};
      }
    if (const XmlElement* surface = e.child("surface"))
      if (const XmlElement* of = surface->child("friction")) friction(*of, out);
    context_.exact(e.at, quoted_name(e));
    link.shapes.push_back(std::move(out));
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

  void friction(const XmlElement& e, RobotShape& out) {
    const auto get = [&](const char* tag, const char* what) {
      const auto v = value(e.child(tag), what);
      return v && *v >= 0.0 && *v < 1e6 ? v : std::nullopt;
    };
    if (const auto mu = get("ode", "mu")) out.friction = *mu;
    out.rolling_friction = get("bullet", "rolling_friction").value_or(0.0);
    // Of a pressure on a patch of the radius R as Hertz has it: 3 pi / 16 mu R.
    out.spinning_friction = 3.0 * kPi / 16.0 * get("torsional", "coefficient").value_or(1.0) *
                            get("torsional", "patch_radius").value_or(0.0);
  }

  void joint(const XmlElement& e, const std::string& scope, const Pose& X_WM,
             std::map<std::string, RelativePose>& poses) {
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
    const auto index = [&](const std::string& link) {
      std::string full = scope + link;
      for (std::size_t i; (i = full.find("::")) != std::string::npos;) full.replace(i, 2, "_");
      int found = robot_.link(full);
      if (found < 0) found = robot_.link(robot_.name + "_" + full);
      return found;
    };
    out.child = index(child);
    out.parent = parent == "world" || parent.empty() ? -1 : index(parent);
    if (out.child < 0 || (out.parent < 0 && parent != "world")) {
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
    const Pose X_WC = robot_.links[out.child].X;
    const Pose X_WP = out.parent < 0 ? Pose() : robot_.links[out.parent].X;
    out.X_PC = X_WP.inverse() * X_WC;
    const Pose X_CJ = X_WC.inverse() * (X_WM * resolve(*name, poses, e, 0));
    out.anchor = X_CJ.p;
    const auto axis = [&](const XmlElement* a) {
      Vec3 v = vector(a, "xyz").value_or(Vec3::UnitZ());
      if (!(v.norm() > 1e-12)) v = Vec3::UnitZ();
      Quat q = X_CJ.q;  // the joint's frame, unless said
      if (const XmlElement* xyz = a == nullptr ? nullptr : a->child("xyz"))
        if (const std::string* in = xyz->find("expressed_in"); in != nullptr && !in->empty())
          q = X_WC.q.conjugate() * (X_WM * resolve(*in, poses, e, 0)).q;
      const std::string parent_frame = a == nullptr ? "" : text(*a, "use_parent_model_frame");
      if (parent_frame == "true" || parent_frame == "1") q = X_WC.q.conjugate() * X_WM.q;
      return Vec3((q * v).normalized());
    };
    const XmlElement* a = e.child("axis");
    out.axis = axis(a);
    out.axis2 = axis(e.child("axis2"));
    if (a != nullptr && (out.type == Type::hinge || out.type == Type::slider))
      axis_law(*a, scope, *type != "continuous", out);
    if (out.type == Type::screw) {
      const double thread =
          value(&e, "screw_thread_pitch").value_or(value(&e, "thread_pitch").value_or(1.0));
      out.pitch = thread;
      context_.approximate(e.at, quoted_name(e),
                           "check the sign of its pitch: versions of SDF differ");
    }
    if (*type == "revolute2") context_.exact(e.at, quoted_name(e), "is a universal joint");
    context_.exact(e.at, quoted_name(e));
    // A second joint on a link closes a loop, and one on a link that its parent hangs on.
    carrier_.resize(robot_.links.size(), kNoLink);
    int& carrier = carrier_[out.child];
    bool closes = carrier != kNoLink;
    for (int up = out.parent; up >= 0 && !closes; up = carrier_[up]) closes = up == out.child;
    if (!closes) carrier = out.parent;
    (closes ? robot_.loops : robot_.joints).push_back(std::move(out));
  }

  /// Limits, damping, friction, spring and coupling of the axis of a hinge or slider.
  void axis_law(const XmlElement& axis, const std::string& scope, bool bounded, RobotJoint& out) {
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
    if (const XmlElement* mimic = axis.child("mimic")) {
      RobotCoupling c;
      c.terms = {{scope + (mimic->find("joint") == nullptr ? "" : *mimic->find("joint")),
                  value(mimic, "multiplier").value_or(1.0)}};
      c.offset = value(mimic, "offset").value_or(0.0);
      out.coupling = c;
    }
  }

  Context& context_;
  RobotModel robot_;
  std::vector<std::unique_ptr<XmlElement>> kept_;
  static constexpr int kNoLink = -2;
  std::vector<int> carrier_;  ///< of each link: the link that its joint hangs on, or the world (-1)
  int models_ = 0;
};

}  // namespace

RobotModel read_sdf(Context& context, const XmlElement& root) {
  return SdfReader(context).read(root);
}

}  // namespace cogrsim::dsl::import

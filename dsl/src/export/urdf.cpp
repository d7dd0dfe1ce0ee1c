// URDF. The frame of a link is that of the joint above it: it has the axes of the body and its
// origin at that of M. Coordinates are 0 where F and M coincide, as in the scene.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/core/roll_pitch_yaw.h"
#include "export/export_tree.h"

namespace cogrsim::dsl::exporting {

namespace {

/// urdfdom requires bounds of revolute and prismatic joints.
constexpr double kUnbounded = 1e9;

class UrdfWriter {
 public:
  explicit UrdfWriter(ExportTree& tree)
      : tree_(tree), xml_("Written by cogrsim export from " + tree.model.name + ".") {}

  std::string write() {
    std::size_t roots = 0;
    bool held = false;
    for (const Link& l : tree_.links)
      if (l.parent < 0) {
        ++roots;
        held = held || l.grounded;
      }
    world_ = roots > 1 || held;
    xml_.begin("robot").with("name", tree_.title());
    if (world_) xml_.begin("link").with("name", "world").end();
    for (const Link& l : tree_.links) link(l);
    for (const Link& l : tree_.links) joint(l);
    for (const int j : tree_.loops)
      tree_.left_out(tree_.model.joints[ExportTree::index(j)].origin,
                     "joint '" + tree_.model.joints[ExportTree::index(j)].name + "'",
                     "closes a loop, and URDF describes trees");
    rest();
    xml_.end();
    return xml_.str();
  }

 private:
  const Body& body(const Link& l) const { return tree_.model.bodies[ExportTree::index(l.body)]; }
  /// Origin of the link's frame in the body.
  static Vec3 origin_of(const Link& l) { return l.joint >= 0 ? l.X_CM.p : Vec3::Zero(); }

  void pose(const char* name, const Pose& X) {
    xml_.begin(name).with("xyz", X.p).with("rpy", roll_pitch_yaw(X.q)).end();
  }

  void link(const Link& l) {
    const Body& b = body(l);
    const Pose X_LB(-origin_of(l), Quat(1, 0, 0, 0));
    xml_.begin("link").with("name", tree_.body_name(l.body));
    if (b.kind == BodyKind::dynamic) {
      xml_.begin("inertial");
      pose("origin", X_LB * Pose(b.com, Quat(1, 0, 0, 0)));
      xml_.begin("mass").with("value", b.mass).end();
      xml_.begin("inertia")
          .with("ixx", b.inertia(0, 0))
          .with("ixy", b.inertia(0, 1))
          .with("ixz", b.inertia(0, 2))
          .with("iyy", b.inertia(1, 1))
          .with("iyz", b.inertia(1, 2))
          .with("izz", b.inertia(2, 2))
          .end();
      xml_.end();
    }
    for (const Shape& s : b.shapes) shape(b, s, X_LB);
    xml_.end();
    const std::string element = "body '" + b.name + "'";
    if (b.kind == BodyKind::kinematic)
      tree_.approximate(b.origin, element, "is static; its prescribed motion is left out");
    else if (b.gravity_scale != 1.0)
      tree_.approximate(b.origin, element,
                        fmt::format("its gravity-scale {} is left out", number(b.gravity_scale)));
    else if (!b.V_WB.linear.isZero() || !b.V_WB.angular.isZero())
      tree_.approximate(b.origin, element, "its initial velocity is left out");
    else
      tree_.exact(b.origin, element);
  }

  void geometry(const Shape& s, const std::string& mesh) {
    xml_.begin("geometry");
    switch (s.type) {
      case ShapeType::box:
        xml_.begin("box").with("size", s.size).end();
        break;
      case ShapeType::sphere:
        xml_.begin("sphere").with("radius", s.radius).end();
        break;
      case ShapeType::cylinder:
      case ShapeType::capsule:
        xml_.begin("cylinder").with("radius", s.radius).with("length", s.length).end();
        break;
      default:
        xml_.begin("mesh").with("filename", mesh).end();
    }
    xml_.end();
  }

  /// One <visual> or <collision>.
  void part(const char* kind, const Shape& s, const Pose& X_LS, const std::string& mesh) {
    xml_.begin(kind);
    pose("origin", X_LS);
    geometry(s, mesh);
    if (std::string(kind) == "visual") {
      const Material& m = tree_.model.materials[ExportTree::index(s.material)];
      const Color& c = m.color;
      xml_.begin("material").with("name", fmt::format("material_{}", s.material));
      xml_.begin("color")
          .with("rgba",
                fmt::format("{} {} {} {}", number(c.r), number(c.g), number(c.b), number(c.a)))
          .end();
      xml_.end();
    }
    xml_.end();
  }

  void shape(const Body& b, const Shape& s, const Pose& X_LB) {
    const std::string element = fmt::format("{} of body '{}'", to_string(s.type), b.name);
    if (s.type == ShapeType::plane || s.type == ShapeType::heightmap) {
      tree_.left_out(s.origin, element, "URDF has no such shape");
      return;
    }
    const std::string mesh = s.type == ShapeType::mesh || s.type == ShapeType::convex_mesh
                                 ? tree_.mesh_file(s.mesh)
                                 : "";
    for (const char* kind : {"visual", "collision"}) {
      if (std::string(kind) == "visual" ? !s.visible : !s.collides) continue;
      part(kind, s, X_LB * s.X_BS, mesh);
      if (s.type == ShapeType::capsule)
        for (const double side : {-0.5, 0.5}) {
          Shape cap = s;
          cap.type = ShapeType::sphere;
          part(kind, cap, X_LB * s.X_BS * Pose(Vec3(0, 0, side * s.length), Quat(1, 0, 0, 0)),
               mesh);
        }
    }
    // A named material has an entry of its own.
    const Material& m = tree_.model.materials[ExportTree::index(s.material)];
    const std::string lost = s.collides && m.name.empty() ? lost_of(m, {}) : "";
    if (!lost.empty())
      tree_.approximate(s.origin, element, lost);
    else if (s.type == ShapeType::capsule)
      tree_.exact(s.origin, element, "is a cylinder and two spheres");
    else if (s.type == ShapeType::convex_mesh && s.collides)
      tree_.approximate(s.origin, element,
                        "whether it collides as its convex hull depends on the program that reads");
    else
      tree_.exact(s.origin, element);
  }

  /// A joint with one axis, or none.
  void joint_element(const std::string& name, const char* type, const std::string& parent,
                     const std::string& child, const Pose& X, const Vec3* axis,
                     const JointAxis* limits) {
    xml_.begin("joint").with("name", name).with("type", type);
    pose("origin", X);
    xml_.begin("parent").with("link", parent).end();
    xml_.begin("child").with("link", child).end();
    if (axis != nullptr) xml_.begin("axis").with("xyz", *axis).end();
    if (limits != nullptr) {
      if (std::string(type) != "continuous") {
        const double infinity = std::numeric_limits<double>::infinity();
        xml_.begin("limit")
            .with("lower", limits->lower == -infinity ? -kUnbounded : limits->lower)
            .with("upper", limits->upper == infinity ? kUnbounded : limits->upper)
            .with("effort", std::min(limits->max_effort, kUnbounded))
            .with("velocity", std::min(limits->max_speed, kUnbounded))
            .end();
      } else if (limits->max_effort < kUnbounded || limits->max_speed < kUnbounded) {
        xml_.begin("limit")
            .with("effort", std::min(limits->max_effort, kUnbounded))
            .with("velocity", std::min(limits->max_speed, kUnbounded))
            .end();
      }
      if (limits->damping > 0.0 || limits->friction > 0.0)
        xml_.begin("dynamics")
            .with("damping", limits->damping)
            .with("friction", limits->friction)
            .end();
    }
  }

  void joint(const Link& l) {
    const std::string child = tree_.body_name(l.body);
    const bool root = l.parent < 0;
    if (l.joint < 0) {
      if (!world_) return;
      joint_element(tree_.unique_name("joint", child + "_joint"), l.grounded ? "fixed" : "floating",
                    "world", child, body(l).X_WB, nullptr, nullptr);
      xml_.end();
      return;
    }
    const Joint& j = tree_.model.joints[ExportTree::index(l.joint)];
    const std::string element = "joint '" + j.name + "'";
    const std::string parent =
        root ? "world" : tree_.body_name(tree_.links[ExportTree::index(l.parent)].body);
    Vec3 shift = Vec3::Zero();
    if (!root) shift = -origin_of(tree_.links[ExportTree::index(l.parent)]);
    const std::string name = tree_.joint_name(l.joint);
    // From the parent's link to this one at q = 0.
    const Pose X_LF = Pose(shift, Quat(1, 0, 0, 0)) * l.X_PF;
    const Quat q_ML = l.X_CM.q.conjugate();
    const Pose X_LL = X_LF * Pose(Vec3::Zero(), q_ML);
    std::vector<AxisStep> steps = axis_steps(j.type);
    std::string note;
    bool lossy = false;
    if (j.type == JointType::fixed || j.type == JointType::free) {
      joint_element(name, j.type == JointType::fixed ? "fixed" : "floating", parent, child, X_LL,
                    nullptr, nullptr);
      xml_.end();
    } else {
      if (j.type == JointType::ball) {
        steps = {{true, true, Vec3::UnitX()}, {true, true, Vec3::UnitY()}, {}};
        note = "three revolute joints about x, y and z, singular at 90 degrees of the second";
        lossy = true;
      } else if (steps.size() > 1) {
        note = fmt::format("{} joints with links without mass between them", steps.size());
      }
      chain(j, name, parent, child, X_LF, q_ML, steps);
    }
    for (std::size_t i = 0; i < j.axes.size(); ++i) {
      const JointAxis& a = j.axes[i];
      const auto lose = [&](const std::string& what) {
        note += (note.empty() ? "" : "; ") + what;
        lossy = true;
      };
      if (a.stiffness != 0.0) lose(fmt::format("its spring {} is left out", number(a.stiffness)));
      if (a.rotor_inertia != 0.0)
        lose(fmt::format("its rotor inertia {} is left out", number(a.rotor_inertia)));
      if (j.type == JointType::ball && a.has_limit()) lose("its limit is left out");
    }
    for (const double q : j.position)
      if (j.type != JointType::ball && j.type != JointType::free && q != 0.0) {
        note += (note.empty() ? "" : "; ") +
                fmt::format("its initial position {} is left out: URDF has none", number(q));
        lossy = true;
        break;
      }
    if (lossy)
      tree_.approximate(j.origin, element, note);
    else
      tree_.exact(j.origin, element, note);
  }

  /// The axes of a joint, one after the other.
  void chain(const Joint& j, const std::string& name, const std::string& parent,
             const std::string& child, const Pose& X_LF, const Quat& q_ML,
             const std::vector<AxisStep>& steps) {
    std::string from = parent;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const bool last = i + 1 == steps.size();
      std::string to = child;
      if (!last) {
        to = tree_.unique_name("body", fmt::format("{}_link_{}", name, i + 1));
        extra_links_.push_back(to);
      }
      // Links between have the axes of F; the last has those of the child.
      const Pose X = (i == 0 ? X_LF : Pose()) * Pose(Vec3::Zero(), last ? q_ML : Quat(1, 0, 0, 0));
      const Vec3 axis = last ? Vec3(q_ML.conjugate() * steps[i].direction) : steps[i].direction;
      const JointAxis limits = i < j.axes.size() ? j.axes[i] : JointAxis();
      const std::string own =
          i == 0 ? name : tree_.unique_name("joint", fmt::format("{}_{}", name, i + 1));
      joint_element(own,
                    !steps[i].turns      ? "prismatic"
                    : limits.has_limit() ? "revolute"
                                         : "continuous",
                    from, to, X, &axis, &limits);
      if (j.type == JointType::screw && i == 1)
        xml_.begin("mimic").with("joint", name).with("multiplier", j.pitch / (2.0 * M_PI)).end();
      if (i == 0) mimic(j);
      xml_.end();
      from = to;
    }
  }

  /// A coupling with one term is a mimic joint.
  void mimic(const Joint& j) {
    for (const Coupling& c : tree_.model.couplings) {
      if (c.removed || &tree_.model.joints[ExportTree::index(c.joint)] != &j ||
          c.terms.size() != 1 || tree_.joint_name(c.terms[0].joint).empty())
        continue;
      xml_.begin("mimic")
          .with("joint", tree_.joint_name(c.terms[0].joint))
          .with("multiplier", c.terms[0].ratio)
          .with("offset", c.offset)
          .end();
      if (c.max_effort < kUnbounded)
        tree_.approximate(c.origin, "coupling '" + c.name + "'", "its effort is not bounded");
      else
        tree_.exact(c.origin, "coupling '" + c.name + "'", "is a mimic joint");
      coupled_.insert(&c);
      return;
    }
  }

  void rest() {
    for (const std::string& name : extra_links_) xml_.begin("link").with("name", name).end();
    const SceneModel& m = tree_.model;
    for (const NamedFrame& f : m.frames) {
      if (f.removed || f.body < 0 || tree_.link_of(f.body) < 0) continue;
      const Link& l = tree_.links[ExportTree::index(tree_.link_of(f.body))];
      const std::string name = tree_.unique_name("body", f.name);
      xml_.begin("link").with("name", name).end();
      joint_element(tree_.unique_name("joint", name + "_joint"), "fixed", tree_.body_name(f.body),
                    name, Pose(-origin_of(l), Quat(1, 0, 0, 0)) * f.X_BF, nullptr, nullptr);
      xml_.end();
      tree_.exact(f.origin, "frame '" + f.name + "'", "is a link without mass");
    }
    const auto all = [&](const auto& list, const char* kind, const char* reason) {
      for (const auto& e : list)
        if (!e.removed && tree_.selected(e.assembly))
          tree_.left_out(e.origin, fmt::format("{} '{}'", kind, e.name), reason);
    };
    for (const Coupling& c : m.couplings)
      if (!c.removed && tree_.selected(c.assembly) && coupled_.count(&c) == 0)
        tree_.left_out(c.origin, "coupling '" + c.name + "'",
                       "a joint of URDF mimics one joint, once");
    all(m.motors, "motor", "URDF has no control laws; the joint has the bounds");
    for (const SensorModel& s : m.sensors)
      if (!s.removed && tree_.selected(s.assembly))
        tree_.left_out(s.origin, fmt::format("{} '{}'", s.type, s.name), "URDF has no sensors");
    all(m.forces, "force", "URDF has no forces");
    for (const Material& material : m.materials)
      if (!material.name.empty())
        tree_.approximate(material.origin, "material '" + material.name + "'",
                          fmt::format("only its colour is written, without friction {} and "
                                      "restitution {}",
                                      number(material.friction), number(material.restitution)));
    for (const auto& [a, b] : m.no_collide)
      if (tree_.link_of(a) >= 0 && tree_.link_of(b) >= 0)
        tree_.left_out(
            {},
            fmt::format("collide between '{}' and '{}'", m.bodies[ExportTree::index(a)].name,
                        m.bodies[ExportTree::index(b)].name),
            "pairs that do not collide stand in an SRDF file");
    if (!tree_.options.assembly.empty()) return;
    for (const LightModel& light : m.lights)
      tree_.left_out(light.origin, "light '" + light.name + "'", "URDF has no lights");
    for (const ViewModel& view : m.views)
      tree_.left_out(view.origin, "view '" + view.name + "'", "URDF has no views");
    tree_.left_out(m.physics.origin, "physics", "URDF has no step, gravity or engine");
  }

  ExportTree& tree_;
  XmlWriter xml_;
  bool world_ = false;
  std::vector<std::string> extra_links_;
  std::set<const Coupling*> coupled_;
};

}  // namespace

std::string write_urdf(ExportTree& tree) { return UrdfWriter(tree).write(); }

}  // namespace cogrsim::dsl::exporting

// SDF 1.8. Links have their poses at time 0, where every coordinate of SDF is 0: limits and rest
// positions are shifted by the initial coordinates.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/core/roll_pitch_yaw.h"
#include "export/export_tree.h"

namespace cogrsim::dsl::exporting {

namespace {

class SdfWriter {
 public:
  explicit SdfWriter(ExportTree& tree)
      : tree_(tree), xml_("Written by cogrsim export from " + tree.model.name + ".") {}

  std::string write() {
    const SceneModel& m = tree_.model;
    const bool whole = tree_.options.assembly.empty();
    xml_.begin("sdf").with("version", "1.8");
    if (whole) {
      xml_.begin("world").with("name", tree_.title());
      xml_.begin("physics").with("name", "steps").with("type", "ignored");
      xml_.text("max_step_size", m.physics.step);
      xml_.text("real_time_factor", 1.0);
      xml_.end();
      xml_.text("gravity", numbers(m.physics.gravity));
      tree_.exact(m.physics.origin, "physics", "step and gravity; the engine is the program's");
      for (const LightModel& light : m.lights) this->light(light);
      for (const ViewModel& view : m.views)
        tree_.left_out(view.origin, "view '" + view.name + "'", "SDF has no views");
    }
    // Static bodies are models of their own, because SDF has static models and no static links.
    for (const Link& l : tree_.links)
      if (body(l).kind != BodyKind::dynamic) static_model(l);
    find_groups();
    for (std::size_t g = 0; g < tree_.links.size(); ++g)
      if (group_[g] == static_cast<int>(g)) model_of(static_cast<int>(g));
    if (whole) xml_.end();
    xml_.end();
    rest();
    return xml_.str();
  }

 private:
  const Body& body(const Link& l) const { return tree_.model.bodies[ExportTree::index(l.body)]; }

  void pose(const Pose& X, const std::string& relative_to = {}) {
    xml_.begin("pose");
    if (!relative_to.empty()) xml_.with("relative_to", relative_to);
    const Vec3 rpy = roll_pitch_yaw(X.q);
    xml_.raw(numbers(X.p) + " " + numbers(rpy));
    xml_.end();
  }

  /// Dynamic bodies that joints connect are one model: the index of the first of them, by link.
  void find_groups() {
    group_.assign(tree_.links.size(), -1);
    const auto first = [&](int link) {
      while (group_[ExportTree::index(link)] != link) link = group_[ExportTree::index(link)];
      return link;
    };
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      const Link& l = tree_.links[i];
      if (body(l).kind != BodyKind::dynamic) continue;
      const int above = l.parent < 0 ? -1 : group_[ExportTree::index(l.parent)];
      group_[i] = above < 0 ? static_cast<int>(i) : first(above);
    }
    for (const int j : tree_.loops) {
      const int a = tree_.link_of(tree_.model.joints[ExportTree::index(j)].parent);
      const int b = tree_.link_of(tree_.model.joints[ExportTree::index(j)].child);
      if (a < 0 || b < 0 || group_[ExportTree::index(a)] < 0 || group_[ExportTree::index(b)] < 0)
        continue;
      const int one = std::min(first(a), first(b)), two = std::max(first(a), first(b));
      group_[ExportTree::index(two)] = one;
    }
    for (int& g : group_)
      if (g >= 0) g = first(g);
  }

  void model_of(int group) {
    const SceneModel& m = tree_.model;
    const auto in = [&](int b) {
      const int link = tree_.link_of(b);
      return link >= 0 && group_[ExportTree::index(link)] == group;
    };
    const Body& base = body(tree_.links[ExportTree::index(group)]);
    const int top = top_level_assembly(m, base.assembly);
    xml_.begin("model").with(
        "name", tree_.unique_name("model", !tree_.options.assembly.empty() ? tree_.title()
                                           : top >= 0 ? m.assemblies[ExportTree::index(top)].name
                                                      : base.name));
    xml_.text("self_collide", "true");
    for (const Link& l : tree_.links)
      if (in(l.body)) link(l);
    for (const NamedFrame& f : m.frames)
      if (in(f.body)) frame(f);
    const auto joint_here = [&](int j) {
      const Joint& joint = m.joints[ExportTree::index(j)];
      return in(joint.child) || (in(joint.parent) && !group_member(joint.child));
    };
    for (const Link& l : tree_.links)
      if (l.joint >= 0 && joint_here(l.joint)) joint(l.joint);
    for (const int j : tree_.loops)
      if (joint_here(j)) joint(j);
    xml_.end();
  }
  bool group_member(int b) const {
    return tree_.link_of(b) >= 0 && group_[ExportTree::index(tree_.link_of(b))] >= 0;
  }

  void static_model(const Link& l) {
    const Body& b = body(l);
    xml_.begin("model").with("name", tree_.unique_name("model", b.name));
    xml_.text("static", "true");
    xml_.begin("link").with("name", tree_.body_name(l.body));
    pose(b.X_WB);
    shapes(b);
    xml_.end();
    xml_.end();
    if (b.kind == BodyKind::kinematic)
      tree_.approximate(b.origin, "body '" + b.name + "'",
                        "is static; its prescribed motion is left out");
    else
      tree_.exact(b.origin, "body '" + b.name + "'");
  }

  void link(const Link& l) {
    const Body& b = body(l);
    xml_.begin("link").with("name", tree_.body_name(l.body));
    pose(b.X_WB);
    xml_.begin("inertial");
    pose(Pose(b.com, Quat(1, 0, 0, 0)));
    xml_.text("mass", b.mass);
    xml_.begin("inertia");
    xml_.text("ixx", b.inertia(0, 0));
    xml_.text("ixy", b.inertia(0, 1));
    xml_.text("ixz", b.inertia(0, 2));
    xml_.text("iyy", b.inertia(1, 1));
    xml_.text("iyz", b.inertia(1, 2));
    xml_.text("izz", b.inertia(2, 2));
    xml_.end();
    xml_.end();
    if (b.gravity_scale == 0.0) xml_.text("gravity", "false");
    shapes(b);
    for (const SensorModel& s : tree_.model.sensors)
      if (!s.removed && s.body == l.body) sensor(s);
    xml_.end();
    const std::string element = "body '" + b.name + "'";
    if (b.gravity_scale != 0.0 && b.gravity_scale != 1.0)
      tree_.approximate(b.origin, element,
                        fmt::format("its gravity-scale {} is left out", number(b.gravity_scale)));
    else if (!b.V_WB.linear.isZero() || !b.V_WB.angular.isZero())
      tree_.approximate(b.origin, element, "its initial velocity is left out");
    else
      tree_.exact(b.origin, element);
  }

  void shapes(const Body& b) {
    for (std::size_t i = 0; i < b.shapes.size(); ++i) {
      const Shape& s = b.shapes[i];
      const std::string element = fmt::format("{} of body '{}'", to_string(s.type), b.name);
      if (s.type == ShapeType::heightmap) {
        tree_.left_out(s.origin, element, "SDF reads heights from an image, which rounds them");
        continue;
      }
      if (s.visible) part("visual", s, i);
      if (s.collides) part("collision", s, i);
      if (s.type == ShapeType::convex_mesh && s.collides)
        tree_.approximate(
            s.origin, element,
            "whether it collides as its convex hull depends on the program that reads");
      else
        tree_.exact(s.origin, element);
    }
  }

  void part(const std::string& kind, const Shape& s, std::size_t i) {
    xml_.begin(kind.c_str()).with("name", fmt::format("{}_{}", kind, i + 1));
    pose(s.X_BS);
    xml_.begin("geometry");
    switch (s.type) {
      case ShapeType::box:
        xml_.begin("box");
        xml_.text("size", numbers(s.size));
        break;
      case ShapeType::sphere:
        xml_.begin("sphere");
        xml_.text("radius", s.radius);
        break;
      case ShapeType::cylinder:
      case ShapeType::capsule:
        xml_.begin(to_string(s.type));
        xml_.text("radius", s.radius);
        xml_.text("length", s.length);
        break;
      case ShapeType::plane:
        xml_.begin("plane");
        xml_.text("normal", "0 0 1");
        xml_.text("size", "100 100");
        break;
      default:
        xml_.begin("mesh");
        xml_.text("uri", tree_.mesh_file(s.mesh));
    }
    xml_.end();
    xml_.end();
    const Material& m = tree_.model.materials[ExportTree::index(s.material)];
    if (kind == "visual") {
      const std::string color = fmt::format("{} {} {} {}", number(m.color.r), number(m.color.g),
                                            number(m.color.b), number(m.color.a));
      xml_.begin("material");
      xml_.text("ambient", color);
      xml_.text("diffuse", color);
      xml_.end();
    } else {
      xml_.begin("surface");
      xml_.begin("friction");
      xml_.begin("ode");
      xml_.text("mu", m.friction);
      xml_.text("mu2", m.friction);
      xml_.end();
      if (m.rolling_friction > 0.0) {
        xml_.begin("bullet");
        xml_.text("rolling_friction", m.rolling_friction);
        xml_.end();
      }
      if (m.spinning_friction > 0.0) {
        // Of a pressure on a patch of the radius R as Hertz has it: 3 pi / 16 R.
        xml_.begin("torsional");
        xml_.text("coefficient", 1.0);
        xml_.text("use_patch_radius", "true");
        xml_.text("patch_radius", m.spinning_friction * 16.0 / (3.0 * M_PI));
        xml_.end();
      }
      xml_.end();
      xml_.begin("bounce");
      xml_.text("restitution_coefficient", m.restitution);
      xml_.text("threshold", tree_.model.physics.bounce_threshold);
      xml_.end();
      if (m.stiffness) {
        xml_.begin("contact");
        xml_.begin("ode");
        xml_.text("kp", *m.stiffness);
        xml_.end();
        xml_.end();
      }
      xml_.end();
    }
    xml_.end();
  }

  void frame(const NamedFrame& f) {
    if (f.removed) return;
    xml_.begin("frame")
        .with("name", tree_.unique_name("body", f.name))
        .with("attached_to", tree_.body_name(f.body));
    pose(f.X_BF);
    xml_.end();
    tree_.exact(f.origin, "frame '" + f.name + "'");
  }

  /// The name of a joint's body, from inside the model of the moving bodies.
  std::string link_name(int b) const {
    if (b < 0 || tree_.link_of(b) < 0) return "world";
    // A static body stands still in the world.
    return tree_.model.bodies[ExportTree::index(b)].kind == BodyKind::dynamic ? tree_.body_name(b)
                                                                              : "world";
  }

  /// SDF's name of a type; nullptr: it has none.
  static const char* joint_type(const Joint& j) {
    switch (j.type) {
      case JointType::fixed:
        return "fixed";
      case JointType::hinge:
        return j.axes[0].has_limit() ? "revolute" : "continuous";
      case JointType::slider:
        return "prismatic";
      case JointType::screw:
        return "screw";
      case JointType::universal:
        return "universal";
      case JointType::ball:
        return "ball";
      default:
        return nullptr;
    }
  }

  void joint(int index) {
    const Joint& j = tree_.model.joints[ExportTree::index(index)];
    const std::string element = "joint '" + j.name + "'";
    if (j.type == JointType::free) {
      tree_.exact(j.origin, element, "is no element: both bodies are free");
      return;
    }
    const char* const type = joint_type(j);
    if (type == nullptr) {
      tree_.left_out(
          j.origin, element,
          fmt::format("SDF has no {} joint; its bodies are not connected", to_string(j.type)));
      return;
    }
    const std::string parent = link_name(j.parent), child = link_name(j.child);
    if (parent == child || child == "world") {
      tree_.left_out(j.origin, element, "its child is static");
      return;
    }
    xml_.begin("joint").with("name", tree_.joint_name(index)).with("type", type);
    pose(j.X_CM, child);
    xml_.text("parent", parent);
    xml_.text("child", child);
    std::string note;
    bool lossy = false;
    const auto lose = [&](const std::string& what) {
      note += (note.empty() ? "" : "; ") + what;
      lossy = true;
    };
    if (j.type == JointType::screw) xml_.text("screw_thread_pitch", j.pitch);
    for (std::size_t i = 0; i < j.axes.size() && j.type != JointType::ball; ++i) {
      const JointAxis& a = j.axes[i];
      const double q0 = i < j.position.size() ? j.position[i] : 0.0;
      Vec3 direction = Vec3::UnitZ();
      if (j.type == JointType::universal) {
        // In M at time 0: x of F, turned back by the second angle, then y of M.
        direction = Vec3::UnitY();
        if (i == 0) {
          const double b = j.position.size() > 1 ? j.position[1] : 0.0;
          direction = Vec3(std::cos(b), 0.0, std::sin(b));
        }
      }
      xml_.begin(i == 0 ? "axis" : "axis2");
      xml_.text("xyz", numbers(direction));
      xml_.begin("limit");
      const double infinity = std::numeric_limits<double>::infinity();
      xml_.text("lower", a.lower == -infinity ? -1e16 : a.lower - q0);
      xml_.text("upper", a.upper == infinity ? 1e16 : a.upper - q0);
      if (a.max_effort < infinity) xml_.text("effort", a.max_effort);
      if (a.max_speed < infinity) xml_.text("velocity", a.max_speed);
      xml_.end();
      if (a.damping > 0.0 || a.friction > 0.0 || a.stiffness > 0.0) {
        xml_.begin("dynamics");
        xml_.text("damping", a.damping);
        xml_.text("friction", a.friction);
        xml_.text("spring_reference", a.rest - q0);
        xml_.text("spring_stiffness", a.stiffness);
        xml_.end();
      }
      xml_.end();
      if (a.rotor_inertia != 0.0)
        lose(fmt::format("its rotor inertia {} is left out", number(a.rotor_inertia)));
      if (q0 != 0.0)
        note += (note.empty() ? "" : "; ") +
                fmt::format("its zero is the initial position {}", number(q0));
    }
    if (j.type == JointType::ball && !j.axes.empty() &&
        (j.axes[0].has_limit() || j.axes[0].damping > 0.0 || j.axes[0].friction > 0.0 ||
         j.axes[0].stiffness > 0.0))
      lose("its limit, damping, friction and spring are left out");
    xml_.end();
    if (lossy)
      tree_.approximate(j.origin, element, note);
    else
      tree_.exact(j.origin, element, note);
  }

  static double parameter(const SensorModel& s, const char* name, std::size_t i, double otherwise) {
    const auto found = s.parameters.find(name);
    if (found == s.parameters.end()) return otherwise;
    if (const double* x = std::get_if<double>(&found->second)) return *x;
    if (const std::int64_t* n = std::get_if<std::int64_t>(&found->second))
      return static_cast<double>(*n);
    const auto* list = std::get_if<std::vector<double>>(&found->second);
    return list != nullptr && i < list->size() ? (*list)[i] : otherwise;
  }

  void scan(const char* name, double samples, double fov) {
    xml_.begin(name);
    xml_.text("samples", samples);
    xml_.text("min_angle", samples > 1 ? -0.5 * fov : 0.0);
    xml_.text("max_angle", samples > 1 ? 0.5 * fov : 0.0);
    xml_.end();
  }

  void sensor(const SensorModel& s) {
    const char* type = s.type == "imu"        ? "imu"
                       : s.type == "camera"   ? "camera"
                       : s.type == "lidar"    ? "gpu_lidar"
                       : s.type == "infrared" ? "gpu_lidar"
                       : s.type == "contact"  ? "contact"
                                              : nullptr;
    const std::string element = fmt::format("{} '{}'", s.type, s.name);
    if (type == nullptr) return;  // rest() reports it
    xml_.begin("sensor").with("name", tree_.unique_name("sensor", s.name)).with("type", type);
    pose(s.X_BS);
    xml_.text("update_rate", s.rate > 0.0 ? s.rate : 1.0 / tree_.model.physics.step);
    if (s.type == "camera") {
      xml_.begin("camera");
      xml_.text("horizontal_fov", parameter(s, "fov", 0, M_PI / 3.0));
      xml_.begin("image");
      xml_.text("width", parameter(s, "resolution", 0, 320.0));
      xml_.text("height", parameter(s, "resolution", 1, 240.0));
      xml_.end();
      xml_.begin("clip");
      xml_.text("near", parameter(s, "near", 0, 0.01));
      xml_.text("far", parameter(s, "far", 0, 100.0));
      xml_.end();
      xml_.end();
    } else if (s.type == "lidar" || s.type == "infrared") {
      const bool lidar = s.type == "lidar";
      xml_.begin("lidar");
      xml_.begin("scan");
      scan("horizontal", lidar ? parameter(s, "rays", 0, 360.0) : 1.0,
           lidar ? parameter(s, "fov", 0, 2.0 * M_PI) : 0.0);
      scan("vertical", lidar ? parameter(s, "rings", 0, 1.0) : 1.0,
           lidar ? parameter(s, "vertical-fov", 0, M_PI / 6.0) : 0.0);
      xml_.end();
      xml_.begin("range");
      xml_.text("min", parameter(s, "range", 0, 0.0));
      xml_.text("max", parameter(s, "range", 1, lidar ? 30.0 : 10.0));
      xml_.end();
      xml_.end();
    } else if (s.type == "contact") {
      xml_.begin("contact");
      std::size_t i = 0;
      for (const Shape& shape : tree_.model.bodies[ExportTree::index(s.body)].shapes)
        if (++i, shape.collides) xml_.text("collision", fmt::format("collision_{}", i));
      xml_.end();
    }
    xml_.end();
    written_.insert(&s);
    if (!s.noise.empty() || s.latency > 0.0)
      tree_.approximate(s.origin, element, "its noise and latency are left out");
    else if (s.type == "infrared")
      tree_.approximate(s.origin, element, "is a lidar with one ray");
    else
      tree_.exact(s.origin, element);
  }

  void light(const LightModel& l) {
    const char* type = l.type == LightModel::Type::directional ? "directional"
                       : l.type == LightModel::Type::point     ? "point"
                                                               : "spot";
    xml_.begin("light").with("name", tree_.unique_name("light", l.name)).with("type", type);
    pose(l.X_WL);
    xml_.text("cast_shadows", l.shadows ? "true" : "false");
    const std::string color =
        numbers(l.intensity * Vec3(l.color.r, l.color.g, l.color.b).cwiseMin(1.0)) + " 1";
    xml_.text("diffuse", color);
    xml_.text("direction", "1 0 0");
    if (l.type == LightModel::Type::spot) {
      xml_.begin("spot");
      xml_.text("inner_angle", 0.0);
      xml_.text("outer_angle", 2.0 * l.cone);
      xml_.text("falloff", 1.0);
      xml_.end();
    }
    xml_.end();
    tree_.approximate(l.origin, "light '" + l.name + "'",
                      "its brightness depends on the program that reads");
  }

  void rest() {
    const SceneModel& m = tree_.model;
    const auto all = [&](const auto& list, const char* kind, const char* reason) {
      for (const auto& e : list)
        if (!e.removed && tree_.selected(e.assembly))
          tree_.left_out(e.origin, fmt::format("{} '{}'", kind, e.name), reason);
    };
    all(m.couplings, "coupling", "SDF 1.8 has none; later versions have mimic");
    all(m.motors, "motor", "SDF leaves drives to plugins");
    all(m.forces, "force", "SDF leaves forces to plugins");
    for (const NamedFrame& f : m.frames)
      if (!f.removed && tree_.selected(f.assembly) && !group_member(f.body))
        tree_.left_out(f.origin, "frame '" + f.name + "'", "is on a static body");
    for (const SensorModel& s : m.sensors)
      if (!s.removed && tree_.selected(s.assembly) && written_.count(&s) == 0)
        tree_.left_out(s.origin, fmt::format("{} '{}'", s.type, s.name),
                       "SDF has no sensor of this kind on this body");
    for (const Material& material : m.materials)
      if (!material.name.empty()) {
        const std::string element = "material '" + material.name + "'";
        if (!material.texture.empty())
          tree_.approximate(material.origin, element, "its texture is left out");
        else
          tree_.exact(material.origin, element);
      }
    tree_.report_pairs("Gazebo's engines take the smaller of two", CombineRule::min);
    for (const MaterialPair& pair : m.material_pairs)
      tree_.left_out(pair.origin, "contact between materials",
                     "SDF combines the values of the two shapes");
    for (const auto& [a, b] : m.no_collide)
      if (tree_.link_of(a) >= 0 && tree_.link_of(b) >= 0)
        tree_.left_out(
            {},
            fmt::format("collide between '{}' and '{}'", m.bodies[ExportTree::index(a)].name,
                        m.bodies[ExportTree::index(b)].name),
            "SDF has no pairs that do not collide");
  }

  ExportTree& tree_;
  XmlWriter xml_;
  std::vector<int> group_;  ///< by link; -1: static
  std::set<const SensorModel*> written_;
};

}  // namespace

std::string write_sdf(ExportTree& tree) { return SdfWriter(tree).write(); }

}  // namespace cogrsim::dsl::exporting

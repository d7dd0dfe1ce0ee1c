// URDF (wiki.ros.org/urdf/XML) and what Gazebo and ROS write into it; SRDF.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "assets/mesh_text.h"
#include "cogrsim/core/parameter.h"
#include "import/gazebo.h"

namespace cogrsim::dsl::import {

namespace {

class UrdfReader {
 public:
  explicit UrdfReader(Context& context) : context_(context) {}

  RobotModel read(const XmlElement& root) {
    if (const std::string* name = root.find("name")) robot_.name = *name;
    for (const auto& e : root.children)
      if (e->name == "material") material(*e, true);
    for (const auto& e : root.children)
      if (e->name == "link") link(*e);
    for (const auto& e : root.children)
      if (e->name == "joint") joint(*e);
    for (const auto& e : root.children) other(*e);
    if (robot_.links.empty()) context_.refuse(root.at, "CG1405", "the robot has no link");
    if (!context_.failed()) check_tree(root);  // a joint that was not understood would be missing
    return std::move(robot_);
  }

 private:
  // An element that this reader does not know is never passed over in silence.
  void unknown(const XmlElement& e, const XmlElement& in, const std::vector<std::string>& known) {
    const std::string near = context_.near(e.name, known);
    context_.left_out(e.at, fmt::format("<{}> of {}", e.name, quoted_name(in)),
                      near.empty()
                          ? "is not an element of URDF"
                          : fmt::format("is not an element of URDF; did you mean <{}>?", near));
  }

  Pose origin(const XmlElement& in) {
    const XmlElement* o = in.child("origin");
    if (o == nullptr) return {};
    Pose out;
    out.p = context_.vec3(*o, "xyz", Vec3::Zero());
    out.q = from_rpy(context_.vec3(*o, "rpy", Vec3::Zero()));
    return out;
  }

  std::optional<Color> color(const XmlElement& e) {
    const XmlElement* c = e.child("color");
    const std::string* text = c == nullptr ? nullptr : c->find("rgba");
    if (text == nullptr) return std::nullopt;
    const auto v = context_.numbers(*c, *text, 3, 4, "'rgba'");
    if (!v) return std::nullopt;
    const auto part = [](double x) { return std::clamp(x, 0.0, 1.0); };
    return Color{part((*v)[0]), part((*v)[1]), part((*v)[2]), v->size() > 3 ? part((*v)[3]) : 1.0};
  }

  struct Material {
    std::optional<Color> color;
    std::string texture;
  };

  Material material(const XmlElement& e, bool global) {
    Material out;
    out.color = color(e);
    const std::string* name = e.find("name");
    if (const XmlElement* t = e.child("texture"))
      if (const std::string* file = t->find("filename"); file != nullptr && !file->empty()) {
        auto found = context_.locate(*file, t->at);
        if (found)
          out.texture = *found;
        else
          context_.left_aside(t->at, "texture of " + quoted_name(e), found.error().message);
      }
    if (name != nullptr && !name->empty()) {
      if (out.color || !out.texture.empty())
        materials_[*name] = out;
      else if (const auto known = materials_.find(*name); known != materials_.end())
        return known->second;
      else if (!global)
        context_.left_aside(e.at, quoted_name(e), "nothing defines this material");
    }
    return out;
  }

  std::optional<Geometry> geometry(const XmlElement& in) {
    const XmlElement* g = in.child("geometry");
    if (g == nullptr || g->children.empty()) {
      context_.error(in.at, "CG1404", fmt::format("<{}> has no <geometry> with a shape", in.name));
      return std::nullopt;
    }
    const XmlElement& s = *g->children.front();
    Geometry out;
    if (s.name == "box") {
      out.type = Geometry::Type::box;
      out.size = context_.vec3(s, "size", Vec3::Zero());
      if (!(out.size.minCoeff() > 0.0)) return empty_shape(s);
    } else if (s.name == "sphere") {
      out.type = Geometry::Type::sphere;
      out.radius = context_.number(s, "radius", 0.0);
      if (!(out.radius > 0.0)) return empty_shape(s);
    } else if (s.name == "cylinder" || s.name == "capsule") {
      out.type = s.name == "cylinder" ? Geometry::Type::cylinder : Geometry::Type::capsule;
      out.radius = context_.number(s, "radius", 0.0);
      out.length = context_.number(s, "length", 0.0);
      if (!(out.radius > 0.0) || !(out.length > 0.0)) return empty_shape(s);
    } else if (s.name == "mesh") {
      out.type = Geometry::Type::mesh;
      out.scale = scale(s);
      const std::string* file = s.find("filename");
      if (file == nullptr || file->empty()) {
        context_.error(s.at, "CG1404", "<mesh> has no filename");
        return std::nullopt;
      }
      if (out.scale.cwiseAbs().minCoeff() <= 0.0) return empty_shape(s);
      auto found = context_.locate(*file, s.at);
      if (!found) {
        context_.not_read(s.at, "mesh", *file, found.error());
        return std::nullopt;
      }
      out.mesh = *found;
    } else {
      unknown(s, in, {"box", "sphere", "cylinder", "capsule", "mesh"});
      return std::nullopt;
    }
    return out;
  }

  /// Three factors; one, as some programs write it, is that of all axes.
  Vec3 scale(const XmlElement& s) {
    const std::string* text = s.find("scale");
    if (text == nullptr) return Vec3::Ones();
    std::string_view rest = *text;
    next_word(rest);
    if (!next_word(rest).empty()) return context_.vec3(s, "scale", Vec3::Ones());
    context_.exact(s.at, "scale of <mesh>", "has one factor, which is taken for all axes");
    return Vec3::Constant(context_.number(s, "scale", 1.0));
  }

  std::optional<Geometry> empty_shape(const XmlElement& s) {
    context_.left_out(s.at, fmt::format("<{}>", s.name), "the shape has no volume");
    return std::nullopt;
  }

  void shape(const XmlElement& e, RobotLink& link, bool visual) {
    const auto g = geometry(e);
    if (!g) return void(link.has_lost_shape = true);
    RobotShape out;
    if (const std::string* name = e.find("name")) out.name = *name;
    out.X = origin(e);
    out.geometry = *g;
    out.visible = visual;
    out.collides = !visual;
    out.at = e.at;
    if (const XmlElement* m = e.child("material"); m != nullptr && visual) {
      Material look = material(*m, false);
      out.color = look.color;
      out.texture = look.texture;
    }
    link.shapes.push_back(std::move(out));
  }

  std::optional<RobotInertia> inertial(const XmlElement& e, const std::string& link) {
    RobotInertia out;
    const XmlElement* mass = e.child("mass");
    out.mass = mass == nullptr ? 0.0 : context_.number(*mass, "value", 0.0);
    if (out.mass < 0.0) {
      context_.error(e.at, "CG1406", fmt::format("link '{}' has a mass of {} kg", link, out.mass),
                     "a mass is not negative");
      return std::nullopt;
    }
    const Pose X = origin(e);
    out.com = X.p;
    if (const XmlElement* i = e.child("inertia")) {
      std::string missing;
      const auto v = [&](const char* name) { return context_.number(*i, name, 0.0); };
      for (const char* name : {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"})
        if (i->find(name) == nullptr) missing += (missing.empty() ? "" : ", ") + std::string(name);
      if (!missing.empty())
        context_.approximate(i->at, fmt::format("inertia of link '{}'", link),
                             fmt::format("does not give {}, which is read as 0", missing));
      Mat3 I;
      I << v("ixx"), v("ixy"), v("ixz"), v("ixy"), v("iyy"), v("iyz"), v("ixz"), v("iyz"), v("izz");
      const Mat3 R = X.q.toRotationMatrix();
      out.I = R * I * R.transpose();
    }
    if (out.mass == 0.0) {
      if (out.I.cwiseAbs().maxCoeff() > 0.0)
        context_.left_out(e.at, fmt::format("inertia of link '{}'", link), "the link has no mass");
      return std::nullopt;
    }
    return out;
  }

  /// Bullet's <contact> of a link: frictions of all its shapes.
  void contact_of(const XmlElement& e, RobotLink& link) {
    for (const auto& c : e.children) {
      const std::string what = fmt::format("<{}> of link '{}'", c->name, link.name);
      const double value = std::max(0.0, context_.number(*c, "value", 0.0));
      const bool lateral = c->name == "lateral_friction", rolling = c->name == "rolling_friction";
      if (!lateral && !rolling && c->name != "spinning_friction") {
        context_.left_out(c->at, what, "concerns Bullet");
        continue;
      }
      for (RobotShape& s : link.shapes) {
        if (lateral) {
          s.friction = value;
          s.friction_combine = CombineRule::multiply;
        } else {
          (rolling ? s.rolling_friction : s.spinning_friction) = value;
        }
      }
      context_.exact(c->at, what);
    }
  }

  void link(const XmlElement& e) {
    RobotLink out;
    const std::string* name = e.find("name");
    if (name == nullptr || name->empty()) {
      context_.error(e.at, "CG1404", "a <link> without a name");
      return;
    }
    out.name = *name;
    out.at = e.at;
    if (robot_.link(*name) >= 0) {
      context_.error(e.at, "CG1407", fmt::format("a second link '{}'", *name));
      return;
    }
    std::size_t visuals = 0, collisions = 0;
    const XmlElement* contact = nullptr;
    for (const auto& c : e.children) {
      if (c->name == "inertial") {
        out.inertia = inertial(*c, *name);
      } else if (c->name == "visual") {
        shape(*c, out, true);
        ++visuals;
      } else if (c->name == "collision") {
        shape(*c, out, false);
        ++collisions;
      } else if (c->name == "contact") {
        contact = c.get();
      } else {
        unknown(*c, e, {"inertial", "visual", "collision", "contact"});
      }
    }
    if (contact != nullptr) contact_of(*contact, out);
    context_.exact(e.at, quoted_name(e),
                   visuals > 0 && collisions == 0 ? "has no collision shape: touches nothing" : "");
    robot_.links.push_back(std::move(out));
  }

  void joint(const XmlElement& e) {
    RobotJoint out;
    const std::string* name = e.find("name");
    const std::string* type = e.find("type");
    if (name == nullptr || name->empty() || type == nullptr) {
      context_.error(e.at, "CG1404", "a <joint> needs name and type");
      return;
    }
    out.name = *name;
    out.at = e.at;
    if (robot_.joint(*name) >= 0) {
      context_.error(e.at, "CG1407", fmt::format("a second joint '{}'", *name));
      return;
    }
    out.parent = joint_end(e, *name, "parent");
    out.child = joint_end(e, *name, "child");
    if (out.parent < 0 || out.child < 0) return;
    out.X_PC = origin(e);
    if (!joint_type(e, *type, out) || !joint_axis(e, out)) return;
    limits(e, out, *type);
    if (const XmlElement* d = e.child("dynamics")) {
      out.damping = std::max(0.0, context_.number(*d, "damping", 0.0));
      out.friction = std::max(0.0, context_.number(*d, "friction", 0.0));
    }
    if (const XmlElement* m = e.child("mimic")) mimic(*m, out);
    for (const auto& c : e.children) {
      static const std::vector<std::string> kKnown = {"origin", "parent",      "child",
                                                      "axis",   "limit",       "dynamics",
                                                      "mimic",  "calibration", "safety_controller"};
      if (c->name == "calibration" || c->name == "safety_controller")
        context_.left_aside(c->at, fmt::format("<{}> of joint '{}'", c->name, *name),
                            "concerns the robot's driver, not its mechanics");
      else if (std::find(kKnown.begin(), kKnown.end(), c->name) == kKnown.end())
        unknown(*c, e, kKnown);
    }
    context_.exact(e.at, quoted_name(e));
    robot_.joints.push_back(std::move(out));
  }

  /// The help of an error: "did you mean 'base'?"; empty: no name is near.
  std::string suggestion(const std::string& wanted, const std::vector<std::string>& known) {
    const std::string near = context_.near(wanted, known);
    return near.empty() ? "" : fmt::format("did you mean '{}'?", near);
  }

  /// The link at one end of a joint; -1: none, which is reported.
  int joint_end(const XmlElement& e, const std::string& joint, const char* tag) {
    const XmlElement* c = e.child(tag);
    const std::string* link = c == nullptr ? nullptr : c->find("link");
    if (link == nullptr) {
      context_.error(e.at, "CG1404", fmt::format("joint '{}' has no <{} link=…>", joint, tag));
      return -1;
    }
    const int index = robot_.link(*link);
    if (index < 0 && *link == "world" && std::string_view(tag) == "parent") {
      RobotLink world;  // as if it were declared: check_tree() makes it the world
      world.name = *link;
      world.at = c->at;
      context_.exact(c->at, "link 'world'", "is not declared");
      robot_.links.push_back(std::move(world));
      return static_cast<int>(robot_.links.size()) - 1;
    }
    if (index < 0) {
      std::vector<std::string> known;
      for (const RobotLink& l : robot_.links) known.push_back(l.name);
      context_.error(c->at, "CG1408",
                     fmt::format("joint '{}': there is no link '{}'", joint, *link),
                     suggestion(*link, known));
    }
    return index;
  }

  bool joint_type(const XmlElement& e, const std::string& type, RobotJoint& out) {
    using Type = RobotJoint::Type;
    static const std::map<std::string, Type> kTypes = {
        {"revolute", Type::hinge}, {"continuous", Type::hinge}, {"prismatic", Type::slider},
        {"fixed", Type::fixed},    {"floating", Type::free},    {"planar", Type::planar},
        {"spherical", Type::ball}};  // Bullet's
    const auto known = kTypes.find(type);
    if (known != kTypes.end()) {
      out.type = known->second;
      return true;
    }
    std::vector<std::string> names;
    for (const auto& [word, t] : kTypes) names.push_back(word);
    context_.error(e.at, "CG1408", fmt::format("joint '{}': there is no type '{}'", out.name, type),
                   suggestion(type, names));
    return false;
  }

  bool joint_axis(const XmlElement& e, RobotJoint& out) {
    using Type = RobotJoint::Type;
    const XmlElement* axis = e.child("axis");
    if (axis == nullptr) return true;
    const Vec3 v = context_.vec3(*axis, "xyz", Vec3::UnitX());
    if (out.type == Type::fixed || out.type == Type::free || out.type == Type::ball) return true;
    if (!(v.norm() > 1e-12)) {
      context_.error(axis->at, "CG1409",
                     fmt::format("joint '{}' has an axis of length 0", out.name));
      return false;
    }
    out.axis = v.normalized();
    return true;
  }

  void mimic(const XmlElement& m, RobotJoint& out) {
    const std::string* of = m.find("joint");
    if (of == nullptr) {
      context_.error(m.at, "CG1404", fmt::format("joint '{}': <mimic> names no joint", out.name));
      return;
    }
    RobotCoupling coupling;
    coupling.terms = {{*of, context_.number(m, "multiplier", 1.0)}};
    coupling.offset = context_.number(m, "offset", 0.0);
    out.coupling = coupling;
  }

  void limits(const XmlElement& e, RobotJoint& out, const std::string& type) {
    using Type = RobotJoint::Type;
    const XmlElement* l = e.child("limit");
    if (l == nullptr) {
      if (type == "revolute" || type == "prismatic")
        context_.approximate(e.at, quoted_name(e),
                             "has no <limit>, which URDF requires: it moves without bounds");
      return;
    }
    if (out.type != Type::hinge && out.type != Type::slider) return;
    const auto bound = [&](const char* name, double& value, const char* effect) {
      const auto v = context_.number(*l, name);
      if (!v) return;
      if (*v > 0.0)
        value = *v;
      else
        context_.approximate(l->at, fmt::format("{} of joint '{}'", name, out.name),
                             fmt::format("is {}: {}", *v, effect));
    };
    bound("effort", out.max_effort, "taken for no bound");
    bound("velocity", out.max_speed, "taken for no bound");
    if (type == "continuous") return;
    out.lower = context_.number(*l, "lower", 0.0);
    out.upper = context_.number(*l, "upper", 0.0);
    if (out.lower > out.upper) {
      context_.approximate(
          l->at, fmt::format("limits of joint '{}'", out.name),
          fmt::format("lower {} is above upper {}: they were exchanged", out.lower, out.upper));
      std::swap(out.lower, out.upper);
    }
  }

  void other(const XmlElement& e) {
    if (e.name == "link" || e.name == "joint" || e.name == "material") return;
    if (e.name == "transmission") return transmission(e);
    if (e.name == "gazebo") return gazebo(e);
    if (e.name == "ros2_control" || e.name == "sensor" || e.name == "group_state") {
      context_.left_aside(e.at, fmt::format("<{}>", e.name), "concerns the robot's driver");
      return;
    }
    std::string message = "is not an element of URDF";
    const std::string near =
        context_.near(e.name, {"link", "joint", "material", "transmission", "gazebo"});
    if (!near.empty()) message += fmt::format("; did you mean <{}>?", near);
    context_.left_out(e.at, quoted_name(e), message);
  }

  void transmission(const XmlElement& e) {
    const XmlElement* j = e.child("joint");
    const std::string* name = j == nullptr ? nullptr : j->find("name");
    const int index = name == nullptr ? -1 : robot_.joint(*name);
    if (index < 0) {
      context_.left_out(e.at, quoted_name(e), "names no joint of the robot");
      return;
    }
    std::string interface;
    if (const XmlElement* i = j->child("hardwareInterface")) interface = i->text;
    RobotDrive drive;
    drive.joint = *name;
    drive.name = *name + "_motor";
    drive.at = e.at;
    drive.max_effort = robot_.joints[index].max_effort;
    if (interface.find("Position") != std::string::npos)
      drive.mode = RobotDrive::Mode::position;
    else if (interface.find("Velocity") != std::string::npos)
      drive.mode = RobotDrive::Mode::velocity;
    else
      drive.mode = RobotDrive::Mode::torque;
    if (context_.options.drives != ImportDrives::none) {
      context_.exact(e.at, quoted_name(e), "its joint gets the drive that was asked for");
      return;
    }
    context_.exact(e.at, quoted_name(e));
    robot_.drives.push_back(std::move(drive));
  }

  void gazebo(const XmlElement& e) {
    const std::string* reference = e.find("reference");
    const int link = reference == nullptr ? -1 : robot_.link(*reference);
    if (reference != nullptr && link < 0 && robot_.joint(*reference) < 0) {
      context_.left_out(e.at, "<gazebo>",
                        fmt::format("there is no link or joint '{}'", *reference));
      return;
    }
    for (const auto& c : e.children) {
      const std::string what =
          fmt::format("<{}> of <gazebo{}>", c->name, reference == nullptr ? "" : " " + *reference);
      // As a text, or as older files write it: <mu1 value="0.8"/>.
      const std::string* attribute = c->find("value");
      const std::string& text = attribute == nullptr ? c->text : *attribute;
      if (c->name == "mu1" && link >= 0) {
        const auto mu = context_.numbers(*c, text, 1, 1, "the friction");
        if (!mu || (*mu)[0] < 0.0) continue;
        context_.spend(robot_.links[link].shapes.size(), c->at);
        for (RobotShape& s : robot_.links[link].shapes) {
          s.friction = (*mu)[0];
          s.friction_combine = CombineRule::min;  // as Gazebo's engines do
        }
        context_.exact(c->at, what);
      } else if (c->name == "mu2" && link >= 0) {
        const XmlElement* one = e.child("mu1");
        if (one == nullptr || one->text != c->text)
          context_.approximate(c->at, what, "friction is the same in all directions: mu1 is taken");
      } else if (c->name == "sensor" && reference != nullptr) {
        sensor(*c, link, *reference);
      } else if (c->name == "plugin") {
        add_gazebo_plugin(context_, *c, robot_, [&](const std::string& joint) {
          return robot_.joint(joint) < 0 ? "" : joint;
        });
      } else {
        if (c->name == "material")
          context_.left_aside(c->at, what, "concerns Gazebo");
        else
          context_.left_out(c->at, what, "concerns Gazebo");
      }
    }
  }

  /// A sensor of a link, or with `link` < 0 of a joint.
  void sensor(const XmlElement& e, int link, const std::string& reference) {
    SensorMount mount;
    mount.X = child_pose(context_, e);
    if (link < 0) {
      mount.joint = reference;
      link = robot_.joints[robot_.joint(reference)].child;
    }
    RobotLink& on = robot_.links[link];
    for (const RobotShape& s : on.shapes) mount.collisions += s.collides ? 1 : 0;
    if (auto made = gazebo_sensor(context_, e, mount)) on.sensors.push_back(std::move(*made));
  }

  void check_tree(const XmlElement& root) {
    std::vector<int> carrier(robot_.links.size(), -1);
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      const RobotJoint& j = robot_.joints[i];
      int& at = carrier[j.child];
      if (at >= 0)
        context_.error(j.at, "CG1410",
                       fmt::format("link '{}' is the child of two joints, '{}' and '{}'",
                                   robot_.links[j.child].name, robot_.joints[at].name, j.name),
                       "URDF describes trees; a loop needs a joint of the scene language");
      else
        at = static_cast<int>(i);
    }
    std::string roots;
    std::size_t top = 0;
    int count = 0;
    for (std::size_t i = 0; i < carrier.size(); ++i) {
      if (carrier[i] >= 0) continue;
      if (++count <= 5) add_to(roots, "'" + robot_.links[i].name + "'", ", ");
      top = i;
    }
    if (count == 0)
      context_.error(root.at, "CG1410", "no link is the root: the joints form a cycle");
    if (count > 1)
      context_.error(root.at, "CG1410", fmt::format("{} links have no parent: {}", count, roots),
                     "join them, or remove those that do not belong to the robot");
    if (count != 1 || context_.failed()) return;
    // By the convention of ROS the root 'world' is the world, to which joints hold the robot.
    if (RobotLink& link = robot_.links[top];
        link.name == "world" && !link.inertia && !robot_.joints.empty()) {
      link.is_static = true;
      context_.exact(link.at, "link 'world'",
                     "is the world: what a fixed joint joins to it is static");
    }
    // Every link must be reached from the root, else some form a cycle.
    std::vector<bool> reached(carrier.size(), false);
    for (std::size_t i = 0; i < carrier.size(); ++i) {
      std::vector<std::size_t> path;
      std::size_t at = i;
      while (!reached[at] && carrier[at] >= 0 && path.size() <= carrier.size()) {
        path.push_back(at);
        at = static_cast<std::size_t>(robot_.joints[carrier[at]].parent);
      }
      if (path.size() > carrier.size()) {
        context_.error(robot_.links[i].at, "CG1410",
                       fmt::format("link '{}' is its own ancestor", robot_.links[i].name));
        return;
      }
      reached[at] = true;
      for (const std::size_t k : path) reached[k] = true;
    }
  }

  Context& context_;
  RobotModel robot_;
  std::map<std::string, Material> materials_;
};

}  // namespace

RobotModel read_urdf(Context& context, const XmlElement& root) {
  return UrdfReader(context).read(root);
}

void read_srdf(Context& context, const XmlElement& root, RobotModel& robot) {
  for (const auto& e : root.children) {
    if (e->name == "disable_collisions") {
      const std::string* a = e->find("link1");
      const std::string* b = e->find("link2");
      if (a == nullptr || b == nullptr || robot.link(*a) < 0 || robot.link(*b) < 0) {
        context.left_out(e->at, "<disable_collisions>",
                         "names a link that the robot does not have");
        continue;
      }
      robot.no_contact.emplace_back(*a, *b);
      context.exact(e->at, fmt::format("no contact of '{}' and '{}'", *a, *b));
    } else {
      context.left_out(e->at, fmt::format("<{}> of the SRDF", e->name), "concerns motion planning");
    }
  }
}

}  // namespace cogrsim::dsl::import

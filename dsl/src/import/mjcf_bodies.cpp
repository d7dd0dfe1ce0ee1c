// Bodies and joints of MJCF.
#include "import/mjcf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "import/scene_text.h"

namespace cogrsim::dsl::import {

void MjcfReader::note_joints(const XmlElement& e, int depth) {
  for (const char* key : {"joint", "joint1", "joint2"})
    if (const std::string* name = e.find(key)) used_joints_.insert(*name);
  for (const char* key : {"geom1", "geom2"})
    if (const std::string* name = e.find(key)) paired_geoms_.insert(*name);
  if (depth < 90)
    for (const auto& c : e.children) note_joints(*c, depth + 1);
}

void MjcfReader::world(const XmlElement& e, const std::string& around) {
  const std::string inner = child_class(e, around);
  for (const auto& c : e.children) {
    if (c->name == "body") {
      body(*c, -1, inner, 0);
    } else if (c->name == "frame") {
      in_frame(*c, [&] { world(*c, inner); });
      context_.exact(c->at, quoted_name(*c));
    } else if (c->name == "geom") {
      const XmlElement g = with_defaults(*c, inner);
      RobotShape shape;
      if (geom(*c, g, {}, shape, nullptr)) {
        if (shape.geometry.type == Geometry::Type::plane ||
            shape.geometry.type == Geometry::Type::heightmap)
          robot_.has_ground = true;
        ground().shapes.push_back(std::move(shape));
      }
    } else if (c->name == "site") {
      const std::string name = name_of(*c, "site");
      const Pose X = pose(with_defaults(*c, inner));
      RobotLink& link = ground();
      sites_[name] = {link.name, X};
      link.frames.push_back({name, X, true});
    } else if (c->name == "camera") {
      ground().sensors.push_back(camera(*c, with_defaults(*c, inner)));
    } else if (c->name == "light") {
      context_.left_aside(c->at, quoted_name(*c), "concerns appearance only");
    } else {
      context_.left_out(c->at, quoted_name(*c), "is not read, nor is what is in it");
    }
  }
}

RobotLink& MjcfReader::ground() {
  const int known = robot_.link("world");
  if (known >= 0) return robot_.links[known];
  RobotLink link;
  link.name = "world";
  link.is_static = link.is_ground = true;
  robot_.links.push_back(std::move(link));
  return robot_.links.back();
}

std::string MjcfReader::child_class(const XmlElement& e, const std::string& around) {
  const std::string* own = e.find("childclass");
  return own != nullptr ? *own : around;
}

std::string MjcfReader::name_of(const XmlElement& e, const char* kind) {
  if (const std::string* name = e.find("name"); name != nullptr && !name->empty()) return *name;
  return fmt::format("{}_{}", kind, ++unnamed_);
}

void MjcfReader::body(const XmlElement& e, int parent, const std::string& around, int depth) {
  if (depth > 80) context_.refuse(e.at, "CG1402", "bodies are nested too deep");
  if (robot_.links.size() > 20000) context_.refuse(e.at, "CG1402", "more than 20000 bodies");
  const std::string inner = child_class(e, around);
  BodyParts parts;
  RobotLink& link = parts.link;
  link.name = name_of(e, "body");
  link.at = e.at;
  if (robot_.link(link.name) >= 0) {
    context_.error(e.at, "CG1407", fmt::format("a second body '{}'", link.name));
    return;
  }
  const Pose X_PB = pose(e);
  const Pose outer = std::exchange(frame_, Pose());
  parts_of_body(e, inner, parts);
  link.inertia = inertia_of(parts);
  if (parts.free_joint != nullptr) free_joint(*parts.free_joint, link);
  for (const auto& [key, value] : e.attributes) {
    if (key == "mocap" && value == "true") {
      link.is_static = true;
      context_.approximate(e.at, quoted_name(e), "a mocap body is static: nothing moves it here");
    } else if (key == "gravcomp" && disabled_.count("passive") == 0) {
      link.gravity_scale *= 1.0 - context_.number(e, "gravcomp", 0.0);
    }
  }
  context_.exact(e.at, quoted_name(e));
  const int index = attach(e, std::move(link), parent, X_PB, parts.joints, parts.is_free);
  bodies_in(e, index, inner, depth + 1);
  frame_ = outer;
}

void MjcfReader::bodies_in(const XmlElement& e, int parent, const std::string& around, int depth) {
  for (const auto& c : e.children) {
    if (c->name == "body") body(*c, parent, around, depth);
    if (c->name == "frame")
      in_frame(*c, [&] { bodies_in(*c, parent, child_class(*c, around), depth); });
  }
}

void MjcfReader::parts_of_body(const XmlElement& e, const std::string& around, BodyParts& parts) {
  for (const auto& c : e.children) {
    if (c->name == "body") continue;
    if (c->name != "frame") {
      part_of_body(*c, around, parts);
      continue;
    }
    in_frame(*c, [&] { parts_of_body(*c, child_class(*c, around), parts); });
    context_.exact(c->at, quoted_name(*c));
  }
}

void MjcfReader::part_of_body(const XmlElement& c, const std::string& around, BodyParts& parts) {
  RobotLink& link = parts.link;
  if (c.name == "freejoint") {
    parts.is_free = true;
  } else if (c.name == "joint") {
    XmlElement j = with_defaults(c, around);
    const std::string* type = j.find("type");
    if (type != nullptr && *type == "free") {
      parts.is_free = true;
      parts.free_joint = std::make_unique<XmlElement>(std::move(j));
    } else {
      parts.joints.push_back({&c, std::move(j), frame_});
    }
  } else if (c.name == "inertial") {
    parts.inertial = &c;
  } else if (c.name == "geom") {
    const XmlElement g = with_defaults(c, around);
    RobotShape shape;
    RobotInertia inertia;
    const bool made = geom(c, g, link.name, shape, &inertia);
    if (inertia.mass > 0.0) {
      parts.masses.push_back(inertia);
      if (shape.geometry.type == Geometry::Type::mesh) parts.mesh = &c;
    }
    if (shape.geometry.type == Geometry::Type::mesh && shape.geometry.mesh.empty())
      link.has_lost_shape = true;
    if (made) link.shapes.push_back(std::move(shape));
  } else if (c.name == "site") {
    const Pose X = pose(with_defaults(c, around));
    const std::string name = name_of(c, "site");
    sites_[name] = {link.name, X};
    link.frames.push_back({name, X, true});
  } else if (c.name == "camera") {
    link.sensors.push_back(camera(c, with_defaults(c, around)));
  } else {
    const std::string what = fmt::format("<{}> of body '{}'", c.name, link.name);
    if (c.name == "light")
      context_.left_aside(c.at, what, "concerns appearance only");
    else
      context_.left_out(c.at, what, "is not read");
  }
}

RobotSensor MjcfReader::camera(const XmlElement& source, const XmlElement& e) {
  const Context::Aside looks(context_);
  RobotSensor out;
  out.name = name_of(source, "camera");
  out.element = "camera";
  out.at = source.at;
  // MuJoCo's cameras look along -z with y up, ours along x with z up.
  Mat3 R;
  R << 0, -1, 0, 0, 0, 1, -1, 0, 0;
  out.X = pose(e) * Pose(Vec3::Zero(), Quat(R));
  std::string differs;
  const auto has = [&](const char* name, const char* value) {
    return e.find(name) != nullptr && *e.find(name) == value;
  };
  if (e.find("mode") != nullptr && !has("mode", "fixed"))
    add_to(differs, "it is fixed to its body");
  if (has("orthographic", "true") || has("projection", "orthographic"))
    add_to(differs, "it is a pinhole");
  for (const char* shift : {"principal", "principalpixel"})
    if (e.find(shift) != nullptr) {
      add_to(differs, "its optical axis is at the image's centre");
      break;
    }

  double columns = 320.0, rows = 240.0;
  const auto pair = [&](const char* name) -> std::optional<Eigen::Vector2d> {
    const std::string* text = e.find(name);
    const auto values = text != nullptr ? context_.numbers(e, *text, 2, 2, name)
                                        : std::optional<std::vector<double>>();
    if (!values) return std::nullopt;
    const Eigen::Vector2d both((*values)[0], (*values)[1]);
    if (both == Eigen::Vector2d::Zero()) return std::nullopt;  // MuJoCo's default: none
    if (both.minCoeff() > 0.0) return both;
    context_.error(source.at, "CG1403",
                   fmt::format("'{}' of {} is '{}'", name, quoted_name(source), *text),
                   "two numbers above zero are expected");
    return std::nullopt;
  };
  const auto pixels = pair("resolution");
  if (pixels && pixels->minCoeff() >= 1.0 && pixels->maxCoeff() <= 4096.0 &&
      pixels->maxCoeff() > 1.0) {  // 1 1 is MuJoCo's default: nothing is said
    columns = std::floor((*pixels)[0]);
    rows = std::floor((*pixels)[1]);
    out.attributes.emplace_back("resolution", fmt::format("{} {}", columns, rows));
  } else if (pixels && pixels->maxCoeff() > 4096.0) {
    add_to(differs, "its resolution is 320 240");
  }
  // The scene has the horizontal opening angle, MJCF the vertical one, in degrees always.
  double half = std::tan(0.5 * context_.number(e, "fovy", 45.0) * kPi / 180.0) * columns / rows;
  const auto sensor = pair("sensorsize"), focal = pair("focal"), focal_pixels = pair("focalpixel");
  if (focal_pixels && pixels)
    half = 0.5 * columns / (*focal_pixels)[0];
  else if (focal && sensor)
    half = 0.5 * (*sensor)[0] / (*focal)[0];
  if (const auto& f = focal_pixels ? focal_pixels : focal;
      f && (focal_pixels || (sensor && pixels))) {
    const Eigen::Vector2d unit =
        focal_pixels ? Eigen::Vector2d(1.0, 1.0) : Eigen::Vector2d(sensor->cwiseQuotient(*pixels));
    const Eigen::Vector2d own = f->cwiseQuotient(unit);
    if (std::abs(own[0] - own[1]) > 1e-6 * own[0]) add_to(differs, "its pixels are square");
  }
  double fov = 2.0 * std::atan(half);
  if (!(fov > 0.0 && fov <= 3.1)) {
    fov = fov > 3.1 ? 3.1 : 1.0;
    add_to(differs, fmt::format("its opening angle is {} rad", fov));
  }
  out.attributes.emplace_back("fov", fmt::format("{} rad", tidy(fov)));
  // MuJoCo takes an image when a program asks for one; a scene's camera takes them at its rate.
  out.attributes.emplace_back("rate", "30 Hz");
  out.attributes.emplace_back("enabled", "false");
  context_.exact_unless(source.at, quoted_name(source), differs,
                        "it takes images, 30 a second, once it is enabled");
  return out;
}

std::optional<RobotInertia> MjcfReader::inertia_of(const BodyParts& parts) {
  std::optional<RobotInertia> out;
  if (parts.inertial != nullptr && from_geoms_ != "true")
    out = given_inertia(*parts.inertial);
  else if (!parts.masses.empty() && from_geoms_ != "false")
    out = sum(parts.masses);
  if (out && parts.mesh != nullptr && !exact_meshes_ &&
      (parts.inertial == nullptr || from_geoms_ == "true"))
    context_.approximate(parts.mesh->at, fmt::format("mass of body '{}'", parts.link.name),
                         "is by the volume of its meshes; without exactmeshinertia MuJoCo counts "
                         "parts of some twice");
  if (!out) return out;
  const RobotInertia written = *out;
  out->mass = std::max(out->mass, bound_mass_);
  if (bound_inertia_ > 0.0)
    for (int i = 0; i < 3; ++i) out->I(i, i) = std::max(out->I(i, i), bound_inertia_);
  if (out->mass != written.mass || out->I != written.I)
    context_.exact(parts.link.at, fmt::format("mass of body '{}'", parts.link.name),
                   "is raised to boundmass and boundinertia");
  return out;
}

void MjcfReader::set_total_mass() {
  if (!(total_mass_ > 0.0)) return;
  double sum = 0.0;
  for (const RobotLink& l : robot_.links)
    if (l.inertia) sum += l.inertia->mass;
  if (!(sum > 0.0)) return;
  for (RobotLink& l : robot_.links)
    if (l.inertia) {
      l.inertia->mass *= total_mass_ / sum;
      l.inertia->I *= total_mass_ / sum;
    }
  context_.exact({}, "settotalmass", fmt::format("masses are scaled by {}", total_mass_ / sum));
}

RobotInertia MjcfReader::sum(const std::vector<RobotInertia>& parts) {
  std::vector<MassProperties> all;
  for (const RobotInertia& p : parts) all.push_back({p.mass, p.com, p.I});
  const MassProperties m = combine(all);
  return {m.mass, m.com, m.inertia};
}

std::optional<RobotInertia> MjcfReader::given_inertia(const XmlElement& e) {
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

// MuJoCo has the damping, the armature a and the dry friction of a joint for each of the six speeds of a
// free one: at its origin, -d v and -d w, and a mass and an inertia of a, which have no weight.
void MjcfReader::free_joint(const XmlElement& e, RobotLink& link) {
  const auto law = [&](const char* name, const char* flag) {
    return disabled_.count(flag) == 0 ? std::max(0.0, context_.number(e, name, 0.0)) : 0.0;
  };
  const std::string what = fmt::format("free joint of body '{}'", link.name);
  link.free_damping = law("damping", "passive");
  if (link.free_damping > 0.0)
    context_.exact(e.at, "damping of the " + what, "is a <drag> on the body");
  if (law("frictionloss", "frictionloss") > 0.0)
    context_.left_out(e.at, "frictionloss of the " + what, "a body without joint has no friction");
  if (law("stiffness", "passive") > 0.0)
    context_.left_out(e.at, "stiffness of the " + what, "a body without joint has no spring");
  const double armature = law("armature", "");
  if (!(armature > 0.0) || !link.inertia) return;
  RobotInertia& body = *link.inertia;
  const double weighs = body.mass / (body.mass + armature);
  const bool off_centre = body.com.norm() > 1e-9;
  body = sum({body, {armature, Vec3::Zero(), armature * Mat3::Identity()}});
  link.gravity_scale *= weighs;
  context_.exact_unless(
      e.at, "armature of the " + what,
      off_centre ? "the weight acts at the centre of mass of body and armature together" : "",
      fmt::format("is {} kg and kg m^2 more of the body, without weight", armature));
}

int MjcfReader::attach(const XmlElement& e, RobotLink link, int parent, const Pose& X_PB,
                       const std::vector<JointSource>& joints, bool is_free) {
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
    if (is_free) coordinates_.push_back({static_cast<int>(robot_.joints.size()), 7, {}, 0.0});
    robot_.joints.push_back(std::move(j));
    return static_cast<int>(robot_.links.size()) - 1;
  }
  std::vector<RobotJoint> made;
  for (const JointSource& j : joints) made.push_back(joint(*j.source, j.e, j.frame));
  if (planar(made)) {
    RobotJoint j;
    j.type = Type::planar;
    j.name = made[0].name;
    j.at = made[0].at;
    for (const RobotJoint& k : made) {
      if (k.type == Type::hinge) j.axis = k.axis;
      const Pose part = k.type == Type::hinge
                            ? Pose(Vec3::Zero(), Quat(Eigen::AngleAxisd(1.0, k.axis)))
                            : Pose(k.axis, Quat::Identity());
      coordinates_.push_back({static_cast<int>(robot_.joints.size()), 1, part, ref_of(k)});
    }
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
      next = link;
    }
    robot_.links.push_back(std::move(next));
    made[i].parent = from;
    made[i].X_PC = X;
    made[i].child = static_cast<int>(robot_.links.size()) - 1;
    from = made[i].child;
    X = Pose();
    if (made[i].type != Type::planar)
      coordinates_.push_back({static_cast<int>(robot_.joints.size()),
                              made[i].type == Type::ball ? std::size_t{4} : std::size_t{1},
                              {},
                              ref_of(made[i])});
    robot_.joints.push_back(made[i]);
  }
  return from;
}

bool MjcfReader::planar(const std::vector<RobotJoint>& joints) const {
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
    if (std::isfinite(j.lower) || std::isfinite(j.upper) || j.damping != 0.0 || j.friction != 0.0 ||
        j.stiffness != 0.0 || j.rotor_inertia != 0.0 || j.anchor != Vec3::Zero())
      return false;
  }
  return slides.size() == 2 && std::abs(slides[0].dot(slides[1])) < 1e-9 && normal.norm() > 0.5 &&
         std::abs(slides[0].dot(normal)) < 1e-9 && std::abs(slides[1].dot(normal)) < 1e-9;
}

RobotJoint MjcfReader::joint(const XmlElement& source, const XmlElement& e, const Pose& frame) {
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
    out.axis = frame.q * axis.normalized();
  else if (out.type != Type::ball)
    context_.error(source.at, "CG1409",
                   fmt::format("joint '{}' has an axis of length 0", out.name));
  out.anchor = frame * context_.vec3(e, "pos", Vec3::Zero());
  const double ref = coordinate(context_.number(e, "ref", 0.0));
  if (is_limited(e)) {
    const auto v = context_.numbers(source, *e.find("range"), 2, 2, "'range'");
    if (v && out.type == Type::ball) {
      const double cone = angle(std::max((*v)[0], (*v)[1]));
      if (cone > 0.0 && cone <= kPi) out.upper = cone;
    } else if (v) {
      out.lower = coordinate((*v)[0]) - ref;
      out.upper = coordinate((*v)[1]) - ref;
      if (out.lower > out.upper) std::swap(out.lower, out.upper);
    }
  }
  if (disabled_.count("passive") == 0) {
    out.damping = std::max(0.0, context_.number(e, "damping", 0.0));
    out.stiffness = std::max(0.0, context_.number(e, "stiffness", 0.0));
  }
  if (disabled_.count("frictionloss") == 0)
    out.friction = std::max(0.0, context_.number(e, "frictionloss", 0.0));
  if (is_limited(e)) out.of_mujoco = note_softness(source, e, "limit", "limit");
  if (out.friction > 0.0) {
    const MujocoAttributes more = note_softness(source, e, "friction", "friction");
    out.of_mujoco.insert(out.of_mujoco.end(), more.begin(), more.end());
  }
  out.rest = coordinate(context_.number(e, "springref", 0.0)) - ref;
  out.rotor_inertia = std::max(0.0, context_.number(e, "armature", 0.0));
  if (const std::string* range = e.find("actuatorfrcrange"); range != nullptr && out.has_one_axis())
    if (const auto v = context_.numbers(e, *range, 2, 2, "actuatorfrcrange")) {
      const double most = std::max(std::abs((*v)[0]), std::abs((*v)[1]));
      if (most > 0.0) out.max_effort = most;
      if ((*v)[0] != -(*v)[1])
        context_.approximate(source.at, fmt::format("actuatorfrcrange of joint '{}'", out.name),
                             fmt::format("bounds both directions by {}", most));
    }
  if (ref != 0.0) refs_[out.name] = ref;
  if (ref != 0.0)
    context_.exact(source.at, fmt::format("ref of joint '{}'", out.name),
                   fmt::format("its zero is MuJoCo's {}", ref));
  context_.exact(source.at, fmt::format("joint '{}'", out.name));
  return out;
}

}  // namespace cogrsim::dsl::import

// Actuators, equalities and sensors of MJCF.
#include "import/mjcf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cogrsim::dsl::import {

double MjcfReader::parameter(const XmlElement& e, const char* name, std::size_t i,
                             double otherwise) {
  const std::string* text = e.find(name);
  if (text == nullptr) return otherwise;
  const auto v = context_.numbers(e, *text, 0, 10, fmt::format("'{}'", name));
  return v && i < v->size() ? (*v)[i] : otherwise;
}

std::pair<double, double> MjcfReader::bounds(const XmlElement& e, const std::string& of) {
  const std::pair<double, double> none{-std::numeric_limits<double>::infinity(),
                                       std::numeric_limits<double>::infinity()};
  const std::string range = of + "range";
  const std::string *text = e.find(range), *limited = e.find(of + "limited");
  const bool by_itself = limited == nullptr || *limited == "auto";
  if (text == nullptr || (by_itself ? !auto_limits_ : *limited != "true")) return none;
  const auto v = context_.numbers(e, *text, 2, 2, fmt::format("'{}'", range));
  if (!v) return none;
  if (!((*v)[0] < (*v)[1])) {
    context_.error(e.at, "CG1403", fmt::format("'{}' of {} is '{}'", range, quoted_name(e), *text),
                   "two numbers are expected, the second above the first");
    return none;
  }
  return {(*v)[0], (*v)[1]};
}

std::pair<double, double> MjcfReader::control_range(const XmlElement& e, const Transmission& acts) {
  const double none = std::numeric_limits<double>::infinity();
  if (disabled_.count("clampctrl") != 0) return {-none, none};
  const double inherits = context_.number(e, "inheritrange", 0.0);
  if (inherits > 0.0 && e.find("ctrlrange") == nullptr && acts.joints.size() == 1) {
    const RobotJoint& j = joint_at(acts.joints.front().first);
    const double middle = 0.5 * (j.lower + j.upper) + acts.at_zero;
    const double half = 0.5 * inherits * (j.upper - j.lower);
    if (std::isfinite(half)) return {middle - half, middle + half};
  }
  return bounds(e, "ctrl");
}

// What is bounded by the largest effort or by the joint's limits needs no bounds of its own.
void MjcfReader::bound_target(const Control& u, RobotDrive& drive) const {
  double low = u.scale * u.least + u.offset, high = u.scale * u.most + u.offset;
  if (low > high) std::swap(low, high);
  const RobotJoint& j = robot_.joints[robot_.joint(drive.joint)];
  const bool holds = drive.mode == RobotDrive::Mode::position;
  const bool pulls = drive.mode == RobotDrive::Mode::torque;
  if (low > (holds ? j.lower : pulls ? -drive.max_effort : -kInfinity)) drive.min_target = low;
  if (high < (holds ? j.upper : pulls ? drive.max_effort : kInfinity)) drive.max_target = high;
}

std::optional<MjcfReader::Transmission> MjcfReader::actuator_joints(const XmlElement& source,
                                                                    const XmlElement& e) {
  Transmission out;
  const std::string *of = e.find("joint"), *tendon = e.find("tendon");
  const auto fixed = tendon == nullptr ? tendon_indices_.end() : tendon_indices_.find(*tendon);
  std::string why;
  if (of != nullptr) {
    const int joint = joint_index(*of);
    if (joint >= 0) {
      out.joints = {{joint, 1.0}};
      out.at_zero = ref(joint);
    } else {
      why = fmt::format("there is no joint '{}'", *of);
    }
  } else if (fixed != tendon_indices_.end()) {
    const auto& sum = tendons_[fixed->second].sum;
    if (sum) out = *sum;
    if (out.joints.empty()) why = "moves no joint";
  } else {
    why = tendon == nullptr ? "drives no joint but a site or a body"
                            : "pulls a tendon in space, and a scene's drives are on joints";
  }
  if (why.empty()) return out;
  context_.left_out(source.at, quoted_name(source), why);
  return std::nullopt;
}

std::optional<MjcfReader::ActuatorLaw> MjcfReader::actuator_law(const XmlElement& source,
                                                                const XmlElement& e) {
  using Mode = RobotDrive::Mode;
  constexpr const char* kAtOnce =
      "reaches its speed at once within its force, where MuJoCo's has "
      "the gain kv";
  ActuatorLaw out;
  if (source.name == "position") {
    out.mode = Mode::position;
    out.gain = context_.number(e, "kp", 1.0);
    out.b1 = -out.gain;
    out.b2 = -context_.number(e, "kv", 0.0);
    out.damping_ratio = std::max(0.0, context_.number(e, "dampratio", 0.0));
  } else if (source.name == "velocity") {
    out.mode = Mode::velocity;
    out.note = kAtOnce;
  } else if (source.name == "general") {
    out.gain = parameter(e, "gainprm", 0, 1.0);
    const std::string *bias = e.find("biastype"), *gain = e.find("gaintype");
    const bool affine = bias != nullptr && *bias == "affine";
    if (affine) {
      out.b0 = parameter(e, "biasprm", 0, 0.0);
      out.b1 = parameter(e, "biasprm", 1, 0.0);
      out.b2 = parameter(e, "biasprm", 2, 0.0);
    }
    const bool speed = out.b0 == 0.0 && out.b1 == 0.0 && out.b2 < 0.0 &&
                       std::abs(out.gain + out.b2) <= 1e-9 * std::abs(out.gain);
    if (out.b1 < 0.0 && out.b2 <= 0.0) {
      out.mode = Mode::position;
    } else if (speed) {
      out.mode = Mode::velocity;
      out.gain = 1.0;
      out.note = kAtOnce;
    } else if (out.b0 != 0.0 || out.b1 != 0.0 || out.b2 != 0.0 ||
               (bias != nullptr && !affine && *bias != "none") ||
               (gain != nullptr && *gain != "fixed")) {
      context_.left_out(source.at, quoted_name(source), "its law is none that a motor has");
      return std::nullopt;
    }
  } else if (source.name != "motor") {
    context_.left_out(source.at, quoted_name(source),
                      fmt::format("there is no drive like <{}>", source.name));
    return std::nullopt;
  }
  if (out.mode == Mode::position && !(out.b1 < 0.0)) {
    context_.left_out(source.at, quoted_name(source), "its gain kp is not above zero");
    return std::nullopt;
  }
  const std::string* dynamics = e.find("dyntype");
  const double delay = context_.number(e, "timeconst", 0.0);
  if ((dynamics != nullptr && *dynamics != "none") || delay > 0.0)
    add_to(out.note, "acts without the delay of MuJoCo's");
  return out;
}

// MuJoCo's torque on a ball joint is gear times the force, in the axes of the child. Motors of a scene
// drive axes: the ball becomes a gimbal, whose last axis is that of the first motor and is fixed in the
// child, as the gear is.
void MjcfReader::ball_motor(const XmlElement& source, const XmlElement& e, int joint,
                            const ActuatorLaw& law) {
  const auto left_out = [&](const char* why) {
    context_.left_out(source.at, quoted_name(source), why);
  };
  const Vec3 gear(parameter(e, "gear", 0, 1.0), parameter(e, "gear", 1, 0.0),
                  parameter(e, "gear", 2, 0.0));
  const double size = gear.norm();
  if (law.mode != RobotDrive::Mode::torque)
    return left_out("holds the rotation of a ball joint, which no drive of a scene does");
  if (size < 1e-12) return left_out("its gear is zero");
  std::vector<Vec3>& axes = ball_axes_[joint];
  const Vec3 along = gear / size;
  const auto parallel = [&](const Vec3& a) { return std::abs(a.dot(along)) > 1.0 - 1e-9; };
  auto axis = std::find_if(axes.begin(), axes.end(), parallel);
  if (axis == axes.end()) {
    if (std::any_of(axes.begin(), axes.end(),
                    [&](const Vec3& a) { return std::abs(a.dot(along)) > 1e-9; }))
      return left_out("its gear is not at right angles to those of the joint's other motors");
    axes.push_back(axes.size() == 2 ? axes[1].cross(axes[0]) : along);
    axis = axes.end() - 1;
  }
  const double scale = law.gain * size * (axis->dot(along) > 0.0 ? 1.0 : -1.0);
  RobotDrive out;
  out.joint = joint_at(joint).name;
  out.name = name_of(source, "motor");
  out.at = source.at;
  out.axis = 3 - static_cast<int>(axis - axes.begin());
  const auto forces = bounds(e, "force");
  out.max_effort = size * std::max(std::abs(forces.first), std::abs(forces.second));
  const auto [least, most] = bounds(e, "ctrl");
  const Control u{robot_.drives.size(), scale, 0.0, least, most};
  bound_target(u, out);
  if (u.of(0.0) != 0.0) out.target = u.of(0.0);
  controls_.back().push_back(u);
  robot_.drives.push_back(std::move(out));
  context_.exact_unless(source.at, quoted_name(source), law.note,
                        scale == 1.0 ? "" : fmt::format("its control u is {:.6g} u here", scale));
}

void MjcfReader::make_gimbals() {
  for (const auto& [index, axes] : ball_axes_) {
    if (axes.empty()) continue;
    RobotJoint& j = joint_at(index);
    j.type = RobotJoint::Type::gimbal;
    j.axis2 = axes.size() > 1 ? axes[1] : axes[0].unitOrthogonal();
    j.axis = j.axis2.cross(axes[0]);
    context_.approximate(
        j.at, fmt::format("joint '{}'", j.name),
        "is a gimbal of three hinges, as motors drive no ball joint: the same near "
        "its zero, and singular where its second angle is 90 degrees");
    if (std::isfinite(j.upper))
      context_.left_out(j.at, fmt::format("range of joint '{}'", j.name),
                        "a gimbal has a limit of each angle");
  }
}

// The diagonal of MuJoCo's mass matrix where all joints are at their zero: of all that the joint
// carries, about its axis.
double MjcfReader::inertia_on(int joint) const {
  const RobotJoint& j = joint_at(joint);
  const auto count = robot_.links.size();
  std::vector<Pose> X(count);  // of what it carries, in its child
  std::vector<bool> carried(count, false);
  carried[static_cast<std::size_t>(j.child)] = true;
  double out = j.rotor_inertia;
  const auto add = [&](std::size_t link) {
    const auto& body = robot_.links[link].inertia;
    if (!body) return;
    const Vec3 axis = X[link].q.conjugate() * j.axis;
    const Vec3 arm = X[link] * body->com - j.anchor;
    out += j.type == RobotJoint::Type::slider
               ? body->mass
               : axis.dot(body->I * axis) + body->mass * j.axis.cross(arm).squaredNorm();
  };
  add(static_cast<std::size_t>(j.child));
  // Parents come before their children.
  for (std::size_t i = static_cast<std::size_t>(joint) + 1; i < robot_.joints.size(); ++i) {
    const RobotJoint& k = robot_.joints[i];
    if (k.parent < 0 || !carried[static_cast<std::size_t>(k.parent)]) continue;
    const auto child = static_cast<std::size_t>(k.child);
    carried[child] = true;
    X[child] = X[static_cast<std::size_t>(k.parent)] * k.X_PC;
    add(child);
  }
  return out;
}

void MjcfReader::actuator(const XmlElement& source) {
  using Mode = RobotDrive::Mode;
  const XmlElement e = with_defaults(source, "");
  controls_.emplace_back();
  const auto acts = actuator_joints(source, e);
  if (!acts) return;
  const auto law = actuator_law(source, e);
  if (!law) return;
  if (const int only = acts->joints.front().first;
      acts->joints.size() == 1 && joint_at(only).type == RobotJoint::Type::ball) {
    ball_motor(source, e, only, *law);
    return;
  }
  const double gear = parameter(e, "gear", 0, 1.0);
  const auto forces = bounds(e, "force");
  const double force = std::max(std::abs(forces.first), std::abs(forces.second));
  const auto range = control_range(e, *acts);
  if (forces.first != -forces.second)
    context_.approximate(source.at, fmt::format("forcerange of {}", quoted_name(source)),
                         fmt::format("bounds both directions by {}", force));
  const bool several = acts->joints.size() > 1;
  if (several && law->mode != Mode::torque) {
    context_.left_out(source.at, quoted_name(source),
                      fmt::format("holds a sum of {} joints that move freely of each other, which "
                                  "no drive of a scene does",
                                  acts->joints.size()));
    return;
  }
  const std::string name = name_of(source, "motor");
  std::string meaning;  // of its control
  for (const auto& [joint, coef] : acts->joints) {
    RobotDrive out;
    out.joint = joint_at(joint).name;
    out.name = several ? fmt::format("{}_{}", name, out.joint) : name;
    out.at = source.at;
    out.mode = law->mode;
    out.followers = acts->followers;
    // The actuator's length changes by s per coordinate of the joint.
    const double s = gear * coef;
    if (s == 0.0) continue;
    out.max_effort = force * std::abs(s);
    const auto reach = std::max(std::abs(range.first), std::abs(range.second));
    if (law->mode == Mode::torque)
      out.max_effort = std::min(force, reach * std::abs(law->gain)) * std::abs(s);
    out.kp = -law->b1 * s * s;
    out.kd = -law->b2 * s * s;
    if (law->damping_ratio > 0.0)
      out.kd += 2.0 * law->damping_ratio * std::sqrt(out.kp * inertia_on(joint));
    // What its control u is for the joint: the effort, speed or target scale u + offset.
    double scale = law->gain * s, offset = 0.0;
    if (law->mode == Mode::velocity) scale = 1.0 / s;
    if (law->mode == Mode::position) {
      scale = law->gain / -law->b1 / s;
      offset = law->b0 / -law->b1 / s - acts->at_zero / coef;
    }
    if (several || std::abs(scale - 1.0) > 1e-9 || std::abs(offset) > 1e-12)
      add_to(meaning, fmt::format("its control u is {:.6g} u{} at joint '{}' here", scale,
                                  offset == 0.0 ? ""
                                                : fmt::format(" {} {:.6g}", offset < 0 ? "-" : "+",
                                                              std::abs(offset)),
                                  out.joint));
    const Control u{robot_.drives.size(), scale, offset, range.first, range.second};
    bound_target(u, out);
    if (u.of(0.0) != 0.0 || law->mode == Mode::position) out.target = u.of(0.0);
    controls_.back().push_back(u);
    robot_.drives.push_back(std::move(out));
  }
  if (!acts->followers.empty())
    add_to(meaning, fmt::format("it drives joint '{}', which the others follow",
                                joint_at(acts->joints.front().first).name));
  if (several)
    context_.approximate(
        source.at, quoted_name(source),
        fmt::format("is {} motors, one for each joint: {}", acts->joints.size(), meaning));
  else
    context_.exact_unless(source.at, quoted_name(source), law->note, meaning);
}

std::vector<double> MjcfReader::polynomial(const XmlElement& source, const XmlElement& e) {
  std::vector<double> out = {0.0, 1.0};
  if (const std::string* text = e.find("polycoef"))
    out = context_.numbers(source, *text, 1, 5, "'polycoef'").value_or(out);
  out.resize(5, 0.0);
  return out;
}

std::string MjcfReader::beyond_linear(const std::vector<double>& poly) {
  const bool linear = poly[2] == 0.0 && poly[3] == 0.0 && poly[4] == 0.0;
  return linear ? "" : "only its linear part is taken";
}

std::optional<Pose> MjcfReader::relpose(const XmlElement& source, const XmlElement& e) {
  const std::string* text = source.name == "weld" ? e.find("relpose") : nullptr;
  const auto v =
      text == nullptr ? std::nullopt : context_.numbers(source, *text, 7, 7, "'relpose'");
  if (!v) return std::nullopt;
  const Quat turn((*v)[3], (*v)[4], (*v)[5], (*v)[6]);
  if (turn.norm() < 1e-9) return std::nullopt;  // as the bodies are at zero
  return Pose(Vec3((*v)[0], (*v)[1], (*v)[2]), turn.normalized());
}

void MjcfReader::equality(const XmlElement& source) {
  const XmlElement e = with_defaults(source, "", "equality");
  if (disabled_.count("equality") != 0) return;
  if (const std::string* active = e.find("active"); active != nullptr && *active == "false") {
    context_.left_out(source.at, quoted_name(source), "is not active");
    return;
  }
  const MujocoAttributes softness = note_softness(source, e, "equality", "");
  if (source.name == "joint") {
    const std::string *a = e.find("joint1"), *b = e.find("joint2");
    const int one = a == nullptr ? -1 : joint_index(*a);
    const int two = b == nullptr ? -1 : joint_index(*b);
    if (one < 0 || two < 0) {
      context_.left_out(source.at, quoted_name(source), "needs two joints of the model");
      return;
    }
    if (joint_at(one).coupling) {
      context_.left_out(source.at, quoted_name(source),
                        fmt::format("joint '{}' follows others already", *a));
      return;
    }
    const std::vector<double> poly = polynomial(source, e);
    joint_at(one).coupling = RobotCoupling{{{*b, poly[1]}}, poly[0], softness};
    context_.exact_unless(source.at, quoted_name(source), beyond_linear(poly));
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
    j.of_mujoco = softness;
    // The anchor is given in body 1, which is the child here.
    j.parent = two;
    j.child = one;
    j.anchor = context_.vec3(e, "anchor", Vec3::Zero());
    const auto relative = relpose(source, e);
    if (relative) welds_.push_back({one, two, *relative, j.name, source.at});
    robot_.loops.push_back(std::move(j));
    if (!relative)
      context_.approximate(source.at, quoted_name(source), "is rigid, where MuJoCo's is soft");
    return;
  }
  if (source.name == "tendon")
    tendon_equality(source, e, softness);
  else
    context_.left_out(source.at, quoted_name(source), "is not read");
}

void MjcfReader::sensor(const XmlElement& e) {
  const Context::Aside reads(context_);
  const std::string& kind = e.name;
  const std::string* joint = e.find("joint");
  RobotSensor out;
  out.name = name_of(e, e.name.c_str());
  out.at = e.at;
  if ((kind == "jointpos" || kind == "jointvel") && joint != nullptr && robot_.joint(*joint) >= 0) {
    if (!encoders_.insert(*joint).second) {
      context_.exact(e.at, quoted_name(e), "the joint's encoder reads both");
      return;
    }
    out.element = "encoder";
    out.joint = *joint;
    const RobotJoint& j = robot_.joints[robot_.joint(*joint)];
    context_.exact(e.at, quoted_name(e));
    robot_.links[j.child].sensors.push_back(std::move(out));
    return;
  }
  static const std::map<std::string_view, std::pair<const char*, const char*>> kKinds = {
      {"gyro", {"imu", ""}},
      {"accelerometer", {"imu", ""}},
      {"touch", {"contact", "reads all contacts of its body"}},
      {"velocimeter", {"pose", "reads the velocity in the world's axes, not in the site's"}},
      {"framepos", {"pose", ""}},
      {"framequat", {"pose", ""}},
      {"framelinvel", {"pose", ""}},
      {"frameangvel", {"pose", ""}}};
  const auto known = kKinds.find(kind);
  std::string why = fmt::format("there is no sensor like <{}>", kind);
  const auto place = known == kKinds.end() ? std::nullopt : sensor_place(e, why);
  if (!place) {
    context_.left_out(e.at, quoted_name(e), why);
    return;
  }
  out.element = known->second.first;
  if (!at_site_.insert(fmt::format("{} {} {}", out.element, place->link, place->name)).second) {
    context_.exact_unless(e.at, quoted_name(e), known->second.second,
                          fmt::format("the {} at its place reads both", out.element));
    return;
  }
  out.X = place->X;
  context_.exact_unless(e.at, quoted_name(e), known->second.second);
  robot_.links[place->link].sensors.push_back(std::move(out));
}

std::optional<MjcfReader::SensorPlace> MjcfReader::sensor_place(const XmlElement& e,
                                                                std::string& why) {
  const std::string *site = e.find("site"), *of = e.find("objname"), *type = e.find("objtype");
  if (type != nullptr && *type == "site") site = of;
  if (e.find("reftype") != nullptr || e.find("refname") != nullptr) {
    why = "reads relative to another frame, where a <pose> reads in the world";
    return std::nullopt;
  }
  if (site != nullptr) {
    const auto known = sites_.find(*site);
    why = fmt::format("there is no site '{}'", *site);
    if (known == sites_.end()) return std::nullopt;
    return SensorPlace{robot_.link(known->second.first), *site, known->second.second};
  }
  const bool inertial = type != nullptr && *type == "body";
  const int link =
      of != nullptr && type != nullptr && (inertial || *type == "xbody") ? robot_.link(*of) : -1;
  why = "is at no site or body";
  if (link < 0) return std::nullopt;
  if (!inertial) return SensorPlace{link, "", Pose()};
  const auto& mass = robot_.links[link].inertia;
  why = "reads the principal axes of the body";
  if (e.name == "framequat" || !mass) return std::nullopt;
  return SensorPlace{link, "com", Pose(mass->com, Quat::Identity())};
}

}  // namespace cogrsim::dsl::import

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

double MjcfReader::largest(const XmlElement& e, const std::string& of) {
  const double none = std::numeric_limits<double>::infinity();
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
  return std::max(std::abs((*v)[0]), std::abs((*v)[1]));
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
    if (e.find("dampratio") != nullptr) out.note = "dampratio is not taken over: it has no damping";
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

void MjcfReader::actuator(const XmlElement& source) {
  using Mode = RobotDrive::Mode;
  const XmlElement e = with_defaults(source, "");
  controls_.emplace_back();
  const auto acts = actuator_joints(source, e);
  if (!acts) return;
  const auto law = actuator_law(source, e);
  if (!law) return;
  const double gear = parameter(e, "gear", 0, 1.0);
  const double force = largest(e, "force"), control = largest(e, "ctrl");
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
    if (law->mode == Mode::torque)
      out.max_effort = std::min(force, control * std::abs(law->gain)) * std::abs(s);
    out.kp = -law->b1 * s * s;
    out.kd = -law->b2 * s * s;
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
    controls_.back().push_back({robot_.drives.size(), scale, offset});
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

void MjcfReader::equality(const XmlElement& source) {
  const XmlElement e = with_defaults(source, "", "equality");
  if (const std::string* active = e.find("active"); active != nullptr && *active == "false") {
    context_.left_out(source.at, quoted_name(source), "is not active");
    return;
  }
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
    joint_at(one).coupling = RobotCoupling{{{*b, poly[1]}}, poly[0]};
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
    // The anchor is given in body 1, which is the child here.
    j.parent = two;
    j.child = one;
    j.anchor = context_.vec3(e, "anchor", Vec3::Zero());
    robot_.loops.push_back(std::move(j));
    context_.approximate(source.at, quoted_name(source), "is rigid, where MuJoCo's is soft");
    return;
  }
  if (source.name == "tendon")
    tendon_equality(source, e);
  else
    context_.left_out(source.at, quoted_name(source), "is not read");
}

void MjcfReader::sensor(const XmlElement& e) {
  const std::string* site = e.find("site");
  const std::string* joint = e.find("joint");
  RobotSensor out;
  out.name = name_of(e, e.name.c_str());
  out.at = e.at;
  const std::string& kind = e.name;
  if ((kind == "jointpos" || kind == "jointvel") && joint != nullptr && robot_.joint(*joint) >= 0) {
    if (!encoders_.insert(*joint).second) {
      context_.exact(e.at, quoted_name(e), "the joint's encoder reads both");
      return;
    }
    out.element = "encoder";
    out.joint = *joint;
    const RobotJoint& j = robot_.joints[robot_.joint(*joint)];
    RobotLink& link = robot_.links[j.child];
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
    RobotLink& link = robot_.links[robot_.link(known->second.first)];
    if (kind == "touch")
      context_.approximate(e.at, quoted_name(e), "reads all contacts of its body");
    else
      context_.exact(e.at, quoted_name(e));
    link.sensors.push_back(std::move(out));
    return;
  }
  context_.left_out(e.at, quoted_name(e), fmt::format("there is no sensor like <{}>", kind));
}

}  // namespace cogrsim::dsl::import

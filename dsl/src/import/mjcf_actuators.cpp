// Actuators, equalities and sensors of MJCF.
#include "import/mjcf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cogrsim::dsl::import {

void MjcfReader::actuator(const XmlElement& source) {
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

void MjcfReader::equality(const XmlElement& source) {
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

}  // namespace cogrsim::dsl::import

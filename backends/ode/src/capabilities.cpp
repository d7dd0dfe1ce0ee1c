#include "capabilities.h"

#include <array>

namespace cogrsim::ode {

namespace {

constexpr std::array kShapes = {ShapeType::box,     ShapeType::sphere,   ShapeType::cylinder,
                                ShapeType::capsule, ShapeType::plane,    ShapeType::convex_mesh,
                                ShapeType::mesh,    ShapeType::heightmap};
constexpr std::array kJoints = {JointType::fixed,  JointType::hinge,       JointType::slider,
                                JointType::screw,  JointType::cylindrical, JointType::universal,
                                JointType::planar, JointType::ball,        JointType::free};
constexpr std::array kModes = {MotorMode::velocity, MotorMode::torque, MotorMode::position,
                               MotorMode::servo, MotorMode::dc};

bool surface(ShapeType type) {
  return type == ShapeType::plane || type == ShapeType::mesh || type == ShapeType::heightmap;
}

/// Why a pair is not exact; null: it is.
const char* pair_note(ShapeType a, ShapeType b) {
  const auto is = [&](ShapeType x, ShapeType y) {
    return (a == x && b == y) || (a == y && b == x);
  };
  const auto any = [&](ShapeType x) { return a == x || b == x; };
  using T = ShapeType;
  if (any(T::mesh) || any(T::heightmap)) {
    return "ODE tests triangles one by one: solid from their outer side only, and felt at the "
           "seams";
  }
  if (any(T::plane) || any(T::sphere)) return nullptr;
  if (is(T::box, T::cylinder)) {
    return "ODE clips the cylinder's end as an octagon around it: it bears 8 % farther out at "
           "eight "
           "points";
  }
  if (any(T::convex_mesh)) {
    return "ODE finds some of the points of two faces, not always those farthest apart: faces may "
           "lean by a few hundredths of a radian, and a face that hits flat starts to turn";
  }
  if (any(T::cylinder) || is(T::box, T::capsule)) {
    return "ODE finds one point unless two ends or two sides lie flat on each other: what hits "
           "along "
           "a line starts to turn";
  }
  return nullptr;
}

}  // namespace

Capabilities make_capabilities() {
  Capabilities out;
  for (const ShapeType a : kShapes) {
    out.set(std::string("shape.") + to_string(a), Support::exact);
    for (const ShapeType b : kShapes) {
      if (surface(a) && surface(b)) {
        out.set(pair_feature(a, b), Support::unsupported,
                "two surfaces: neither can be moved by forces");
      } else if (const char* note = pair_note(a, b)) {
        out.set(pair_feature(a, b), Support::approximate, note);
      } else {
        out.set(pair_feature(a, b), Support::exact);
      }
    }
  }
  for (const JointType type : kJoints) {
    const std::string name = to_string(type);
    out.set("joint." + name, Support::exact);
    out.set("loop." + name, Support::exact);
    for (const char* part : {"limit", "damping", "friction", "stiffness"}) {
      if (type == JointType::fixed || type == JointType::free) {
        out.set("joint." + std::string(part) + "." + name, Support::unsupported,
                "this joint has no axes");
      } else {
        out.set("joint." + std::string(part) + "." + name, Support::exact);
      }
    }
  }
  for (const MotorMode mode : kModes) {
    out.set(std::string("motor.") + to_string(mode), Support::exact);
  }
  out.set("contact.stiffness", Support::approximate,
          "a spring per contact point; restitution becomes its damping");
  for (const char* feature :
       {"body.static", "body.kinematic", "runtime.add", "runtime.remove", "runtime.save",
        "runtime.set_state", "runtime.attach", "runtime.body_kind", "runtime.joint_axes",
        "report.contact_force", "report.joint_reaction", "report.joint_effort"}) {
    out.set(feature, Support::exact);
  }
  return out;
}

}  // namespace cogrsim::ode

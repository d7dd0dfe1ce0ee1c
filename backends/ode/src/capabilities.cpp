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

}  // namespace

Capabilities make_capabilities() {
  Capabilities out;
  for (const ShapeType a : kShapes) {
    out.set(std::string("shape.") + to_string(a), Support::exact);
    for (const ShapeType b : kShapes) {
      if (surface(a) && surface(b)) {
        out.set(pair_feature(a, b), Support::unsupported,
                "two surfaces: neither can be moved by forces");
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

#include "capabilities.h"

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::mujoco {

namespace {

std::string pair_note(ShapeType a, ShapeType b) {
  const auto any = [&](ShapeType x) { return a == x || b == x; };
  const auto is = [&](ShapeType x, ShapeType y) {
    return (a == x && b == y) || (a == y && b == x);
  };
  using T = ShapeType;
  const std::string soft =
      "soft contact: rests sunk in, slides slowly under friction that should hold, bounces "
      "approximately";
  if (any(T::plane) || is(T::box, T::box) || is(T::sphere, T::box) || is(T::capsule, T::box) ||
      is(T::sphere, T::sphere) || is(T::sphere, T::capsule) || is(T::capsule, T::capsule)) {
    return soft;
  }
  if (any(T::heightmap)) return soft + "; a point for each triangle that is touched";
  return soft + "; one point where flat sides meet (multiccd: several)";
}

}  // namespace

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  for (const ShapeType a : kShapeTypes) {
    for (const ShapeType b : kShapeTypes) {
      if (is_surface(a) && is_surface(b)) continue;
      if (a == ShapeType::mesh || b == ShapeType::mesh) {
        out.set(pair_feature(a, b), Support::unsupported,
                "MuJoCo has meshes as their convex hulls only; use convex meshes");
      } else {
        out.set(pair_feature(a, b), Support::approximate, pair_note(a, b));
      }
    }
  }
  out.set("shape.convex-mesh", Support::approximate, "MuJoCo keeps its corners as floats");
  out.set("shape.heightmap", Support::approximate, "MuJoCo keeps its heights as floats");
  set_joint_features(out);
  for (const JointType type : kJointTypes) {
    const std::string name = to_string(type);
    if (type != JointType::free) {
      out.set("loop." + name, Support::unsupported,
              "MuJoCo closes loops by points and welds: let a hinge, ball or fixed joint of the "
              "loop be the last one in the file");
    }
    if (type == JointType::fixed || type == JointType::free) continue;
    const bool ball = type == JointType::ball;
    out.set("joint.limit." + name, Support::approximate, "a soft stop, see solreflimit");
    out.set("joint.friction." + name, Support::approximate,
            std::string("slides slowly under loads that it should hold, see solreffriction") +
                (ball ? "; on each of three axes by itself" : ""));
    out.set("joint.stiffness." + name, Support::approximate,
            "an explicit spring: unstable where stiffness times step squared exceeds four times "
            "the inertia");
  }
  out.set("joint.screw", Support::approximate,
          "its travel is tied to its angle by a soft constraint, see solrefequality");
  const char* const soft_loop = "held by a soft constraint, see solrefequality";
  for (const char* loop : {"loop.hinge", "loop.ball", "loop.fixed"}) {
    out.set(loop, Support::approximate, soft_loop);
  }
  const char* const explicit_gain =
      "an explicit actuator: gains are at most what stops the axis within a step";
  out.set("motor.velocity", Support::approximate,
          "a velocity actuator: lags under load by the load times step over inertia");
  out.set("motor.position", Support::approximate,
          "a velocity actuator: lags under load by the load times step over inertia");
  out.set("motor.servo", Support::approximate, explicit_gain);
  out.set("motor.dc", Support::approximate, explicit_gain);
  out.set("contact.stiffness", Support::unsupported,
          "MuJoCo's contacts yield by acceleration, not by force: see solref and solimp");
  for (const char* feature :
       {"body.static", "body.kinematic", "runtime.add", "runtime.remove", "runtime.save",
        "runtime.set_state", "runtime.body_kind", "runtime.joint_axes", "report.contact_force",
        "report.joint_effort"}) {
    out.set(feature, Support::exact);
  }
  out.set("runtime.attach", Support::approximate,
          "a joint that closes a loop takes what it forbids in some hundredths of a second");
  out.set("report.joint_reaction", Support::approximate,
          "of joints in a tree that a fixed joint closes to a loop: MuJoCo leaves out part of its "
          "torque");
  return out;
}

}  // namespace cogrsim::mujoco

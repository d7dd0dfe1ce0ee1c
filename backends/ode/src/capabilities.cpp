#include "capabilities.h"

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::ode {

namespace {

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
           "eight points";
  }
  if (any(T::convex_mesh)) {
    return "ODE finds some of the points of two faces, not always those farthest apart: faces may "
           "lean, and a face that hits flat starts to turn";
  }
  if (any(T::cylinder) || is(T::box, T::capsule)) {
    return "ODE finds one point unless two ends or two sides lie flat on each other: what hits "
           "along a line starts to turn";
  }
  return nullptr;
}

void set_joints(Capabilities& out) {
  set_joint_features(out);
  const char* no_screw = "ODE has no screw";
  for (const char* feature :
       {"joint.screw", "loop.screw", "joint.limit.screw", "joint.damping.screw",
        "joint.friction.screw", "joint.stiffness.screw"}) {
    out.set(feature, Support::unsupported, no_screw);
  }
  const char* planar = "two angles stopped (AMotor) and no speed along the normal (LMotor)";
  out.set("joint.planar", Support::approximate, planar);
  out.set("loop.planar", Support::approximate, planar);
  out.set("joint.limit.planar", Support::unsupported, "ODE's LMotor has no stops");
  out.set("joint.limit.ball", Support::unsupported, "ODE's ball has no stops");
}

}  // namespace

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  for (const ShapeType a : kShapeTypes) {
    for (const ShapeType b : kShapeTypes) {
      if (is_surface(a) && is_surface(b)) continue;
      if (const char* note = pair_note(a, b)) {
        out.set(pair_feature(a, b), Support::approximate, note);
      }
    }
  }
  set_joints(out);
  out.set("contact.stiffness", Support::approximate, "a spring per contact point");
  for (const char* feature :
       {"body.static", "body.kinematic", "runtime.add", "runtime.remove", "runtime.save",
        "runtime.set_state", "runtime.attach", "runtime.body_kind", "runtime.joint_axes",
        "report.contact_force", "report.joint_reaction", "report.joint_effort"}) {
    out.set(feature, Support::exact);
  }
  return out;
}

}  // namespace cogrsim::ode

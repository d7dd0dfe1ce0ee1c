#include "mobilizers.h"

namespace cogrsim::dynamics {
namespace {

// Simbody slides along x where the scene language slides along z.
const SimTK::Rotation& x_to_z() {
  static const SimTK::Rotation R(-SimTK::Pi / 2, SimTK::YAxis);
  return R;
}

}  // namespace

SimTK::Body::Rigid rigid_body(const Body& body, double mass, const Mat3& inertia) {
  if (body.kind == BodyKind::kinematic)
    return SimTK::Body::Rigid(SimTK::MassProperties(1, SimTK::Vec3(0), SimTK::UnitInertia(1)));
  const Mat3& I = inertia;
  const SimTK::Vec3 c = to_simtk(body.com);
  const SimTK::Inertia central(SimTK::Vec3(I(0, 0), I(1, 1), I(2, 2)),
                               SimTK::Vec3(I(0, 1), I(0, 2), I(1, 2)));
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, c, central.shiftFromMassCenter(c, mass)));
}

Mobilizer mobilizer_of(const Joint& joint, bool reversed, SimTK::MobilizedBody inboard,
                       const Pose* anchor, const SimTK::Body::Rigid& rigid) {
  using SimTK::MobilizedBody;
  Mobilizer out;
  SimTK::Transform inner = to_simtk(reversed ? joint.X_CM : joint.X_PF);
  SimTK::Transform outer = to_simtk(reversed ? joint.X_PF : joint.X_CM);
  if (anchor) inner = to_simtk(*anchor) * inner;
  const auto direction = reversed ? MobilizedBody::Reverse : MobilizedBody::Forward;
  switch (joint.type) {
    case JointType::fixed:
      out.mobod = MobilizedBody::Weld(inboard, inner, rigid, outer);
      break;
    case JointType::hinge:
      out.mobod = MobilizedBody::Pin(inboard, inner, rigid, outer, direction);
      break;
    case JointType::slider:
      inner.updR() = inner.R() * x_to_z();
      outer.updR() = outer.R() * x_to_z();
      out.mobod = MobilizedBody::Slider(inboard, inner, rigid, outer, direction);
      break;
    case JointType::screw:
      out.mobod = MobilizedBody::Screw(inboard, inner, rigid, outer, joint.pitch / (2 * SimTK::Pi),
                                       direction);
      break;
    case JointType::cylindrical:
      out.mobod = MobilizedBody::Cylinder(inboard, inner, rigid, outer, direction);
      break;
    case JointType::universal:
      out.mobod = MobilizedBody::Universal(inboard, inner, rigid, outer, direction);
      break;
    case JointType::planar:
      out.mobod = MobilizedBody::Planar(inboard, inner, rigid, outer, direction);
      out.q_map = {1, 2, 0};
      out.u_map = {1, 2, 0};
      break;
    case JointType::ball:
      out.mobod = MobilizedBody::Ball(inboard, inner, rigid, outer, direction);
      break;
    case JointType::free:
      out.mobod = MobilizedBody::Free(inboard, inner, rigid, outer, direction);
      out.q_map = {4, 5, 6, 0, 1, 2, 3};
      out.u_map = {3, 4, 5, 0, 1, 2};
      break;
  }
  return out;
}

}  // namespace cogrsim::dynamics

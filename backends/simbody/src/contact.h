// Contact between shapes of all kinds, as a force element: points from CogRSim's geometry, the normal
// force and friction as Simbody's own contact elements have them.
#pragma once

#include <vector>

#include "collision/detector.h"
#include "mechanism.h"

#include "cogrsim/physics/state.h"

namespace cogrsim::simbody {

/// Normal force of Hunt and Crossley, f = k x (1 + c xdot) >= 0, x the depth (Simbody's for a brick's
/// corners on a half-space). Friction of Hollars, mu f min(v / v_t, 1) against the slip v, v_t the
/// transition velocity (Simbody's HuntCrossleyForce with equal static and dynamic coefficients and no
/// viscous one); rolling and spinning friction likewise, with v_t per metre as transition spin. A
/// function of the state alone: points are found again in each evaluation.
class GeneralContact final : public SimTK::Force::Custom::Implementation {
 public:
  GeneralContact(const Mechanism& mechanism, const Options& options);

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& body_forces,
                 SimTK::Vector_<SimTK::Vec3>& particle_forces,
                 SimTK::Vector& mobility_forces) const override;
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0.0; }  // not asked

  /// What touches, with the forces now. The state is realized to Stage::Velocity.
  const std::vector<Contact>& read(const SimTK::State& state) const;

 private:
  struct Motion {
    SimTK::Vec3 p{0};
    SimTK::SpatialVec V{SimTK::Vec3(0)};
    SimTK::MobilizedBodyIndex index;
  };
  struct Surface {
    double mu = 0.0, rolling = 0.0, spinning = 0.0, c = 0.0, k = 0.0;
    bool known = false;
  };

  const Surface& surface(int material_a, int material_b) const;
  double stiffness(const dynamics::Collider& a, const dynamics::Collider& b) const;
  /// On b at the point, world: torque [N m] and force [N].
  SimTK::SpatialVec push(const dynamics::ContactPoint& point) const;

  const Mechanism& mechanism_;
  const Options options_;
  mutable dynamics::Detector detector_;
  mutable std::vector<dynamics::ContactPoint> points_;
  mutable std::vector<Motion> motions_;  // of what contacts_ was found for, by body
  mutable SimTK::Vector q_, u_;          // likewise
  mutable std::vector<Contact> contacts_;
  mutable std::vector<SimTK::Vec3> torques_;  // of rolling and spinning friction, by contact
  mutable std::vector<Surface> surfaces_;     // nmaterial x nmaterial
};

/// Contacts of a step: means by the trapezoidal rule over the integrator's own steps. Points of one
/// pair of shapes that are nearer to each other than 2 cm are the same.
class ContactReport {
 public:
  void start(const std::vector<Contact>& now) { last_ = now, sums_.clear(); }
  void add(const std::vector<Contact>& now, double h);
  std::vector<Contact> get(double dt) const;

 private:
  std::vector<Contact> last_;  ///< forces [N]
  std::vector<Contact> sums_;  ///< impulses [N s], in the order of bodies and shapes
};

}  // namespace cogrsim::simbody

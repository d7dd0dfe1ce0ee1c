// Contact between shapes of all kinds, as a force element.
#pragma once

#include <vector>

#include "collision/compliant_contact.h"
#include "mechanism.h"

namespace cogrsim::simbody {

/// dynamics::CompliantContact: normal force as Simbody's for a brick's corners on a half-space, and
/// friction as HuntCrossleyForce's with equal static and dynamic coefficients and no viscous one.
class GeneralContact final : public SimTK::Force::Custom::Implementation {
 public:
  GeneralContact(const Mechanism& mechanism, const Options& options)
      : mechanism_(mechanism),
        contact_(mechanism.model(), options.contact, mechanism.static_poses()) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& body_forces,
                 SimTK::Vector_<SimTK::Vec3>& particle_forces,
                 SimTK::Vector& mobility_forces) const override;
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0.0; }  // not asked

  /// What touches, with the forces now. The state is realized to Stage::Velocity.
  const std::vector<Contact>& read(const SimTK::State& state) const;

 private:
  const Mechanism& mechanism_;
  mutable dynamics::CompliantContact contact_;
  mutable SimTK::Vector q_, u_;  // of what was found
};

}  // namespace cogrsim::simbody

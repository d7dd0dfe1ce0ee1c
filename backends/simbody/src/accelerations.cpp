#include "accelerations.h"

namespace cogrsim::simbody {
namespace {

// Beyond this many degrees of freedom in one tree the recursion beats the dense block.
constexpr int kLargestDense = 48;

}  // namespace

Accelerations::Accelerations(Mechanism& mechanism)
    : mechanism_(mechanism),
      mobility_forces_(mechanism.state.getNU(), 0.0),
      zero_(mechanism.state.getNU(), 0.0),
      body_forces_(mechanism.matter.getNumBodies(),
                   SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0))) {}

void Accelerations::compute(const std::vector<AxisLaw>& laws, SimTK::Vector& udot) {
  Mechanism& m = mechanism_;
  m.realize_velocity();
  const SimTK::Vector& q = m.state.getQ();
  const SimTK::Vector& u = m.state.getU();

  const SimTK::Vec3 g = to_simtk(m.model().physics.gravity);
  const std::vector<LinkMotion>& motions = m.motions();
  SimTK::SpatialVec* const body_forces = &body_forces_[0];
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Link& link = m.links()[i];
    if (link.kinematic) continue;
    const SimTK::Vec3 weight_force = link.mass * g;
    const SimTK::Vec3 arm = to_simtk(motions[i].X.R * link.com);
    body_forces[int(link.mobod.getMobilizedBodyIndex())] =
        SimTK::SpatialVec(arm % weight_force, weight_force);
  }

  double* const mobility_forces = numbers(mobility_forces_);
  std::fill_n(mobility_forces, mobility_forces_.size(), 0.0);
  for (const AxisLaw& law : laws) {
    if (!law.implicit) mobility_forces[law.speed] += law.effort_at(q, u);
  }

  if (m.has_loops()) {
    m.system.realize(m.state, SimTK::Stage::Dynamics);
    m.matter.calcAcceleration(m.state, mobility_forces_, body_forces_, udot, body_accelerations_);
    return;
  }
  if (m.largest_component() > kLargestDense) {
    m.system.realize(m.state, SimTK::Stage::Dynamics);
    m.matter.calcAccelerationIgnoringConstraints(m.state, mobility_forces_, body_forces_, udot,
                                                 body_accelerations_);
    return;
  }
  m.matter.calcResidualForceIgnoringConstraints(m.state, mobility_forces_, body_forces_, zero_,
                                                residual_);
  udot.resize(m.state.getNU());
  double* const accelerations = numbers(udot);
  const double* const residual = numbers(residual_);
  std::fill_n(accelerations, udot.size(), 0.0);
  for (Component& c : m.components()) {
    update_component(m, c);
    local_.resize(std::size_t(c.size()));
    for (int k = 0; k < c.size(); ++k) local_[std::size_t(k)] = -residual[c.speeds[std::size_t(k)]];
    solve_mass(c, local_.data());
    for (int k = 0; k < c.size(); ++k)
      accelerations[c.speeds[std::size_t(k)]] = local_[std::size_t(k)];
  }
}

}  // namespace cogrsim::simbody

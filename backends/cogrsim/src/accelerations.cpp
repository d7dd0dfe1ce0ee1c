#include "accelerations.h"

namespace cogrsim::dynamics {
Accelerations::Accelerations(Mechanism& mechanism)
    : mechanism_(mechanism),
      mobility_forces_(mechanism.state.getNU(), 0.0),
      zero_(mechanism.state.getNU(), 0.0),
      body_forces_(mechanism.matter.getNumBodies(),
                   SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0))) {}

void Accelerations::compute(const std::vector<AxisLaw>& laws, SimTK::Vector& udot) {
  Mechanism& m = mechanism_;
  const SimTK::Vector& q = m.state.getQ();
  const SimTK::Vector& u = m.state.getU();

  const Vec3 g = m.model().physics.gravity;
  const std::vector<LinkMotion>& motions = m.motions();
  weights_.resize(motions.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Link& link = m.links()[i];
    if (link.kinematic) continue;
    weights_[i] = link.mass * g;
  }

  double* const mobility_forces = numbers(mobility_forces_);
  std::fill_n(mobility_forces, mobility_forces_.size(), 0.0);
  for (const AxisLaw& law : laws) {
    if (!law.implicit) mobility_forces[law.speed] += law.effort_at(q, u);
  }
  if (m.closed_form()) {
    udot.resize(m.state.getNU());
    double* const accelerations = numbers(udot);
    std::fill_n(accelerations, udot.size(), 0.0);
    for (Component& c : m.components()) {
      local_.resize(std::size_t(c.size()));
      find_bias(m, c, weights_, local_.data());
      solve_block(c, accelerations);
    }
    return;
  }
  compute_with_simbody(udot);
}

// udot of one component; `local_` holds its bias.
void Accelerations::solve_block(Component& c, double* udot) {
  const double* const mobility_forces = numbers(mobility_forces_);
  for (int k = 0; k < c.size(); ++k) {
    double& x = local_[std::size_t(k)];
    x = mobility_forces[c.speeds[std::size_t(k)]] - x;
  }
  update_component(mechanism_, c);
  solve_mass(c, local_.data());
  for (int k = 0; k < c.size(); ++k) udot[c.speeds[std::size_t(k)]] = local_[std::size_t(k)];
}

void Accelerations::compute_with_simbody(SimTK::Vector& udot) {
  Mechanism& m = mechanism_;
  m.realize_velocity();
  const std::vector<LinkMotion>& motions = m.motions();
  SimTK::SpatialVec* const body_forces = &body_forces_[0];
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Link& link = m.links()[i];
    if (link.kinematic) continue;
    const SimTK::Vec3 weight = to_simtk(weights_[i]);
    const SimTK::Vec3 arm = to_simtk(motions[i].X.R * link.com);
    body_forces[int(link.mobod.getMobilizedBodyIndex())] = SimTK::SpatialVec(arm % weight, weight);
  }
  if (m.has_loops()) {
    m.system.realize(m.state, SimTK::Stage::Dynamics);
    m.matter.calcAcceleration(m.state, mobility_forces_, body_forces_, udot, body_accelerations_);
    return;
  }
  if (m.largest_component() > Mechanism::kLargestDense) {
    m.system.realize(m.state, SimTK::Stage::Dynamics);
    m.matter.calcAccelerationIgnoringConstraints(m.state, mobility_forces_, body_forces_, udot,
                                                 body_accelerations_);
    return;
  }
  m.matter.calcResidualForceIgnoringConstraints(m.state, zero_, body_forces_, zero_, residual_);
  udot.resize(m.state.getNU());
  double* const accelerations = numbers(udot);
  std::fill_n(accelerations, udot.size(), 0.0);
  const double* const residual = numbers(residual_);
  for (Component& c : m.components()) {
    local_.resize(std::size_t(c.size()));
    for (int k = 0; k < c.size(); ++k) local_[std::size_t(k)] = residual[c.speeds[std::size_t(k)]];
    solve_block(c, accelerations);
  }
}

}  // namespace cogrsim::dynamics

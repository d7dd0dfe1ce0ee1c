#include "accelerations.h"

#include "loops.h"

namespace cogrsim::dynamics {
Accelerations::Accelerations(Mechanism& mechanism)
    : mechanism_(mechanism),
      mobility_forces_(mechanism.state.getNU(), 0.0),
      zero_(mechanism.state.getNU(), 0.0),
      body_forces_(mechanism.matter.getNumBodies(),
                   SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0))) {}

void Accelerations::compute(const std::vector<AxisLaw>& laws, SimTK::Vector& udot,
                            const Middle* middle) {
  compute_open(laws, udot);
  if (mechanism_.has_loops()) close(middle, udot);
}

void Accelerations::compute_open(const std::vector<AxisLaw>& laws, SimTK::Vector& udot) {
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
  } else {
    compute_with_simbody(udot);
  }
}

void Accelerations::close(const Middle* middle, SimTK::Vector& udot) {
  Mechanism& m = mechanism_;
  if (!middle && !m.closed_form()) m.matter.calcBiasForSystemJacobian(m.state, body_bias_);
  for (Component& c : m.components()) {
    if (c.welds.empty()) continue;
    update_component(m, c);
    const std::size_t size = std::size_t(c.size());
    wanted_.resize(6 * c.welds.size());
    if (middle) {
      // G (u0 + h / 2 udot) = 0, where G u0 is what is found here less h / 2 of what led here.
      find_loop_speeds(m, c, wanted_.data());
      for (double& e : wanted_) e *= -2.0 / middle->h;
      start_.resize(size);
      for (std::size_t k = 0; k < size; ++k) start_[k] = (*middle->udot)[c.speeds[k]];
      add_loop_rows(c, 1.0, start_.data(), wanted_.data());
    } else {
      if (!m.closed_form()) take_bias(c);
      find_loop_bias(m, c, wanted_.data());
      for (double& e : wanted_) e = -e;
    }
    local_.resize(size);
    for (std::size_t k = 0; k < size; ++k) local_[k] = udot[c.speeds[k]];
    close_loops(c, local_.data(), wanted_.data());
    for (std::size_t k = 0; k < size; ++k) udot[c.speeds[k]] = local_[k];
  }
}

// Simbody has accelerations of the bodies' origins, Component::bias those of the space about its own.
void Accelerations::take_bias(Component& c) const {
  c.bias.resize(c.links.size());
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const LinkMotion& motion = mechanism_.motions()[std::size_t(c.links[i])];
    const Link& link = mechanism_.links()[std::size_t(c.links[i])];
    const SimTK::SpatialVec& a = body_bias_[int(link.mobod.getMobilizedBodyIndex())];
    c.bias[i].angular = from_simtk(a[0]);
    c.bias[i].linear = from_simtk(a[1]) - motion.angular.cross(motion.linear) +
                       c.bias[i].angular.cross(c.origin - motion.X.p);
  }
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
  if (m.largest_tree() > Mechanism::kLargestDense) {
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

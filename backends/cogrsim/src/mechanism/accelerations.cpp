#include "mechanism/accelerations.h"

#include "mechanism/loops.h"

namespace cogrsim::dynamics {
namespace {

// With more degrees of freedom the recursion beats the dense factor; and with more than this one that
// rows would need, for components that no row concerns.
constexpr int kLargestDense = 12, kLargestFactored = 48;

}  // namespace

Accelerations::Accelerations(Mechanism& mechanism) : mechanism_(mechanism) {}

void Accelerations::compute(const std::vector<AxisLaw>& laws, Values& udot, const Middle* middle) {
  compute_open(laws, udot);
  if (mechanism_.has_loops()) close(middle, udot);
}

void Accelerations::compute_open(const std::vector<AxisLaw>& laws, Values& udot) {
  Mechanism& m = mechanism_;
  const Values& q = m.state.q();
  const Values& u = m.state.u();

  udot.setZero(m.state.nu());
  for (const AxisLaw& law : laws) {
    if (!law.implicit && !m.components()[std::size_t(law.component)].asleep)
      udot[law.speed] += law.effort_at(q, u);
  }
  for (Component& c : m.components()) {
    if (c.asleep) continue;
    local_.resize(std::size_t(c.size()));
    find_bias(m, c, local_.data());
    for (int k = 0; k < c.size(); ++k) {
      double& x = local_[std::size_t(k)];
      x = udot[c.speeds[std::size_t(k)]] - x;
    }
    const bool factored = with_rows || c.has_loops();
    if (c.size() > (factored ? kLargestFactored : kLargestDense)) {
      solve_mass_recursively(c, local_.data());
    } else {
      update_component(m, c);
      solve_mass(c, local_.data());
    }
    for (int k = 0; k < c.size(); ++k) udot[c.speeds[std::size_t(k)]] = local_[std::size_t(k)];
  }
}

void Accelerations::close(const Middle* middle, Values& udot) {
  Mechanism& m = mechanism_;
  for (Component& c : m.components()) {
    if (!c.has_loops() || c.asleep) continue;
    update_component(m, c);
    const std::size_t size = std::size_t(c.size());
    wanted_.resize(6 * c.linkage->welds.size());
    if (middle) {
      // G (u0 + h / 2 udot) = 0, where G u0 is what is found here less h / 2 of what led here.
      find_loop_speeds(m, c, wanted_.data());
      for (double& e : wanted_) e *= -2.0 / middle->h;
      start_.resize(size);
      for (std::size_t k = 0; k < size; ++k) start_[k] = (*middle->udot)[c.speeds[k]];
      add_loop_rows(c, 1.0, start_.data(), wanted_.data());
    } else {
      find_loop_bias(m, c, wanted_.data());
      for (double& e : wanted_) e = -e;
    }
    local_.resize(size);
    for (std::size_t k = 0; k < size; ++k) local_[k] = udot[c.speeds[k]];
    close_loops(c, local_.data(), wanted_.data());
    for (std::size_t k = 0; k < size; ++k) udot[c.speeds[k]] = local_[k];
  }
}

}  // namespace cogrsim::dynamics

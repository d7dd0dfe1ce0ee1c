// Coordinates and speeds of a mechanism.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cogrsim::dynamics {

using Values = Eigen::VectorXd;

/// Coordinates q (nq) of all bases and joints and their speeds u (nu), with qdot = N(q) u.
class State {
 public:
  State() = default;
  State(int nq, int nu) : q_(Values::Zero(nq)), u_(Values::Zero(nu)) {}
  int nq() const { return int(q_.size()); }
  int nu() const { return int(u_.size()); }
  const Values& q() const { return q_; }
  const Values& u() const { return u_; }
  /// For one change; what was found at the values before is not of this state any more.
  Values& change_q() {
    ++q_version_;
    return q_;
  }
  Values& change_u() {
    ++u_version_;
    return u_;
  }
  std::int64_t q_version() const { return q_version_; }
  std::int64_t u_version() const { return u_version_; }

 private:
  Values q_, u_;
  std::int64_t q_version_ = 0, u_version_ = 0;
};

}  // namespace cogrsim::dynamics

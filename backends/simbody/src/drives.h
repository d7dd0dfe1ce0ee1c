// Motors and dry friction of joints, for which Simbody has no element: an effort is found at the start
// of each step from Simbody's own dynamics, and applied over the step as a generalized force.
#pragma once

#include <vector>

#include "mechanism.h"

#include "cogrsim/physics/drive.h"

namespace cogrsim::simbody {

/// The law of all drives at the end of the step, linearly ahead: with a the acceleration that the
/// axes have without drives and W = P M^-1 P^T what unit efforts add to it (Simbody's, loops
/// included), the speeds at the end are u + dt (a + W effort), and every effort obeys its law there
/// (see Drive) within its bound. Dry friction is a drive towards rest whose bound is the friction.
/// A damper too stiff for Simbody's explicit integrators (Mechanism::stiff_damping) is one, too.
class Drives {
 public:
  /// To be made before Mechanism::realize_topology(), and located after.
  explicit Drives(Mechanism& mechanism);
  void locate();

  bool empty() const { return axes_.empty(); }
  /// Realizes the state to Stage::Acceleration, and sets its discrete forces.
  void set(SimTK::State& state, double dt, const std::vector<Drive>& drives);
  /// Adds the efforts of the last step to `joints` (WorldState::joint_efforts), `motors` takes them.
  void get_efforts(const SimTK::State& state, std::vector<double>& joints,
                   std::vector<double>& motors) const;

 private:
  struct Axis {
    int motor = -1;  ///< SceneModel::motors; -1: dry friction; kDamper
    int effort = 0;  ///< WorldState::joint_efforts
    int link = -1, tree = -1;
    int q = -1, u = -1;  ///< in the state, once located
    double friction = 0.0;
    int damper = -1;       ///< that of the same axis: it acts in every law there
    double damping = 0.0;  ///< its
    bool ball = false;     ///< one of three axes in a row that share `friction` as one vector
    SimTK::Force::MobilityDiscreteForce force;
    std::size_t first = 0;  ///< of its tree's axes
    double now = 0.0;
  };

  static constexpr int kDamper = -2;

  void add(Mechanism& mechanism, int joint, int axis, int motor, double friction);
  void find_mobility(const SimTK::State& state);
  double& w(std::size_t row, std::size_t column) {
    return w_[row * widest_ + (column - axes_[row].first)];
  }

  const Mechanism& mechanism_;
  std::vector<Axis> axes_;  ///< by tree
  std::size_t widest_ = 0;  ///< most axes of a tree
  std::vector<double> w_;   ///< W, by axis and axis of the same tree [1/(kg m^2)], [1/kg]
};

}  // namespace cogrsim::simbody

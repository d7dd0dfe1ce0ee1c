// The scene as a Simbody system: bodies, mobilizers, the welds that close loops, and its own forces.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "convert.h"
#include "options.h"
#include "rows.h"

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"

namespace cogrsim::simbody {

/// A mobilized body. Simbody's body frame is the scene's; what moves freely moves in its centre of
/// mass (kinematic: in its origin), so that its speeds are its angular velocity and the velocity of
/// that point, in world axes.
struct Link {
  SimTK::MobilizedBody mobod;
  /// q_map[i]: index, among the mobilizer's q, of the model's q_i; u_map likewise.
  std::array<int, 7> q_map{0, 1, 2, 3, 4, 5, 6};
  std::array<int, 6> u_map{0, 1, 2, 3, 4, 5};
  int body = -1;          ///< SceneModel::bodies
  int joint = -1;         ///< SceneModel::joints; -1: moves freely in the world
  bool reversed = false;  ///< outboard is the joint's parent
  bool slave = false;     ///< a part of a body that was cut to open a loop
  bool kinematic = false;
  int tree = -1;                 ///< number of what can push each other through joints
  SimTK::Motion::Steady motion;  ///< of kinematic ones
  int q = 0, nq = 0, u = 0, nu = 0;
};

/// A rotor on an axis: a body on a pin on the ground that turns as fast as the axis (LinearRows).
struct Rotor {
  int link = -1, axis = 0;  ///< Mechanism::links(), the axis of its joint
  double inertia = 0.0;
  SimTK::MobilizedBody pin;
  int u = 0;  ///< in the state
};

/// Springs, dampers and stops of one axis, as Simbody has them.
struct AxisForces {
  int joint = -1;    ///< SceneModel::joints
  int effort = 0;    ///< WorldState::joint_efforts
  int q = 0, u = 0;  ///< in the state
  JointAxis axis;
  SimTK::Force::MobilityLinearStop stop;
  SimTK::Force damper;  ///< disabled where is_stiff
  bool stops = false, is_stiff = false;
  double stop_stiffness = 0.0;
  double rotor = 0.0;  ///< inertia
};

class Mechanism {
 public:
  /// `static_poses` has the poses of static bodies. Throws what Simbody throws.
  Mechanism(SceneModelPtr model, std::vector<Pose> static_poses, const Options& options);

  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};

  const SceneModel& model() const { return *model_; }
  const std::vector<Pose>& static_poses() const { return static_poses_; }
  const std::vector<Link>& links() const { return links_; }
  /// -1: the ground.
  int body_link(int body) const { return body < 0 ? -1 : body_links_[body]; }
  /// -1: holds nothing that forces move.
  int joint_link(int joint) const { return joint_links_[joint]; }
  const SimTK::MobilizedBody& mobod(int body) const;
  const std::vector<AxisForces>& axes() const { return axes_; }
  const std::vector<Rotor>& rotors() const { return rotors_; }
  /// Of a speed (WorldState::joint_efforts) whose damper an explicit integrator cannot hold in the
  /// scene's steps [N m s/rad], [N s/m]; 0: it has none such.
  double stiff_damping(int effort) const;
  bool has_loops() const { return has_loops_; }

  /// To be called once, when all forces are there: the scene's state at the start.
  SimTK::State realize_topology();

  // Realized to Stage::Position, Stage::Velocity.
  Pose pose(const SimTK::State& state, int body) const;
  Twist twist(const SimTK::State& state, int body) const;

  // Of one mobilizer's own coordinates.
  void set_base(SimTK::State& state, const Link& link, const Pose& X_WB, const Twist& V_WB) const;
  void set_joint(SimTK::State& state, const Link& link, const double* q, const double* u) const;
  void get_joint(const SimTK::State& state, const Link& link, double* q, double* u) const;
  /// All coordinates and speeds, then project().
  void set_all(SimTK::State& state, const WorldState& from) const;
  /// Kinematic bodies move with the speeds that the state has.
  void set_rates(SimTK::State& state) const;

  /// Rotors turn as their axes do.
  void set_rotors(SimTK::State& state) const;
  /// Of couplings in the state, to those of joints (WorldState::joint_efforts).
  void add_coupling_efforts(const SimTK::State& state, std::vector<double>& joints) const;
  /// Forces on bodies (nbody), or none, from now on. Realized to Stage::Position.
  void set_external(SimTK::State& state, const std::vector<Wrench>& forces) const;

  /// Quaternions to unit length, coordinates and speeds onto closed loops.
  void project(SimTK::State& state) const;

 private:
  bool is_ground(int body) const;
  bool is_dynamic(int body) const;
  int inboard(int link) const;
  void plan();
  void weld_slaves();
  void join_trees(int one, int other);
  void add_link(Link link, int inboard, int anchor, int fragments);
  void add_axes(const Joint& joint, const Link& link);
  SimTK::Constraint keep(std::unique_ptr<LinearRows> rows);
  void add_rotors();
  void add_couplings();
  void set_axes(SimTK::State& state);

  SimTK::Force::DiscreteForces external_{forces, matter};
  SceneModelPtr model_;
  std::vector<Pose> static_poses_;
  Options options_;
  std::vector<Link> links_;
  std::vector<int> body_links_, joint_links_;
  std::vector<AxisForces> axes_;
  std::vector<Rotor> rotors_;
  std::vector<LinearRows*> rows_;  ///< owned by the constraints
  std::vector<SimTK::Constraint> rows_constraints_;
  SimTK::Constraint couplers_;
  std::vector<int> coupled_;  ///< SceneModel::couplings of the rows of coordinates
  bool has_loops_ = false;
};

}  // namespace cogrsim::simbody

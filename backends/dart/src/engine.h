// One scene in DART: its world, skeletons, shapes and rows. Another is made when the scene changes.
#pragma once

#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/simulation/World.hpp>
#include <memory>
#include <vector>

#include "cogrsim/physics/drive.h"
#include "contacts.h"
#include "options.h"
#include "rows.h"
#include "trees.h"

namespace cogrsim::dart_engine {

class Engine {
 public:
  /// The scene in the state `begin`. Errors: a shape or an option that DART does not take, with its
  /// source position.
  static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model, const WorldState& begin);

  const Trees& trees() const { return trees_; }
  const SceneModel& model() const { return *model_; }

  /// World::step. `twists`: of kinematic bodies; `external`: on bodies, or none.
  void step(double h, const std::vector<Drive>& drives, const std::vector<Twist>& twists,
            const std::vector<Wrench>& external);
  /// The body of the first link beyond all bounds or not a number; -1: none. DART would end the
  /// process over what is not a number.
  int find_lost() const;
  /// Likewise of a motor or force with which a step would end so.
  int find_overload(const std::vector<Drive>& drives, const std::vector<Wrench>& external) const;

  Pose pose(int body) const;
  Twist twist(int body) const;
  void efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void reactions(std::vector<Wrench>& out) const;
  void report(std::vector<Contact>& out) const {
    detector_->report(world_->getConstraintSolver()->getLastCollisionResult(), out);
  }
  /// There is no last step any more.
  void forget_step();
  /// All that DART holds between steps, to the bit.
  struct State {
    std::vector<Motion> motions;                  ///< by link
    std::vector<std::array<double, 6>> impulses;  ///< by weld
  };
  State state() const;
  void set_state(const State& state);
  /// Takes over what is held as it was in `old`.
  void take_over(const Engine& old);

 private:
  using RowPtr = std::shared_ptr<AxisRow>;
  /// What acts along an axis beside motors.
  struct AxisLaw {
    int joint = -1, axis = 0;
    dart::dynamics::Joint* in_dart = nullptr;
    RowPtr look;     ///< the speed before constraints, for efforts of DART's spring and damper
    RowPtr passive;  ///< spring and damper of an axis with a rotor, which DART's own do not see
    RowPtr rotor;
    double q = 0.0;  ///< when the last step began
  };
  struct MotorLaw {
    int motor = -1;
    RowPtr row;
    dart::dynamics::Joint* joint = nullptr;
    bool servo = false;    ///< may be DART's own
    double applied = 0.0;  ///< as a command [N m], [N]
  };

  Engine(const SceneModelPtr& model, const std::vector<Pose>& poses)
      : model_(model), trees_(*model, poses) {}
  RowPtr add_row(std::vector<AxisRow::Term> terms);
  void add_axes();
  void add_ball(int joint);
  void add_motors();
  void add_couplings();
  bool is_coupled(int joint) const;
  void set_motor(MotorLaw& law, const Drive& drive, double h);
  void set_coupling(std::size_t index, double h);
  void set_kinematic(const Link& link, const Twist& V, double h) const;
  void push(const std::vector<Wrench>& external) const;
  const JointAxis& axis_of(const AxisLaw& law) const {
    return model_->joints[static_cast<std::size_t>(law.joint)]
        .axes[static_cast<std::size_t>(law.axis)];
  }

  SceneModelPtr model_;
  Trees trees_;
  dart::simulation::WorldPtr world_;
  std::shared_ptr<Detector> detector_;
  std::vector<AxisLaw> axes_;
  std::vector<MotorLaw> motors_;
  struct CouplingLaw {
    int coupling = -1;
    RowPtr row;
    double constant = 0.0;  ///< offset, and what does not move
  };
  std::vector<CouplingLaw> couplings_;
  std::vector<Eigen::Isometry3d> before_;  ///< by link, when the last step began
  double h_ = 0.0;                         ///< of the last step; 0: none
};

}  // namespace cogrsim::dart_engine

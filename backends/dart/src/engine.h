// One scene in DART: its world, skeletons, shapes and rows. Another is made when the scene changes.
#pragma once

#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/simulation/World.hpp>
#include <memory>
#include <vector>

#include "cogrsim/physics/engine_world.h"
#include "contacts.h"
#include "rows.h"
#include "trees.h"

namespace cogrsim::dart_engine {

class Engine final : public SceneEngine {
 public:
  static constexpr const char *kName = "dart", *kTitle = "DART";
  static constexpr bool kLacksCouplings = false;
  /// By DART's own names and with its own defaults but one.
  static const ParameterTable& options();

  /// Errors: a shape that DART does not take, with its source position.
  static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model, const Parameters& options,
                                              const WorldState& begin, const Engine* old);
  void take_over(const Engine& old, const WorldState& begin, const SceneChange& change);

  /// World::step, of what is a number: DART would end the process over what is not.
  void step(const StepInput& input);
  int find_lost() const;
  bool undo();

  Pose pose(int body) const { return from_dart(trees_.node(body)->getTransform()); }
  Twist twist(int body) const;
  /// A ball's is followed: of two signs of a quaternion it is the one nearer to what it was.
  bool has_coordinates(int joint) const {
    return trees_.link_of_joint(joint) >= 0 && model_->joints[joint].type != JointType::ball;
  }
  bool read_joint(int joint, double* q, double* u) const;
  void write(const WorldState& state) {
    trees_.set_all(state);
    forget_step();
  }
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void read_reactions(std::vector<Wrench>& out) const;
  void read_contacts(std::vector<Contact>& out) const {
    detector_->report(world_->getConstraintSolver()->getLastCollisionResult(), out);
  }
  std::shared_ptr<const HostedMemory> save() const { return std::make_shared<State>(state()); }
  void restore(const HostedMemory& memory);

 private:
  /// All that DART holds between steps, to the bit.
  struct State final : HostedMemory {
    std::vector<Motion> motions;                  ///< by link
    std::vector<std::array<double, 6>> impulses;  ///< by weld
  };
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
  /// Throws StepRefused over a motor or force with which DART would end the process.
  void check_loads(const StepInput& input) const;
  State state() const;
  void forget_step();  ///< there is no last step any more
  const JointAxis& axis_of(const AxisLaw& law) const {
    return model_->joints[law.joint].axes[law.axis];
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
  State start_;                            ///< of the last step
  std::vector<Eigen::Isometry3d> before_;  ///< by link, when it began
  double h_ = 0.0;                         ///< of the last step; 0: none
};

}  // namespace cogrsim::dart_engine

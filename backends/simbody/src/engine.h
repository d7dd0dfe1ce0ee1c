// One scene in Simbody: its system with all that was added to it, and a state of it.
#pragma once

#include <memory>
#include <vector>

#include "contact.h"
#include "drives.h"
#include "mechanism.h"
#include "trackers.h"

#include "cogrsim/physics/engine_world.h"

namespace cogrsim::simbody {

class Engine final : public SceneEngine {
 public:
  static constexpr const char *kName = "simbody", *kTitle = "Simbody";
  static constexpr bool kLacksCouplings = false;
  static constexpr double kEvaluationTime = 0.5;
  static constexpr StateBounds kBounds{1e6, 1e6, 1e6};
  static const ParameterTable& options() { return world_option_table(); }

  static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model, const Parameters& options,
                                              const WorldState& begin, const Engine*) {
    return std::unique_ptr<Engine>(new Engine(model, options_from(options), begin.poses));
  }
  void take_over(Engine& old, const WorldState& begin, const SceneChange& change);

  void step(const StepInput& input);
  int find_lost() const;
  bool undo();
  void prepare_reading() const { mechanism_.system.realize(state(), SimTK::Stage::Velocity); }
  Pose pose(int body) const { return mechanism_.pose(state(), body); }
  Twist twist(int body) const { return mechanism_.twist(state(), body); }
  bool has_coordinates(int joint) const { return mechanism_.joint_link(joint) >= 0; }
  bool read_joint(int joint, double* q, double* u) const;
  void write(const WorldState& state);
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void read_contacts(std::vector<Contact>& out) const { out = contacts_.get(last_dt_); }
  void read_reactions(std::vector<Wrench>& out) const;
  std::shared_ptr<const HostedMemory> save() const;
  void restore(const HostedMemory& memory);
  void move_kinematic(int body, const Twist& twist);

 private:
  struct Coordinates {
    SimTK::Vector q, u;
    double time = 0.0;
  };
  struct Memory final : HostedMemory {
    Coordinates coordinates;
    double next_step = 0.0;
  };

  Engine(const SceneModelPtr& model, const Options& options, const std::vector<Pose>& poses);
  void start_integrator(double dt);
  void stop_integrator();
  const SimTK::State& state() const {
    return integrator_ ? integrator_->getAdvancedState() : state_;
  }
  void put_back(const Coordinates& from);
  void run_integrator(double end);
  void look(double h);
  /// Each mobilizer that was there before as it was, bit for bit; the others as `seen`.
  void carry_over(const Engine& old, const WorldState& seen, const std::vector<int>& inelastic);

  const SceneModelPtr model_;
  const Options options_;
  Mechanism mechanism_;
  Drives drives_{mechanism_};
  GeneralContact* contact_ = nullptr;  ///< owned by the force subsystem
  std::unique_ptr<TrackerContact> trackers_;
  SimTK::State start_, state_;                     ///< state_: while there is no integrator
  std::unique_ptr<SimTK::Integrator> integrator_;  ///< none: before the first step, after changes
  double next_step_ = 0.0;  ///< of the integrator that is to come [s]; 0: as Simbody has it
  double last_dt_ = 0.0;
  bool has_external_forces_ = false;  ///< the state has them
  Coordinates before_;                ///< the last step
  dynamics::ContactMeans contacts_;
  std::vector<Contact> now_;
  std::vector<double> efforts_, last_efforts_;  ///< of springs, dampers, stops: impulses, at a time
};

}  // namespace cogrsim::simbody

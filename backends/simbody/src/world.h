// A running world on Simbody.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contact.h"
#include "drives.h"
#include "mechanism.h"
#include "trackers.h"

#include "cogrsim/physics/hosted_world.h"

namespace cogrsim::simbody {

class SimbodyWorld final : public HostedWorld {
 public:
  double evaluation_time() const override { return 0.5; }

 private:
  using StaticPoses = std::shared_ptr<const std::vector<Pose>>;  ///< of static bodies, by body
  struct Saved final : HostedMemory {
    StaticPoses static_poses;
    SimTK::Vector q, u;
    double time = 0.0, next_step = 0.0;
  };
  /// Simbody's system with all that was added to it. It stays where it is: the system refers to it.
  struct Engine {
    Engine(SceneModelPtr model, StaticPoses poses, const Options& options);
    const SceneModelPtr scene;
    StaticPoses static_poses;
    Mechanism mechanism;
    Drives drives{mechanism};
    GeneralContact* contact = nullptr;  ///< owned by the force subsystem
    std::unique_ptr<TrackerContact> trackers;
    SimTK::State start;
  };

  const char* engine_name() const override { return "simbody"; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override;
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange& change) override;
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override;
  void prepare_reading() const override {
    engine_->mechanism.system.realize(state(), SimTK::Stage::Velocity);
  }
  Pose pose(int body) const override { return engine_->mechanism.pose(state(), body); }
  Twist twist(int body) const override { return engine_->mechanism.twist(state(), body); }
  bool has_coordinates(int joint) const override {
    return engine_->mechanism.joint_link(joint) >= 0;
  }
  bool read_joint(int joint, double* q, double* u) const override;
  Result<> write(const WorldState& state) override;
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override;
  void read_contacts(std::vector<Contact>& out) const override { out = contacts_.get(last_dt_); }
  void read_reactions(std::vector<Wrench>& out) const override;
  MemoryPtr save_memory() const override;
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override;
  void move_kinematic(int body) override;

  void start_integrator(double dt);
  void stop_integrator();
  const SimTK::State& state() const {
    return integrator_ ? integrator_->getAdvancedState() : state_;
  }
  void run_integrator(double end);
  void read_contacts(const SimTK::State& state);
  void add_efforts(const SimTK::State& state, double h);
  int find_diverged(const SimTK::State& state) const;
  SimTK::State carried_over(const Mechanism& old, const WorldState& seen,
                            const std::vector<int>& inelastic) const;

  bool has_external_forces_ = false;  ///< the state has external forces
  Options options_;
  std::shared_ptr<Engine> engine_;
  std::unique_ptr<SimTK::Integrator> integrator_;  ///< none: before the first step, after changes
  SimTK::State state_;                             ///< while there is no integrator
  double next_step_ = 0.0;  ///< of the integrator that is to come [s]; 0: as Simbody has it
  double last_dt_ = 0.0;
  dynamics::ContactMeans contacts_;
  std::vector<Contact> now_;
  std::vector<double> efforts_, last_efforts_;  ///< of springs, dampers, stops: impulses, at a time
};

}  // namespace cogrsim::simbody

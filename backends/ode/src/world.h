// A running world on ODE.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/physics/hosted_world.h"
#include "engine.h"

namespace cogrsim::ode {

class OdeWorld final : public HostedWorld {
 public:
  std::vector<Diagnostic> warnings() const override;

 private:
  /// All that a run knows beside what ODE's bodies hold, which are read into it after each step.
  struct Progress final : HostedMemory {
    unsigned long seed = 0;
    std::vector<Motion> motions;  ///< of ODE's bodies (nbody)
    double h = 0.0;               ///< of the last step
    std::vector<int> order;       ///< Engine::order(), of what is saved
  };

  const char* engine_name() const override { return "ode"; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override;
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange& change) override;
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override;
  Pose pose(int body) const override;
  Twist twist(int body) const override;
  double fastest_spin() const override;
  Result<> write(const WorldState& state) override;
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override;
  void read_contacts(std::vector<Contact>& out) const override { engine_->report(out); }
  void read_reactions(std::vector<Wrench>& out) const override;
  MemoryPtr save_memory() const override;
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override;
  void move_kinematic(int body) override;
  bool lacks_couplings() const override { return true; }

  /// Another engine for `model` with the motions of `progress`. Errors: as Engine::make; nothing has
  /// changed then.
  Result<> make(const SceneModelPtr& model, const std::vector<Pose>& poses, Progress progress);
  void write_motions();
  /// The first body beyond all bounds after reading all; -1: none.
  int read_motions();
  StepResult lost(int body, std::string what);

  ShapeData shapes_;
  Progress now_;
  std::vector<Motion> before_;  ///< Progress::motions before the last step
  std::unique_ptr<Engine> engine_;
  bool unchecked_ = true;  ///< motions that no step has left
};

}  // namespace cogrsim::ode

// A running world on DART.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/physics/hosted_world.h"
#include "engine.h"

namespace cogrsim::dart_engine {

class DartWorld final : public HostedWorld {
 private:
  struct Memory final : HostedMemory {
    Engine::State state;
  };

  const char* engine_name() const override { return "dart"; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override;
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange& change) override;
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override;
  Pose pose(int body) const override { return engine_->pose(body); }
  Twist twist(int body) const override { return engine_->twist(body); }
  bool has_coordinates(int joint) const override;
  bool read_joint(int joint, double* q, double* u) const override;
  Result<> write(const WorldState& state) override;
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override {
    engine_->efforts(joints, motors);
  }
  void read_contacts(std::vector<Contact>& out) const override { engine_->report(out); }
  void read_reactions(std::vector<Wrench>& out) const override { engine_->reactions(out); }
  MemoryPtr save_memory() const override;
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override;

  std::unique_ptr<Engine> engine_;
};

}  // namespace cogrsim::dart_engine

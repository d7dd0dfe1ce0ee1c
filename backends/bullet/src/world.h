// A world of the Bullet backend.
#pragma once

#include <memory>
#include <vector>

#include "convert.h"
#include "engine.h"

namespace cogrsim::bullet {

class BulletWorld final : public HostedWorld {
 public:
  std::vector<Diagnostic> warnings() const override { return engine_->warnings(); }

 private:
  const char* engine_name() const override { return "bullet"; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override;
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange& change) override;
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override;
  Pose pose(int body) const override { return engine_->pose(body); }
  Twist twist(int body) const override {
    const bool kinematic = model()->bodies[at(body)].kind == BodyKind::kinematic;
    return kinematic ? twists()[at(body)] : engine_->twist(body);
  }
  double fastest_spin() const override { return engine_->fastest_spin(); }
  Result<> write(const WorldState& state) override {
    engine_->set_state(state);
    return {};
  }
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override {
    engine_->get_efforts(joints, motors);
  }
  void read_contacts(std::vector<Contact>& out) const override { engine_->get_contacts(out); }
  void read_reactions(std::vector<Wrench>& out) const override { engine_->get_reactions(out); }
  MemoryPtr save_memory() const override { return engine_->save(); }
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override;
  bool lacks_couplings() const override { return true; }

  std::unique_ptr<Engine> engine_;
};

}  // namespace cogrsim::bullet

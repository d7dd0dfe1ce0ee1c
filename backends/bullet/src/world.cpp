#include "world.h"

namespace cogrsim::bullet {

Result<> BulletWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  auto engine = Engine::create(model, begin);
  if (!engine) return tl::unexpected<Error>(engine.error());
  engine_ = std::move(*engine);
  return {};
}

Result<> BulletWorld::rebuild(const SceneModelPtr& next, const WorldState& begin,
                              const SceneChange&) {
  const auto memory = engine_->save();
  if (auto built = build(next, begin); !built) return built;
  engine_->restore(*memory);
  return {};
}

Result<> BulletWorld::restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                     const WorldState&) {
  if (auto built = build(model, initial_state(*model)); !built) return built;
  engine_->restore(static_cast<const Memory&>(*memory));
  return {};
}

StepResult BulletWorld::advance(double dt, const std::vector<Drive>& drives,
                                const std::vector<double>& efforts) {
  const int lost = engine_->step(
      dt, {drives, efforts, twists(), external_, [this](int joint) { return coordinates(joint); }});
  return lost < 0 ? StepResult() : diverged(lost, StateBounds());
}

}  // namespace cogrsim::bullet

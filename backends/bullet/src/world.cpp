#include "world.h"

namespace cogrsim::bullet {

Result<std::unique_ptr<World>> BulletWorld::create(const SceneModelPtr& model) {
  if (!model) return fail("no scene given");
  const auto options = read_options(*model);
  if (!options) return tl::unexpected<Error>(options.error());
  std::unique_ptr<BulletWorld> out(new BulletWorld(*options));
  if (auto started = out->start(model); !started) return tl::unexpected<Error>(started.error());
  return out;
}

Result<> BulletWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  auto engine = Engine::create(model, options_, begin);
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
  const int lost = engine_->step(dt, {drives, efforts, twists(), external_});
  return lost < 0 ? StepResult() : diverged(lost, "1000 km, 100 km/s");
}

void BulletWorld::read(WorldState& out) const {
  const SceneModel& scene = *model();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (body.removed) continue;
    out.poses[b] = engine_->pose(static_cast<int>(b));
    if (body.kind != BodyKind::kinematic) out.twists[b] = engine_->twist(static_cast<int>(b));
  }
  engine_->get_joints(out);
}

}  // namespace cogrsim::bullet

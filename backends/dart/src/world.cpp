#include "world.h"

#include <algorithm>
#include <exception>

namespace cogrsim::dart_engine {

Result<> DartWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  auto made = Engine::make(model, begin);
  if (!made) return tl::unexpected(made.error());
  engine_ = std::move(*made);
  return {};
}

Result<> DartWorld::rebuild(const SceneModelPtr& next, const WorldState& begin,
                            const SceneChange& change) {
  auto made = Engine::make(next, begin);
  if (!made) return tl::unexpected(made.error());
  (*made)->take_over(*engine_);
  const std::vector<int> hit = struck_bodies(*next, change);
  if (!hit.empty()) (*made)->trees().take_impact(begin, hit);
  engine_ = std::move(*made);
  return {};
}

StepResult DartWorld::advance(double dt, const std::vector<Drive>& drives,
                              const std::vector<double>&) {
  // DART would end the process over what is not a number or nearly so.
  if (const int body = engine_->find_lost(); body >= 0) return diverged(body, StateBounds());
  if (const int body = engine_->find_overload(drives, external_); body >= 0)
    return diverged(body, "1e12 N, N m, m/s");
  const Engine::State before = engine_->state();
  StepResult out;
  try {
    engine_->step(dt, drives, twists(), external_);
    if (const int body = engine_->find_lost(); body >= 0) out = diverged(body, StateBounds());
  } catch (const std::bad_alloc&) {
    throw;  // no fault of the world's
  } catch (const std::exception& error) {
    out = {StepStatus::diverged, -1, std::string("DART: ") + error.what()};
  }
  if (out.status != StepStatus::diverged) return out;
  engine_->set_state(before);
  engine_->forget_step();
  return out;
}

// Of two signs of a quaternion the one that is nearer to what it was, which a state alone does not tell.
bool DartWorld::has_coordinates(int joint) const {
  return engine_->trees().link_of_joint(joint) >= 0 &&
         engine_->model().joints[static_cast<std::size_t>(joint)].type != JointType::ball;
}

bool DartWorld::read_joint(int joint, double* q, double* u) const {
  const Trees& trees = engine_->trees();
  const int link = trees.link_of_joint(joint);
  if (link >= 0) trees.get_joint(trees.links()[static_cast<std::size_t>(link)], q, u);
  return link >= 0;
}

Result<> DartWorld::write(const WorldState& state) {
  engine_->trees().set_all(state);
  engine_->forget_step();
  return {};
}

HostedWorld::MemoryPtr DartWorld::save_memory() const {
  auto out = std::make_shared<Memory>();
  out->state = engine_->state();
  return out;
}

Result<> DartWorld::restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                   const WorldState& begin) {
  if (model != this->model())
    if (auto made = build(model, begin); !made) return made;
  const auto& saved = static_cast<const Memory&>(*memory);
  engine_->set_state(saved.state);
  engine_->forget_step();
  return {};
}

}  // namespace cogrsim::dart_engine

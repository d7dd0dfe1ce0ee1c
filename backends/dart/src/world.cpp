#include "world.h"

#include <algorithm>
#include <exception>

namespace cogrsim::dart_engine {

Result<std::unique_ptr<World>> DartWorld::create(const SceneModelPtr& model) {
  std::unique_ptr<DartWorld> world(new DartWorld);
  if (auto started = world->start(model); !started) return tl::unexpected(started.error());
  return world;
}

Result<> DartWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  auto made = Engine::make(model, begin);
  if (!made) return tl::unexpected(made.error());
  engine_ = std::move(*made);
  take_scene(begin);
  return {};
}

Result<> DartWorld::rebuild(const SceneModelPtr& next, const WorldState& begin,
                            const SceneChange& change) {
  auto made = Engine::make(next, begin);
  if (!made) return tl::unexpected(made.error());
  (*made)->take_over(*engine_);
  // Inelastic impacts: of a new joint, or with what has been made static.
  std::vector<int> hit;
  const auto add = [&](const Joint& joint) { hit.insert(hit.end(), {joint.parent, joint.child}); };
  for (const int j : change.attached) add(next->joints[static_cast<std::size_t>(j)]);
  for (const int b : change.kinds)
    for (const Joint& joint : next->joints)
      if (!joint.removed && (joint.parent == b || joint.child == b)) add(joint);
  if (!hit.empty()) (*made)->trees().take_impact(begin, hit);
  engine_ = std::move(*made);
  take_scene(begin);
  return {};
}

StepResult DartWorld::advance(double dt, const std::vector<Drive>& drives,
                              const std::vector<double>&) {
  constexpr const char* kBounds = "1000 km, 100 km/s";
  // DART would end the process over what is not a number or nearly so.
  if (const int body = engine_->find_lost(); body >= 0) return diverged(body, kBounds);
  if (const int body = engine_->find_overload(drives, external_); body >= 0)
    return diverged(body, "1e12 N, N m, m/s");
  const Engine::State before = engine_->state();
  StepResult out;
  try {
    engine_->step(dt, drives, twists(), external_);
    if (const int body = engine_->find_lost(); body >= 0) out = diverged(body, kBounds);
  } catch (const std::bad_alloc&) {
    throw;  // no fault of the world's
  } catch (const std::exception& error) {
    out = {StepStatus::diverged, -1, std::string("DART: ") + error.what()};
  }
  if (out.status != StepStatus::diverged) {
    follow();
    return out;
  }
  engine_->set_state(before);
  engine_->forget_step();
  return out;
}

void DartWorld::read_bodies(WorldState& out) const {
  const SceneModel& model = engine_->model();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (model.bodies[b].removed) continue;
    const bool still = model.bodies[b].kind == BodyKind::static_body;
    out.poses[b] = still ? last().poses[b] : engine_->pose(static_cast<int>(b));
    out.twists[b] = still ? Twist() : engine_->twist(static_cast<int>(b));
  }
}

void DartWorld::read_joints(WorldState& out, const std::vector<int>& joints) const {
  const Trees& trees = engine_->trees();
  for (const int j : joints) {
    const Joint& joint = engine_->model().joints[static_cast<std::size_t>(j)];
    double* const q = out.joint_positions.data() + joint.position_offset;
    double* const u = out.joint_velocities.data() + joint.speed_offset;
    std::copy_n(followed_.begin() + joint.position_offset, position_count(joint.type), q);
    const int link = trees.link_of_joint(j);
    link >= 0 ? trees.get_joint(trees.links()[static_cast<std::size_t>(link)], q, u)
              : read_joint(joint, out, q, u);
  }
}

void DartWorld::read(WorldState& out) const {
  read_bodies(out);
  read_joints(out, joints_);
}

// Of two signs of a quaternion the one that is nearer to what it was, which a state alone does not tell.
void DartWorld::follow() {
  if (turning_.empty()) return;
  WorldState now = last();
  read_bodies(now);
  read_joints(now, turning_);
  followed_ = now.joint_positions;
}

void DartWorld::take_scene(const WorldState& begin) {
  followed_ = begin.joint_positions;
  joints_.clear();
  turning_.clear();
  const SceneModel& model = engine_->model();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].removed) continue;
    joints_.push_back(static_cast<int>(j));
    if (model.joints[j].type == JointType::ball ||
        engine_->trees().link_of_joint(static_cast<int>(j)) < 0)
      turning_.push_back(static_cast<int>(j));
  }
}

Result<> DartWorld::write(const WorldState& state) {
  engine_->trees().set_all(state);
  followed_ = state.joint_positions;
  engine_->forget_step();
  return {};
}

HostedWorld::MemoryPtr DartWorld::save_memory() const {
  auto out = std::make_shared<Memory>();
  out->state = engine_->state();
  out->followed = followed_;
  return out;
}

Result<> DartWorld::restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                   const WorldState& begin) {
  if (model != this->model())
    if (auto made = build(model, begin); !made) return made;
  const auto& saved = static_cast<const Memory&>(*memory);
  engine_->set_state(saved.state);
  followed_ = saved.followed;
  engine_->forget_step();
  return {};
}

}  // namespace cogrsim::dart_engine

#include "simulation/world_host.h"

#include <algorithm>

#include "cogrsim/model/randomize.h"
#include "cogrsim/plugin/crash_report.h"
#include "core/index.h"

namespace cogrsim {

WorldHost::WorldHost(std::shared_ptr<const Backend> backend, Provenance provenance,
                     SceneModelPtr scene, std::vector<std::string> without)
    : backend_(std::move(backend)),
      provenance_(std::move(provenance)),
      without_(std::move(without)),
      original_(reduced(with_drawn_values(scene))),
      model_(original_) {
  if (original_ != scene) undrawn_ = std::move(scene);
}

Result<> WorldHost::create() {
  const PluginCall call("backend", backend_->name(), "", "", "while the world was created");
  auto world = backend_->create_world(model_);
  if (!world) return tl::unexpected(world.error());
  world_ = std::move(*world);
  changed();
  return {};
}

Result<> WorldHost::restart(std::optional<std::uint64_t> seed) {
  SceneModelPtr original = original_, undrawn = undrawn_;
  bool rebuild = rebuild_on_restart_;
  if (seed && *seed != original->physics.seed) {
    auto reseeded = std::make_shared<SceneModel>(undrawn ? *undrawn : *original);
    reseeded->physics.seed = *seed;
    if (undrawn) {
      undrawn = reseeded;
      rebuild = true;  // with other values
    }
    original = reduced(with_drawn_values(std::move(reseeded)));
  }
  if (rebuild) {
    auto fresh = backend_->create_world(original);
    if (!fresh) return tl::unexpected(fresh.error());
    world_ = std::move(*fresh);
    rebuild_on_restart_ = false;
  } else if (auto done = world_->reset(); !done) {
    return done;
  }
  original_ = std::move(original);
  undrawn_ = std::move(undrawn);
  model_ = original_;
  before_ = {};
  changed();
  return {};
}

void WorldHost::restart_from(const WorldHost& scene) {
  original_ = scene.original_;
  undrawn_ = scene.undrawn_;
  rebuild_on_restart_ = true;
}

Result<> WorldHost::add(SceneModelPtr next) {
  if (auto added = world_->add(next); !added) return added;
  model_ = std::move(next);
  changed();
  return {};
}

Result<> WorldHost::remove(SceneModelPtr next) {
  if (auto removed = world_->remove(next); !removed) return removed;
  model_ = std::move(next);
  changed();
  return {};
}

Result<> WorldHost::change(SceneModelPtr next) {
  if (auto done = world_->change(next); !done) return done;
  model_ = std::move(next);
  changed();
  return {};
}

const WorldState& WorldHost::state() {
  if (state_fresh_) return state_;
  if (world_) {
    get_state(state_);
  } else {
    state_.poses.resize(model_->bodies.size());
    state_.twists.resize(model_->bodies.size());
    state_.joint_positions.assign(at(model_->joint_positions), 0.0);
    state_.joint_velocities.assign(at(model_->joint_speeds), 0.0);
    state_.joint_efforts.assign(at(model_->joint_speeds), 0.0);
    state_.motor_efforts.assign(model_->motors.size(), 0.0);
  }
  state_fresh_ = true;
  return state_;
}

void WorldHost::get_state(WorldState& out) const {
  world_->get_state(out);
  const auto known = [](const std::vector<double>& before, std::vector<double>& now) {
    std::copy_n(before.begin(), std::min(before.size(), now.size()), now.begin());
  };
  known(before_.joint_efforts, out.joint_efforts);
  known(before_.motor_efforts, out.motor_efforts);
}

StepResult WorldHost::step(double time, double dt, const std::vector<Drive>& drives, bool twists) {
  if (twists) {
    before_.twists = state().twists;
  } else {
    before_.twists.clear();
  }
  const PluginCall call("backend", backend_->name(), "", "", "in a step", time);
  StepResult result = world_->step(dt, drives);
  before_.joint_efforts.clear();
  before_.motor_efforts.clear();
  changed();
  return result;
}

Result<> WorldHost::restore(const Saved& saved) {
  if (undrawn_ && saved.original != original_) {  // a run with other values
    auto other = backend_->create_world(saved.original);
    if (!other) return tl::unexpected(other.error());
    world_ = std::move(*other);
    original_ = saved.original;
    undrawn_ = saved.undrawn;
    rebuild_on_restart_ = false;
  }
  if (auto done = world_->restore(saved.world); !done) return done;
  model_ = saved.model;
  before_ = saved.before;
  changed();
  return {};
}

}  // namespace cogrsim

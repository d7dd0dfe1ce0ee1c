#include "simulation/batch/batch_world.h"

#include <cmath>

#include "core/index.h"
#include "simulation/find_named.h"
#include "simulation/impl.h"
#include "simulation/snapshot/data.h"

namespace cogrsim {

tl::expected<BatchWorld, std::vector<Diagnostic>> BatchWorld::create(
    SceneModelPtr scene, std::uint64_t seed, const BatchOptions& options,
    std::shared_ptr<PluginLoader> loader) {
  BatchWorld world;
  world.options_ = &options;
  world.loader_ = std::move(loader);
  world.first_seed_ = seed;
  if (auto built = world.build(std::move(scene), seed); !built) return Trouble(built.error());
  return world;
}

tl::expected<void, std::vector<Diagnostic>> BatchWorld::build(SceneModelPtr scene,
                                                              std::uint64_t seed) {
  SimulationOptions options;
  options.backend = options_->backend;
  options.step = options_->step;
  options.seed = seed;
  options.without = options_->without;
  auto simulation = Simulation::create(scene, options, loader_);
  if (!simulation) return Trouble(simulation.error());
  auto names = look_up(**simulation, *options_);
  if (!names) return Trouble(names.error());
  scene_ = std::move(scene);
  simulation_ = std::move(*simulation);
  names_ = std::move(*names);
  broken_ = false;
  return {};
}

tl::expected<BatchWorld::Names, std::vector<Diagnostic>> BatchWorld::look_up(
    const Simulation& simulation, const BatchOptions& options) {
  const SceneModel& model = *simulation.model();
  Names names;
  std::vector<Diagnostic> found;
  for (const std::string& name : options.actions) {
    const auto motor = find_named(model.motors, "motor", name);
    if (motor) {
      names.motors.push_back(*motor);
    } else {
      found.push_back(to_diagnostic(motor.error()));
    }
  }
  const SignalScope scope{model, [&](int sensor) { return &simulation.channels(sensor); }, {}, {}};
  for (const std::string& text : options.observations) {
    auto signal = Signal::parse(scope, text);
    if (signal) {
      names.needs = names.needs | signal->needs();
      names.signals.push_back(std::move(*signal));
    } else {
      found.push_back(to_diagnostic(signal.error()));
    }
  }
  if (!options.reward.empty()) {
    auto reward = Signal::parse(scope, options.reward);
    if (reward) {
      names.needs = names.needs | reward->needs();
      names.reward = std::move(*reward);
    } else {
      found.push_back(to_diagnostic(reward.error()));
    }
  }
  if (!options.done.empty()) {
    auto done = Condition::parse(scope, options.done);
    if (done) {
      names.needs = names.needs | done->needs();
      names.done = std::move(*done);
    } else {
      found.push_back(to_diagnostic(done.error()));
    }
  }
  if (!found.empty()) return Trouble(std::move(found));
  return names;
}

void BatchWorld::set_rows(const Rows& rows) {
  rows_ = rows;
  std::fill_n(rows_.final_observations, names_.signals.size(), options_->missing);
  observe();
}

void BatchWorld::write_targets() {
  const Simulation::Impl& impl = SnapshotAccess::of(*simulation_);
  for (std::size_t k = 0; k < names_.motors.size(); ++k) {
    rows_.actions[k] = impl.devices.motor(names_.motors[k]).target;
  }
}

void BatchWorld::give_targets() {
  Simulation::Impl& impl = SnapshotAccess::of(*simulation_);
  for (std::size_t k = 0; k < names_.motors.size(); ++k) {
    const int motor = names_.motors[k];
    const Motor& description = impl.model().motors[at(motor)];
    const double target = rows_.actions[k];
    if (description.removed) {
      impl.log.report(Severity::error, "batch",
                      "there is no motor '" + description.name + "' any more");
    } else if (!std::isfinite(target)) {
      impl.log.report(Severity::error, "batch",
                      "motor '" + description.name + "': the target is not a finite number");
    } else {
      impl.devices.set_target(motor, target);
    }
  }
}

void BatchWorld::observe() {
  if (names_.signals.empty()) return;
  const FramePtr frame = SnapshotAccess::of(*simulation_).frame_with(names_.needs);
  for (std::size_t k = 0; k < names_.signals.size(); ++k) {
    const double value = names_.signals[k].evaluate(*frame);
    rows_.observations[k] = std::isnan(value) ? options_->missing : value;
  }
}

void BatchWorld::take_reward() {
  if (!names_.reward) return;
  const double value =
      names_.reward->evaluate(*SnapshotAccess::of(*simulation_).frame_with(names_.needs));
  *rows_.reward = std::isnan(value) ? options_->missing : value;
}

EpisodeEnd BatchWorld::ended_by_run() const {
  switch (simulation_->status()) {
    case RunStatus::running:
      return simulation_->paused() ? EpisodeEnd::stopped : EpisodeEnd::none;
    case RunStatus::completed:
    case RunStatus::stopped:
      return EpisodeEnd::stopped;
    case RunStatus::fault:
      return EpisodeEnd::fault;
    case RunStatus::diverged:
      return EpisodeEnd::diverged;
  }
  return EpisodeEnd::none;
}

std::string BatchWorld::last_message() const {
  if (simulation_->paused()) return "it was paused, and nothing resumes it";
  const auto& messages = simulation_->messages();
  if (messages.empty()) return "the run was stopped";
  return messages.back().source + ": " + messages.back().message;
}

void BatchWorld::end_episode(EpisodeEnd why, std::string message) {
  end_ = why;
  end_message_ = std::move(message);
  ended_ = true;
}

void BatchWorld::fail_episode(const std::string& what) {
  broken_ = true;
  end_episode(EpisodeEnd::fault, "threw: " + what);
}

void BatchWorld::advance(std::int64_t most, double end_time) {
  steps_made_ = 0;
  if (ended_ && !options_->auto_reset) return;
  if (ended_ && !reset(std::nullopt)) return;  // an earlier reset failed, and this one, too
  end_ = EpisodeEnd::none;
  try {
    Simulation& run = *simulation_;
    Simulation::Impl& impl = SnapshotAccess::of(run);
    give_targets();
    // Half a step of slack, as run_until() has.
    while (steps_made_ < most && run.time() + 0.5 * run.dt() < end_time) {
      const std::uint64_t before = run.step_count();
      run.step();
      if (run.step_count() != before) ++steps_made_;
      if (const EpisodeEnd why = ended_by_run(); why != EpisodeEnd::none) {
        end_episode(why, last_message());
      } else if (names_.done && names_.done->holds(*impl.frame_with(names_.needs))) {
        end_episode(EpisodeEnd::done, names_.done->text());
      } else if (run.time() + 0.5 * run.dt() >= options_->duration) {
        end_episode(EpisodeEnd::time, "the duration is over");
      }
      if (ended_) break;
    }
    observe();
    take_reward();
  } catch (const std::exception& e) {
    fail_episode(message_of(e));
  } catch (...) {
    fail_episode("something that is not a std::exception");
  }
  if (!ended_) return;
  std::copy_n(rows_.observations, names_.signals.size(), rows_.final_observations);
  if (options_->auto_reset) static_cast<void>(reset(std::nullopt));
}

Result<> BatchWorld::reset(std::optional<std::uint64_t> seed) {
  // The reason for the end of the previous episode remains available, because ends() reports it for
  // the call in which it ended.
  const std::uint64_t first = seed.value_or(first_seed_);
  const std::uint64_t episode = seed ? 0 : episode_ + 1;
  const auto failed = [&](const std::string& why) {
    end_episode(EpisodeEnd::fault, "reset: " + why);
    return fail(end_message_);
  };
  try {
    if (broken_) {
      if (auto built = build(scene_, episode_seed(first, episode)); !built) {
        return failed(built.error().front().message);
      }
    } else {
      Simulation::Impl& impl = SnapshotAccess::of(*simulation_);
      impl.log.clear();
      impl.pace.paused = impl.pace.single_step = false;
      impl.clock.set_dt(impl.host.original()->physics.step);
      if (auto done = impl.restart(episode_seed(first, episode)); !done) {
        broken_ = true;
        return failed(done.error().message);
      }
    }
    first_seed_ = first;
    episode_ = episode;
    ended_ = false;
    observe();
  } catch (const std::exception& e) {
    broken_ = true;
    return failed("threw: " + message_of(e));
  } catch (...) {
    broken_ = true;
    return failed("threw something that is not a std::exception");
  }
  return {};
}

tl::expected<void, std::vector<Diagnostic>> BatchWorld::reset(SceneModelPtr scene,
                                                              std::optional<std::uint64_t> seed) {
  const std::uint64_t first = seed.value_or(first_seed_);
  const std::uint64_t episode = seed ? 0 : episode_ + 1;
  if (auto built = build(std::move(scene), episode_seed(first, episode)); !built) return built;
  first_seed_ = first;
  episode_ = episode;
  ended_ = false;
  observe();
  return {};
}

}  // namespace cogrsim

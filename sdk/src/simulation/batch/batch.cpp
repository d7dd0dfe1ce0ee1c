// The tables of a batch, and the distribution of its worlds to threads.
#include "cogrsim/simulation/batch.h"

#include <algorithm>
#include <system_error>
#include <thread>

#include "cogrsim/core/random.h"
#include "cogrsim/core/worker_pool.h"
#include "simulation/batch/batch_world.h"

namespace cogrsim {

namespace {

tl::unexpected<std::vector<Diagnostic>> refuse(const std::string& message,
                                               const std::string& help = {}) {
  Diagnostic d;
  d.code = "CG0905";
  d.message = "batch: " + message;
  d.help = help;
  return tl::unexpected(std::vector<Diagnostic>{std::move(d)});
}

tl::unexpected<std::vector<Diagnostic>> too_many(std::size_t worlds) {
  return refuse("at most " + std::to_string(kMostWorlds) + " worlds are made, not " +
                std::to_string(worlds));
}

}  // namespace

const char* to_string(EpisodeEnd end) {
  switch (end) {
    case EpisodeEnd::none:
      return "none";
    case EpisodeEnd::done:
      return "done";
    case EpisodeEnd::time:
      return "time";
    case EpisodeEnd::stopped:
      return "stopped";
    case EpisodeEnd::fault:
      return "fault";
    case EpisodeEnd::diverged:
      return "diverged";
  }
  return "none";
}

std::uint64_t episode_seed(std::uint64_t first, std::uint64_t episode) {
  if (episode == 0) return first;
  return RandomStream(first, "episode " + std::to_string(episode)).next();
}

struct Batch::Impl {
  Impl(BatchOptions given, int threads) : options(std::move(given)), pool(threads) {}

  Eigen::Index rows() const { return static_cast<Eigen::Index>(worlds.size()); }
  void advance(std::int64_t most, double end_time);
  void note_ends();

  BatchOptions options;
  WorkerPool pool;
  std::vector<BatchWorld> worlds;
  Batch::RowMajor actions, observations, final_observations;
  double* observed = nullptr;  ///< the memory of `observations`, or a table of the caller
  std::vector<double> rewards;
  std::vector<EpisodeEnd> ends;
  std::vector<std::int64_t> steps_made;
};

Batch::Batch(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Batch::~Batch() = default;

tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> Batch::create(
    SceneModelPtr scene, int count, const BatchOptions& options,
    std::shared_ptr<PluginLoader> loader) {
  if (count < 1) return refuse("at least one world is needed, not " + std::to_string(count));
  if (count > kMostWorlds) return too_many(static_cast<std::size_t>(count));
  return create(std::vector<SceneModelPtr>(static_cast<std::size_t>(count), scene), options,
                std::move(loader));
}

tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> Batch::create(
    const std::vector<SceneModelPtr>& scenes, const BatchOptions& options,
    std::shared_ptr<PluginLoader> loader) {
  const std::size_t count = scenes.size();
  if (count == 0) return refuse("at least one world is needed");
  if (count > kMostWorlds) return too_many(count);
  if (std::any_of(scenes.begin(), scenes.end(), [](const auto& scene) { return !scene; })) {
    return refuse("a world has no scene", "see the diagnostics of its compilation");
  }
  if (!loader) return refuse("a loader of plugins is needed", "make one with PluginLoader");
  if (!options.seeds.empty() && options.seeds.size() != count) {
    return refuse(std::to_string(options.seeds.size()) + " seeds for " + std::to_string(count) +
                  " worlds");
  }
  if (!(options.duration > 0.0)) return refuse("the duration must be above 0 s");
  if (options.threads < 0) return refuse("the number of threads must be 0 or more");
  int threads = options.threads;
  if (threads == 0) threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  threads = static_cast<int>(std::min(static_cast<std::size_t>(threads), count));

  std::unique_ptr<Impl> impl;
  try {
    impl = std::make_unique<Impl>(options, threads);
  } catch (const std::system_error& e) {
    return refuse("the system gives no " + std::to_string(threads) +
                  " threads: " + e.code().message());
  }
  using Made = tl::expected<std::optional<BatchWorld>, std::vector<Diagnostic>>;
  std::vector<Made> made(count);
  impl->pool.run(count, [&](std::size_t i) {
    const std::uint64_t seed =
        options.seeds.empty() ? scenes[i]->physics.seed + i : options.seeds[i];
    try {
      auto world = BatchWorld::create(scenes[i], seed, impl->options, loader);
      if (world) {
        made[i] = std::move(*world);
      } else {
        made[i] = tl::unexpected(std::move(world.error()));
      }
    } catch (const std::exception& e) {
      made[i] = refuse("it threw while being built: " + message_of(e));
    } catch (...) {
      made[i] = refuse("it threw something that is not a std::exception while being built");
    }
  });
  for (std::size_t i = 0; i < count; ++i) {
    if (!made[i]) {
      for (Diagnostic& d : made[i].error()) {
        if (d.severity == Severity::error) {
          d.notes.emplace_back("in world " + std::to_string(i) + " of a batch");
        }
      }
      return tl::unexpected(std::move(made[i].error()));
    }
    impl->worlds.push_back(std::move(**made[i]));
  }

  const auto columns = [](const std::vector<std::string>& names) {
    return static_cast<Eigen::Index>(names.size());
  };
  impl->actions.setZero(impl->rows(), columns(options.actions));
  impl->observations.setConstant(impl->rows(), columns(options.observations), options.missing);
  impl->final_observations = impl->observations;
  impl->observed = impl->observations.data();
  impl->rewards.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    impl->worlds[i].set_rows(
        {impl->actions.data() + row * impl->actions.cols(),
         impl->observations.data() + row * impl->observations.cols(),
         impl->final_observations.data() + row * impl->final_observations.cols(),
         &impl->rewards[i]});
    impl->worlds[i].write_targets();
  }
  impl->ends.assign(count, EpisodeEnd::none);
  impl->steps_made.assign(count, 0);
  return std::unique_ptr<Batch>(new Batch(std::move(impl)));
}

int Batch::size() const { return static_cast<int>(impl_->worlds.size()); }
int Batch::threads() const { return impl_->pool.threads(); }

Batch::Table Batch::actions() {
  return {impl_->actions.data(), impl_->actions.rows(), impl_->actions.cols()};
}

Batch::ConstTable Batch::observations() const {
  return {impl_->observed, impl_->observations.rows(), impl_->observations.cols()};
}

void Batch::observe_into(double* table) {
  double* const to = table ? table : impl_->observations.data();
  if (to == impl_->observed) return;
  std::copy_n(impl_->observed, impl_->observations.size(), to);
  impl_->observed = to;
  for (std::size_t i = 0; i < impl_->worlds.size(); ++i) {
    impl_->worlds[i].observe_into(to + static_cast<Eigen::Index>(i) * impl_->observations.cols());
  }
}

const std::vector<double>& Batch::rewards() const { return impl_->rewards; }

Batch::ConstTable Batch::final_observations() const {
  return {impl_->final_observations.data(), impl_->final_observations.rows(),
          impl_->final_observations.cols()};
}

const std::vector<EpisodeEnd>& Batch::ends() const { return impl_->ends; }
const std::vector<std::int64_t>& Batch::steps_made() const { return impl_->steps_made; }

void Batch::Impl::note_ends() {
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    ends[i] = worlds[i].end();
    steps_made[i] = worlds[i].steps_made();
  }
}

void Batch::Impl::advance(std::int64_t most, double end_time) {
  struct Call {
    std::vector<BatchWorld>& worlds;
    std::int64_t most;
    double end_time;
  } call{worlds, most, end_time};
  // The lambda captures one pointer only, so that std::function allocates no memory.
  pool.run(worlds.size(),
           [&call](std::size_t i) { call.worlds[i].advance(call.most, call.end_time); });
  note_ends();
}

void Batch::step(int steps) {
  impl_->advance(std::max(0, steps), std::numeric_limits<double>::infinity());
}

void Batch::run_until(double end_time) {
  impl_->advance(std::numeric_limits<std::int64_t>::max(), end_time);
}

Result<> Batch::reset(int world, std::optional<std::uint64_t> seed) {
  if (world < 0 || world >= size()) {
    return fail("batch: there is no world " + std::to_string(world) + " of " +
                std::to_string(size()));
  }
  const auto i = static_cast<std::size_t>(world);
  auto done = impl_->worlds[i].reset(seed);
  impl_->ends[i] = done ? EpisodeEnd::none : EpisodeEnd::fault;
  return done;
}

tl::expected<void, std::vector<Diagnostic>> Batch::reset(int world, SceneModelPtr scene,
                                                         std::optional<std::uint64_t> seed) {
  if (world < 0 || world >= size()) {
    return refuse("there is no world " + std::to_string(world) + " of " + std::to_string(size()));
  }
  if (!scene) return refuse("world " + std::to_string(world) + " was given no scene");
  const auto i = static_cast<std::size_t>(world);
  auto done = impl_->worlds[i].reset(std::move(scene), seed);
  if (done) impl_->ends[i] = EpisodeEnd::none;
  return done;
}

void Batch::reset_all() {
  impl_->pool.run(impl_->worlds.size(), [this](std::size_t i) {
    impl_->ends[i] = impl_->worlds[i].reset(std::nullopt) ? EpisodeEnd::none : EpisodeEnd::fault;
  });
}

const std::string& Batch::end_message(int world) const {
  return impl_->worlds.at(world).end_message();
}
std::uint64_t Batch::seed(int world) const { return impl_->worlds.at(world).seed(); }
std::uint64_t Batch::episode(int world) const { return impl_->worlds.at(world).episode(); }
Simulation& Batch::world(int world) { return impl_->worlds.at(world).simulation(); }
const Simulation& Batch::world(int world) const { return impl_->worlds.at(world).simulation(); }

}  // namespace cogrsim

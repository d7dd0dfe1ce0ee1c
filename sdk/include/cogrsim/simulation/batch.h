// Vectorised simulation for learning and sweeps: many simulations of one scene with different seeds
// and parameters, stepped in several threads.
//
//     BatchOptions options;
//     options.actions = {"cart.motor"};
//     options.observations = {"cart.slide.position", "cart.hinge.position"};
//     options.done = "abs(cart.hinge.position) gt 20 deg";
//     options.duration = 10.0;
//     options.auto_reset = true;
//     auto batch = Batch::create(scene, 64, options, loader);
//     while (learning) {
//       (*batch)->actions() = policy((*batch)->observations());  // (64 x 1) from (64 x 2)
//       (*batch)->step(10);
//     }
//
// Each world is a Simulation. Its results do not depend on the number of threads or on the other
// worlds: every state is bit-identical to that of a single Simulation of the same scene and seed
// whose motors get the same targets in the same steps.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cogrsim/simulation/simulation.h"

namespace cogrsim {

/// The reason for the end of an episode.
enum class EpisodeEnd {
  none,     ///< the episode has not ended
  done,     ///< the condition BatchOptions::done became true
  time,     ///< the episode reached BatchOptions::duration
  stopped,  ///< a rule or supervisor ended or paused the run
  fault,    ///< a fault of a controller, an exception, or a failed reset
  diverged  ///< the physics diverged
};
/// "none", "done", "time", "stopped", "fault", "diverged".
COGRSIM_API const char* to_string(EpisodeEnd end);

/// Of a batch; each world takes some 100 kB and more.
inline constexpr int kMostWorlds = 100'000;

/// Options of a batch, common to all worlds.
struct BatchOptions {
  std::string backend;  ///< empty: that of the scene, otherwise "bullet"
  double step = 0.0;    ///< time step [s]; 0: that of the scene
  std::vector<std::string> without;  ///< see SimulationOptions
  int threads = 0;      ///< number of threads, including that of the caller; 0: one per core
  /// Seeds of the first episodes (nworld); empty: the seed of the scene plus the index of the
  /// world.
  std::vector<std::uint64_t> seeds;
  std::vector<std::string> actions;       ///< dotted names of motors
  std::vector<std::string> observations;  ///< signals, see cogrsim/signals/signal.h
  std::string done;  ///< condition that ends an episode, checked after every step; empty: none
  /// Signal whose value at the end of every step() or run_until() is the reward of a world; empty:
  /// none.
  std::string reward;
  double duration = std::numeric_limits<double>::infinity();  ///< of an episode at most [s], > 0
  /// Starts the next episode of a world in the same call in which its episode ended.
  bool auto_reset = false;
  /// Value in observations() of a signal without a value; most sensors have none before the first
  /// step.
  double missing = std::numeric_limits<double>::quiet_NaN();
};

/// Seed of an episode (counted from 0) of a world whose first episode has the seed `first`. The
/// seed of episode 0 is `first`.
COGRSIM_API std::uint64_t episode_seed(std::uint64_t first, std::uint64_t episode);

/// A batch of worlds. Not thread-safe: the calls on a batch must not overlap.
class COGRSIM_API Batch {
 public:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// Row-major view of the memory of the batch, with one row per world.
  using Table = Eigen::Map<RowMajor>;
  using ConstTable = Eigen::Map<const RowMajor>;

  /// Creates `count` worlds that share one scene. Errors: count < 1 or > kMostWorlds; the number of seeds differs
  /// from that of the worlds; a motor or signal does not exist (with the most similar existing
  /// name); those of Simulation::create() of the first world that fails, which is named.
  static tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> create(
      SceneModelPtr scene, int count, const BatchOptions& options,
      std::shared_ptr<PluginLoader> loader);
  /// Creates one world per scene, for a scene compiled with different parameters or for different
  /// scenes that all have the named motors and signals.
  static tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> create(
      const std::vector<SceneModelPtr>& scenes, const BatchOptions& options,
      std::shared_ptr<PluginLoader> loader);
  ~Batch();

  int size() const;     ///< number of worlds, nworld
  int threads() const;  ///< number of threads, including that of the caller

  /// Targets of the motors BatchOptions::actions (nworld x nmotor), in the units of their modes
  /// (rad/s, rad, N m, …); initially those of the scene. step() and run_until() apply them as a
  /// SetMotor command: they are clamped to the limits of the motor, and a controller that sets the
  /// same motor overrides them. A value that is not finite leaves the target unchanged and adds a
  /// message to Simulation::messages() of the world.
  Table actions();
  /// Values of the signals BatchOptions::observations (nworld x nsignal) after the last step, or at
  /// the start of a new episode.
  ConstTable observations() const;
  /// Writes observations() to `table` (nworld x nsignal, row-major) from now on, beginning with the
  /// current values; nullptr: to memory of the batch. The table must remain valid until the next
  /// call, or as long as the batch.
  void observe_into(double* table);
  /// Values of the signal BatchOptions::reward (nworld) at the end of the last step() or
  /// run_until(), or at the end of the episode if it ended in that call; 0 without such a signal.
  /// A signal without a value gives BatchOptions::missing.
  const std::vector<double>& rewards() const;
  /// Values of the signals at the end of the last episode of each world (nworld x nsignal);
  /// BatchOptions::missing if none has ended.
  ConstTable final_observations() const;

  /// The reasons for which episodes ended during the last step() or run_until() (nworld). A world
  /// that has not been reset does not advance and retains its reason.
  const std::vector<EpisodeEnd>& ends() const;
  /// The reason for the end of the last ended episode as text; empty: none has ended.
  const std::string& end_message(int world) const;
  /// Number of steps of each world in the last step() or run_until() (nworld); fewer than requested
  /// if the episode ended.
  const std::vector<std::int64_t>& steps_made() const;

  /// Steps every world `steps` times, except those whose episode has ended. A world whose episode
  /// ends makes no further steps in this call; with `auto_reset` it is then at the start of the
  /// next episode.
  void step(int steps = 1);
  /// Steps every world until its own time reaches `end_time` [s], as Simulation::run_until().
  void run_until(double end_time);

  /// Starts the next episode of a world: the initial state, new controllers, and the given seed or
  /// else episode_seed(). A given seed becomes the seed of episode 0. Errors: an element cannot be
  /// built again; the world then has EpisodeEnd::fault and does not advance.
  Result<> reset(int world, std::optional<std::uint64_t> seed = std::nullopt);
  /// Starts the next episode of a world with another scene, for parameters that change between
  /// episodes. The scene must have the named motors and signals. Errors: as create(); the world is
  /// then unchanged.
  tl::expected<void, std::vector<Diagnostic>> reset(
      int world, SceneModelPtr scene, std::optional<std::uint64_t> seed = std::nullopt);
  /// Resets all worlds in parallel. Failures are reported in ends().
  void reset_all();

  std::uint64_t seed(int world) const;     ///< seed of the current episode
  std::uint64_t episode(int world) const;  ///< index of the current episode, from 0
  /// The simulation of a world, for frames, messages and commands. Only the batch should step and
  /// restart it. A reset with another scene replaces the object.
  Simulation& world(int world);
  const Simulation& world(int world) const;

  struct Impl;

 private:
  explicit Batch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim

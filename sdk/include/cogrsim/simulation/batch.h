// Many worlds at once, for learning and sweeps: simulations of one scene, with different seeds and
// parameters, stepped on several threads.
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
// A world is a Simulation. What it computes does not depend on the number of threads, nor on the
// other worlds: state for state it is, bit for bit, a single Simulation of that scene and seed whose
// motors get the same targets at the same steps.
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

/// Why a world's episode ended.
enum class EpisodeEnd {
  none,     ///< it goes on
  done,     ///< BatchOptions::done held
  time,     ///< it lasted BatchOptions::duration
  stopped,  ///< a rule or supervisor ended or paused it
  fault,    ///< a controller's fault ended it, something threw, or it could not be reset
  diverged  ///< the physics exploded
};
/// "none", "done", "time", "stopped", "fault", "diverged".
COGRSIM_API const char* to_string(EpisodeEnd end);

struct BatchOptions {
  std::string backend;  ///< empty: the scene's, else "bullet"
  double step = 0.0;    ///< [s]; 0: the scene's
  int threads = 0;      ///< that work, the caller's among them; 0: one per core
  /// Of every world's first episode (nworld); empty: the scene's seed plus the world's number.
  std::vector<std::uint64_t> seeds;
  std::vector<std::string> actions;       ///< motors, by dotted name
  std::vector<std::string> observations;  ///< signals, see cogrsim/signals/signal.h
  std::string done;  ///< condition that ends an episode, looked at after every step; empty: none
  double duration = std::numeric_limits<double>::infinity();  ///< of an episode, at most [s], > 0
  /// A world whose episode ended begins the next one within the same call.
  bool auto_reset = false;
  /// Stands in observations() where a signal has no value: most sensors have none before the first
  /// step.
  double missing = std::numeric_limits<double>::quiet_NaN();
};

/// Seed of a world's episode, from 0, by the seed of its first: that one itself for episode 0.
COGRSIM_API std::uint64_t episode_seed(std::uint64_t first, std::uint64_t episode);

/// To be used by one thread at a time.
class COGRSIM_API Batch {
 public:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// Row-major, a row per world; a view of the batch's own memory.
  using Table = Eigen::Map<RowMajor>;
  using ConstTable = Eigen::Map<const RowMajor>;

  /// `count` worlds of one scene, which they share. Errors: count < 1; as many seeds as worlds are
  /// needed; a motor or signal that is not there, with the nearest that is; Simulation::create()'s,
  /// of the first world that has any, which is named.
  static tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> create(
      SceneModelPtr scene, int count, const BatchOptions& options,
      std::shared_ptr<PluginLoader> loader);
  /// A world per scene: one scene compiled with different parameters, or different scenes that all
  /// have the motors and signals named.
  static tl::expected<std::unique_ptr<Batch>, std::vector<Diagnostic>> create(
      const std::vector<SceneModelPtr>& scenes, const BatchOptions& options,
      std::shared_ptr<PluginLoader> loader);
  ~Batch();

  int size() const;     ///< nworld
  int threads() const;  ///< that work, the caller's among them

  /// Targets of the motors `BatchOptions::actions` (nworld x nmotor) in their modes' units: rad/s,
  /// rad, N m … At first those of the scene. step() and run_until() give them to the motors as a
  /// SetMotor sent just before would: clamped to what the motor can be asked for, and a controller
  /// that sets the same motor has the last word. What is not a finite number leaves a motor's target
  /// as it is, with a message in the world's messages().
  Table actions();
  /// Values of the signals after the last step (nworld x nsignal), or at the start of an episode that
  /// has just begun.
  ConstTable observations() const;
  /// As observations(), at the end of the last episode that ended; `missing` where none has.
  ConstTable final_observations() const;

  /// (nworld) Why episodes ended during the last step() or run_until(). A world that was not reset
  /// stands still and goes on saying why.
  const std::vector<EpisodeEnd>& ends() const;
  /// The same in words, of the last episode that ended; empty: none has.
  const std::string& end_message(int world) const;
  /// Steps the world made in the last step() or run_until(): fewer than asked for when its episode
  /// ended.
  const std::vector<std::int64_t>& steps_made() const;

  /// Steps every world `steps` times, those apart whose episode has ended. An episode that ends is
  /// over for this call: with `auto_reset` the world then stands at the start of the next one.
  void step(int steps = 1);
  /// Steps every world until its own clock says `end_time` [s], as Simulation::run_until.
  void run_until(double end_time);

  /// Begins the world's next episode: everything as at the start, controllers anew, with the seed
  /// given or else episode_seed(). A seed given counts as that of episode 0. Errors: something could
  /// not be built again; the world then stands still with EpisodeEnd::fault.
  Result<> reset(int world, std::optional<std::uint64_t> seed = std::nullopt);
  /// The same with another scene, for parameters that change from episode to episode; it must have
  /// the motors and signals named. Errors: as create(); the world is then as it was.
  tl::expected<void, std::vector<Diagnostic>> reset(
      int world, SceneModelPtr scene, std::optional<std::uint64_t> seed = std::nullopt);
  /// All worlds, in parallel. Worlds that fail say so in ends().
  void reset_all();

  std::uint64_t seed(int world) const;     ///< of the present episode
  std::uint64_t episode(int world) const;  ///< from 0
  /// For everything else: frames, messages, commands. Commands that restart or step it are better
  /// left to the batch. A reset with another scene replaces it.
  Simulation& world(int world);
  const Simulation& world(int world) const;

  struct Impl;

 private:
  explicit Batch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim

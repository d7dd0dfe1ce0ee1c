// One world of a batch: a simulation, its episodes, and its rows of the tables.
#pragma once

#include "cogrsim/signals/condition.h"
#include "cogrsim/simulation/batch.h"

namespace cogrsim {

/// One world of a batch. Used by one thread at a time.
class BatchWorld {
 public:
  using Trouble = tl::unexpected<std::vector<Diagnostic>>;
  struct Rows {
    double* actions = nullptr;
    double* observations = nullptr;
    double* final_observations = nullptr;
    double* reward = nullptr;
  };

  /// `options` must outlive the object. Errors: those of Simulation::create(), or an unknown name.
  static tl::expected<BatchWorld, std::vector<Diagnostic>> create(
      SceneModelPtr scene, std::uint64_t seed, const BatchOptions& options,
      std::shared_ptr<PluginLoader> loader);

  /// Sets the rows of the tables that belong to this world and writes the initial values.
  void set_rows(const Rows& rows);
  void observe_into(double* observations) { rows_.observations = observations; }
  /// Writes the motor targets of the scene as actions.
  void write_targets();

  /// Makes at most `most` steps, and not beyond `end_time` [s]. Does not throw.
  void advance(std::int64_t most, double end_time);
  /// Starts the next episode. Does not throw.
  Result<> reset(std::optional<std::uint64_t> seed);
  tl::expected<void, std::vector<Diagnostic>> reset(SceneModelPtr scene,
                                                    std::optional<std::uint64_t> seed);

  Simulation& simulation() { return *simulation_; }
  const Simulation& simulation() const { return *simulation_; }
  EpisodeEnd end() const { return end_; }
  const std::string& end_message() const { return end_message_; }
  std::int64_t steps_made() const { return steps_made_; }
  std::uint64_t seed() const { return episode_seed(first_seed_, episode_); }
  std::uint64_t episode() const { return episode_; }

 private:
  /// Elements of a scene that are resolved only once.
  struct Names {
    std::vector<int> motors;
    std::vector<Signal> signals;
    std::optional<Condition> done;
    std::optional<Signal> reward;
    FrameContents needs;
  };
  static tl::expected<Names, std::vector<Diagnostic>> look_up(const Simulation& simulation,
                                                              const BatchOptions& options);
  tl::expected<void, std::vector<Diagnostic>> build(SceneModelPtr scene, std::uint64_t seed);
  void give_targets();
  void observe();
  void take_reward();
  void end_episode(EpisodeEnd why, std::string message);
  void fail_episode(const std::string& what);
  EpisodeEnd ended_by_run() const;
  std::string last_message() const;

  const BatchOptions* options_ = nullptr;
  std::shared_ptr<PluginLoader> loader_;
  SceneModelPtr scene_;
  std::unique_ptr<Simulation> simulation_;
  Names names_;
  Rows rows_;
  std::uint64_t first_seed_ = 0, episode_ = 0;
  EpisodeEnd end_ = EpisodeEnd::none;
  bool ended_ = false;  ///< the episode has ended and the next one has not begun
  bool broken_ = false;    ///< an exception was thrown; a new simulation is needed
  std::string end_message_;
  std::int64_t steps_made_ = 0;
};

}  // namespace cogrsim

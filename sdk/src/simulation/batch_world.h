// One world of a batch: a simulation, its episodes, and its rows of the batch's tables.
#pragma once

#include "cogrsim/signals/condition.h"
#include "cogrsim/simulation/batch.h"

namespace cogrsim {

class BatchWorld {
 public:
  using Trouble = tl::unexpected<std::vector<Diagnostic>>;
  struct Rows {
    double* actions = nullptr;
    double* observations = nullptr;
    double* final_observations = nullptr;
  };

  /// `options` must outlive it. Errors: Simulation::create()'s, names that are not there.
  static tl::expected<BatchWorld, std::vector<Diagnostic>> create(
      SceneModelPtr scene, std::uint64_t seed, const BatchOptions& options,
      std::shared_ptr<PluginLoader> loader);

  /// Where its numbers stand from now on; writes those of the start.
  void set_rows(const Rows& rows);
  /// The scene's targets, as actions.
  void write_targets();

  /// Steps at most `most` times, and no longer than until `end_time` [s]. Throws nothing.
  void advance(std::int64_t most, double end_time);
  /// The next episode. Throws nothing.
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
  /// What is looked up in a scene once.
  struct Names {
    std::vector<int> motors;
    std::vector<Signal> signals;
    std::optional<Condition> done;
    FrameContents needs;
  };
  static tl::expected<Names, std::vector<Diagnostic>> look_up(const Simulation& simulation,
                                                              const BatchOptions& options);
  tl::expected<void, std::vector<Diagnostic>> build(SceneModelPtr scene, std::uint64_t seed);
  void give_targets();
  void observe();
  void end_episode(EpisodeEnd why, std::string message);
  void broke(const std::string& what);
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
  bool standing_ = false;  ///< its episode has ended, and no other has begun
  bool broken_ = false;    ///< something threw: only a new simulation helps
  std::string end_message_;
  std::int64_t steps_made_ = 0;
};

}  // namespace cogrsim

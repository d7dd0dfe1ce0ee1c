// The thread that owns the simulation: runs commands, paces real time, stores frames.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/recording/recording.h"
#include "cogrsim/simulation/simulation.h"
#include "compare_run.h"
#include "history.h"
#include "run.h"
#include "run/inputs.h"
#include "run_scenes.h"
#include "run_status.h"

namespace cogrsim::studio {

using Refusal = std::vector<Diagnostic>;

/// The first error of them, with how many more there are.
Error to_error(const Refusal& found);

/// "controller 'bot.pilot' of 'bot'".
std::string described(const PluginWatch::Call& call);

/// A body that a person pulls.
struct GrabRequest {
  std::string body;
  Vec3 point = Vec3::Zero();        ///< of the body, in its frame [m]
  Vec3 target = Vec3::Zero();       ///< where it is pulled to, in the world [m]
  std::optional<double> stiffness;  ///< [N/m]; empty: by the mass that hangs on it
};

class Engine {
 public:
  /// `restarted`: called when all frames before are gone.
  Engine(RunOptions options, std::vector<std::string> plugin_folders, History& history,
         Scenes& scenes, StatusPublisher& publisher, std::function<void()> restarted);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// To be done on the engine's thread between two steps, in order. From any thread.
  void post(std::function<void()> task);
  /// The same for requests that end the present run: a controller that does not return is ended, if
  /// it can be.
  void post_ending(std::function<void()> task);
  /// Pauses; while a plugin does not return the answer is not waited for. From any thread.
  void pause(const Reply& reply);
  /// Ends the process of the controller that does not return. From any thread.
  Answer end_controller();
  /// See Run.
  void watch_processes(Run::ProcessListener changed);
  void ask_processes();
  std::optional<HeldCall> held_call(const std::string& controller) const;
  /// See Run::finish().
  std::string finish();

  // ---- on the engine's thread alone, see post()

  Answer play();
  Answer pause();
  Answer stop(bool then_play);
  /// Answers when they are done, or something else was asked for.
  void step(std::int64_t count, Reply reply);
  Answer set_speed(std::optional<double> factor);
  Answer set_step(std::optional<double> dt);
  /// `without`: see RunOptions; nullopt: as before.
  using Without = std::optional<std::vector<std::string>>;
  Answer set_backend(const std::string& name, const Without& without);
  /// What a backend lacks of the newest scene, or else the one that it is compared with; `beside`: of the
  /// scene that runs, for compare().
  Answer lacking(const std::string& name, bool beside) const;
  /// The library of a controller, or of all of them, as it is on disk now: while paused.
  Answer reload(const std::optional<std::string>& controller);
  // engine_hands.cpp: what a person does in the run
  /// Sets a motor's target, until something else sets it.
  Answer set_motor(const std::string& name, double target);
  Answer set_input(const std::string& controller, const std::string& input, double value);
  /// Pulls a body by a spring to `target`, until it is released or that client is gone.
  Answer grab(ClientId client, GrabRequest request);
  Answer move_grab(ClientId client, const Vec3& target);
  Answer release(ClientId client);
  /// From the start, with all that a person did in the present run, or in the one before it.
  Answer repeat();
  Answer record(bool on, const std::optional<std::string>& file);
  Answer compare(CompareRequest request, const Without& without);
  Answer end_compare();
  tl::expected<std::vector<std::string>, Refusal> show(Scene scene);
  /// Whether the engine lacked something of the last scene that show() was given, and no other one has
  /// taken it since.
  bool has_refused() const { return refused_.has_value(); }

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { stopped, playing, paused, ended };
  using Made = tl::expected<std::unique_ptr<Simulation>, Refusal>;

  void run();
  void watch_calls();
  void tell_processes();
  bool run_tasks();
  void settle();
  Result<> may_run() const;
  /// One step, or the steps to the next common time of both runs. False: the run does not advance.
  bool advance();
  bool within_duration() const;
  bool step_main();
  bool step_ghost();
  void run_piece();
  Clock::duration until_due() const;
  void anchor();

  // engine_scene.cpp: scenes and simulations
  SimulationOptions simulation_options() const;
  Made make(const SceneModelPtr& model, const SimulationOptions& options) const;
  tl::expected<void, Refusal> begin_again(const Scene& scene, const std::string& backend,
                                          std::optional<double> dt,
                                          std::optional<CompareRequest> request);
  /// `anyway`: the run continues as another one even where nothing else has changed.
  tl::expected<std::vector<std::string>, Refusal> carry_over(const Scene& scene,
                                                             const std::string& backend,
                                                             bool anyway = false);
  tl::expected<std::vector<std::string>, Refusal> take(const Scene& scene);
  Answer continue_on(const std::string& name, bool anyway);
  Answer with_options(const Without& without, const std::function<Answer()>& act);
  void adopt(std::unique_ptr<Simulation> simulation);
  void forget_past();

  // engine_hands.cpp
  struct Grab {
    ClientId client = 0;
    GrabRequest request;
    double stiffness = 0.0, damping = 0.0;  ///< [N/m], [N s/m]
    double dt = 0.0;                        ///< for which they are [s]
  };
  Result<> give(const Command& command);
  void give_hands();
  void pull();
  void set_spring(Grab& grab, std::size_t body) const;
  void forget_inputs();
  cli::Inputs all_inputs() const;
  void lose_inputs(const std::string& why);

  // engine_record.cpp
  Result<std::string> recording_path(const std::optional<std::string>& file) const;
  void end_recording(const std::string& why);

  // engine_watch.cpp: what is kept and published
  void on_frame(const FramePtr& frame);
  void take_instant(bool keep);
  bool due_to_be_kept() const;
  Instant instant();
  void end(const std::string& why);
  void found_status();
  void collect_messages();
  void publish(bool urgent);
  void measure();

  RunOptions options_;
  std::vector<std::string> plugin_folders_;
  History& history_;
  Scenes& scenes_;
  StatusPublisher& publisher_;
  const std::function<void()> restarted_;

  // What the requests have set.
  std::optional<Scene> scene_;
  std::optional<Scene> refused_;  ///< see has_refused()
  OriginsPtr origins_;
  std::string backend_;
  std::optional<double> dt_;
  std::optional<double> speed_ = 1.0;

  std::unique_ptr<Simulation> simulation_;
  std::shared_ptr<const Provenance> provenance_;  ///< of it
  FramePtr latest_;                               ///< of the last step
  SceneModelPtr numbered_model_;                  ///< the one that has a number
  bool same_lineage_ = false;                     ///< the next number is for the same scene
  SimulationOptions created_with_;
  std::uint32_t scene_number_ = 0;
  State state_ = State::stopped;
  std::string ending_;
  std::string end_reason_;  ///< what an event said
  std::int64_t steps_left_ = 0;
  Reply step_reply_;
  std::size_t messages_seen_ = 0;
  std::optional<double> last_kept_;  ///< [s]

  std::unique_ptr<SecondRun> ghost_;

  std::unique_ptr<Recorder> recorder_;
  std::string recording_;

  cli::Inputs inputs_;                         ///< of the present run
  cli::Inputs before_;                         ///< of the last run before it that had any
  SceneModelPtr inputs_scene_, before_scene_;  ///< what these runs started with
  std::vector<std::string> inputs_without_, before_without_;  ///< and were without
  cli::InputPlayer repeated_{{}};
  std::optional<Grab> grab_;

  // Keeping time.
  Clock::time_point anchor_wall_{};
  double anchor_time_ = 0.0;
  Clock::time_point measured_wall_{};
  double measured_time_ = 0.0, factor_ = 0.0;
  Clock::time_point published_{}, status_published_{};

  std::mutex mutex_;
  std::condition_variable waiting_;
  std::deque<std::function<void()>> tasks_;
  std::atomic<bool> asked_{false};  ///< there are tasks, or it is to end
  bool over_ = false, ended_ = false;

  std::mutex listener_mutex_;
  Run::ProcessListener processes_changed_;

  // The plugin call that does not return, as another thread sees it.
  PluginWatch watch_;
  std::atomic<int> endings_{0};  ///< post_ending()'s that have not begun
  std::condition_variable ending_or_time_;
  std::thread thread_, onlooker_;
};

}  // namespace cogrsim::studio

// The inside of a Simulation.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <utility>

#include "cogrsim/assembly/assembly.h"
#include "cogrsim/control/controller.h"
#include "cogrsim/control/supervisor.h"
#include "cogrsim/core/random.h"
#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/sensing/sensor.h"
#include "cogrsim/simulation/simulation.h"
#include "control/hosted_controller.h"
#include "sensing/frame_sensing.h"
#include "sensing/sensor_suite.h"
#include "simulation/frame_pool.h"
#include "simulation/living.h"
#include "simulation/motor_law.h"
#include "simulation/rate_timer.h"

namespace cogrsim {

/// What the handles of one controller reach through; lives as long as they do.
struct AssemblyAccess {
  Simulation::Impl* simulation = nullptr;
  int assembly = -1;
  std::string name;
  std::string mind;  ///< dotted name of the controller
  std::string plugin;
  const ParameterTable* table = nullptr;
  Parameters parameters;
  const std::vector<PluginOutput>* declared = nullptr;
  std::vector<double> outputs;  ///< as declared
  std::optional<RandomStream> random;
  std::vector<int> motors;            ///< those it asked for
  std::vector<std::string> mistakes;  ///< of configure()
  std::optional<std::string> fault;   ///< of the update that is running
};

/// Sets one of the declared outputs, or says what is wrong.
std::optional<std::string> publish_output(const std::vector<PluginOutput>& declared,
                                          const std::string& name, double value,
                                          std::vector<double>& outputs);

/// When a mind ran last.
struct MindClock {
  RateTimer timer;
  bool stopped = false;
  double last_time = 0.0;
  std::uint64_t count = 0;
};

/// What the handles of a new controller reach through; `parameters` are complete.
std::shared_ptr<AssemblyAccess> make_access(Simulation::Impl& simulation,
                                            const ControllerModel& description,
                                            const PluginPtr& plugin, Parameters parameters);

struct ControllerSlot {
  PluginPtr plugin;
  std::shared_ptr<AssemblyAccess> access;
  std::unique_ptr<HostedController> controller;
  MindClock clock;
};

/// What was wrong when a mind was configured.
struct StartOutcome {
  std::vector<std::string> mistakes;   ///< it noted, or was found to have made
  std::optional<std::string> failure;  ///< "threw while being configured: …"
};

/// The scene as controllers in processes of their own see it, as text: without shapes, meshes, rules
/// and what else does not concern them. Made once for each model.
struct SceneForMinds {
  SceneModelPtr model, original;
  std::string text;
  const std::string& of(const SceneModelPtr& now, const SceneModelPtr& at_start);
};

class SupervisorStage;

struct SupervisorSlot {
  PluginPtr plugin;
  const SupervisorEntry* entry = nullptr;
  std::unique_ptr<SupervisorStage> stage;
  std::unique_ptr<Supervisor, void (*)(Supervisor*)> supervisor{nullptr, nullptr};
  FrameContents needs;
  std::vector<Event> events;  ///< since its last update
  MindClock clock;
  SupervisorSlot();
  SupervisorSlot(SupervisorSlot&&) noexcept;
  SupervisorSlot& operator=(SupervisorSlot&&) noexcept;
  ~SupervisorSlot();
};

/// A command on its way to the next step boundary.
struct QueuedCommand {
  Command command;
  bool own = false;  ///< a supervisor's: part of snapshots; else from outside, which are not
};

struct SimulationSnapshot {
  SceneModelPtr model;
  SnapshotPtr world;
  double dt = 0.0, base_time = 0.0, last_dt = 0.0;
  std::uint64_t steps = 0, steps_since_base = 0;
  RunStatus status = RunStatus::running;
  std::vector<MotorState> motors;
  std::vector<SensorMemory> sensors;
  std::vector<MindClock> controllers, supervisors;
  std::vector<std::uint64_t> controller_random, supervisor_random;
  std::vector<std::vector<double>> controller_outputs, supervisor_outputs;
  std::vector<std::vector<Event>> supervisor_events;
  std::vector<Twist> twists_before;
  std::vector<double> joint_efforts_before, motor_efforts_before;
  LivingMemory living;
  std::vector<QueuedCommand> sent;  ///< by supervisors, for the next boundary
};

struct Simulation::Impl {
  explicit Impl(std::shared_ptr<PluginLoader> plugins)
      : loader(std::move(plugins)), sensing(*loader) {}

  std::shared_ptr<PluginLoader> loader;
  std::shared_ptr<const Backend> backend;
  Provenance provenance;
  std::unique_ptr<World> world;
  SceneModelPtr original;     ///< as given, with the options' seed and step
  SceneModelPtr model;        ///< as it is now
  bool restart_anew = false;  ///< the world began with another scene than `original`

  // Clock: time = base_time + steps_since_base * dt, so that no rounding accumulates.
  double dt = 1e-3;
  double base_time = 0.0;
  std::uint64_t steps = 0, steps_since_base = 0;
  double speed = std::numeric_limits<double>::infinity();
  Isolation isolation = Isolation::none;  ///< of controllers that do not say
  bool paused = false;
  bool single_step = false;  ///< one step although paused
  RunStatus status = RunStatus::running;
  std::atomic<bool> stop_requested{false};

  std::vector<MotorState> motors;
  std::vector<Drive> drives;
  SensorSuite sensors;
  FrameSensing sensing;
  std::vector<ControllerSlot> controllers;
  std::vector<SupervisorSlot> supervisors;
  SceneForMinds scene_for_minds;
  std::vector<RunMessage> messages;
  bool spin_reported = false;
  std::vector<Event> events;         ///< since the last frame
  std::vector<Causes> event_causes;  ///< of each of them
  Causes causes;                     ///< of the action that is being applied
  Living living;
  bool ending = false;  ///< the run ends with this step

  std::mutex queue_mutex;
  std::deque<QueuedCommand> queue;
  std::size_t own_in_queue = 0;  ///< commands of supervisors among them

  std::vector<std::shared_ptr<Observation::Watcher>> watchers;
  bool start_shown = false;  ///< watchers have seen the frame at the start

  std::shared_ptr<FramePool> pool = std::make_shared<FramePool>();
  FramePtr cached;  ///< of the present step
  FrameContents cached_contents;
  WorldState state;  ///< scratch: present state
  bool state_fresh = false;
  std::vector<Twist> twists_before;  ///< of the step before; empty when nobody needs them
  double last_dt = 0.0;
  /// Efforts of the step before, as WorldState has them, where the engine does not know them: after
  /// going on from a file.
  std::vector<double> joint_efforts_before, motor_efforts_before;

  double time() const { return base_time + static_cast<double>(steps_since_base) * dt; }
  /// Of the world, with the efforts that only this knows; present_state(): kept until it changes.
  void get_state(WorldState& out) const;
  const WorldState& present_state();
  FramePtr frame_with(const FrameContents& contents);
  void copy_controller_outputs(Frame& frame) const;
  void world_changed();

  // create.cpp: building what the model names; errors as diagnostics at the element's place.
  void build_motors(std::size_t first);
  std::vector<Diagnostic> build_sensors(std::size_t first);
  std::vector<Diagnostic> build_minds(std::size_t first_controller, bool with_supervisors);
  std::vector<Diagnostic> build_all();

  // minds.cpp
  Diagnostic problem(const std::string& message, const SourceSpan& origin, const std::string& code,
                     const std::string& help = {}) const;
  std::vector<Diagnostic> build_controller(std::size_t index);
  /// Makes and configures the controller of a slot that has its plugin and its access.
  StartOutcome start_controller(ControllerSlot& slot, std::size_t index);
  std::vector<Diagnostic> build_supervisor(const ControllerModel& description);
  void run_minds();
  void fault(const ControllerModel& description, MindClock& clock, const std::string& message);
  void let_go(const AssemblyAccess& access);

  // reload.cpp
  Result<Reloaded> reload(const std::string& name);
  std::optional<std::string> take_over(const ControllerSlot& old, ControllerSlot& fresh,
                                       std::size_t index, Reloaded& done);

  // step.cpp
  void read_sensors();
  RunStatus step();
  void show_start();
  void show_frame();  ///< the present one, to the watchers
  void report(Severity severity, const std::string& source, const std::string& message);
  void watch_spin();

  // rules.cpp: what happens by itself
  void happen(Event event);  ///< into the next frame, caused by what is being applied
  void look_around();        ///< after a step and at the start: regions, doors, rules
  void apply_due();          ///< at a boundary: what rules set off, lifetimes that are over
  void fire(std::size_t rule, const Causes& led_to);
  void fire_rules();

  // commands.cpp
  void apply_commands();
  void apply(Command& command);
  void refused(const Error& error);
  Result<> add_assembly(const AddAssembly& command, const std::string& subject = {});
  Result<> remove_named(const std::string& name);
  Result<> set_motor(const std::string& name, double target);
  Result<> restart(std::optional<std::uint64_t> seed);

  // actions.cpp
  Result<> spawn(const Spawn& action);
  Result<> attach(const Attach& action);
  Result<> detach(const Detach& action);
  Result<> set_limits(const SetJointLimits& action);
  Result<> set_static(const SetStatic& action);
  Result<> move_door(const MoveDoor& action);
  Result<> change_to(Result<SceneModelPtr> next);
  Result<> room_to_add(const std::string& what, std::size_t bodies);

  bool wants_accelerations() const;
};

/// What is not there by that name, with the nearest that is.
template <class Elements>
Result<int> find_named(const Elements& elements, const std::string& kind, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (elements[i].removed) continue;
    if (elements[i].name == name) return static_cast<int>(i);
    names.push_back(elements[i].name);
  }
  const std::string near = nearest_name(name, names);
  return fail("there is no " + kind + " '" + name + "'", "",
              near.empty() ? "" : "did you mean '" + near + "'?");
}

/// Fills in what the model's minds publish, as their plugins say.
void name_outputs(SceneModel& model, PluginLoader& loader);

/// The side of a supervisor's Stage that belongs to the simulation.
class SupervisorStage final : public Stage {
 public:
  SupervisorStage(Simulation::Impl& simulation, const ControllerModel& description,
                  Parameters parameters, const std::vector<PluginOutput>& declared,
                  std::uint64_t seed)
      : simulation_(simulation),
        name_(description.name),
        plugin_(description.plugin),
        parameters_(std::move(parameters)),
        declared_(declared),
        outputs_(declared.size(), std::numeric_limits<double>::quiet_NaN()),
        random_(seed, name_) {}

  const Frame& frame() const override { return *frame_; }
  void send(Command command) override;
  const ParameterValue* parameter(const std::string& name) const override;
  double uniform(double low, double high) override { return random_.uniform(low, high); }
  void report(const std::string& message) override;
  void publish(const std::string& output, double value) override;

  void show(FramePtr frame) { frame_ = std::move(frame); }
  RandomStream& random() { return random_; }
  std::vector<double>& outputs() { return outputs_; }
  /// To be kept while the supervisor is called.
  PluginCall calling(const char* doing) const {
    return {"supervisor", name_.c_str(), "", plugin_.c_str(), doing, simulation_.time()};
  }
  /// What went wrong since the last call.
  std::optional<std::string> take_fault() { return std::exchange(fault_, std::nullopt); }

 private:
  Simulation::Impl& simulation_;
  std::string name_, plugin_;
  Parameters parameters_;
  const std::vector<PluginOutput>& declared_;
  std::vector<double> outputs_;
  std::optional<std::string> fault_;
  RandomStream random_;
  FramePtr frame_;
};

}  // namespace cogrsim

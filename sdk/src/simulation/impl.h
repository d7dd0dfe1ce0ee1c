// Implementation of Simulation.
#pragma once

#include <atomic>
#include <utility>

#include "cogrsim/assembly/assembly.h"
#include "cogrsim/control/controller.h"
#include "cogrsim/control/supervisor.h"
#include "cogrsim/core/random.h"
#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/sensing/sensor.h"
#include "cogrsim/simulation/simulation.h"
#include "core/rate_timer.h"
#include "sensing/frame_sensor_context.h"
#include "sensing/sensor_suite.h"
#include "simulation/clock.h"
#include "simulation/command_queue.h"
#include "simulation/controllers/hosted_controller.h"
#include "simulation/frame_pool.h"
#include "simulation/events/event_system.h"
#include "simulation/force_system.h"
#include "simulation/message_log.h"
#include "simulation/motor_law.h"

namespace cogrsim {

/// Access of the handles of one controller to the simulation; lives as long as the handles.
struct AssemblyAccess {
  Simulation::Impl* simulation = nullptr;
  int assembly = -1;
  std::string name;
  std::string controller;  ///< dotted name of the controller
  std::string plugin;
  const ParameterTable* table = nullptr;
  Parameters parameters;
  const std::vector<PluginOutput>* declared = nullptr;
  std::vector<double> outputs;  ///< in the order of `declared`
  std::optional<RandomStream> random;
  std::vector<int> motors;            ///< the motors that it requested
  std::vector<std::string> mistakes;  ///< errors in configure()
  std::optional<std::string> fault;   ///< error in the current update
};

/// Sets one of the declared outputs; returns an error message if it is not declared.
std::optional<std::string> publish_output(const std::vector<PluginOutput>& declared,
                                          const std::string& name, double value,
                                          std::vector<double>& outputs);

/// Timing of the updates of a controller.
struct ControllerClock {
  RateTimer timer;
  bool stopped = false;
  double last_time = 0.0;
  std::uint64_t count = 0;
};

/// Creates the access of a new controller; `parameters` are complete.
std::shared_ptr<AssemblyAccess> make_access(Simulation::Impl& simulation,
                                            const ControllerModel& description,
                                            const PluginPtr& plugin, Parameters parameters);

struct ControllerSlot {
  PluginPtr plugin;
  std::shared_ptr<AssemblyAccess> access;
  std::unique_ptr<HostedController> controller;
  ControllerClock clock;
};

/// Errors in the configuration of a controller.
struct StartOutcome {
  std::vector<std::string> mistakes;   ///< errors that were collected
  std::optional<std::string> failure;  ///< "threw while being configured: …"
};

/// The scene as text for controllers in processes of their own, without shapes, meshes, rules and
/// other elements that they do not need. Computed once for each model.
struct SceneForControllers {
  SceneModelPtr model, original;
  std::string text;
  const std::string& of(const SceneModelPtr& now, const SceneModelPtr& at_start);
};

class LiveSupervisorContext;

struct SupervisorSlot {
  PluginPtr plugin;
  const SupervisorEntry* entry = nullptr;
  std::unique_ptr<LiveSupervisorContext> context;
  std::unique_ptr<Supervisor, void (*)(Supervisor*)> supervisor{nullptr, nullptr};
  FrameContents needs;
  std::vector<Event> events;  ///< since its last update
  ControllerClock clock;
  SupervisorSlot();
  SupervisorSlot(SupervisorSlot&&) noexcept;
  SupervisorSlot& operator=(SupervisorSlot&&) noexcept;
  ~SupervisorSlot();
};

struct SimulationSnapshot {
  SceneModelPtr model;
  SnapshotPtr world;
  Clock::State clock;
  RunStatus status = RunStatus::running;
  std::vector<MotorState> motors;
  std::vector<SensorMemory> sensors;
  std::vector<ControllerClock> controllers, supervisors;
  std::vector<std::uint64_t> controller_random, supervisor_random;
  std::vector<std::vector<double>> controller_outputs, supervisor_outputs;
  std::vector<std::vector<Event>> supervisor_events;
  std::vector<Twist> twists_before;
  std::vector<double> joint_efforts_before, motor_efforts_before;
  EventState event_system;
  std::vector<Command> sent;  ///< commands of supervisors for the next step boundary
};

struct Simulation::Impl {
  explicit Impl(std::shared_ptr<PluginLoader> plugins)
      : loader(std::move(plugins)), sensing(*loader) {}

  std::shared_ptr<PluginLoader> loader;
  std::shared_ptr<const Backend> backend;
  Provenance provenance;
  std::unique_ptr<World> world;
  SceneModelPtr original;           ///< the initial scene, with the seed and step of the options
  SceneModelPtr model;              ///< the current scene
  bool rebuild_on_restart = false;  ///< the world was created from another scene than `original`

  Clock clock;
  Pace pace;
  MessageLog log{clock};
  CommandQueue commands;
  Isolation isolation = Isolation::none;  ///< of controllers whose isolation is not set
  RunStatus status = RunStatus::running;
  std::atomic<bool> stop_requested{false};

  std::vector<MotorState> motors;
  std::vector<Drive> drives;
  ForceSystem forces;
  SensorSuite sensors;
  FrameSensorContext sensing;
  std::vector<ControllerSlot> controllers;
  std::vector<SupervisorSlot> supervisors;
  SceneForControllers scene_for_controllers;
  bool spin_reported = false;
  std::vector<Event> events;         ///< since the last frame
  std::vector<Causes> event_causes;  ///< of each entry of `events`
  Causes causes;                     ///< of the current action
  EventSystem event_system;
  bool ending = false;  ///< the run ends with this step

  std::vector<std::shared_ptr<Observation::Slot>> observers;
  bool start_shown = false;  ///< the observers have received the initial frame

  std::shared_ptr<FramePool> pool = std::make_shared<FramePool>();
  FramePtr cached;  ///< frame of the current step
  FrameContents cached_contents;
  WorldState state;  ///< cached current state, valid if `state_fresh`
  bool state_fresh = false;
  std::vector<Twist> twists_before;  ///< of the previous step; empty if not needed
  /// Efforts of the previous step, as in WorldState, if the engine does not have them: after
  /// resuming from a snapshot file.
  std::vector<double> joint_efforts_before, motor_efforts_before;

  double time() const { return clock.time(); }
  /// The state of the world, including `joint_efforts_before`; present_state() caches it.
  void get_state(WorldState& out) const;
  const WorldState& present_state();
  FramePtr frame_with(const FrameContents& contents);
  void copy_controller_outputs(Frame& frame) const;
  void world_changed();

  // create.cpp: builds the elements of the model; errors have the source location of the element.
  void build_motors(std::size_t first);
  std::vector<Diagnostic> build_sensors(std::size_t first);
  std::vector<Diagnostic> build_controllers(std::size_t first_controller, bool with_supervisors);
  std::vector<Diagnostic> build_all();

  // controllers.cpp
  Diagnostic problem(const std::string& message, const SourceSpan& origin, const std::string& code,
                     const std::string& help = {}) const;
  std::vector<Diagnostic> build_controller(std::size_t index);
  /// Creates and configures the controller of a slot that has its plugin and its access.
  StartOutcome start_controller(ControllerSlot& slot, std::size_t index);
  std::vector<Diagnostic> build_supervisor(const ControllerModel& description);
  void run_controllers();
  void fault(const ControllerModel& description, ControllerClock& clock,
             const std::string& message);
  void stop_motors(const AssemblyAccess& access);

  // reload.cpp
  Result<Reloaded> reload(const std::string& name);
  std::optional<std::string> transfer_state(const ControllerSlot& old, ControllerSlot& fresh,
                                            std::size_t index, Reloaded& done);

  // step.cpp
  void read_sensors();
  void apply_forces();
  RunStatus step();
  void show_start();
  void show_frame();  ///< passes the current frame to the observers
  void check_spin();

  // rules.cpp: events and rules
  void publish_event(Event event);  ///< adds an event with the current causes to the next frame
  void detect_events();             ///< regions, doors and rules, after a step and at the start
  void apply_due();                 ///< applies scheduled actions and removes expired assemblies
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
  Result<> check_capacity(const std::string& what, std::size_t bodies);

  bool wants_accelerations() const;
};

/// Index of the element with this name; the error has the most similar name.
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

/// Fills in the outputs of the controllers and supervisors that their plugins declare.
void name_outputs(SceneModel& model, PluginLoader& loader);

/// Implementation of SupervisorContext in a simulation.
class LiveSupervisorContext final : public SupervisorContext {
 public:
  LiveSupervisorContext(Simulation::Impl& simulation, const ControllerModel& description,
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
  /// Crash-report scope for a call of the supervisor.
  PluginCall calling(const char* doing) const {
    return {"supervisor", name_.c_str(), "", plugin_.c_str(), doing, simulation_.time()};
  }
  /// Returns and clears the error since the last call.
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

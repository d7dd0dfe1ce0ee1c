// Resuming from a snapshot file, with the same or an edited scene, or on another engine.
#include <algorithm>
#include <cmath>
#include <set>

#include "cogrsim/core/constants.h"
#include "model/diagnose.h"
#include "simulation/impl.h"
#include "simulation/snapshot/data.h"
#include "simulation/snapshot/events.h"

namespace cogrsim {

using namespace snapshots;

namespace {

/// Transfers the parts of a snapshot to a simulation that was created for it.
class Resumption {
 public:
  Resumption(Simulation::Impl& to, const SnapshotFile& snapshot, bool same_seed,
             std::vector<std::string>& notes)
      : to_(to), content_(snapshot.impl().content), same_seed_(same_seed), notes_(notes) {}

  Result<> run() {
    clock();
    if (auto good = world(); !good) return good;
    motors();
    to_.world_changed();
    // Controllers are configured again, so that they see the current world and not the initial one.
    if (const auto found = to_.build_controllers(); !found.empty()) {
      return fail("the controllers cannot be configured: " + joined(found), found.front());
    }
    sensors();
    const SceneModel& model = to_.model();
    inputs();
    hosted("controller", content_.at("controllers"), model.controllers, to_.controllers.slots());
    hosted("supervisor", content_.at("supervisors"), model.supervisors, to_.supervisors.slots());
    to_.events.update_model(to_.host.model());  // a door that the file lacks is at its start
    event_state_from(content_.at("event_system"), model, to_.events.memory);
    forces();
    if (!same_seed_) {
      notes_.push_back("the seed differs: the random streams restart");
    }
    if (const int sent = whole_from<int>(content_.at("sent")); sent > 0) {
      notes_.push_back(std::to_string(sent) +
                       " commands that supervisors had just sent are not in the snapshot");
    }
    return {};
  }

 private:
  void clock() {
    const Json& saved = content_.at("clock");
    Clock::State now;
    now.dt = to_.clock.dt();
    now.steps = whole_from<std::uint64_t>(saved.at("steps"));
    now.last_dt = number_from(saved.at("last_dt"));
    if (now.dt == number_from(saved.at("dt"))) {
      now.base_time = number_from(saved.at("base_time"));
      now.steps_since_base = whole_from<std::uint64_t>(saved.at("steps_since_base"));
    } else {
      now.base_time = number_from(saved.at("time"));
    }
    to_.clock.restore(now);
  }

  Result<> world() {
    const SceneModel& model = to_.model();
    WorldState state;
    to_.host.world().get_state(state);
    WorldHost::Before before = to_.host.before();
    before.joint_efforts.assign(state.joint_efforts.size(), 0.0);
    const Json &bodies = content_.at("bodies"), &joints = content_.at("joints");
    std::vector<std::string> fresh, odd;
    std::set<std::string> names;
    std::size_t carried = 0;
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      const Body& body = model.bodies[i];
      if (body.removed) continue;
      names.insert(body.name);
      if (!bodies.contains(body.name)) {
        fresh.push_back(body.name);
        continue;
      }
      ++carried;
      // Immobile bodies have the poses of the scene, where they may have been moved on purpose.
      if (body.kind == BodyKind::static_body) continue;
      state.poses[i] = pose_from(bodies.at(body.name).at("pose"));
      state.twists[i] = twist_from(bodies.at(body.name).at("twist"));
    }
    note_elements("starts as in the scene, because the snapshot does not have it: body",
                  "start as in the scene, because the snapshot does not have them: bodies", fresh);
    note_missing("body", "bodies", bodies, names);
    if (carried == 0 && !bodies.empty()) {
      return fail("no body of the snapshot is in the scene '" + model.name + "'");
    }
    names.clear();
    fresh.clear();
    for (const Joint& joint : model.joints) {
      if (joint.removed) continue;
      names.insert(joint.name);
      if (!joints.contains(joint.name)) {
        fresh.push_back(joint.name);
        continue;
      }
      const Json& then = joints.at(joint.name);
      const std::vector<double> q = numbers_from(then.at("position"));
      const std::vector<double> u = numbers_from(then.at("velocity"));
      if (then.at("type") != to_string(joint.type) ||
          q.size() != static_cast<std::size_t>(position_count(joint.type)) ||
          u.size() != static_cast<std::size_t>(speed_count(joint.type))) {
        odd.push_back(joint.name);
        continue;
      }
      std::copy(q.begin(), q.end(), state.joint_positions.begin() + joint.position_offset);
      std::copy(u.begin(), u.end(), state.joint_velocities.begin() + joint.speed_offset);
      if (!then.contains("effort")) continue;  // older files
      const std::vector<double> effort = numbers_from(then.at("effort"));
      if (effort.size() == u.size()) {
        std::copy(effort.begin(), effort.end(), before.joint_efforts.begin() + joint.speed_offset);
      }
    }
    note_elements("starts as in the scene, because the snapshot does not have it: joint",
                  "start as in the scene, because the snapshot does not have them: joints", fresh);
    note_elements("is of another type than in the snapshot and starts as in the scene: joint",
                  "are of another type than in the snapshot and start as in the scene: joints",
                  odd);
    note_missing("joint", "joints", joints, names);
    if (auto done = to_.host.world().set_state(state); !done) return done;
    const Json& twists = content_.at("twists_before");
    if (!twists.empty()) {
      before.twists = state.twists;
      for (std::size_t i = 0; i < model.bodies.size(); ++i) {
        const std::string& name = model.bodies[i].name;
        if (twists.contains(name)) before.twists[i] = twist_from(twists.at(name));
      }
    }
    to_.host.set_before(std::move(before));
    to_.world_changed();
    return {};
  }

  void motors() {
    const Json& then = content_.at("motors");
    const SceneModel& model = to_.model();
    std::set<std::string> names;
    std::vector<std::string> fresh, odd;
    DeviceManager::Saved devices = to_.devices.save();
    WorldHost::Before before = to_.host.before();
    before.motor_efforts.assign(model.motors.size(), 0.0);
    for (std::size_t i = 0; i < model.motors.size(); ++i) {
      const Motor& motor = model.motors[i];
      if (motor.removed) continue;
      names.insert(motor.name);
      if (!then.contains(motor.name)) {
        fresh.push_back(motor.name);
        continue;
      }
      const Json& saved = then.at(motor.name);
      if (saved.at("mode") != to_string(motor.mode)) {
        odd.push_back(motor.name);
        continue;
      }
      devices.motors[i].target = clamp_target(model, motor, number_from(saved.at("target")));
      devices.motors[i].acting = devices.motors[i].target;
      if (saved.contains("acting")) {  // not in older files
        devices.motors[i].acting = clamp_target(model, motor, number_from(saved.at("acting")));
        for (const Json& it : saved.at("waiting")) {
          if (motor.delay <= 0.0) break;
          const DelayedTarget next{number_from(it.at(0)),
                                   clamp_target(model, motor, number_from(it.at(1)))};
          check_order("motor", motor.name, devices.motors[i].waiting, next.time);
          devices.motors[i].waiting.push_back(next);
        }
      }
      devices.motors[i].integral = number_from(saved.at("integral"));
      if (saved.contains("follows"))  // not in older files
        devices.motors[i].follows = saved.at("follows").get<bool>();
      if (saved.contains("effort"))  // not in older files
        before.motor_efforts[i] = number_from(saved.at("effort"));
    }
    to_.devices.restore(devices);
    to_.host.set_before(std::move(before));
    note_elements("starts as in the scene, because the snapshot does not have it: motor",
                  "start as in the scene, because the snapshot does not have them: motors", fresh);
    note_elements("has another mode than in the snapshot and starts as in the scene: motor",
                  "have another mode than in the snapshot and start as in the scene: motors", odd);
    note_missing("motor", "motors", then, names);
  }

  /// With the same rate the next tick is that of the snapshot; otherwise the first one from now on.
  void set_timer(RateTimer& timer, const Json& saved, double rate) const {
    if (saved.is_object() && number_from(saved.at("rate")) == rate) {
      timer.set_next(whole_from<std::uint64_t>(saved.at("ticks")));
    } else {
      timer.skip_to(to_.clock.time(), to_.clock.dt());
    }
  }

  // What is under way has been set or measured before now, one after the other.
  template <class Queue>
  void check_order(const char* kind, const std::string& name, const Queue& queue, double time) {
    const double now = number_from(content_.at("clock").at("time"));
    if (!(time >= 0.0 && time <= now) || (!queue.empty() && time < queue.back().time))
      throw Damaged(std::string("the ") + kind + " '" + name + "' has something under way from " +
                    "another time than before that of the snapshot");
  }

  static void take_reading(const Json& saved, const SensorModel& sensor, std::size_t channels,
                           Reading& reading) {
    reading.sequence = whole_from<std::uint64_t>(saved.at("sequence"));
    reading.values = numbers_from(saved.at("values"));
    if (!reading.values.empty() && reading.values.size() != channels)
      throw Damaged("the sensor '" + sensor.name + "' has not as many values as its type");
    reading.time = number_from(saved.at("time"));
    reading.valid = saved.at("valid").get<bool>();
    const Json& pose = saved.value("pose", Json());  // not in older snapshots
    if (!pose.is_null()) reading.pose = pose_from(pose);
  }

  void sensors() {
    const Json& then = content_.at("sensors");
    DeviceManager::Saved devices = to_.devices.save();
    std::set<std::string> names;
    std::vector<std::string> fresh;
    for (std::size_t i = 0; i < devices.sensors.size(); ++i) {
      const SensorModel& sensor = to_.model().sensors[i];
      if (sensor.removed) continue;
      names.insert(sensor.name);
      SensorMemory& memory = devices.sensors[i];
      set_timer(memory.timer, then.contains(sensor.name) ? then.at(sensor.name) : Json(),
                sensor.rate);
      if (!then.contains(sensor.name) || then.at(sensor.name).at("type") != sensor.type) {
        fresh.push_back(sensor.name);
        continue;
      }
      const Json& saved = then.at(sensor.name);
      memory.enabled = memory.reading.enabled = saved.at("enabled").get<bool>();
      memory.complained = saved.at("complained").get<bool>();
      if (same_seed_) memory.random = whole_from<std::uint64_t>(saved.at("random"));
      memory.reading.sequence = whole_from<std::uint64_t>(saved.at("sequence"));
      const std::vector<double> walk = numbers_from(saved.at("walk"));
      // With other parameters the number of channels may differ.
      if (walk.size() != memory.walk.size()) continue;
      memory.walk = walk;
      const std::size_t channels = to_.devices.sensors().channels(i).size();
      take_reading(saved, sensor, channels, memory.reading);
      if (sensor.latency <= 0.0 || !saved.contains("in_flight")) continue;
      for (const Json& it : saved.at("in_flight")) {
        Reading reading = memory.reading;
        take_reading(it, sensor, channels, reading);
        check_order("sensor", sensor.name, memory.in_flight, reading.time);
        memory.in_flight.push_back(std::move(reading));
      }
    }
    to_.devices.restore(devices);
    note_elements("restarts, because the snapshot does not have it: sensor",
                  "restart, because the snapshot does not have them: sensors", fresh);
    note_missing("sensor", "sensors", then, names);
  }

  void take_clock(const Json& saved, double rate, ControllerClock& clock) const {
    set_timer(clock.timer, saved, rate);
    clock.stopped = clock.stopped || saved.at("stopped").get<bool>();
    clock.last_time = number_from(saved.at("last_time"));
    clock.count = whole_from<std::uint64_t>(saved.at("count"));
  }

  /// Whether a snapshot's controllers have this one; with another plugin it is another one.
  static bool is_of(const Json& then, const ControllerModel& model) {
    return then.contains(model.name) && then.at(model.name).at("plugin") == model.plugin;
  }

  /// Transfers controllers or supervisors.
  template <class Slot>
  void hosted(const std::string& kind, const Json& then, const std::vector<ControllerModel>& models,
              std::vector<Slot>& slots) {
    std::set<std::string> names;
    std::vector<std::string> fresh, forgetful;
    for (std::size_t i = 0; i < models.size(); ++i) {
      const ControllerModel& model = models[i];
      if (model.removed) continue;
      names.insert(model.name);
      Slot& slot = slots[i];
      if (!is_of(then, model)) {
        slot.clock.timer.skip_to(to_.clock.time(), to_.clock.dt());
        fresh.push_back(model.name);
        continue;
      }
      const Json& saved = then.at(model.name);
      take_clock(saved.at("clock"), model.rate, slot.clock);
      RandomStream* random = slot.random();
      std::vector<double>* outputs = slot.outputs();
      if (random && same_seed_) random->set_state(whole_from<std::uint64_t>(saved.at("random")));
      const std::vector<double> published = numbers_from(saved.at("outputs"));
      if (outputs && published.size() == outputs->size()) *outputs = published;
      if (saved.at("memory").is_null()) {
        forgetful.push_back(model.name);
        continue;
      }
      const auto failure = slot.restore(saved.at("memory").template get<std::string>());
      if (!failure) continue;
      const bool there = failure->kind == HostFailure::Kind::thrown;
      notes_.push_back(kind + " '" + model.name + "' does not accept its state" +
                       (there ? " and restarts: " + failure->what
                              : ": it " + phrase(*failure, "while taking it")));
    }
    note_elements("restarts, because the snapshot does not have it: " + kind,
                  "restart, because the snapshot does not have them: " + kind + "s", fresh);
    note_elements("saves no state for snapshots and restarts: " + kind,
                  "save no state for snapshots and restart: " + kind + "s", forgetful);
    note_missing(kind, kind + "s", then, names);
  }

  /// Those that somebody had set; older files have none.
  void inputs() {
    const Json& then = content_.at("controllers");
    const auto& models = to_.model().controllers;
    for (std::size_t i = 0; i < models.size(); ++i) {
      const auto& access = to_.controllers.slots()[i].access;
      if (models[i].removed || !access || !is_of(then, models[i])) continue;
      const Json saved = then.at(models[i].name).value("inputs", Json::object());
      std::vector<ControllerInput> had;
      for (const auto& [name, value] : saved.items())
        had.push_back({name, {}, 0.0, 0.0, number_from(value), kNaN});
      carry_inputs(had, access->inputs);
    }
  }

  /// Those of commands.
  void forces() {
    if (!content_.contains("forces")) return;  // older files
    std::vector<ForceSystem::Applied> applied;
    std::vector<std::string> lost;
    for (const Json& saved : content_.at("forces")) {
      ForceSystem::Applied it;
      it.command.body = saved.at("body").get<std::string>();
      it.body = find_body(to_.model(), it.command.body);
      if (it.body < 0) {
        lost.push_back(it.command.body);
        continue;
      }
      it.command.force = vector_from(saved.at("force"));
      it.command.torque = vector_from(saved.at("torque"));
      it.command.point = vector_from(saved.at("point"));
      it.command.in_body = saved.at("in_body").get<bool>();
      it.until = number_from(saved.at("until"));
      applied.push_back(std::move(it));
    }
    to_.forces.set_applied(std::move(applied));
    note_elements("is not in the scene any more, and its force ends: body",
                  "are not in the scene any more, and their forces end: bodies", lost);
  }

  void note_elements(const std::string& one, const std::string& many,
                     const std::vector<std::string>& names) {
    if (!names.empty()) notes_.push_back(listed(one, many, names));
  }
  void note_missing(const std::string& one, const std::string& many, const Json& then,
                    const std::set<std::string>& now) {
    std::vector<std::string> missing;
    for (const auto& entry : then.items()) {
      if (now.count(entry.key()) == 0) missing.push_back(entry.key());
    }
    note_elements("is not in the scene any more: " + one, "are not in the scene any more: " + many,
                  missing);
  }

  Simulation::Impl& to_;
  const Json& content_;
  bool same_seed_;
  std::vector<std::string>& notes_;
};

}  // namespace

tl::expected<Resumed, std::vector<Diagnostic>> resume(const SnapshotFile& snapshot,
                                                      SceneModelPtr scene,
                                                      const SimulationOptions& options,
                                                      std::shared_ptr<PluginLoader> loader) {
  using Failure = tl::unexpected<std::vector<Diagnostic>>;
  const auto refuse = [](const Error& error) {
    return Failure(std::vector<Diagnostic>{to_diagnostic(error)});
  };
  const SnapshotInfo& info = snapshot.info();
  const Json& content = snapshot.impl().content;
  if (info.scene != scene->name) {
    return refuse(
        Error("the snapshot is of scene '" + info.scene + "', not of '" + scene->name + "'"));
  }
  Resumed resumed;
  try {
    if (content.at("status") != to_string(RunStatus::running)) {
      resumed.notes.push_back("the run had ended (" + content.at("status").get<std::string>() +
                              ") when the snapshot was taken; it is continued anyway");
    }
    // If elements were added or removed, the world is created with the elements of the snapshot; a
    // restart creates that of the scene.
    SceneModelPtr then = scene;
    std::unique_ptr<Simulation> plain_run;
    if (info.changed) {
      auto plain = Simulation::create(scene, options, loader);
      if (!plain) return Failure(plain.error());
      plain_run = std::move(*plain);
      then = with_changes(*scene, content, resumed.notes);
    }
    auto created = Simulation::create(then, options, loader);
    if (!created) return Failure(created.error());
    resumed.simulation = std::move(*created);
    Simulation::Impl& to = SnapshotAccess::of(*resumed.simulation);
    const WorldHost& of_scene = plain_run ? SnapshotAccess::of(*plain_run).host : to.host;
    const std::string signature = scene_signature(*of_scene.original());
    const bool unchanged = content.at("signature") == signature;
    if (plain_run) to.host.restart_from(of_scene);
    if (!unchanged) {
      resumed.notes.push_back(
          "the scene is not that of the snapshot: the state is transferred by names of elements");
    }
    resumed.same_scene = unchanged && info.backend == to.host.backend().name();
    const bool same_seed = to.host.seed() == info.seed;
    if (auto good = Resumption(to, snapshot, same_seed, resumed.notes).run(); !good) {
      return refuse(good.error());
    }
  } catch (const Json::exception& e) {
    return refuse(Error(std::string("the snapshot is damaged: ") + e.what()));
  } catch (const Damaged& e) {
    return refuse(Error(std::string("the snapshot is damaged: ") + e.what()));
  } catch (const std::out_of_range&) {
    return refuse(Error("the snapshot is damaged: its scene is inconsistent"));
  }
  return resumed;
}

}  // namespace cogrsim

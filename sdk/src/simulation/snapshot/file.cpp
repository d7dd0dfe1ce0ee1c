// Snapshot files: writing, reading and checking.
#include "cogrsim/simulation/snapshot_file.h"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cogrsim/core/random.h"
#include "simulation/impl.h"
#include "simulation/snapshot/data.h"
#include "simulation/snapshot/events.h"

namespace cogrsim {

using namespace snapshots;

namespace {

constexpr const char* kFormat = "cogrsim-snapshot";
/// Largest file that is read. The maximum of 100000 spawned bodies takes about 200 MB.
constexpr std::uintmax_t kMostBytes = std::uintmax_t{512} << 20;

std::string checksum(const Json& content) {
  const std::string text = content.dump(-1, ' ', false, Json::error_handler_t::replace);
  return std::to_string(hash_bytes(text.data(), text.size()));
}

Json clock_json(const ControllerClock& clock, double rate) {
  return {{"rate", rate},
          {"ticks", clock.timer.next()},
          {"stopped", clock.stopped},
          {"last_time", number(clock.last_time)},
          {"count", clock.count}};
}

/// The controllers or supervisors by name, each with the state that it saves itself.
template <class Slot>
Result<Json> hosted_json(const std::vector<ControllerModel>& models,
                         const std::vector<Slot>& slots) {
  Json out = Json::object();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const ControllerModel& model = models[i];
    const Slot& slot = slots[i];
    if (model.removed || !slot.random()) continue;
    Json one = {{"plugin", model.plugin},
                {"clock", clock_json(slot.clock, model.rate)},
                {"random", slot.random()->state()},
                {"outputs", numbers(*slot.outputs())},
                {"memory", nullptr}};
    std::optional<std::string> memory;
    if (const auto failure = slot.save(memory)) {
      return fail("'" + model.name + "' " + phrase(*failure, "while its state was saved"));
    }
    if (memory) one["memory"] = *memory;
    out[model.name] = std::move(one);
  }
  return out;
}

void put_world(const Simulation::Impl& from, const WorldState& state, Json& content) {
  const SceneModel& model = from.model();
  const std::vector<Twist>& twists_before = from.host.before().twists;
  Json bodies = Json::object(), before = Json::object();
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    bodies[model.bodies[i].name] = {{"pose", pose(state.poses[i])},
                                    {"twist", twist(state.twists[i])}};
    if (i < twists_before.size()) before[model.bodies[i].name] = twist(twists_before[i]);
  }
  Json joints = Json::object();
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    joints[joint.name] = {
        {"type", to_string(joint.type)},
        {"position", numbers(state.joint_positions.data() + joint.position_offset,
                             static_cast<std::size_t>(position_count(joint.type)))},
        {"velocity", numbers(state.joint_velocities.data() + joint.speed_offset,
                             static_cast<std::size_t>(speed_count(joint.type)))},
        {"effort", numbers(state.joint_efforts.data() + joint.speed_offset,
                           static_cast<std::size_t>(speed_count(joint.type)))}};
  }
  content["bodies"] = std::move(bodies);
  content["joints"] = std::move(joints);
  content["twists_before"] = std::move(before);
}

Json reading_json(const Reading& reading) {
  return {{"time", number(reading.time)},
          {"sequence", reading.sequence},
          {"valid", reading.valid},
          {"pose", reading.pose ? pose(*reading.pose) : Json()},
          {"values", numbers(reading.values)}};
}

void put_devices(const Simulation::Impl& from, const WorldState& state, Json& content) {
  const SceneModel& model = from.model();
  const DeviceManager::Saved devices = from.devices.save();
  Json motors = Json::object(), sensors = Json::object();
  for (std::size_t i = 0; i < model.motors.size(); ++i) {
    if (model.motors[i].removed) continue;
    Json waiting = Json::array();
    for (const DelayedTarget& it : devices.motors[i].waiting)
      waiting.push_back(Json::array({number(it.time), number(it.target)}));
    motors[model.motors[i].name] = {{"mode", to_string(model.motors[i].mode)},
                                    {"target", number(devices.motors[i].target)},
                                    {"acting", number(devices.motors[i].acting)},
                                    {"waiting", std::move(waiting)},
                                    {"integral", number(devices.motors[i].integral)},
                                    {"follows", devices.motors[i].follows},
                                    {"effort", number(state.motor_efforts[i])}};
  }
  for (std::size_t i = 0; i < model.sensors.size(); ++i) {
    if (model.sensors[i].removed) continue;
    const SensorMemory& memory = devices.sensors[i];
    Json one = reading_json(memory.reading), in_flight = Json::array();
    // Pictures and lists of contacts are not in a snapshot, and a reading without them is none.
    for (const Reading& reading : memory.in_flight)
      if (!reading.picture && reading.contacts.empty()) in_flight.push_back(reading_json(reading));
    one["type"] = model.sensors[i].type;
    one["rate"] = model.sensors[i].rate;
    one["ticks"] = memory.timer.next();
    one["enabled"] = memory.enabled;
    one["complained"] = memory.complained;
    one["random"] = memory.random;
    one["walk"] = numbers(memory.walk);
    one["in_flight"] = std::move(in_flight);
    sensors[model.sensors[i].name] = std::move(one);
  }
  content["motors"] = std::move(motors);
  content["sensors"] = std::move(sensors);
}

Result<SnapshotInfo> info_from(const Json& content) {
  SnapshotInfo info;
  info.scene = content.at("scene").get<std::string>();
  info.backend = content.at("backend").get<std::string>();
  info.engine_version = content.at("engine_version").get<std::string>();
  info.seed = whole_from<std::uint64_t>(content.at("seed"));
  info.step = number_from(content.at("clock").at("dt"));
  info.time = number_from(content.at("clock").at("time"));
  for (const auto& [name, value] : content.at("parameters").items()) {
    info.parameters[name] = value.get<std::string>();
  }
  info.changed = !content.at("changes").is_null();
  if (!(info.step > 0.0) || !(info.time >= 0.0)) return fail("its clock cannot be");
  return info;
}

}  // namespace

Result<> write_snapshot(const Simulation& simulation, const std::string& path,
                        const std::map<std::string, std::string>& parameters,
                        const OutputRules& rules) {
  const Simulation::Impl& from = SnapshotAccess::of(simulation);
  Json content;
  content["scene"] = from.model().name;
  content["signature"] = scene_signature(*from.host.original());
  content["backend"] = from.host.backend().name();
  content["engine_version"] = from.host.backend().engine_version();
  content["parameters"] = Json::object();
  for (const auto& [name, value] : parameters) content["parameters"][name] = value;
  content["seed"] = from.host.seed();
  content["status"] = to_string(from.status);
  const Clock::State& clock = from.clock.save();
  content["clock"] = {{"time", number(from.clock.time())},
                      {"dt", number(clock.dt)},
                      {"base_time", number(clock.base_time)},
                      {"last_dt", number(clock.last_dt)},
                      {"steps", clock.steps},
                      {"steps_since_base", clock.steps_since_base}};
  WorldState state;
  from.host.get_state(state);
  put_world(from, state, content);
  put_devices(from, state, content);
  auto controllers = hosted_json(from.model().controllers, from.controllers.slots());
  if (!controllers) return tl::unexpected(controllers.error());
  for (const ControllerInputs& each : from.controllers.inputs())
    for (const ControllerInput& input : each.inputs)  // the others start as the scene says
      if (input.was_set())
        (*controllers)[each.controller]["inputs"][input.name] = number(input.value);
  content["controllers"] = std::move(*controllers);
  auto supervisors = hosted_json(from.model().supervisors, from.supervisors.slots());
  if (!supervisors) return tl::unexpected(supervisors.error());
  content["supervisors"] = std::move(*supervisors);
  content["event_system"] = event_state_json(from.model(), from.events.memory);
  content["forces"] = Json::array();
  for (const ForceSystem::Applied& it : from.forces.applied())
    content["forces"].push_back({{"body", it.command.body},
                                 {"force", vector(it.command.force)},
                                 {"torque", vector(it.command.torque)},
                                 {"point", vector(it.command.point)},
                                 {"in_body", it.command.in_body},
                                 {"until", number(it.until)}});
  content["sent"] = from.commands.own_count();
  content["changes"] = from.host.model() == from.host.original()
                           ? Json(nullptr)
                           : changes_of(*from.host.original(), from.model());
  const Json file = {{"format", kFormat},
                     {"version", kSnapshotVersion},
                     {"checksum", checksum(content)},
                     {"content", std::move(content)}};
  return write_output_file(path, OutputKind::snapshot,
                           file.dump(1, ' ', false, Json::error_handler_t::replace) + "\n", rules);
}

const SnapshotInfo& SnapshotFile::info() const { return impl_->info; }

Result<SnapshotFile> SnapshotFile::read(const std::string& path) {
  const auto refuse = [&](const std::string& why, const std::string& hint = {}) {
    return fail("'" + path + "' " + why, "", hint);
  };
  const auto unreadable = [&](const std::string& why) {
    return fail("cannot read the snapshot '" + path + "': " + why);
  };
  // A device never ends, and a pipe blocks until it has a writer.
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (error) return unreadable(error.message());
  if (std::filesystem::is_directory(status)) return unreadable("it is a folder");
  if (!std::filesystem::is_regular_file(status)) {
    return refuse("is not a regular file", "copy what it gives into one first");
  }
  if (const std::uintmax_t size = std::filesystem::file_size(path, error);
      !error && size > kMostBytes) {
    return refuse("is too large for a snapshot: " + std::to_string(size >> 20) + " MB, at most " +
                  std::to_string(kMostBytes >> 20) + " MB are read");
  }
  std::ifstream in(path, std::ios::binary);
  if (!in.is_open()) return unreadable(std::strerror(errno));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) return unreadable(std::strerror(errno));
  const Json file = Json::parse(text, nullptr, false);
  if (file.is_discarded()) {
    const bool ours = text.find(kFormat) != std::string::npos && text.find(kFormat) < 100;
    return ours ? refuse("is damaged: it is cut off, or not JSON any more")
                : refuse("is not a snapshot", "snapshots are made by cogrsim run --save-at");
  }
  if (!file.is_object() || !file.contains("format") || file["format"] != kFormat ||
      !file.contains("version") || !file["version"].is_number_integer()) {
    return refuse("is not a snapshot", "snapshots are made by cogrsim run --save-at");
  }
  if (const auto version = file["version"].get<std::int64_t>(); version != kSnapshotVersion) {
    return refuse("is a snapshot of version " + std::to_string(version) + ", this program reads " +
                      std::to_string(kSnapshotVersion),
                  "use the cogrsim that wrote it");
  }
  if (!file.contains("content") || !file.contains("checksum") ||
      file["checksum"] != checksum(file["content"])) {
    return refuse("is damaged, or was changed by hand: its checksum does not fit");
  }
  auto impl = std::make_shared<Impl>();
  impl->content = file["content"];
  try {
    auto info = info_from(impl->content);
    if (!info) return refuse("is damaged: " + info.error().message);
    impl->info = std::move(*info);
  } catch (const Json::exception& e) {
    return refuse(std::string("is damaged: ") + e.what());
  } catch (const Damaged& e) {
    return refuse(std::string("is damaged: ") + e.what());
  }
  SnapshotFile snapshot;
  snapshot.impl_ = std::move(impl);
  return snapshot;
}

}  // namespace cogrsim

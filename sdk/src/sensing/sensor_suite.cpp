#include "sensing/sensor_suite.h"

#include <algorithm>
#include <type_traits>

#include "cogrsim/core/constants.h"
#include "cogrsim/sensing/sensor_models.h"
#include "model/diagnose.h"
#include "sensing/delays.h"

namespace cogrsim {

PluginCall SensorSuite::calling(const Slot& slot, const char* doing, double time) {
  return {"sensor", slot.name.c_str(), "", slot.type.c_str(), doing, time};
}

void SensorSuite::take_down(Slot& slot) {
  if (!slot.sensor) return;
  const PluginCall call = calling(slot, "while it was destroyed", kNaN);
  slot.sensor.reset();
}

std::vector<Diagnostic> SensorSuite::make(const SceneModel& model, std::size_t index,
                                          PluginLoader& loader, double step, Slot& slot) const {
  const SensorModel& description = model.sensors[index];
  const auto refuse = [&](const Error& error, const char* code) {
    return std::vector<Diagnostic>{diagnose(model, description.origin,
                                            "sensor '" + description.name + "': " + error.message,
                                            error.code.empty() ? code : error.code, error.hint)};
  };
  const SensorEntry* entry = built_in_sensor(description.type);
  ParameterTable table;
  if (entry) {
    for (PluginDescriptor& d : built_in_sensors()) {
      if (d.name == description.type) table = std::move(d.parameters);
    }
  } else {
    auto plugin = loader.load(PluginKind::sensor, description.type);
    if (!plugin) return refuse(plugin.error(), "CG0901");
    slot.plugin = *plugin;
    entry = static_cast<const SensorEntry*>((*plugin)->descriptor().factory);
    table = (*plugin)->descriptor().parameters;
  }
  if (description.removed) return {};
  slot.name = description.name;
  slot.type = description.type;
  const PluginCall call = calling(slot, "while being configured", kNaN);
  slot.sensor = {entry->create(), entry->destroy};
  const auto parameters = complete_parameters(table, description.parameters);
  if (!parameters) return refuse(parameters.error(), "CG0906");
  if (auto ready = slot.sensor->configure(model, description, *parameters); !ready) {
    return refuse(ready.error(), "CG0906");
  }
  slot.channels = std::make_shared<const std::vector<Channel>>(slot.sensor->channels());
  if (const auto late = unusable_latency(description, step, slot)) return refuse(*late, "CG0716");
  slot.needs = slot.sensor->needs();
  return {};
}

std::optional<Error> SensorSuite::unusable_latency(const SensorModel& description, double step,
                                                   const Slot& slot) {
  if (!slot.plugin || !slot.sensor) return std::nullopt;
  return cogrsim::unusable_latency(description, step, static_cast<double>(slot.channels->size()));
}

std::optional<Error> SensorSuite::unusable_latency(const SceneModel& model, double step) const {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (model.sensors[i].removed) continue;
    if (auto late = unusable_latency(model.sensors[i], step, slots_[i])) return late;
  }
  return std::nullopt;
}

std::vector<Diagnostic> SensorSuite::build(const SceneModelPtr& model, std::uint64_t seed,
                                           PluginLoader& loader, double step, std::size_t first) {
  std::vector<Diagnostic> found;
  cut(first);
  for (std::size_t i = first; i < model->sensors.size(); ++i) {
    const SensorModel& description = model->sensors[i];
    Slot slot;
    for (Diagnostic& d : make(*model, i, loader, step, slot)) found.push_back(std::move(d));
    slot.noise = description.noise;
    slot.latency = description.latency;
    slot.random = RandomStream(seed, description.name);
    slot.memory.timer = RateTimer(description.rate);
    slot.memory.enabled = description.enabled;
    slot.memory.walk.assign(slot.channels->size(), 0.0);
    slot.memory.reading.sensor = static_cast<int>(i);
    slot.memory.reading.enabled = description.enabled;
    slots_.push_back(std::move(slot));
  }
  return found;
}

void SensorSuite::cut(std::size_t count) {
  due_.clear();
  channels_.reset();
  if (count < slots_.size()) {
    std::for_each(slots_.begin() + static_cast<std::ptrdiff_t>(count), slots_.end(), take_down);
    slots_.erase(slots_.begin() + static_cast<std::ptrdiff_t>(count), slots_.end());
  }
}

std::optional<FrameContents> SensorSuite::begin(double time, double dt) {
  now_ = time;
  due_.clear();
  FrameContents needed;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    std::deque<Reading>& waiting = slot.memory.in_flight;
    // A boundary counts as reached up to a millionth of a step earlier, as for rates.
    while (!waiting.empty() && waiting.front().time + slot.latency <= time + 1e-6 * dt) {
      slot.memory.reading = std::move(waiting.front());
      waiting.pop_front();
    }
    if (!slot.sensor || !slot.memory.timer.due(time, dt)) continue;
    slot.memory.timer.advance(time, dt);
    if (!slot.memory.enabled) continue;
    due_.push_back(i);
    needed = needed | slot.needs;
  }
  if (due_.empty()) return std::nullopt;
  return needed;
}

std::vector<SensorFault> SensorSuite::read(SensorContext& context) {
  std::vector<SensorFault> faults;
  for (const std::size_t i : due_) {
    Slot& slot = slots_[i];
    std::deque<Reading>& waiting = slot.memory.in_flight;
    if (slot.latency > 0.0 && slot.memory.reading.sequence > 0) {
      Reading next;
      const Reading& newest = waiting.empty() ? slot.memory.reading : waiting.back();
      next.sensor = newest.sensor;
      next.time = newest.time;
      next.sequence = newest.sequence;
      next.enabled = true;
      waiting.push_back(std::move(next));
    }
    Reading& reading = waiting.empty() ? slot.memory.reading : waiting.back();
    const double period = reading.sequence == 0 ? 0.0 : now_ - reading.time;
    reading.values.assign(slot.channels->size(), 0.0);
    reading.picture.reset();
    reading.contacts.clear();
    const PluginCall call = calling(slot, "in a reading", now_);
    const Result<> measured = slot.sensor->read(context, reading);
    if (!measured && !slot.memory.complained) {
      faults.push_back({static_cast<int>(i), measured.error()});
    }
    slot.memory.complained = !measured;
    reading.valid = measured && slot.sensor->disturb(slot.noise, period, slot.random,
                                                     slot.memory.walk, reading);
    reading.time = now_;
    reading.pose = sensor_pose(context.frame().model->sensors[i], context.frame().state);
    ++reading.sequence;
  }
  due_.clear();
  return faults;
}

void SensorSuite::copy_readings(std::vector<Reading>& out) const {
  out.resize(slots_.size());
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const Reading& reading = slots_[i].memory.reading;
    // Assignment would retain the memory of the values from before the sensor was retired.
    if (reading.values.empty())
      out[i] = Reading(reading);
    else
      out[i] = reading;
  }
}

std::shared_ptr<const SensorChannels> SensorSuite::channels() const {
  if (!channels_) {
    auto all = std::make_shared<SensorChannels>();
    for (const Slot& slot : slots_) all->push_back(slot.channels);
    channels_ = std::move(all);
  }
  return channels_;
}

void SensorSuite::enable(std::size_t sensor, bool on) {
  SensorMemory& memory = slots_[sensor].memory;
  memory.enabled = memory.reading.enabled = on;
  if (on) return;
  memory.reading.valid = false;
  memory.in_flight.clear();
}

void SensorSuite::retire(std::size_t sensor) {
  enable(sensor, false);
  Slot& slot = slots_[sensor];
  take_down(slot);
  const auto free = [](auto& elements) { std::decay_t<decltype(elements)>().swap(elements); };
  slot.channels = std::make_shared<const std::vector<Channel>>();
  channels_.reset();
  free(slot.noise);
  free(slot.memory.walk);
  free(slot.memory.in_flight);
  free(slot.memory.reading.values);
  free(slot.memory.reading.contacts);
  slot.memory.reading.picture.reset();
}

FrameContents SensorSuite::needs() const {
  FrameContents needed;
  for (const Slot& slot : slots_) {
    if (slot.sensor && slot.memory.enabled) needed = needed | slot.needs;
  }
  return needed;
}

bool SensorSuite::wants_accelerations() const {
  return std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) {
    return slot.memory.enabled && slot.needs.accelerations;
  });
}

std::vector<SensorMemory> SensorSuite::save() const {
  std::vector<SensorMemory> memories;
  memories.reserve(slots_.size());
  for (const Slot& slot : slots_) {
    memories.push_back(slot.memory);
    memories.back().random = slot.random.state();
  }
  return memories;
}

void SensorSuite::restore(const std::vector<SensorMemory>& memories) {
  for (std::size_t i = 0; i < memories.size() && i < slots_.size(); ++i) {
    slots_[i].memory = memories[i];
    slots_[i].random.set_state(memories[i].random);
  }
}

void mean_accelerations(const std::vector<Twist>& before, const std::vector<Twist>& now, double dt,
                        std::vector<Twist>& out) {
  out.assign(now.size(), Twist());
  const std::size_t known = std::min(before.size(), now.size());
  for (std::size_t i = 0; i < known; ++i) {
    out[i].linear = (now[i].linear - before[i].linear) / dt;
    out[i].angular = (now[i].angular - before[i].angular) / dt;
  }
}

}  // namespace cogrsim

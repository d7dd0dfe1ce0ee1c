// Recomputation of readings from recorded frames, with the code, timers and random streams of the
// sensors, including the times at which they were switched on and off.
#include <fmt/format.h>

#include "core/rate_timer.h"
#include "recording/recording_impl.h"
#include "sensing/frame_sensor_context.h"
#include "sensing/sensor_suite.h"

namespace cogrsim {

namespace {

// The frame that sensors measure at the end of `frame` if the scene of the next step is `next`:
// bodies that were added at that step boundary have their initial poses.
FramePtr seen_by_sensors(const FramePtr& frame, const SceneModelPtr& next) {
  if (frame->model == next) return frame;
  auto out = std::make_shared<Frame>(*frame);
  const SceneModel& model = *next;
  out->model = next;
  WorldState& state = out->state;
  for (std::size_t i = state.poses.size(); i < model.bodies.size(); ++i) {
    state.poses.push_back(model.bodies[i].X_WB);
    state.twists.push_back(model.bodies[i].V_WB);
  }
  for (std::size_t i = frame->model->joints.size(); i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const auto append = [](std::vector<double>& to, const std::vector<double>& values) {
      to.insert(to.end(), values.begin(), values.end());
    };
    append(state.joint_positions, joint.position);
    append(state.joint_velocities, joint.velocity);
  }
  state.joint_efforts.resize(state.joint_velocities.size());
  state.motor_efforts.resize(model.motors.size());
  if (!out->accelerations.empty()) out->accelerations.resize(model.bodies.size());
  if (!out->joint_reactions.empty()) out->joint_reactions.resize(model.joints.size());
  return out;
}

// The sensors of a run while its frames are processed.
class Reader {
 public:
  // `contacts`: whether the frames have them.
  Reader(PluginLoader& loader, std::uint64_t seed, bool contacts)
      : loader_(loader), seed_(seed), contacts_(contacts), sensing_(loader) {}

  // Sets up the sensors as at the start of a run.
  Result<> begin(const SceneModelPtr& model) {
    suite_.clear();
    timers_.clear();
    model_ = nullptr;
    return follow(model);
  }

  // Processes the step from `from` to `to`, both as recorded.
  Result<> step(const FramePtr& from, const Frame& to) {
    if (auto done = follow(to.model); !done) return done;
    for (std::size_t i = 0; i < suite_.size(); ++i) {
      const bool due = timers_[i].due(from->time, to.dt);
      if (due) timers_[i].advance(from->time, to.dt);
      const std::uint64_t before = i < from->readings.size() ? from->readings[i].sequence : 0;
      // A sensor was enabled at that time if it has a reading; with a latency that comes later.
      const bool late = model_->sensors[i].latency > 0.0;
      if (due) suite_.enable(i, late ? to.readings[i].enabled : to.readings[i].sequence > before);
    }
    if (suite_.begin(from->time, to.dt)) {
      sensing_.show(seen_by_sensors(from, to.model));
      for (const SensorFault& fault : suite_.read(sensing_)) {
        if (to.readings[fault.sensor].valid) {
          const std::string& name = model_->sensors[fault.sensor].name;
          return fail(fmt::format("sensor '{}' cannot measure: {}", name, fault.error.message), "",
                      fault.error.hint);
        }
      }
      sensing_.hide();
    }
    for (std::size_t i = 0; i < suite_.size(); ++i) suite_.enable(i, to.readings[i].enabled);
    return {};
  }

  void copy_readings(std::vector<Reading>& out) const { suite_.copy_readings(out); }

 private:
  // Sensors that were added are created, and those of removed elements are retired, as in the run.
  Result<> follow(const SceneModelPtr& model) {
    if (model == model_) return {};
    const std::size_t first = std::min(suite_.size(), model->sensors.size());
    const auto found = suite_.build(model, seed_, loader_, model->physics.step, first);
    if (!found.empty()) return fail(found.front().message, "", found.front().help);
    for (std::size_t i = 0; i < first; ++i) {
      if (model->sensors[i].removed) suite_.retire(i);
    }
    timers_.resize(first);
    for (std::size_t i = first; i < model->sensors.size(); ++i) {
      timers_.emplace_back(model->sensors[i].rate);
    }
    model_ = model;
    if (!contacts_ && suite_.needs().contacts) {
      return fail("readings cannot be recomputed: a sensor needs contacts, which were not recorded",
                  "", "record with contacts=\"true\"");
    }
    return {};
  }

  PluginLoader& loader_;
  std::uint64_t seed_;
  bool contacts_;
  FrameSensorContext sensing_;
  SensorSuite suite_;
  std::vector<RateTimer> timers_;
  SceneModelPtr model_;
};

}  // namespace

Result<> Recording::recompute(PluginLoader& loader,
                              const std::function<bool(const Frame&)>& visit) {
  Impl& impl = *impl_;
  const auto not_all = [](const std::string& why) {
    return fail("readings cannot be recomputed: " + why, "",
                "record every step: leave 'every' out, and give the recording a fast disk");
  };
  if (!impl.every_step) return not_all("not every step was recorded");
  Reader reader(loader, impl.info.seed, impl.contacts);
  std::shared_ptr<Frame> before;
  for (std::size_t i = 0; i < impl.frames.size(); ++i) {
    auto frame = impl.frame(i);
    if (!frame) return tl::unexpected(frame.error());
    const Frame& now = **frame;
    const bool restarted = before && now.step == 0;
    if (!before || restarted) {
      if (now.step != 0) return not_all("the recording does not begin with the run");
      if (auto done = reader.begin(now.model); !done) return done;
    } else if (now.step != before->step + 1) {
      return not_all(fmt::format("after {:.6g} s frames are missing", before->time));
    } else if (auto done = reader.step(before, now); !done) {
      return done;
    }
    Frame computed = now;
    reader.copy_readings(computed.readings);
    if (!visit(computed)) break;
    before = std::move(*frame);
  }
  return {};
}

}  // namespace cogrsim

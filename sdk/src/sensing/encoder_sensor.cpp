#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Encoder: position q and speed u of one axis of a joint. With a resolution r the position is
/// r round(q / r) as in an incremental encoder, within r / 2 of the true value; it is rounded after
/// the noise. The speed is the exact speed of the joint, not a difference of counts.
class Encoder final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    if (sensor.joint < 0) return fail("it measures no joint", "", "name one: joint=\"…\"");
    const Joint& joint = model.joints[sensor.joint];
    const bool axes_are_coordinates = joint.type != JointType::ball &&
                                      joint.type != JointType::free &&
                                      joint.type != JointType::fixed;
    const auto axis = static_cast<int>(integer(parameters, "axis")) - 1;
    if (!axes_are_coordinates || axis >= speed_count(joint.type)) {
      return fail("joint '" + joint.name + "' (" + to_string(joint.type) + ") has no axis " +
                  std::to_string(axis + 1));
    }
    const bool linear = !axis_turns(joint.type, axis);
    resolution_ = number(parameters, "resolution");
    max_speed_ = number(parameters, "max-speed");
    if (const auto counts = integer(parameters, "counts"); counts > 0) {
      if (linear) {
        return fail("joint '" + joint.name + "' slides, so there are no counts per turn", "",
                    "give the resolution as a length");
      }
      if (resolution_ > 0.0) return fail("'counts' and 'resolution' exclude each other");
      resolution_ = 2.0 * kPi / static_cast<double>(counts);
    }
    const std::string unit = linear ? "m" : "rad";
    channels_ = {{"position", unit, true}, {"velocity", unit + "/s", false}};
    position_ = static_cast<std::size_t>(joint.position_offset + axis);
    speed_ = static_cast<std::size_t>(joint.speed_offset + axis);
    return {};
  }
  std::vector<Channel> channels() const override { return channels_; }
  Result<> read(SensorContext& context, Reading& reading) override {
    const WorldState& state = context.frame().state;
    reading.values = {state.joint_positions[position_], state.joint_velocities[speed_]};
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    const bool received = apply_noise(noise, channels_, period, random, walk, reading.values);
    double& position = reading.values[0];
    if (resolution_ > 0.0) position = resolution_ * std::round(position / resolution_);
    saturate(reading.values, 1, 2, max_speed_);
    return received;
  }

 private:
  std::vector<Channel> channels_;
  double resolution_ = 0.0, max_speed_ = 0.0;
  std::size_t position_ = 0, speed_ = 0;
};

}  // namespace

PluginDescriptor encoder() {
  return describe<Encoder>(
      "encoder", "position and speed of a joint's axis",
      {parameter("axis", 1, "which axis of the joint, counted from 1").range(1, 3),
       parameter("resolution", 0.0, "", "step of the position [rad or m]; 0: exact")
           .range(0.0, kInfinity),
       parameter("counts", 0, "counts per turn, instead of a resolution; 0: none").range(0, 1e9),
       parameter("max-speed", 0.0, "", "largest speed it reads [rad/s or m/s]; 0: no limit")
           .range(0.0, kInfinity)});
}

}  // namespace cogrsim::sensor_models

#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Force-torque sensor: force and torque that the parent of a joint exerts on its child, about the
/// origin and in the axes of the joint frame M of the child, mean over the last step. For an arm
/// that hangs at rest it measures f = -m g and t = -c x m g, with c from the joint to the centre of
/// mass. Noise of group 0 acts on the force and of group 1 on the torque; both are then saturated.
class ForceTorque final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    if (sensor.joint < 0) return fail("it measures no joint", "", "name one: joint=\"…\"");
    joint_ = static_cast<std::size_t>(sensor.joint);
    const Joint& joint = model.joints[joint_];
    child_ = joint.child;
    q_CM_ = joint.X_CM.q;
    max_force_ = number(parameters, "max-force");
    max_torque_ = number(parameters, "max-torque");
    channels_.clear();
    for (const char* axis : {"fx", "fy", "fz"}) channels_.push_back({axis, "N", true, 0});
    for (const char* axis : {"tx", "ty", "tz"}) channels_.push_back({axis, "N*m", true, 1});
    return {};
  }
  std::vector<Channel> channels() const override { return channels_; }
  FrameContents needs() const override {
    FrameContents contents;
    contents.joint_reactions = true;
    return contents;
  }
  Result<> read(SensorContext& context, Reading& reading) override {
    const Frame& frame = context.frame();
    if (joint_ >= frame.joint_reactions.size()) {
      return fail("the backend does not report joint reactions");
    }
    const Quat q_WC = child_ == kWorld ? Quat(1, 0, 0, 0) : frame.state.poses[child_].q;
    const Quat q_MW = (q_WC * q_CM_).conjugate();
    put(reading.values, 0, q_MW * frame.joint_reactions[joint_].force);
    put(reading.values, 3, q_MW * frame.joint_reactions[joint_].torque);
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    const bool received = apply_noise(noise, channels_, period, random, walk, reading.values);
    saturate(reading.values, 0, 3, max_force_);
    saturate(reading.values, 3, 6, max_torque_);
    return received;
  }

 private:
  std::vector<Channel> channels_;
  std::size_t joint_ = 0;
  int child_ = kWorld;
  Quat q_CM_{1, 0, 0, 0};
  double max_force_ = 0.0, max_torque_ = 0.0;
};

}  // namespace

PluginDescriptor force_torque() {
  return describe<ForceTorque>(
      "force-torque", "force and torque that a joint's parent exerts on its child",
      {parameter("max-force", 0.0, "N", "largest component it reads; 0: no limit")
           .range(0.0, kInfinity),
       parameter("max-torque", 0.0, "N*m", "largest component it reads; 0: no limit")
           .range(0.0, kInfinity)});
}

}  // namespace cogrsim::sensor_models

#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Inertial measurement unit: specific force f = R_SW (a_S - g) and angular velocity R_SW w, in the
/// axes of the sensor, with a_S = a_B + alpha x r + w x (w x r) and r from the body origin to the
/// sensor. The acceleration is the mean over the last step (a difference of twists), as for a
/// device that integrates over its sampling period. Noise of group 0 acts on f and of group 1 on w;
/// both are then saturated.
class Imu final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    if (sensor.body == kWorld) return fail("it is mounted on no body", "", "name one: on=\"…\"");
    sensor_ = sensor;
    gravity_ = model.physics.gravity;
    max_acceleration_ = number(parameters, "max-acceleration");
    max_angular_speed_ = number(parameters, "max-angular-speed");
    channels_.clear();
    for (const char* axis : {"fx", "fy", "fz"}) channels_.push_back({axis, "m/s^2", true, 0});
    for (const char* axis : {"wx", "wy", "wz"}) channels_.push_back({axis, "rad/s", true, 1});
    return {};
  }
  std::vector<Channel> channels() const override { return channels_; }
  FrameContents needs() const override {
    FrameContents contents;
    contents.accelerations = true;
    return contents;
  }
  Result<> read(SensorContext& context, Reading& reading) override {
    const Frame& frame = context.frame();
    std::vector<double>& values = reading.values;
    const SensorMotion motion = motion_of(sensor_, frame.state);
    const auto body = static_cast<std::size_t>(sensor_.body);
    if (body >= frame.accelerations.size()) {
      put(values, 0, Vec3::Constant(kNaN));
    } else {
      const Twist& a = frame.accelerations[body];
      const Vec3& w = motion.V_WS.angular;
      const Vec3 at_sensor = a.linear + a.angular.cross(motion.arm) + w.cross(w.cross(motion.arm));
      put(values, 0, motion.X_WS.q.conjugate() * (at_sensor - gravity_));
    }
    put(values, 3, motion.X_WS.q.conjugate() * motion.V_WS.angular);
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    const bool received = apply_noise(noise, channels_, period, random, walk, reading.values);
    saturate(reading.values, 0, 3, max_acceleration_);
    saturate(reading.values, 3, 6, max_angular_speed_);
    return received;
  }

 private:
  SensorModel sensor_;
  std::vector<Channel> channels_;
  Vec3 gravity_ = Vec3::Zero();
  double max_acceleration_ = 0.0, max_angular_speed_ = 0.0;
};

}  // namespace

PluginDescriptor imu() {
  return describe<Imu>(
      "imu", "specific force and angular velocity in the sensor's axes",
      {parameter("max-acceleration", 0.0, "m/s^2", "largest component it reads; 0: no limit")
           .range(0.0, kInfinity),
       parameter("max-angular-speed", 0.0, "rad/s", "largest component it reads; 0: no limit")
           .range(0.0, kInfinity)});
}

}  // namespace cogrsim::sensor_models

#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Pose sensor: pose and twist of the sensor frame in the world, as an ideal tracking system
/// measures them. Noise acts on the position.
class PoseOfFrame final : public Sensor {
 public:
  Result<> configure(const SceneModel&, const SensorModel& sensor, const Parameters&) override {
    sensor_ = sensor;
    return {};
  }
  std::vector<Channel> channels() const override {
    std::vector<Channel> all;
    for (const char* axis : {"x", "y", "z"}) all.push_back({axis, "m", true});
    for (const char* part : {"qw", "qx", "qy", "qz"}) all.push_back({part, "1", false});
    for (const char* axis : {"vx", "vy", "vz"}) all.push_back({axis, "m/s", false});
    for (const char* axis : {"wx", "wy", "wz"}) all.push_back({axis, "rad/s", false});
    return all;
  }
  Result<> read(SensorContext& context, Reading& reading) override {
    std::vector<double>& values = reading.values;
    const SensorMotion motion = motion_of(sensor_, context.frame().state);
    put(values, 0, motion.X_WS.p);
    const Quat& q = motion.X_WS.q;
    values[3] = q.w();
    values[4] = q.x();
    values[5] = q.y();
    values[6] = q.z();
    put(values, 7, motion.V_WS.linear);
    put(values, 10, motion.V_WS.angular);
    return {};
  }

 private:
  SensorModel sensor_;
};

}  // namespace

PluginDescriptor pose() {
  return describe<PoseOfFrame>("pose", "ideal pose and twist of the sensor's frame in the world");
}

}  // namespace cogrsim::sensor_models

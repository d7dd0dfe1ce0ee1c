// The sensors that need nothing but the state: encoder, pose, imu.
#include <cmath>
#include <limits>
#include <memory>

#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Pose and twist of the sensor's own frame S in the world.
struct SensorMotion {
  Pose X_WS;
  Twist V_WS;
  Vec3 arm = Vec3::Zero();  // from the body's origin to S, world axes
};

SensorMotion motion_of(const SensorModel& sensor, const WorldState& state) {
  SensorMotion motion;
  if (sensor.body == kWorld) {
    motion.X_WS = sensor.X_BS;
    return motion;
  }
  const auto body = static_cast<std::size_t>(sensor.body);
  const Pose& X_WB = state.poses[body];
  motion.X_WS = X_WB * sensor.X_BS;
  motion.arm = X_WB.q * sensor.X_BS.p;
  motion.V_WS.linear = state.twists[body].at(motion.arm);
  motion.V_WS.angular = state.twists[body].angular;
  return motion;
}

void put(std::vector<double>& values, std::size_t at, const Vec3& v) {
  for (int i = 0; i < 3; ++i) values[at + static_cast<std::size_t>(i)] = v[i];
}

/// Position and speed of one joint axis.
class EncoderSensor final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters& parameters) override {
    if (sensor.joint < 0) {
      return fail("encoder '" + sensor.name + "' measures no joint", place_of(model, sensor.origin),
                  "name one: joint=\"…\"");
    }
    const Joint& joint = model.joints[static_cast<std::size_t>(sensor.joint)];
    const bool axes_are_coordinates = joint.type != JointType::ball &&
                                      joint.type != JointType::free &&
                                      joint.type != JointType::fixed;
    const auto axis = static_cast<int>(std::get<std::int64_t>(parameters.at("axis")));
    if (!axes_are_coordinates || axis < 0 || axis >= speed_count(joint.type)) {
      return fail("encoder '" + sensor.name + "': joint '" + joint.name + "' (" +
                      to_string(joint.type) + ") has no axis " + std::to_string(axis),
                  place_of(model, sensor.origin));
    }
    const bool linear = joint.type == JointType::slider ||
                        (joint.type == JointType::cylindrical && axis == 1) ||
                        (joint.type == JointType::planar && axis < 2);
    unit_ = linear ? "m" : "rad";
    position_ = static_cast<std::size_t>(joint.position_offset + axis);
    speed_ = static_cast<std::size_t>(joint.speed_offset + axis);
    return {};
  }
  std::vector<Channel> channels() const override {
    return {{"position", unit_, true}, {"velocity", unit_ + "/s", false}};
  }
  Result<> read(Sensing& sensing, Reading& reading) override {
    const WorldState& state = sensing.frame().state;
    reading.values = {state.joint_positions[position_], state.joint_velocities[speed_]};
    return {};
  }

 private:
  std::string unit_;
  std::size_t position_ = 0, speed_ = 0;
};

/// Ideal tracking: pose and twist of the sensor's frame in the world.
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
  Result<> read(Sensing& sensing, Reading& reading) override {
    std::vector<double>& values = reading.values;
    const SensorMotion motion = motion_of(sensor_, sensing.frame().state);
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

/// Specific force f = R_SW (a_S - g) and angular velocity, in the sensor's axes. The acceleration
/// is the mean over the last step (a difference of twists), as an instrument integrating over its
/// sample time would report.
class ImuSensor final : public Sensor {
 public:
  Result<> configure(const SceneModel& model, const SensorModel& sensor,
                     const Parameters&) override {
    if (sensor.body == kWorld) {
      return fail("imu '" + sensor.name + "' is mounted on no body", place_of(model, sensor.origin),
                  "name one: on=\"…\"");
    }
    sensor_ = sensor;
    gravity_ = model.physics.gravity;
    return {};
  }
  std::vector<Channel> channels() const override {
    std::vector<Channel> all;
    for (const char* axis : {"fx", "fy", "fz"}) all.push_back({axis, "m/s^2", true});
    for (const char* axis : {"wx", "wy", "wz"}) all.push_back({axis, "rad/s", false});
    return all;
  }
  FrameContents needs() const override {
    FrameContents contents;
    contents.accelerations = true;
    return contents;
  }
  Result<> read(Sensing& sensing, Reading& reading) override {
    const Frame& frame = sensing.frame();
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

 private:
  SensorModel sensor_;
  Vec3 gravity_ = Vec3::Zero();
};

template <class Type>
const SensorEntry* entry() {
  static constexpr SensorEntry kEntry = {[]() -> Sensor* { return new Type; },
                                         [](Sensor* sensor) { delete sensor; }};
  return &kEntry;
}

}  // namespace

const SensorEntry* built_in_sensor(const std::string& type) {
  if (type == "encoder") return entry<EncoderSensor>();
  if (type == "pose") return entry<PoseOfFrame>();
  if (type == "imu") return entry<ImuSensor>();
  return nullptr;
}

std::vector<PluginDescriptor> built_in_sensors() {
  const auto about = [](const char* name, const char* what, ParameterTable parameters = {}) {
    PluginDescriptor d;
    d.kind = PluginKind::sensor;
    d.name = name;
    d.version = "1.0.0";
    d.author = "CogRSim";
    d.summary = what;
    d.parameters = std::move(parameters);
    d.factory = built_in_sensor(name);
    return d;
  };
  return {about("encoder", "position and speed of a joint's axis",
                {parameter("axis", 0, "which axis of the joint, from 0").range(0, 2)}),
          about("imu", "specific force and angular velocity in the sensor's axes"),
          about("pose", "ideal pose and twist of the sensor's frame in the world")};
}

}  // namespace cogrsim

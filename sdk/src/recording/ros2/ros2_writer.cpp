#include "cogrsim/recording/ros2_writer.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor_models.h"
#include "recording/mcap/scene_messages.h"
#include "recording/recording_file.h"
#include "recording/ros2/cdr.h"
#include "recording/ros2/ros2_types.h"
#include "recording/run_encoder.h"

namespace cogrsim {

namespace {

using ros2::Cdr;

constexpr std::size_t kRos2ChunkBytes = 1u << 20;

// From the sensor's axes (x forward, z up) to those of pictures (z forward, y down).
Quat picture_orientation() { return Quat(0.5, -0.5, 0.5, -0.5); }

// Names are separated by dots in a scene, and by slashes in topics and frames of ROS.
std::string slashed(std::string name) {
  std::replace(name.begin(), name.end(), '.', '/');
  return name;
}

// Of a topic, too, which allows letters, digits and underlines, and no part begins with a digit.
std::string topic_of(const std::string& name) {
  std::string out = "/";
  for (const char c : slashed(name)) {
    const bool digit = c >= '0' && c <= '9';
    const bool good =
        digit || c == '/' || c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (digit && out.back() == '/') out += '_';
    out += good ? c : '_';
  }
  return out;
}

std::string frame_of(const SceneModel& model, int body) {
  return body == kWorld ? "world" : slashed(model.bodies[static_cast<std::size_t>(body)].name);
}

struct StampedTransform {
  std::string parent, child;
  Pose pose;
};

void put_transform_list(Cdr& out, const std::vector<StampedTransform>& all, std::uint64_t time) {
  out.count(all.size());
  for (const StampedTransform& transform : all) {
    out.header(time, transform.parent);
    out.text(transform.child);
    out.put(transform.pose.p);
    out.put(transform.pose.q);
  }
}

// Exact, or not known: the latter is what a -1 in the first place says.
template <std::size_t N>
void put_covariance(Cdr& out, double first = 0.0) {
  for (std::size_t i = 0; i < N; ++i) out.put(i == 0 ? first : 0.0);
}

}  // namespace

struct Ros2Writer::Impl {
  explicit Impl(std::unique_ptr<RecordingFile> to) : file(to.get()), mcap(std::move(to)) {}

  RecordingFile* file;  // owned by the writer
  mcap::Writer mcap;
  std::map<std::string, std::uint16_t> schemas, channels;
  std::map<std::string, std::uint32_t> counts;  // of messages, by topic
  std::set<std::string> left_out;
  SceneModelPtr model;
  std::vector<std::uint64_t> sequences;  // of the readings written last
  std::uint64_t late = 0;                // from the stamp of a message to when it is there [ns]

  std::uint16_t channel(const std::string& topic, const std::string& type);
  template <class Fill>
  void put(const std::string& topic, const std::string& type, std::uint64_t time, Fill&& fill);

  void fixed_frames(const Frame& frame, std::uint64_t time);
  void moving_frames(const Frame& frame, std::uint64_t time);
  void joints(const Frame& frame, std::uint64_t time);
  void reading(const Frame& frame, const SensorModel& sensor, const Reading& reading);
  void odometry(const SensorModel& sensor, const Reading& reading, std::uint64_t time);
  void imu(const SensorModel& sensor, const Reading& reading, std::uint64_t time);
  void scan(const SensorModel& sensor, const Reading& reading, std::uint64_t time);
  void picture(const Frame& frame, const SensorModel& sensor, const Picture& picture,
               std::uint64_t time);
};

std::uint16_t Ros2Writer::Impl::channel(const std::string& topic, const std::string& type) {
  std::uint16_t& id = channels[topic];
  if (id != 0) return id;
  std::uint16_t& schema = schemas[type];
  if (schema == 0) schema = mcap.add_schema(type, "ros2msg", ros2::schema_of(type));
  // Who listens later needs them too: kept for the last, reliable, transient-local.
  const std::string latched =
      "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
      "  deadline:\n    sec: 9223372036\n    nsec: 854775807\n"
      "  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
      "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
      "  avoid_ros_namespace_conventions: false";
  id = mcap.add_channel(schema, topic, "cdr",
                        {{"offered_qos_profiles", topic == "/tf_static" ? latched : ""}});
  return id;
}

template <class Fill>
void Ros2Writer::Impl::put(const std::string& topic, const std::string& type, std::uint64_t time,
                           Fill&& fill) {
  mcap.message(channel(topic, type), counts[topic]++, time + late, [&](std::string& out) {
    // The first bytes of a message decide where its numbers stand.
    Cdr cdr(out);
    fill(cdr);
  });
}

void Ros2Writer::Impl::fixed_frames(const Frame& at, std::uint64_t time) {
  const SceneModel& now = *at.model;
  std::vector<StampedTransform> all;
  for (std::size_t i = 0; i < now.bodies.size(); ++i) {
    const Body& body = now.bodies[i];
    if (!body.removed && body.kind == BodyKind::static_body)
      all.push_back({"world", slashed(body.name), at.state.poses[i]});
  }
  for (const NamedFrame& frame : now.frames) {
    if (!frame.removed) all.push_back({frame_of(now, frame.body), slashed(frame.name), frame.X_BF});
  }
  for (const SensorModel& sensor : now.sensors) {
    if (sensor.removed) continue;
    const std::string name = slashed(sensor.name);
    all.push_back({frame_of(now, sensor.body), name, sensor.X_BS});
    if (sensor.type == "camera")
      all.push_back({name, name + "_optical_frame", Pose(Vec3::Zero(), picture_orientation())});
  }
  if (all.empty()) return;
  put("/tf_static", "tf2_msgs/msg/TFMessage", time,
      [&](Cdr& out) { put_transform_list(out, all, time); });
}

void Ros2Writer::Impl::moving_frames(const Frame& frame, std::uint64_t time) {
  std::vector<StampedTransform> all;
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    const Body& body = frame.model->bodies[i];
    if (!body.removed && body.kind != BodyKind::static_body)
      all.push_back({"world", slashed(body.name), frame.state.poses[i]});
  }
  if (all.empty()) return;
  put("/tf", "tf2_msgs/msg/TFMessage", time, [&](Cdr& out) { put_transform_list(out, all, time); });
}

void Ros2Writer::Impl::joints(const Frame& frame, std::uint64_t time) {
  std::vector<std::string> names;
  std::vector<double> positions, velocities, efforts;
  for (const Joint& joint : frame.model->joints) {
    const int count = position_count(joint.type);
    if (joint.removed || count == 0) continue;
    if (count != speed_count(joint.type)) {
      left_out.insert(fmt::format("joint '{}' ({})", joint.name, to_string(joint.type)));
      continue;
    }
    for (int axis = 0; axis < count; ++axis) {
      const auto q = static_cast<std::size_t>(joint.position_offset + axis);
      const auto u = static_cast<std::size_t>(joint.speed_offset + axis);
      names.push_back(count == 1 ? joint.name : fmt::format("{}/{}", joint.name, axis));
      positions.push_back(frame.state.joint_positions[q]);
      velocities.push_back(frame.state.joint_velocities[u]);
      efforts.push_back(u < frame.state.joint_efforts.size() ? frame.state.joint_efforts[u] : 0.0);
    }
  }
  if (names.empty()) return;
  put("/joint_states", "sensor_msgs/msg/JointState", time, [&](Cdr& out) {
    out.header(time, "");
    out.count(names.size());
    for (const std::string& name : names) out.text(name);
    for (const auto* numbers : {&positions, &velocities, &efforts}) out.list(*numbers);
  });
}

void Ros2Writer::Impl::odometry(const SensorModel& sensor, const Reading& reading,
                                std::uint64_t time) {
  const std::vector<double>& v = reading.values;
  if (v.size() < 13) return;
  const Quat q(v[3], v[4], v[5], v[6]);
  put(topic_of(sensor.name) + "/odom", "nav_msgs/msg/Odometry", time, [&](Cdr& out) {
    out.header(time, "world");
    out.text(slashed(sensor.name));
    out.put(Vec3(v[0], v[1], v[2]));
    out.put(q);
    put_covariance<36>(out);
    // In the axes of the child, where readings have those of the world.
    out.put(Vec3(q.conjugate() * Vec3(v[7], v[8], v[9])));
    out.put(Vec3(q.conjugate() * Vec3(v[10], v[11], v[12])));
    put_covariance<36>(out);
  });
}

void Ros2Writer::Impl::imu(const SensorModel& sensor, const Reading& reading, std::uint64_t time) {
  const std::vector<double>& v = reading.values;
  if (v.size() < 6) return;
  put(topic_of(sensor.name) + "/imu", "sensor_msgs/msg/Imu", time, [&](Cdr& out) {
    out.header(time, slashed(sensor.name));
    out.put(Quat(Quat::Identity()));
    put_covariance<9>(out, -1.0);  // an orientation is not measured
    out.put(Vec3(v[3], v[4], v[5]));
    put_covariance<9>(out);
    out.put(Vec3(v[0], v[1], v[2]));
    put_covariance<9>(out);
  });
}

void Ros2Writer::Impl::scan(const SensorModel& sensor, const Reading& reading, std::uint64_t time) {
  const std::vector<Vec3> rays = ray_directions(sensor);
  if (rays.size() < 2 || reading.values.size() < rays.size()) return;
  const PlanarScan angles = planar_scan(rays);
  const RangeLimits limits = range_limits(sensor);
  put(topic_of(sensor.name) + "/scan", "sensor_msgs/msg/LaserScan", time, [&](Cdr& out) {
    out.header(time, slashed(sensor.name));
    for (const double number :
         {angles.first, angles.last, angles.step, 0.0, sensor.rate > 0.0 ? 1.0 / sensor.rate : 0.0,
          limits.least, limits.most}) {
      out.put(static_cast<float>(number));
    }
    out.count(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) out.put(static_cast<float>(reading.values[i]));
    out.count(0);
  });
}

void Ros2Writer::Impl::picture(const Frame& frame, const SensorModel& sensor,
                               const Picture& picture, std::uint64_t time) {
  const std::string topic = topic_of(sensor.name),
                    frame_id = slashed(sensor.name) + "_optical_frame";
  const auto width = static_cast<std::uint32_t>(picture.width);
  const auto height = static_cast<std::uint32_t>(picture.height);
  const auto image = [&](const std::string& name, const char* encoding, std::uint32_t pixel,
                         std::string_view data) {
    put(topic + name, "sensor_msgs/msg/Image", time, [&](Cdr& out) {
      out.header(time, frame_id);
      out.put(height);
      out.put(width);
      out.text(encoding);
      out.put(std::uint8_t{0});
      out.put(pixel * width);
      out.bytes(data);
    });
  };
  const auto view = [](const auto& numbers) {
    return std::string_view(reinterpret_cast<const char*>(numbers.data()),
                            numbers.size() * sizeof numbers[0]);
  };
  const bool color = !picture.color.data.empty(), depth = !picture.depth.empty();
  if (color) image("/image_raw", "rgb8", 3, view(picture.color.data));
  if (depth) image("/depth/image_raw", "32FC1", 4, view(picture.depth));
  if (!picture.bodies.empty()) image("/segmentation/image_raw", "32SC1", 4, view(picture.bodies));
  const auto request = camera_request(*frame.model, sensor, frame.state);
  if (!request) return;
  const Camera& camera = request->camera;
  put(topic + "/camera_info", "sensor_msgs/msg/CameraInfo", time, [&](Cdr& out) {
    out.header(time, frame_id);
    out.put(height);
    out.put(width);
    out.text("plumb_bob");
    out.count(camera.distortion.size());
    for (const double part : camera.distortion) out.put(part);
    // The centre of the first pixel is (0, 0) there, and (0.5, 0.5) here.
    const double cx = camera.cx - 0.5, cy = camera.cy - 0.5;
    for (const double part : {camera.fx, 0.0, cx, 0.0, camera.fy, cy, 0.0, 0.0, 1.0}) out.put(part);
    for (const double part : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) out.put(part);
    for (const double part :
         {camera.fx, 0.0, cx, 0.0, 0.0, camera.fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0}) {
      out.put(part);
    }
    for (int i = 0; i < 2 + 4; ++i) out.put(std::uint32_t{0});  // no binning, the whole picture
    out.put(false);
  });
}

void Ros2Writer::Impl::reading(const Frame& frame, const SensorModel& sensor,
                               const Reading& reading) {
  const std::uint64_t time = nanoseconds(reading.time);
  late = nanoseconds(sensor.latency);
  if (sensor.type == "pose") {
    odometry(sensor, reading, time);
  } else if (sensor.type == "imu") {
    imu(sensor, reading, time);
  } else if (is_planar_scan(sensor)) {
    scan(sensor, reading, time);
  } else if (sensor.type == "camera") {
    if (reading.picture) {
      picture(frame, sensor, *reading.picture, time);
    } else {
      left_out.insert(fmt::format("sensor '{}' (pictures that were not recorded)", sensor.name));
    }
  } else {
    left_out.insert(fmt::format("sensor '{}' ({})", sensor.name, sensor.type));
  }
  late = 0;
}

Result<std::unique_ptr<Ros2Writer>> Ros2Writer::create(const std::string& path,
                                                       const OutputRules& rules) {
  auto file = RecordingFile::create(path, rules);
  if (!file) return tl::unexpected(file.error());
  auto impl = std::make_unique<Impl>(std::move(*file));
  if (auto done = impl->mcap.start("ros2", "cogrsim " COGRSIM_VERSION); !done) {
    return tl::unexpected(done.error());
  }
  return std::unique_ptr<Ros2Writer>(new Ros2Writer(std::move(impl)));
}

Ros2Writer::Ros2Writer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Ros2Writer::~Ros2Writer() = default;

Result<> Ros2Writer::add(const Frame& frame) {
  Impl& impl = *impl_;
  const std::uint64_t time = nanoseconds(frame.time);
  const SceneModel& model = *frame.model;
  if (frame.model != impl.model) {
    impl.model = frame.model;
    impl.fixed_frames(frame, time);
  }
  impl.put("/clock", "rosgraph_msgs/msg/Clock", time, [&](Cdr& out) { out.time(time); });
  impl.moving_frames(frame, time);
  impl.joints(frame, time);
  impl.sequences.resize(std::max(impl.sequences.size(), frame.readings.size()));
  for (std::size_t i = 0; i < frame.readings.size() && i < model.sensors.size(); ++i) {
    const Reading& reading = frame.readings[i];
    if (reading.sequence == impl.sequences[i]) continue;
    impl.sequences[i] = reading.sequence;
    if (reading.valid && !model.sensors[i].removed) impl.reading(frame, model.sensors[i], reading);
  }
  return impl.mcap.pending() < kRos2ChunkBytes ? Result<>() : impl.mcap.flush();
}

Result<Ros2Writer::Summary> Ros2Writer::finish() {
  Impl& impl = *impl_;
  if (auto done = impl.mcap.finish("cogrsim.ros2", {}); !done) return tl::unexpected(done.error());
  if (auto done = impl.file->replace_target(); !done) return tl::unexpected(done.error());
  if (auto done = impl.file->close(); !done) return tl::unexpected(done.error());
  Summary summary;
  for (const auto& [topic, count] : impl.counts) summary.messages[topic] = count;
  summary.left_out.assign(impl.left_out.begin(), impl.left_out.end());
  return summary;
}

}  // namespace cogrsim

#include "support.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cogrsim/rendering/renderer.h"

namespace cogrsim::test {

namespace {

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same(const Contact& a, const Contact& b) {
  return a.body_a == b.body_a && a.body_b == b.body_b && a.shape_a == b.shape_a &&
         a.shape_b == b.shape_b && same_bits(a.depth, b.depth) &&
         std::memcmp(a.point.data(), b.point.data(), 24) == 0 &&
         std::memcmp(a.normal.data(), b.normal.data(), 24) == 0 &&
         std::memcmp(a.force.data(), b.force.data(), 24) == 0;
}

bool same(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Contact& x, const Contact& y) { return same(x, y); });
}

bool same(const Picture& a, const Picture& b) {
  return a.width == b.width && a.height == b.height && a.color.data == b.color.data &&
         same_bits(a.depth, b.depth) && a.bodies == b.bodies;
}

std::string difference(const Reading& a, const Reading& b) {
  if (a.sensor != b.sensor) return "sensor";
  if (!same_bits(a.time, b.time)) return "time";
  if (a.sequence != b.sequence) return "sequence";
  if (a.valid != b.valid) return "valid";
  if (a.enabled != b.enabled) return "enabled";
  if (!same_bits(a.values, b.values)) return "values";
  if (a.pose.has_value() != b.pose.has_value()) return "pose there";
  if (a.pose && (a.pose->p != b.pose->p || a.pose->q.coeffs() != b.pose->q.coeffs())) return "pose";
  if (!same(a.contacts, b.contacts)) return "contacts";
  if (!a.picture != !b.picture) return "picture there";
  if (a.picture && !same(*a.picture, *b.picture)) return "picture";
  return {};
}

}  // namespace

std::string read_all(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_all(const std::string& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  REQUIRE(out);
}

std::shared_ptr<PluginLoader> loader() {
  static const auto kLoader = std::make_shared<PluginLoader>();
  return kLoader;
}

namespace {

SensorModel sensor(const std::string& name, const std::string& type, int body, double rate) {
  SensorModel out;
  out.name = name;
  out.type = type;
  out.body = body;
  out.rate = rate;
  return out;
}

NoiseTerm noise(NoiseTerm::Kind kind, double a, double b) {
  NoiseTerm term;
  term.kind = kind;
  term.a = a;
  term.b = b;
  return term;
}

}  // namespace

ModelBuilder busy_scene() {
  ModelBuilder builder("busy");
  builder.plane("floor");
  for (int i = 0; i < 3; ++i) {
    builder.box("box_" + std::to_string(i), Vec3(0.2, 0.3, 0.1), 1.0,
                Pose(Vec3(0.5 * i, 0.0, 0.06 + 0.02 * i), Quat(1, 0, 0, 0)));
  }
  TriangleMesh wedge;
  wedge.name = "wedge.stl";
  wedge.vertices = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}};
  wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  builder.mesh("wedge", wedge, true, 0.5, Pose(Vec3(2, 0, 0.2), Quat(1, 0, 0, 0)));
  HeightGrid hill;
  hill.name = "hill.png";
  hill.columns = hill.rows = 3;
  hill.heights = {0, 0, 0, 0, 0.1, 0, 0, 0, 0};
  builder.heightmap("hill", hill, Pose(Vec3(5, 5, 0), Quat(1, 0, 0, 0)));
  const int wheel =
      builder.cylinder("robot.wheel", 0.1, 0.05, 0.7, Pose(Vec3(-1, 0, 0.5), Quat(1, 0, 0, 0)));
  const int axle = builder.joint("robot.axle", JointType::hinge, kWorld, wheel,
                                 Pose(Vec3(-1, 0, 0.5), Quat(1, 0, 0, 0)));
  const int robot = builder.assembly("robot", {wheel}, {axle});
  const int motor = builder.motor("robot.motor", axle, MotorMode::velocity);
  builder.model.motors[motor].assembly = robot;
  builder.model.motors[motor].target = 3.0;
  builder.model.joints[axle].axes[0].damping = 1e-3;

  std::vector<SensorModel>& sensors = builder.model.sensors;
  using Kind = NoiseTerm::Kind;
  sensors.push_back(sensor("robot.encoder", "encoder", kWorld, 100.0));
  sensors.back().joint = axle;
  sensors.back().noise = {noise(Kind::normal, 0.0, 0.01), noise(Kind::quantisation, 0.001, 0.0)};
  sensors.push_back(sensor("robot.imu", "imu", wheel, 0.0));
  sensors.back().noise = {noise(Kind::bias_walk, 0.1, 0.0), noise(Kind::dropout, 0.2, 0.0)};
  sensors.push_back(sensor("robot.pose", "pose", wheel, 30.0));
  sensors.push_back(sensor("robot.lidar", "lidar", wheel, 50.0));
  sensors.back().parameters["rays"] = std::int64_t{300};
  sensors.back().noise = {noise(Kind::normal, 0.0, 0.003)};
  sensors.push_back(sensor("box_touch", "contact", 1, 200.0));
  sensors.push_back(sensor("late", "pose", 2, 0.0));
  sensors.back().enabled = false;
  for (SensorModel& s : sensors) {
    if (s.name.rfind("robot.", 0) == 0) s.assembly = robot;
  }
  return builder;
}

SceneModelPtr visitor() {
  ModelBuilder builder("visitor");
  const int ball = builder.sphere("ball", 0.1, 0.4, Pose(Vec3(0, 0, 0.5), Quat(1, 0, 0, 0)));
  const int assembly = builder.assembly("all", {ball});
  builder.model.sensors.push_back(sensor("place", "pose", ball, 0.0));
  builder.model.sensors.back().assembly = assembly;
  return builder.build();
}

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     std::uint64_t seed) {
  SimulationOptions options;
  options.backend = backend;
  options.seed = seed;
  auto simulation = Simulation::create(scene, options, loader());
  if (!simulation) {
    for (const Diagnostic& d : simulation.error()) UNSCOPED_INFO(d.code << " " << d.message);
  }
  REQUIRE(simulation);
  return std::move(*simulation);
}

std::vector<FramePtr> record(Simulation& simulation, RecorderOptions options, int steps,
                             const std::function<void(int)>& before_step) {
  auto recorder = Recorder::start(simulation, std::move(options));
  if (!recorder) UNSCOPED_INFO(recorder.error().text());
  REQUIRE(recorder);
  std::vector<FramePtr> frames;
  FrameContents contents;
  contents.contacts = contents.for_sensors = true;
  simulation.observe(contents, [&frames](const FramePtr& frame) { frames.push_back(frame); });
  for (int i = 0; i < steps; ++i) {
    if (before_step) before_step(i);
    simulation.step();
  }
  const auto finished = (*recorder)->finish(RunStatus::completed);
  if (!finished) UNSCOPED_INFO(finished.error().text());
  REQUIRE(finished);
  // The observer refers to `frames`, which go away: no further step may come.
  simulation.stop();
  return frames;
}

std::string difference(const Frame& a, const Frame& b) {
  if (a.step != b.step) return "step";
  if (!same_bits(a.time, b.time)) return "time";
  if (!same_bits(a.dt, b.dt)) return "dt";
  if (!same_bits(a.state.poses, b.state.poses)) return "poses";
  if (!same_bits(a.state.twists, b.state.twists)) return "twists";
  if (!same_bits(a.state.joint_positions, b.state.joint_positions)) return "joint positions";
  if (!same_bits(a.state.joint_velocities, b.state.joint_velocities)) return "joint velocities";
  if (!same_bits(a.state.joint_efforts, b.state.joint_efforts)) return "joint efforts";
  if (!same_bits(a.state.motor_efforts, b.state.motor_efforts)) return "motor efforts";
  if (!same_bits(a.accelerations, b.accelerations)) return "accelerations";
  if (!same_bits(a.joint_reactions, b.joint_reactions)) return "joint reactions";
  if (!same(a.contacts, b.contacts)) return "contacts";
  if (a.events.size() != b.events.size()) return "number of events";
  for (std::size_t i = 0; i < a.events.size(); ++i) {
    const Event &x = a.events[i], &y = b.events[i];
    if (!same_bits(x.time, y.time) || x.kind != y.kind || x.source != y.source ||
        x.message != y.message) {
      return "event";
    }
  }
  if (a.readings.size() != b.readings.size()) return "number of readings";
  for (std::size_t i = 0; i < a.readings.size(); ++i) {
    const std::string what = difference(a.readings[i], b.readings[i]);
    if (!what.empty()) return "reading " + std::to_string(i) + ": " + what;
  }
  const SceneModel &m = *a.model, &n = *b.model;
  const auto names = [](const auto& elements) {
    std::string all;
    for (const auto& e : elements) all += e.name + (e.removed ? "(removed) " : " ");
    return all;
  };
  if (names(m.bodies) != names(n.bodies)) return "bodies' names";
  if (names(m.joints) != names(n.joints)) return "joints' names";
  if (names(m.sensors) != names(n.sensors)) return "sensors' names";
  return {};
}

std::unique_ptr<Recording> opened(const std::string& path) {
  auto recording = Recording::open(path);
  if (!recording) UNSCOPED_INFO(recording.error().text());
  REQUIRE(recording);
  return std::move(*recording);
}

}  // namespace cogrsim::test

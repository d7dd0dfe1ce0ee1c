// Contact, force-torque, encoder resolution and the imu's two noises against closed forms.
#include <cmath>

#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SensorModel sensor(const std::string& name, const std::string& type, int body) {
  SensorModel model;
  model.name = name;
  model.type = type;
  model.body = body;
  return model;
}

}  // namespace

TEST_CASE("a contact sensor under a resting box carries its weight", "[sensors][touch]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("weight");
  const int floor = builder.plane("floor");
  const int crate =
      builder.box("crate", Vec3(0.2, 0.2, 0.2), 3.0, Pose(Vec3(0, 0, 0.1), Quat(1, 0, 0, 0)));
  const int far =
      builder.box("far", Vec3(0.2, 0.2, 0.2), 1.0, Pose(Vec3(9, 0, 50), Quat(1, 0, 0, 0)));
  // On the crate in axes turned by 90 degrees about y, x down: the floor's push is along -x.
  builder.model.sensors = {sensor("feet", "contact", crate), sensor("scales", "contact", floor),
                           sensor("nothing", "contact", far)};
  builder.model.sensors[0].X_BS.q = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));
  auto simulation = simulate(builder.build(), backend);
  simulation->run_until(1.0);
  const FramePtr frame = simulation->frame();
  const double weight = 3.0 * 9.81;
  const Reading& feet = frame->readings[0];
  const Reading& scales = frame->readings[1];
  // At rest the mean force of a step is the weight; engines settle to a few parts in a thousand.
  CHECK(feet.values[2] == Approx(-weight).epsilon(0.01));
  CHECK(std::abs(feet.values[4]) < 0.01 * weight);
  CHECK(feet.values[1] == 1.0);
  CHECK(feet.values[0] >= 3.0);  // a face on a plane: at least three points
  REQUIRE(feet.contacts.size() == static_cast<std::size_t>(feet.values[0]));
  for (const Contact& contact : feet.contacts) {
    CHECK(contact.body_b == crate);
    CHECK(contact.body_a == floor);
    CHECK(contact.normal.z() == Approx(1.0).margin(1e-6));
  }
  CHECK(scales.values[4] == Approx(-weight).epsilon(0.01));
  CHECK(frame->readings[2].values[0] == 0.0);
  CHECK(frame->readings[2].valid);
}

TEST_CASE("a contact sensor of a whole assembly ignores contacts within it", "[sensors][touch]") {
  ModelBuilder builder("stack");
  builder.plane("floor");
  const int lower =
      builder.box("tower.lower", Vec3(0.4, 0.4, 0.2), 2.0, Pose(Vec3(0, 0, 0.1), Quat(1, 0, 0, 0)));
  const int upper =
      builder.box("tower.upper", Vec3(0.2, 0.2, 0.2), 1.0, Pose(Vec3(0, 0, 0.3), Quat(1, 0, 0, 0)));
  const int tower = builder.assembly("tower", {lower, upper});
  builder.model.sensors = {sensor("one", "contact", lower), sensor("all", "contact", lower)};
  builder.model.sensors[1].assembly = tower;
  builder.model.sensors[1].parameters["whole-assembly"] = true;
  auto simulation = simulate(builder.build(), "bullet");
  simulation->run_until(1.0);
  const FramePtr frame = simulation->frame();
  CHECK(frame->readings[0].values[1] == 2.0);                               // floor and upper
  CHECK(frame->readings[0].values[4] == Approx(2.0 * 9.81).epsilon(0.01));  // floor less upper
  CHECK(frame->readings[1].values[1] == 1.0);
  CHECK(frame->readings[1].values[4] == Approx(3.0 * 9.81).epsilon(0.01));
}

TEST_CASE("a force-torque sensor measures the weight and the moment of an arm",
          "[sensors][touch]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("arm");
  // Held level at its end by a weld: f = m g upwards, t = -c x m g about the joint, c = 0.25 m in
  // x.
  const int arm =
      builder.box("arm", Vec3(0.5, 0.05, 0.05), 2.0, Pose(Vec3(0.25, 0, 1), Quat(1, 0, 0, 0)));
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3::UnitY()));
  const int weld = builder.joint("weld", JointType::fixed, kWorld, arm, Pose(Vec3(0, 0, 1), turn));
  SensorModel wrist = sensor("wrist", "force-torque", arm);
  wrist.joint = weld;
  builder.model.sensors.push_back(wrist);
  wrist.name = "weak";
  wrist.parameters["max-force"] = 5.0;
  builder.model.sensors.push_back(wrist);
  auto simulation = simulate(builder.build(), backend);
  simulation->run_until(0.5);
  const std::vector<double>& values = simulation->frame()->readings[0].values;
  const Vec3 force = turn.conjugate() * Vec3(0, 0, 2.0 * 9.81);
  const Vec3 torque = turn.conjugate() * Vec3(0.25, 0, 0).cross(Vec3(0, 0, 2.0 * 9.81));
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    CHECK(values[at] == Approx(force[i]).margin(0.02));
    CHECK(values[3 + at] == Approx(torque[i]).margin(0.02));
  }
  CHECK(simulation->frame()->readings[1].values[2] == 5.0);
}

TEST_CASE("an encoder counts", "[sensors]") {
  Flywheel scene;
  scene.builder.model.motors[0].target = 3.0;
  scene.builder.model.sensors[0].parameters["counts"] = std::int64_t{64};
  SensorModel exact = scene.builder.model.sensors[0];
  exact.name = "bot.exact";
  exact.parameters = {{"max-speed", 2.0}};
  scene.builder.model.sensors.push_back(exact);
  auto simulation = simulate(scene.builder.build(), "bullet");
  const double step = 2.0 * M_PI / 64.0;
  double largest = 0.0, whole = 0.0;
  simulation->observe({}, [&](const FramePtr& frame) {
    if (frame->readings[0].sequence == 0) return;
    const double counted = frame->readings[0].values[0], truth = frame->readings[1].values[0];
    largest = std::max(largest, std::abs(counted - truth));
    whole = std::max(whole, std::abs(counted / step - std::round(counted / step)));
  });
  simulation->run_until(2.0);
  CHECK(largest <= 0.5 * step + 1e-12);
  CHECK(largest > 0.4 * step);  // it does round: two seconds pass through all phases of a step
  CHECK(whole < 1e-9);
  CHECK(simulation->frame()->readings[1].values[1] == 2.0);
  Flywheel twice;
  twice.builder.model.sensors[0].parameters = {{"counts", std::int64_t{64}}, {"resolution", 0.1}};
  CHECK(refusal(twice.builder.build(), "bullet").find("exclude each other") != std::string::npos);
}

TEST_CASE("an imu's bias walks on accelerometer and gyroscope, each with its own strength",
          "[sensors]") {
  // 400 sensors in free fall, whose truth is 0: after t the walk has the variance sigma^2 t.
  constexpr int kSensors = 400;
  const double sigma = 0.05, gyro_sigma = 0.01;
  auto builder = falling_ball();
  for (int i = 0; i < kSensors; ++i) {
    SensorModel imu = sensor("imu" + std::to_string(i), "imu", 0);
    imu.rate = 50.0;
    imu.noise = {{NoiseTerm::Kind::bias_walk, sigma, 0.0, 0},
                 {NoiseTerm::Kind::bias_walk, gyro_sigma, 0.0, 1}};
    builder.model.sensors.push_back(imu);
  }
  SimulationOptions options;
  options.step = 0.01;
  auto simulation = simulate(builder.build(), "bullet", options);
  for (const double t : {0.4, 0.8}) {
    simulation->run_until(t + 0.011);  // past the reading at t
    double force = 0.0, spin = 0.0;
    const FramePtr frame = simulation->frame();
    for (int i = 0; i < kSensors; ++i) {
      const std::vector<double>& v = frame->readings[i].values;
      for (std::size_t k = 0; k < 3; ++k) {
        force += v[k] * v[k];
        spin += v[3 + k] * v[3 + k];
      }
    }
    const double n = 3.0 * kSensors;
    // Variance of n normal numbers: 5 sqrt(2 / n) = 20 %. The first reading has no period.
    CHECK(force / n == Approx(sigma * sigma * t).epsilon(0.2));
    CHECK(spin / n == Approx(gyro_sigma * gyro_sigma * t).epsilon(0.2));
  }
}

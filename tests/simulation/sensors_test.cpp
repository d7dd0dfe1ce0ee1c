// Encoder, pose and imu against the motion they measure; noise.
#include <cmath>

#include "cogrsim/sensing/sensor.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SensorModel sensor(const std::string& type, int body, const Pose& X_BS = {}) {
  SensorModel model;
  model.name = type;
  model.type = type;
  model.body = body;
  model.X_BS = X_BS;
  return model;
}

const std::vector<double>& values(const FramePtr& frame, int index) {
  return frame->readings[index].values;
}

}  // namespace

TEST_CASE("an imu measures gravity at rest and nothing in free fall", "[sensors]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("imu");
  // Tilted by 90 degrees about y: the sensor's x points down.
  const Pose X_BS(Vec3::Zero(), Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY())));
  const int resting =
      builder.box("resting", Vec3(0.2, 0.2, 0.2), 1.0, Pose(Vec3(0, 0, 0.1), Quat(1, 0, 0, 0)));
  const int falling =
      builder.box("falling", Vec3(0.2, 0.2, 0.2), 1.0, Pose(Vec3(3, 0, 50), Quat(1, 0, 0, 0)));
  builder.plane("floor");
  builder.model.sensors = {sensor("imu", resting, X_BS), sensor("imu", falling)};
  builder.model.sensors[1].name = "imu2";
  auto simulation = simulate(builder.build(), backend);
  simulation->run_until(0.5);
  const FramePtr frame = simulation->frame();
  // Where contact does not quite come to rest, the sensor measures it.
  const double tremble = states_figures(backend) ? 0.02 : 0.4;
  CHECK(values(frame, 0)[0] == Approx(-9.81).margin(tremble));
  CHECK(std::abs(values(frame, 0)[2]) < tremble);
  for (std::size_t i = 0; i < 6; ++i) CHECK(std::abs(values(frame, 1)[i]) < 1e-6);
}

TEST_CASE("an imu off the axis of a spinning wheel measures the centripetal acceleration",
          "[sensors]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene;
  scene.builder.model.motors[0].target = 4.0;
  scene.builder.model.sensors.push_back(
      sensor("imu", scene.wheel, Pose(Vec3(0.5, 0, 0), Quat(1, 0, 0, 0))));
  scene.builder.model.sensors.push_back(
      sensor("pose", scene.wheel, Pose(Vec3(0.5, 0, 0), Quat(1, 0, 0, 0))));
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->run_until(0.5);
  const FramePtr frame = simulation->frame();
  CHECK(values(frame, 1)[0] == Approx(-4.0 * 4.0 * 0.5).epsilon(1e-3));
  CHECK(values(frame, 1)[5] == Approx(4.0).epsilon(1e-6));
  const double angle = values(frame, 0)[0];  // the encoder; one step old, like the pose beside it
  CHECK(values(frame, 2)[0] == Approx(0.5 * std::cos(angle)).margin(1e-6));
  CHECK(values(frame, 2)[1] == Approx(0.5 * std::sin(angle)).margin(1e-6));
  CHECK(values(frame, 2)[8] == Approx(2.0 * std::cos(angle)).margin(1e-6));
}

TEST_CASE("readings come at the sensor's rate, and only while it is on", "[sensors]") {
  Flywheel scene;
  scene.builder.model.sensors[0].rate = 100.0;
  auto simulation = simulate(scene.builder.build(), "bullet");
  simulation->run_until(0.1);
  CHECK(simulation->frame()->readings[0].sequence == 10);
  simulation->send(EnableSensor{"bot.encoder", false});
  simulation->run_until(0.2);
  CHECK(simulation->frame()->readings[0].sequence == 10);
  CHECK_FALSE(simulation->frame()->readings[0].valid);
  simulation->send(EnableSensor{"bot.encoder", true});
  simulation->run_until(0.3);
  CHECK(simulation->frame()->readings[0].valid);
}

TEST_CASE("noise has the requested moments and a stream of its own", "[sensors]") {
  const auto moments = [](bool with_another) {
    Flywheel scene;
    scene.builder.model.sensors[0].noise = {{NoiseTerm::Kind::normal, 0.5, 0.2}};
    if (with_another) {
      auto other = scene.builder.model.sensors[0];
      other.name = "aaa";
      scene.builder.model.sensors.push_back(other);
    }
    auto simulation = simulate(scene.builder.build(), "bullet");
    double sum = 0.0, squares = 0.0;
    int count = 0;
    simulation->observe({}, [&](const FramePtr& frame) {
      if (!frame->readings[0].valid) return;
      const double x = frame->readings[0].values[0];
      sum += x;
      squares += x * x;
      ++count;
    });
    simulation->run_until(10.0);
    const double mean = sum / count;
    return std::make_pair(mean, std::sqrt(squares / count - mean * mean));
  };
  const auto alone = moments(false);
  // 10,000 draws: the mean is within 5 sigma / sqrt(n) = 0.01, sigma within 5 / sqrt(2n) = 3.5 %.
  CHECK(alone.first == Approx(0.5).margin(0.01));
  CHECK(alone.second == Approx(0.2).epsilon(0.035));
  CHECK(moments(true) == alone);
}

TEST_CASE("dropout loses the requested share, quantisation leaves whole steps", "[sensors]") {
  Flywheel scene;
  scene.builder.model.motors[0].target = 1.0;
  scene.builder.model.sensors[0].noise = {{NoiseTerm::Kind::dropout, 0.25, 0.0},
                                          {NoiseTerm::Kind::quantisation, 0.1, 0.0}};
  auto simulation = simulate(scene.builder.build(), "bullet");
  int lost = 0, total = 0;
  bool whole = true;
  simulation->observe({}, [&](const FramePtr& frame) {
    const Reading& reading = frame->readings[0];
    if (reading.sequence == 0) return;
    ++total;
    if (!reading.valid) ++lost;
    const double steps = reading.values[0] / 0.1;
    whole = whole && std::abs(steps - std::round(steps)) < 1e-9;
  });
  simulation->run_until(10.0);
  // Binomial: 0.25 +- 5 sqrt(0.25 * 0.75 / 10000) = 0.022.
  CHECK(static_cast<double>(lost) / total == Approx(0.25).margin(0.022));
  CHECK(whole);
}

TEST_CASE("a sensor that lacks what it measures is refused", "[sensors]") {
  auto builder = falling_ball();
  builder.model.sensors = {sensor("encoder", 0), sensor("radar", 0)};
  const std::string said = refusal(builder.build(), "bullet");
  CHECK(said.find("measures no joint") != std::string::npos);
  CHECK(said.find("radar") != std::string::npos);
}

// Infrared and lidar against closed forms.
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/sensing/sensor_models.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SensorModel sensor(const std::string& name, const std::string& type, const Pose& X_WS) {
  SensorModel model;
  model.name = name;
  model.type = type;
  model.X_BS = X_WS;
  return model;
}

Pose turned_about_z(double angle, const Vec3& p = Vec3::Zero()) {
  return {p, Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()))};
}

Parameters range(double least, double most) {
  return {{"range", std::vector<double>{least, most}}};
}

/// A wall whose near face lies in the plane x = `distance`.
void add_wall(ModelBuilder& builder, double distance) {
  builder.box("wall", Vec3(0.2, 20, 20), 0.0, Pose(Vec3(distance + 0.1, 0, 0), Quat(1, 0, 0, 0)));
}

/// The readings at the start.
FramePtr look(const SceneModelPtr& scene, const std::string& backend = "bullet") {
  auto simulation = simulate(scene, backend);
  simulation->step();
  return simulation->frame();
}

}  // namespace

TEST_CASE("an infrared sensor measures the distance to a wall under an angle",
          "[sensors][ranging]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("wall");
  add_wall(builder, 0.6);
  const double angles[] = {0.0, 0.3, -0.5, 0.9};
  for (std::size_t i = 0; i < 4; ++i) {
    builder.model.sensors.push_back(
        sensor("ir" + std::to_string(i), "infrared", turned_about_z(angles[i])));
    builder.model.sensors.back().parameters = range(0.02, 0.8);
  }
  const FramePtr frame = look(builder.build(), backend);
  for (std::size_t i = 0; i < 3; ++i) {
    // Rays are exact to 1e-9 m.
    CHECK(frame->readings[i].values[0] == Approx(0.6 / std::cos(angles[i])).margin(1e-9));
    CHECK(frame->readings[i].values[1] == 0.0);
  }
  // 0.6 / cos 0.9 = 0.965 m lies beyond the range: nothing is seen, nothing named.
  CHECK(frame->readings[3].values[0] == kInfinity);
  CHECK(frame->readings[3].values[1] == -1.0);
}

TEST_CASE("an infrared sensor is blind below its range and does not see its own body",
          "[sensors][ranging]") {
  ModelBuilder builder("near");
  add_wall(builder, 0.05);
  const int carrier =
      builder.box("carrier", Vec3(0.06, 0.1, 0.1), 1.0, Pose(Vec3(0, 0, 0), Quat(1, 0, 0, 0)));
  builder.model.physics.gravity = Vec3::Zero();
  SensorModel ir = sensor("ir", "infrared", {});
  ir.body = carrier;
  ir.parameters = range(0.1, 0.8);
  builder.model.sensors.push_back(ir);
  ir.name = "own";
  ir.parameters = range(0.01, 0.8);
  ir.parameters["sees-own-body"] = true;
  builder.model.sensors.push_back(ir);
  const FramePtr frame = look(builder.build());
  CHECK(frame->readings[0].values[0] == -kInfinity);
  CHECK(frame->readings[0].values[1] == 0.0);  // a body is there nevertheless
  CHECK(frame->readings[1].values[0] == Approx(0.03).margin(1e-9));
  CHECK(frame->readings[1].values[1] == carrier);
}

TEST_CASE("the cone of an infrared sensor detects an edge that its axis misses",
          "[sensors][ranging]") {
  ModelBuilder builder("edge");
  // Begins 2 cm beside the axis, 0.5 m in front: within a cone of 20 degrees (8.8 cm there).
  builder.box("post", Vec3(0.2, 1.0, 1.0), 0.0, Pose(Vec3(0.6, 0.52, 0), Quat(1, 0, 0, 0)));
  SensorModel ir = sensor("ray", "infrared", {});
  ir.parameters = range(0.02, 1.0);
  builder.model.sensors.push_back(ir);
  ir.name = "cone";
  ir.parameters["beam"] = 20.0 * M_PI / 180.0;
  ir.parameters["rays"] = std::int64_t{200};
  builder.model.sensors.push_back(ir);
  ir.name = "mean";
  ir.parameters["reading"] = std::string("mean");
  builder.model.sensors.push_back(ir);
  const SceneModelPtr scene = builder.build();
  const FramePtr frame = look(scene);
  CHECK(frame->readings[0].values[0] == kInfinity);
  // Between the face's distance and that of the far end of its side along the cone's edge.
  const double nearest = frame->readings[1].values[0], mean = frame->readings[2].values[0];
  CHECK(nearest >= 0.5);
  CHECK(nearest < mean);
  CHECK(mean <= 0.7 / std::cos(10.0 * M_PI / 180.0));
  for (const Vec3& d : ray_directions(scene->sensors[1])) {
    CHECK(d.norm() == Approx(1.0).margin(1e-12));
    CHECK(d.x() >= std::cos(10.0 * M_PI / 180.0) - 1e-12);
  }
}

TEST_CASE("a GP2Y0A21 gives the volts of its data sheet and folds back when near",
          "[sensors][ranging]") {
  // Typical figures; the fit is documented to be within 1.5 %, and figures are read to 0.01 V.
  const std::pair<double, double> figures[] = {
      {0.10, 2.3}, {0.20, 1.3}, {0.30, 0.93}, {0.40, 0.74}, {0.80, 0.4}};
  const auto volts_at = [](double distance) {
    ModelBuilder builder("volts");
    add_wall(builder, distance);
    builder.model.sensors.push_back(sensor("ir", "infrared", {}));
    builder.model.sensors[0].parameters = range(0.1, 0.8);
    builder.model.sensors[0].parameters["response"] = std::string("GP2Y0A21");
    return look(builder.build())->readings[0].values[2];
  };
  for (const auto& [distance, volts] : figures) {
    CHECK(volts_at(distance) == Approx(volts).epsilon(0.016).margin(0.0));
  }
  CHECK(volts_at(0.06) == Approx(3.15).epsilon(0.02));
  CHECK(volts_at(0.03) < volts_at(0.06));
  CHECK(volts_at(5.0) < 0.12);
}

TEST_CASE("a lidar in a box room reads the room", "[sensors][ranging]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("room");
  // Inner faces at x = +-3, y = +-2.
  const auto wall = [&](const char* name, const Vec3& size, const Vec3& at) {
    builder.box(name, size, 0.0, Pose(at, Quat(1, 0, 0, 0)));
  };
  wall("east", Vec3(0.2, 5, 4), Vec3(3.1, 0, 0));
  wall("west", Vec3(0.2, 5, 4), Vec3(-3.1, 0, 0));
  wall("north", Vec3(7, 0.2, 4), Vec3(0, 2.1, 0));
  wall("south", Vec3(7, 0.2, 4), Vec3(0, -2.1, 0));
  const Vec3 at(0.5, -0.25, 0.1);
  const double heading = 0.2;
  SensorModel scan = sensor("scan", "lidar", turned_about_z(heading, at));
  scan.parameters["rays"] = std::int64_t{72};
  scan.parameters["rings"] = std::int64_t{3};
  scan.parameters["vertical-fov"] = 0.2;
  scan.parameters["bodies"] = true;
  builder.model.sensors.push_back(scan);
  const FramePtr frame = look(builder.build(), backend);
  const std::vector<double>& values = frame->readings[0].values;
  REQUIRE(values.size() == 2 * 216);
  for (std::size_t ring = 0; ring < 3; ++ring) {
    const double up = -0.1 + 0.1 * static_cast<double>(ring);
    for (std::size_t i = 0; i < 72; ++i) {
      // A full turn from behind, counter-clockwise.
      const double left = heading - M_PI + 2.0 * M_PI * static_cast<double>(i) / 72.0;
      const double dx = std::cos(left), dy = std::sin(left);
      const double to_x = (dx > 0 ? 3.0 - at.x() : -3.0 - at.x()) / dx;
      const double to_y = (dy > 0 ? 2.0 - at.y() : -2.0 - at.y()) / dy;
      const double expected = std::min(to_x, to_y) / std::cos(up);
      const std::size_t k = ring * 72 + i;
      CHECK(values[k] == Approx(expected).margin(1e-9));
      const double body = to_x < to_y ? (dx > 0 ? 0 : 1) : (dy > 0 ? 2 : 3);
      CHECK(values[216 + k] == body);
    }
  }
}

TEST_CASE("a lidar of less than a full turn covers both ends", "[sensors][ranging]") {
  SensorModel scan = sensor("scan", "lidar", {});
  scan.parameters["rays"] = std::int64_t{3};
  scan.parameters["fov"] = M_PI;
  const std::vector<Vec3> directions = ray_directions(scan);
  REQUIRE(directions.size() == 3);
  CHECK((directions[0] - Vec3(0, -1, 0)).norm() < 1e-12);
  CHECK((directions[1] - Vec3(1, 0, 0)).norm() < 1e-12);
  CHECK((directions[2] - Vec3(0, 1, 0)).norm() < 1e-12);
}

TEST_CASE("backends give the same reading for the same state", "[sensors][ranging]") {
  const auto start = [](const std::string& backend) {
    ModelBuilder builder("same");
    add_wall(builder, 0.5);
    // Upright: engines keep orientations in different forms, equal to rounding only.
    const int car =
        builder.box("car", Vec3(0.2, 0.1, 0.1), 1.0, Pose(Vec3(0.125, 0.25, 0), Quat(1, 0, 0, 0)));
    for (const char* type : {"infrared", "lidar", "pose", "contact"}) {
      builder.model.sensors.push_back(sensor(type, type, turned_about_z(0.3, Vec3(0.1, 0, 0))));
      builder.model.sensors.back().body = car;
      builder.model.sensors.back().noise = {{NoiseTerm::Kind::normal, 0.0, 0.01}};
    }
    return look(builder.build(), backend);
  };
  const FramePtr bullet = start("bullet"), cogrsim = start("cogrsim");
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(bullet->readings[i].valid);
    CHECK(bullet->readings[i].values == cogrsim->readings[i].values);  // to the last bit
  }
}

TEST_CASE("noise on a range is on the distance and the limits come after it",
          "[sensors][ranging]") {
  ModelBuilder builder("noise");
  add_wall(builder, 0.8);  // at the very end of the range: half of the readings are beyond
  builder.model.sensors.push_back(sensor("ir", "infrared", {}));
  builder.model.sensors[0].parameters = range(0.02, 0.8);
  builder.model.sensors[0].noise = {{NoiseTerm::Kind::normal, 0.0, 0.003}};
  const SceneModelPtr scene = builder.build();
  const auto run = [&] {
    std::vector<double> read;
    auto simulation = simulate(scene, "bullet");
    simulation->observe({}, [&](const FramePtr& frame) {
      if (frame->readings[0].sequence > 0) read.push_back(frame->readings[0].values[0]);
    });
    simulation->run_until(2.0);
    return read;
  };
  const std::vector<double> read = run();
  int beyond = 0;
  double squares = 0.0;
  for (const double d : read) {
    if (d == kInfinity) {
      ++beyond;
    } else {
      squares += (d - 0.8) * (d - 0.8);
    }
  }
  const auto n = static_cast<double>(read.size());
  REQUIRE(n >= 1999.0);
  // A fair coin: 0.5 +- 5 sqrt(0.25 / 2000) = 0.056. The half normal has the same mean square,
  // sigma^2, known to 5 sqrt(2 / 1000) = 22 %.
  CHECK(beyond / n == Approx(0.5).margin(0.056));
  CHECK(squares / (n - beyond) == Approx(9e-6).epsilon(0.22));
  CHECK(run() == read);
}

TEST_CASE("range finders with senseless settings are refused", "[sensors][ranging]") {
  ModelBuilder builder("refused");
  builder.model.sensors = {sensor("a", "infrared", {}), sensor("b", "lidar", {}),
                           sensor("c", "infrared", {})};
  builder.model.sensors[0].parameters = range(0.8, 0.1);
  builder.model.sensors[1].parameters = {{"rays", std::int64_t{100000}},
                                         {"rings", std::int64_t{100}}};
  builder.model.sensors[2].parameters = {{"response", std::string("GP2D12")}};
  const std::string said = refusal(builder.build(), "bullet");
  CHECK(said.find("below the second") != std::string::npos);
  CHECK(said.find("the limit is 1000000") != std::string::npos);
  CHECK(said.find("GP2D12") != std::string::npos);
}

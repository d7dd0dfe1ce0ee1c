// Tests that the scene cannot express: statistics of the noise, and surfaces out of range.
// Catch2 2.13 or 3. COGRSIM_TEST_BACKENDS="a,b" in the environment limits it to some backends.
#define CATCH_CONFIG_MAIN
#include <cogrsim/dsl/loader_catalog.h>
#include <cogrsim/testing/catch.h>

namespace {

cogrsim::SceneModelPtr scene() {
  cogrsim::dsl::LoaderCatalog plugins;
  cogrsim::dsl::CompileOptions options;
  options.plugins = &plugins;
  const auto compiled = cogrsim::dsl::compile_file("@NAME@.scene.xml", options);
  INFO(cogrsim::dsl::to_text(compiled.diagnostics));
  REQUIRE(compiled.ok());
  return compiled.model;
}

}  // namespace

TEST_CASE("the noise has the standard deviation of the scene") {
  const std::string backend = GENERATE(cogrsim::testing::backends());
  CAPTURE(backend);
  const auto run = cogrsim::testing::start(scene(), backend);
  const auto trajectory = cogrsim::testing::record(
      *run, {"probe.real.distance - probe.ideal.distance"}, 4.0, 0.02);
  double sum = 0.0, squares = 0.0;
  int samples = 0;
  for (const std::vector<double>& row : trajectory.values) {
    if (std::isnan(row[0])) continue;
    sum += row[0];
    squares += row[0] * row[0];
    ++samples;
  }
  // Measured at 50 Hz for 4 s, and sampled at the same rate.
  REQUIRE(samples >= 200);
  const double mean = sum / samples;
  const double deviation = std::sqrt(squares / samples - mean * mean);
  // For n samples the standard error of the mean is sigma / sqrt(n), and that of the deviation
  // sigma / sqrt(2 n); five times these values are allowed.
  const double sigma = 4e-3;
  CHECK(std::abs(mean) < 5.0 * sigma / std::sqrt(samples));
  CHECK(std::abs(deviation - sigma) < 5.0 * sigma / std::sqrt(2.0 * samples));
}

TEST_CASE("the distance of a surface out of range is infinite") {
  const std::string backend = GENERATE(cogrsim::testing::backends());
  CAPTURE(backend);
  auto model = std::make_shared<cogrsim::SceneModel>(*scene());
  for (cogrsim::SensorModel& sensor : model->sensors) sensor.parameters["range"] = 0.5;
  const auto run = cogrsim::testing::start(model, backend);
  run->run_until(0.1);  // still a metre high
  const cogrsim::Reading& reading = run->frame()->readings.at(0);
  REQUIRE(reading.valid);
  CHECK(std::isinf(reading.values.at(0)));
  CHECK(reading.values.at(1) == 0.0);
}

// A test that the scene cannot express: the robot obeys the parameter `gap` for different values.
// Catch2 2.13 or 3. COGRSIM_TEST_BACKENDS="a,b" in the environment limits it to some backends.
#define CATCH_CONFIG_MAIN
#include <cogrsim/dsl/loader_catalog.h>
#include <cogrsim/testing/catch.h>

namespace {

// Mean distance between robot and wall over the last second of a run [m].
double final_distance(const std::string& gap, const std::string& backend) {
  cogrsim::dsl::LoaderCatalog plugins;
  cogrsim::dsl::CompileOptions options;
  options.plugins = &plugins;
  options.set_parameters["gap"] = gap;
  const auto scene = cogrsim::dsl::compile_file("@NAME@.scene.xml", options);
  INFO(cogrsim::dsl::to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  const auto run = cogrsim::testing::start(scene.model, backend);
  const auto trajectory = cogrsim::testing::record(*run, {"distance(robot, wall)"}, 8.0, 0.05);
  double sum = 0.0;
  int samples = 0;
  for (std::size_t i = 0; i < trajectory.times.size(); ++i) {
    if (trajectory.times[i] < 7.0) continue;
    sum += trajectory.values[i][0];
    ++samples;
  }
  return sum / samples;
}

}  // namespace

TEST_CASE("the robot stops at the commanded distance") {
  const std::string backend = GENERATE(cogrsim::testing::backends());
  CAPTURE(backend);
  // The readings have errors of 2 mm, and the robot follows their mean. The distance between deck
  // and wall is that between sensor and wall, except for pitching of the deck, which is below 2 mm
  // here.
  CHECK(std::abs(final_distance("20 cm", backend) - 0.20) < 0.005);
  CHECK(std::abs(final_distance("45 cm", backend) - 0.45) < 0.005);
}

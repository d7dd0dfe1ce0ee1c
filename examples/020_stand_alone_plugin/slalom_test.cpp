// The slalom in C++: on every backend it drives the same path, which is stored beside this file.
// `slalom_test --update-golden` keeps a new one.
#define CATCH_CONFIG_RUNNER
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/testing/catch.h"

using namespace cogrsim;

int main(int argc, char** argv) {
  testing::take_golden_option(argc, argv);
  return Catch::Session().run(argc, argv);
}

TEST_CASE("the robot drives its slalom") {
  dsl::LoaderCatalog plugins;
  dsl::CompileOptions options;
  options.plugins = &plugins;
  const auto scene = dsl::compile_file("slalom.scene.xml", options);
  INFO(dsl::to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  const std::string backend = GENERATE(testing::backends());
  CAPTURE(backend);

  const auto run = testing::start(scene.model, backend);
  // The engines' wheels scrub differently: centimetres after two seconds.
  const auto path = testing::record(*run, {"robot.x", "robot.y"}, 2.0, 0.25);
  CHECK_THAT(path, testing::MatchesGolden(__FILE__, "slalom.csv", 5e-2));
}

// A test that the scene cannot express: the number of balls for different values of `spread`.
// Catch2 2.13 or 3. COGRSIM_TEST_BACKENDS="a,b" in the environment limits it to some backends.
#define CATCH_CONFIG_MAIN
#include <cogrsim/dsl/loader_catalog.h>
#include <cogrsim/testing/catch.h>

namespace {

struct Score {
  double spawned = 0.0, caught = 0.0;
  double ended = 0.0;  // [s]
};

Score play(const std::string& spread, const std::string& backend) {
  cogrsim::dsl::LoaderCatalog plugins;
  cogrsim::dsl::CompileOptions options;
  options.plugins = &plugins;
  options.set_parameters["spread"] = spread;
  const auto scene = cogrsim::dsl::compile_file("@NAME@.scene.xml", options);
  INFO(cogrsim::dsl::to_text(scene.diagnostics));
  REQUIRE(scene.ok());
  const auto run = cogrsim::testing::start(scene.model, backend);
  // The supervisor ends the run before 20 s.
  REQUIRE(run->run_until(20.0) == cogrsim::RunStatus::stopped);
  const cogrsim::FramePtr frame = run->frame();
  return {frame->supervisor_outputs.at(0).at(0), frame->supervisor_outputs.at(0).at(1),
          frame->time};
}

}  // namespace

TEST_CASE("every ball that falls over the basket counts") {
  const std::string backend = GENERATE(cogrsim::testing::backends());
  CAPTURE(backend);
  const Score sure = play("0 m", backend);
  CHECK(sure.caught == 5.0);
  // A ball falls from 1 m to the rim at 0.2 m in sqrt(2 * 0.8 / 9.81) = 0.40 s, less than the 0.5 s
  // between two balls, so no ball is superfluous.
  CHECK(sure.spawned == 5.0);
  // The fifth ball starts at 4 * 0.5 s. A tolerance of five updates of the supervisor, 10 ms each,
  // covers the delays of events and commands.
  CHECK(std::abs(sure.ended - (4 * 0.5 + 0.404)) < 0.05);
}

TEST_CASE("balls outside the basket do not count") {
  const std::string backend = GENERATE(cogrsim::testing::backends());
  CAPTURE(backend);
  const Score wide = play("60 cm", backend);
  CHECK(wide.caught == 5.0);
  CHECK(wide.spawned > 5.0);
}

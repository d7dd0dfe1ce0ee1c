// A library that is rebuilt while the run waits.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "../support/engines.h"
#include "../support/temporary_folder.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A folder with the library "counter", of which other versions can be built.
class Workshop {
 public:
  Workshop() { build(1); }
  void build(int version) {
    // As a linker does it: another file under the same name.
    fs::remove(library());
    fs::copy_file(
        fs::path(COGRSIM_TEST_CONTROLLERS) / ("version_" + std::to_string(version)) / "counter.so",
        library());
  }
  fs::path library() const { return folder_.path / "counter.so"; }
  std::string folder() const { return folder_.path.string(); }

 private:
  TemporaryFolder folder_;
};

std::unique_ptr<Simulation> counting(const Workshop& shop, Isolation isolation,
                                     const std::string& backend = "bullet") {
  ControllerModel controller;
  controller.plugin = "counter";
  controller.rate = 100.0;
  controller.isolation = isolation;
  return simulate(flywheel(controller), backend, loader(shop.folder()));
}

double count_of(Simulation& simulation) { return simulation.frame()->controller_outputs[0][0]; }

/// The run waits.
void pause(Simulation& simulation) {
  simulation.send(Pause{});
  simulation.step();
}

}  // namespace

TEST_CASE("a new library continues with the memory of the old one", "[reload]") {
  const auto isolation = GENERATE(Isolation::none, Isolation::process);
  Workshop shop;
  auto simulation = counting(shop, isolation);
  simulation->run_until(0.1);
  CHECK(count_of(*simulation) == 10.0);
  pause(*simulation);
  shop.build(2);
  const auto done = simulation->reload_controller("bot");
  REQUIRE(done);
  CHECK(done->controller == "bot.driver");
  CHECK(done->version == "2.0.0");
  CHECK(done->memory_kept);
  CHECK(done->note.empty());
  simulation->send(Resume{});
  simulation->run_until(0.2);
  CHECK(count_of(*simulation) == 110.0);
  // Its variables are its own, not those of the previous library.
  CHECK(simulation->frame()->controller_outputs[0][1] == 10.0);
  // Objects that are added later use the new one, too.
  simulation->send(Restart{});
  simulation->step();
  simulation->run_until(0.1);
  CHECK(count_of(*simulation) == 100.0);
  CHECK_THAT(messages_of(*simulation), Contains("reloaded, version 2.0.0"));
  // No files are left beside the library.
  CHECK(std::distance(fs::directory_iterator(shop.folder()), {}) == 1);
}

TEST_CASE("reloading what has not changed changes nothing", "[reload]") {
  const std::string backend = GENERATE(engines());
  const auto isolation = GENERATE(Isolation::none, Isolation::process);
  Workshop shop;
  auto plain = counting(shop, Isolation::none, backend);
  plain->run_until(0.3);
  auto reloaded = counting(shop, isolation, backend);
  for (int i = 1; i <= 30; ++i) {
    reloaded->run_until(0.01 * i);
    if (i % 7 == 0) REQUIRE(reloaded->reload_controller("bot.driver"));
  }
  CHECK(state_hash(reloaded->frame()->state) == state_hash(plain->frame()->state));
  CHECK(count_of(*reloaded) == count_of(*plain));
}

TEST_CASE("an incompatible library leaves the old one running and reports why", "[reload]") {
  struct Case {
    int version;
    const char* why;
  };
  const auto c = GENERATE(values<Case>({{4, "its parameters have changed"},
                                        {5, "it publishes other outputs now"},
                                        {6, "does not accept the state of the old one"},
                                        {7, "half finished"},
                                        {0, "counter.so"}}));
  const auto isolation = GENERATE(Isolation::none, Isolation::process);
  Workshop shop;
  auto simulation = counting(shop, isolation);
  simulation->run_until(0.1);
  const double target = simulation->frame()->state.joint_velocities[0];
  if (c.version > 0) {
    shop.build(c.version);
  } else {
    fs::remove(shop.library());  // by a linker that has not finished
    std::ofstream(shop.library()) << "\x7f"
                                  << "ELF";
  }
  const auto done = simulation->reload_controller("bot.driver");
  REQUIRE_FALSE(done);
  INFO(done.error().text());
  CHECK_THAT(done.error().message, Contains("the old one is kept") && Contains(c.why));
  simulation->run_until(0.2);
  CHECK(count_of(*simulation) == 20.0);
  // configure() of the refused one has set another target; it did not last.
  auto untouched = counting(Workshop(), Isolation::none);
  untouched->run_until(0.2);
  CHECK(state_hash(simulation->frame()->state) == state_hash(untouched->frame()->state));
  CHECK(target > 0.0);
}

TEST_CASE("one without a memory restarts and reports it", "[reload]") {
  Workshop shop;
  shop.build(3);
  auto simulation = counting(shop, Isolation::none);
  simulation->run_until(0.1);
  const auto done = simulation->reload_controller("bot.driver");
  REQUIRE(done);
  CHECK_FALSE(done->memory_kept);
  CHECK_THAT(done->note, Contains("it restarted"));
  simulation->run_until(0.2);
  CHECK(count_of(*simulation) == 10.0);
}

TEST_CASE("a new library keeps what somebody has set, and else has its own start", "[reload]") {
  const auto isolation = GENERATE(Isolation::none, Isolation::process);
  const auto version = GENERATE(2, 3);  // with and without a memory
  const bool set = GENERATE(false, true);
  Workshop shop;
  auto simulation = counting(shop, isolation);
  if (set) simulation->send(SetInput{"bot", "speed", 7.0});
  simulation->run_until(0.1);
  shop.build(version);
  REQUIRE(simulation->reload_controller("bot"));
  CHECK(simulation->controller_inputs()[0].inputs[0].value == (set ? 7.0 : version));
}

TEST_CASE("a controller that was stopped runs again once it is corrected", "[reload]") {
  auto simulation = simulate(flywheel(trouble("throw")), "bullet");
  simulation->run_until(0.1);
  CHECK(simulation->frame()->controller_outputs[0][0] == 3.0);
  REQUIRE(simulation->reload_controller("bot.driver"));
  simulation->run_until(0.2);
  CHECK(simulation->frame()->controller_outputs[0][0] > 10.0);
}

TEST_CASE("names of controllers to reload are looked up with care", "[reload]") {
  Workshop shop;
  auto simulation = counting(shop, Isolation::none);
  const auto unknown = simulation->reload_controller("bot.drivr");
  REQUIRE_FALSE(unknown);
  CHECK_THAT(unknown.error().text(),
             Contains("there is no controller 'bot.drivr'") && Contains("did you mean 'bot.driver'?"));
}

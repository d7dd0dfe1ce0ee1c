// Controllers beside the scene: built from the page, and taken over by the run.
#include <catch2/catch.hpp>

#include "document_support.h"
#include "studio_process.h"

using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;

namespace {

const char* const kScene = R"(<scene name="built" version="1">
  <physics step="1 ms"/>
  <assembly name="bot" xyz="0 0 1">
    <box name="base" static="true" size="10 10 10 cm"/>
    <cylinder name="wheel" radius="5 cm" length="2 cm" mass="150 g" xyz="0 10 cm 0" rpy="90 0 0 deg"/>
    <hinge name="axle" parent="base" child="wheel" axis="0 0 1"/>
    <motor name="drive" joint="axle" mode="velocity" max-torque="2 N*m" max-speed="20 rad/s"/>
    <controller plugin="built_driver" rate="100 Hz"/>
  </assembly>
</scene>
)";

const char* const kProject = R"(cmake_minimum_required(VERSION 3.23)
project(built_driver LANGUAGES CXX)
find_package(CogRSim REQUIRED)
cogrsim_add_plugin(built_driver SOURCES driver.cpp)
)";

// `line` becomes line 9.
std::string source_of(const std::string& line) {
  return R"(#include <cogrsim/control/controller.h>

class Driver final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    drive_ = robot.motor("drive");
  }
  void update(const cogrsim::Tick&) override {
)" + line +
         R"(
  }

 private:
  cogrsim::MotorHandle drive_;
};

COGRSIM_CONTROLLER(Driver, "built_driver", version("1.0.0"), summary("turns a wheel"))
)";
}

}  // namespace

TEST_CASE("a controller is built from the page and the run continues with it", "[studio][build]") {
  const Folder folder;
  folder.write("built.scene.xml", kScene);
  folder.write("CMakeLists.txt", kProject);
  folder.write("driver.cpp", source_of("    drive_.set(5.0);"));
  const StudioProcess studio(
      {folder.path("built.scene.xml"), "--allow-build"},
      {{"XDG_RUNTIME_DIR", folder.path("run")}, {"XDG_CACHE_HOME", folder.path("cache")}});
  LivePage page(studio);
  CHECK(page.hello["allow_build"] == true);
  // Nothing is built yet: that is reported at the controller's position, and nothing runs.
  const Json missing = page.wait("problems", [](const Json& p) { return p["good"] == false; });
  CHECK(missing["problems"][0]["line"] == 8);
  CHECK(page.ask("play")["ok"] == false);

  // The scene is shown without its controller; with it, it is another one.
  const Json shown = page.wait("status", [](const Json& s) { return s["scene"] != 0; })["scene"];
  const Json first = page.get("build");
  INFO(first["log"].get<std::string>());
  REQUIRE(first["built"] == true);
  page.wait("problems", [](const Json& p) { return p["good"] == true; });
  page.wait("status",
            [&](const Json& s) { return s["state"] == "stopped" && s["scene"] != shown; });
  // How far the wheel has turned during that many more steps.
  int steps = 0;
  const auto turned = [&](int more) {
    const auto angle = [&] {
      const Json low = page.get("series", {{"signals", {"bot.axle.position"}}})["series"][0]["low"];
      REQUIRE(!low.empty());
      return low.back().get<double>();
    };
    const double before = angle();
    page.get("step", {{"count", more}});
    steps += more;
    page.wait("status",
              [&](const Json& s) { return s["step_count"] == steps && s["state"] == "paused"; });
    return angle() - before;
  };
  // 5 rad/s, but for the start: the motor's 2 N m bring the wheel there within a step or two, and the
  // controller's first commands come at the first or the second of its 10 ms.
  CHECK(turned(200) == Approx(1.0).margin(0.06));

  // A mistake is reported at its line, and the run continues as it is.
  const Json source = page.get("open-source", {{"name", "driver.cpp"}});
  CHECK(source["text"] == source_of("    drive_.set(5.0);"));
  page.get("save-source", {{"name", "driver.cpp"},
                           {"version", source["version"]},
                           {"text", source_of("    drive_.set(-5.0) oops;")}});
  const Json bad = page.get("build");
  INFO(bad["log"].get<std::string>());
  CHECK(bad["built"] == false);
  REQUIRE(bad["problems"].size() >= 1);
  CHECK(bad["problems"][0]["file"] == "driver.cpp");
  CHECK(bad["problems"][0]["line"] == 9);
  CHECK(bad["problems"][0]["severity"] == "error");
  CHECK(turned(100) == Approx(0.5).margin(1e-3));

  // Mended, it is taken in where the run is.
  page.get("save-source", {{"name", "driver.cpp"}, {"text", source_of("    drive_.set(-5.0);")}});
  const Json scene = page.wait("status", [](const Json&) { return true; })["scene"];
  const Json again = page.get("build");
  INFO(again["log"].get<std::string>());
  REQUIRE(again["built"] == true);
  CHECK(again["problems"].empty());
  page.wait("status", [&](const Json& s) { return s["scene"] != scene; });
  CHECK(turned(100) == Approx(-0.5).margin(0.06));
  // And from the start.
  page.get("stop");
  page.wait("status", [](const Json& s) { return s["step_count"] == 0; });
  steps = 0;
  CHECK(turned(200) == Approx(-1.0).margin(0.06));
}

// Play, pause, step and similar requests; viewers do not affect them.
#include <catch2/catch.hpp>

#include "../support/engines.h"
#include "cogrsim/simulation/simulation.h"
#include "protocol.h"
#include "run_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::test;

namespace {

std::string bare_hash(const std::string& backend, int steps) {
  SimulationOptions options;
  options.backend = backend;
  auto made =
      Simulation::create(scene_of(small_scene()).model, options, std::make_shared<PluginLoader>());
  REQUIRE(made);
  for (int i = 0; i < steps; ++i) (*made)->step();
  char text[17];
  std::snprintf(text, sizeof text, "%016llx",
                static_cast<unsigned long long>(state_hash((*made)->frame()->state)));
  return text;
}

}  // namespace

TEST_CASE("a run in the studio has the state hash of a bare one", "[studio][run]") {
  const std::string backend = GENERATE(cogrsim::test::engines());
  const std::string expected = bare_hash(backend, 600);
  RunOptions options;
  options.backend = backend;
  Page page(options);
  page.join(1);
  page.show(small_scene());

  SECTION("stepped at once") {
    page.get("step", {{"count", 600}});
    CHECK(page.hash_after(600) == expected);
  }
  SECTION("chopped, with three viewers, one of which asks for everything") {
    page.join(2, Role::viewer);
    page.join(3, Role::viewer);
    page.get("subscribe", {{"contacts", true}, {"readings", true}}, 3);
    page.get("step", {{"count", 1}});
    page.get("step", {{"count", 99}});
    page.get("seek", {{"time", 0.05}}, 2);
    page.get("step", {{"count", 200}});
    page.leave(3);
    page.get("step", {{"count", 300}});
    CHECK(page.hash_after(600) == expected);
  }
  SECTION("played at changing speeds, paused in between") {
    page.get("speed", {{"factor", 3.0}});
    page.get("play");
    REQUIRE(page.outbox().wait([&] { return page.status().at("time") >= 0.1; }));
    page.get("pause");
    page.get("speed", {{"factor", 0.5}});
    page.get("play");
    REQUIRE(page.outbox().wait([&] { return page.status().at("time") >= 0.15; }));
    page.get("pause");
    const int done = page.status("paused").at("step_count");
    REQUIRE(done < 600);
    page.get("step", {{"count", 600 - done}});
    CHECK(page.hash_after(600) == expected);
  }
}

TEST_CASE("stop goes back to the start and restart plays from there", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  const std::string start = page.hash_after(0);
  page.get("step", {{"count", 50}});
  const std::string later = page.hash_after(50);
  CHECK(later != start);
  page.get("stop");
  CHECK(page.hash_after(0) == start);
  CHECK(page.status("stopped").at("frames") == 1);
  page.get("step", {{"count", 50}});
  CHECK(page.hash_after(50) == later);
  page.get("speed", {{"factor", nullptr}});
  page.get("restart");
  REQUIRE(page.outbox().wait([&] { return page.status().at("time") > 0.2; }));
  CHECK(page.status().at("state") == "playing");
  CHECK(page.status().at("speed").is_null());
}

TEST_CASE("another step takes effect at once and changes the result", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  page.get("step", {{"count", 10}});
  page.get("dt", {{"value", 0.002}});
  page.get("step", {{"count", 10}});
  page.hash_after(20);
  CHECK(page.status().at("time").get<double>() == Approx(0.030));
  CHECK(page.status().at("dt") == 0.002);
  CHECK(page.status().at("scene_dt") == 0.001);
  page.get("dt", {{"value", nullptr}});
  page.get("step", {{"count", 10}});
  page.hash_after(30);
  CHECK(page.status().at("time").get<double>() == Approx(0.040));
}

TEST_CASE("controllers are reloaded while the run is paused", "[studio][run]") {
  const std::string scene = R"(<scene name="wheel" version="1">
  <assembly name="bot">
    <cylinder name="wheel" radius="10 cm" length="2 cm" xyz="0 0 1"/>
    <hinge name="axle" child="wheel" axis="0 0 1"/>
    <motor name="drive" joint="axle" mode="torque" max-torque="1 N*m"/>
    <sphere name="bob" radius="10 cm" xyz="1 0 1"/>
    <hinge name="arm" child="bob" axis="0 0 1"/>
    <motor name="turn" joint="arm" mode="torque" max-torque="1 N*m"/>
    <controller name="driver" plugin="joint_pid"><set motors="drive turn" target="1 0.5 rad"/></controller>
  </assembly>
</scene>)";
  Page page;
  page.join(1);
  page.show(scene);
  CHECK(page.error("reload").find("while the run is paused") != std::string::npos);
  page.get("step", {{"count", 20}});
  CHECK(page.error("reload", {{"controller", "bot.drivr"}}).find("bot.drivr") != std::string::npos);
  CHECK(page.error("reload", {{"controller", 7}}).find("controller") != std::string::npos);
  const Json done = page.get("reload");
  REQUIRE(done.at("reloaded").size() == 1);
  CHECK(done.at("reloaded")[0].at("controller") == "bot.driver");
  CHECK(done.at("reloaded")[0].at("memory_kept") == true);
  CHECK(done.at("kept").empty());
  CHECK(page.get("reload", {{"controller", "bot"}}).at("reloaded").size() == 1);
  page.get("play");
  CHECK(page.error("reload").find("while the run is paused") != std::string::npos);
}

TEST_CASE("requests with wrong fields are refused by name", "[studio][run]") {
  Page page;
  page.join(1);
  CHECK(page.error("play") == "there is no scene yet that can be run");
  CHECK(page.error("seek", {{"time", 1.0}}) == "there is no frame yet");
  page.show(small_scene());
  CHECK_THAT(page.error("step", {{"count", 0}}), Catch::Contains("'count'"));
  CHECK_THAT(page.error("step", {{"count", 1.5}}), Catch::Contains("'count'"));
  CHECK_THAT(page.error("step", {{"count", "ten"}}), Catch::Contains("'count'"));
  CHECK_THAT(page.error("speed", {{"factor", 0.0}}), Catch::Contains("'factor'"));
  CHECK_THAT(page.error("dt", {{"value", -1.0}}), Catch::Contains("'value'"));
  CHECK_THAT(page.error("seek"), Catch::Contains("'time'"));
  CHECK_THAT(page.error("backend", {{"name", "../../evil"}}), Catch::Contains("'name'"));
  CHECK_THAT(page.error("backend", {{"name", "nosuch"}}), Catch::Contains("nosuch"));
  CHECK_FALSE(find_request("play")->viewers);
  CHECK(find_request("seek")->viewers);
  page.get("step");
  CHECK(page.hash_after(1) != "");
}

TEST_CASE("frames have the layout of the protocol", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene(), 7);
  REQUIRE(page.outbox().wait([&] { return page.outbox().last_frame(1) != nullptr; }));
  const Json scene = page.outbox().last(1, "scene");
  REQUIRE(scene.is_object());
  CHECK(scene.at("version") == 7);
  const ReadFrame start = read_frame(*page.outbox().last_frame(1));
  CHECK(start.live);
  CHECK(!start.ghost);
  CHECK(start.scene == scene.at("scene"));
  CHECK(start.time == 0.0);
  CHECK(start.tail.is_null());
  const Json& bodies = scene.at("bodies");
  REQUIRE(start.poses.size() == 7 * bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    CHECK(bodies[b].at("element") == 10 + b);
    for (std::size_t k = 0; k < 7; ++k) {
      // An engine may keep other coordinates and give back what they round to in single precision.
      CHECK(start.poses[7 * b + k] == Approx(bodies[b].at("pose")[k].get<double>()).margin(1e-6));
    }
  }
  page.get("subscribe", {{"contacts", true}});
  page.get("step", {{"count", 400}});
  page.hash_after(400);
  REQUIRE(page.outbox().wait([&] { return read_frame(*page.outbox().last_frame(1)).step == 400; }));
  const ReadFrame end = read_frame(*page.outbox().last_frame(1));
  // The ball fell 25 cm, for 0.23 s: it touches the plate.
  REQUIRE(end.tail.at("contacts").size() >= 1);
  CHECK(end.tail.at("contacts")[0].at("force").is_number());
}

TEST_CASE("each client looks where it likes", "[studio][run]") {
  Page page;
  page.join(1);
  page.join(2, Role::viewer);
  page.show(small_scene());
  page.get("step", {{"count", 100}});
  page.hash_after(100);
  CHECK(page.status().at("frames") == 101);
  CHECK(page.get("seek", {{"time", 0.0505}}, 2).at("time").get<double>() == Approx(0.050));
  const auto shows = [&](ClientId client, double step, bool live) {
    return page.outbox().wait([&] {
      const Bytes bytes = page.outbox().last_frame(client);
      if (!bytes) return false;
      const ReadFrame frame = read_frame(*bytes);
      return frame.step == step && frame.live == live;
    });
  };
  CHECK(shows(2, 50, false));
  CHECK(shows(1, 100, true));
  CHECK(page.get("step-back", Json::object(), 2).at("time").get<double>() == Approx(0.049));
  CHECK(shows(2, 49, false));
  CHECK(page.get("seek", {{"time", -5.0}}, 2).at("time") == 0.0);
  CHECK(page.get("step-back", Json::object(), 2).at("time") == 0.0);
  page.get("step", {{"count", 10}});
  CHECK(shows(1, 110, true));
  CHECK(shows(2, 0, false));
  page.get("live", Json::object(), 2);
  CHECK(shows(2, 110, true));
  // When the frames are gone, only the present can be viewed.
  page.get("seek", {{"time", 0.02}}, 2);
  page.get("stop");
  CHECK(shows(2, 0, true));
}

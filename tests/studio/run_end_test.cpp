// Ends of runs, and scenes that are refused without harm.
#include <catch2/catch.hpp>

#include "run_support.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using namespace cogrsim::studio::test;

namespace {

std::string with(const std::string& element) {
  const std::string scene = small_scene();
  return scene.substr(0, scene.rfind("</scene>")) + element + "</scene>";
}

}  // namespace

TEST_CASE("a run that the scene ends says so and restarts after stop", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(with(R"(<on name="enough" time="50 ms"><end reason="enough is enough"/></on>)"));
  page.get("speed", {{"factor", nullptr}});
  page.get("play");
  const Json ended = page.status("ended");
  CHECK_THAT(ended.at("ending").get<std::string>(), Catch::Contains("enough is enough"));
  CHECK(ended.at("time").get<double>() == Approx(0.05).margin(0.0015));
  CHECK_THAT(page.error("play"), Catch::Contains("has ended"));
  CHECK_THAT(page.error("step"), Catch::Contains("has ended"));
  bool reported = false;
  const Json events = page.get("events");
  for (const Json& event : events.at("events")) {
    if (event.at("kind") == "ended") reported = event.at("message") == "enough is enough";
  }
  CHECK(reported);
  CHECK(page.get("seek", {{"time", 0.02}}).at("time").get<double>() == Approx(0.02));
  page.get("stop");
  page.status("stopped");
  CHECK(page.get("events").at("events").empty());
  page.get("step", {{"count", 5}});
  page.hash_after(5);
  CHECK(page.status().at("ending") == "");
}

TEST_CASE("a scene that the engine refuses leaves the run as it is", "[studio][run]") {
  Page page;
  page.join(1);
  page.show(small_scene());
  page.get("step", {{"count", 30}});
  const std::string before = page.hash_after(30);
  const int at = GENERATE(0, 30);
  if (at == 0) {
    page.get("stop");
    page.hash_after(0);
  }
  CHECK_THAT(page.refused(with(R"(<supervisor name="boss" plugin="nosuch_plugin"/>)")),
             Catch::Contains("nosuch_plugin"));
  page.get("step", {{"count", at == 0 ? 30 : 5}});
  if (at == 0) CHECK(page.hash_after(30) == before);
  page.get("backend", {{"name", "bullet"}});
}

// How runs end, and what is refused without harm; what streaming costs.
#include <catch2/catch.hpp>

#include <algorithm>
#include <iostream>
#include <thread>

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

TEST_CASE("a run that the scene ends says so and begins anew after stop", "[studio][run]") {
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
  bool told = false;
  const Json events = page.get("events");
  for (const Json& event : events.at("events")) {
    if (event.at("kind") == "ended") told = event.at("message") == "enough is enough";
  }
  CHECK(told);
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

// cogrsim_studio_tests "[.streaming]"
TEST_CASE("streaming a thousand bodies to three pages", "[.streaming]") {
  std::string xml =
      "<scene name=\"many\" version=\"1\"><physics step=\"2 ms\"/>"
      "<box name=\"floor\" static=\"true\" size=\"60 60 0.1\" xyz=\"0 0 -0.05\"/>";
  for (int i = 0; i < 1000; ++i) {
    xml += "<sphere name=\"s" + std::to_string(i) +
           "\" radius=\"0.1\" linear-velocity=\"0.3 0.2 0\" "
           "xyz=\"" +
           std::to_string(0.5 * (i % 32) - 8) + " " + std::to_string(0.5 * (i / 32) - 8) +
           " 0.1\"/>";
  }
  Page page;
  page.join(1);
  page.show(xml + "</scene>");
  page.get("speed", {{"factor", nullptr}});
  page.run().left(1);
  page.get("play");
  // All are told the status; the clock is read when one comes.
  const auto fresh = [&] {
    const double before = page.outbox().told("status").at("step_count");
    double now = before;
    REQUIRE(page.outbox().wait([&] {
      now = page.outbox().told("status").at("step_count");
      return now != before;
    }));
    return std::make_pair(now, std::chrono::steady_clock::now());
  };
  const auto rate = [&] {
    const auto [steps, begin] = fresh();
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    const auto [more, end] = fresh();
    return (more - steps) / std::chrono::duration<double>(end - begin).count();
  };
  std::vector<double> ratios;
  for (int i = 0; i < 15; ++i) {
    const double alone = rate();
    for (ClientId c = 11; c <= 13; ++c) page.run().joined(c, Role::viewer);
    const double watched = rate();
    for (ClientId c = 11; c <= 13; ++c) page.run().left(c);
    ratios.push_back(alone / watched);
  }
  std::sort(ratios.begin(), ratios.end());
  std::cout << "frames to each page: " << page.outbox().frame_count(11)
            << "; time with three pages to time without, median of 15: " << ratios[7] << " ("
            << ratios[3] << " to " << ratios[11] << ")\n";
  CHECK(page.outbox().frame_count(11) > 0);
}

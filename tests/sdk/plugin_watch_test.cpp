// Calls of plugins, as another thread sees them.
#include <catch2/catch.hpp>

#include <string>
#include <thread>

#include "cogrsim/plugin/crash_report.h"

using namespace cogrsim;

TEST_CASE("whoever looks during a call is told which it is", "[plugins]") {
  PluginWatch watch;
  std::string seen;
  const auto look = [&](const PluginWatch::Call& call) {
    seen = call.kind + " " + call.name + " " + call.doing;
  };
  bool before = true, within = false;
  std::thread([&] {
    watch.watch_this_thread();
    before = watch.during(look);
    const PluginCall outer("controller", "bot.driver", "bot", "pid", "in update", 0.25);
    const PluginCall inner("library", "pid.so", "", "", "while it was loaded");
    within = watch.during(look);
  }).join();
  CHECK_FALSE(before);
  CHECK(within);
  CHECK(seen == "controller bot.driver in update");  // the outermost
  CHECK_FALSE(watch.during(look));
}

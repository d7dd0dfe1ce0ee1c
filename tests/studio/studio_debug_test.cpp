// A controller in the debugger: built, stopped, looked at, stepped, crashed, left.
#include <catch2/catch.hpp>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "cogrsim/core/run_program.h"
#include "document_support.h"
#include "studio_process.h"

using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;
using Catch::Matchers::Contains;

namespace {

// A deadline that is far below the time that a person looks at a line.
const char* const kScene = R"(<scene name="built" version="1">
  <physics backend="bullet" step="1 ms"/>
  <assembly name="bot" xyz="0 0 1">
    <box name="base" static="true" size="10 10 10 cm"/>
    <cylinder name="wheel" radius="5 cm" length="2 cm" mass="150 g" xyz="0 10 cm 0" rpy="90 0 0 deg"/>
    <hinge name="axle" parent="base" child="wheel" axis="0 0 1"/>
    <encoder name="angle" joint="axle"/>
    <motor name="drive" joint="axle" mode="velocity" max-torque="2 N*m" max-speed="20 rad/s"/>
    <controller name="driver" plugin="debugged_driver" rate="100 Hz" deadline="300 ms"/>
  </assembly>
</scene>
)";

const char* const kProject = R"(cmake_minimum_required(VERSION 3.23)
project(debugged_driver LANGUAGES CXX)
find_package(CogRSim REQUIRED)
cogrsim_add_plugin(debugged_driver SOURCES driver.cpp)
)";

const char* const kSource = R"(#include <cogrsim/control/controller.h>
#include <vector>

namespace {
double twice(double speed) {
  const double doubled = 2.0 * speed;
  return doubled;
}
}  // namespace

class Driver final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override { drive_ = robot.motor("drive"); }
  void update(const cogrsim::Tick& tick) override {
    ++calls_;
    std::vector<double> speeds = {0.25 * calls_, tick.period};

    drive_.set(twice(speeds[0]));
    if (crash_ != 0) *reinterpret_cast<volatile int*>(crash_) = 1;
  }

 private:
  cogrsim::MotorHandle drive_;
  int calls_ = 0;
  long crash_ = 0;
};

COGRSIM_CONTROLLER(Driver, "debugged_driver", version("1.0.0"), summary("turns a wheel"))
)";

bool gdb_is_there() {
  const auto end = cogrsim::run_program({"gdb", "--version"});
  return end && end->status == 0;
}

/// The processes that a process has started and that run `program`.
std::vector<pid_t> children_running(pid_t parent, const std::string& program) {
  std::vector<pid_t> out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");
    std::string id, name, state;
    pid_t its_parent = 0;
    if (!(stat >> id >> name >> state >> its_parent)) continue;
    if (its_parent == parent && name == "(" + program + ")" && state != "Z")
      out.push_back(static_cast<pid_t>(std::stol(id)));
  }
  return out;
}

Json breakpoint(int line, const std::string& condition = {}) {
  return {{"file", "driver.cpp"}, {"line", line}, {"condition", condition}};
}

Json named(const Json& list, const std::string& name) {
  for (const Json& one : list)
    if (one["name"] == name) return one;
  FAIL("there is no '" << name << "' in " << list);
  return {};
}

/// The program on the scene, with the controller built for debugging, and a page.
struct Bench {
  Folder folder;
  std::unique_ptr<StudioProcess> studio;
  std::unique_ptr<LivePage> page;

  Bench() {
    folder.write("built.scene.xml", kScene);
    folder.write("CMakeLists.txt", kProject);
    folder.write("driver.cpp", kSource);
    studio = std::make_unique<StudioProcess>(
        std::vector<std::string>{folder.path("built.scene.xml"), "--allow-build"},
        std::map<std::string, std::string>{{"XDG_RUNTIME_DIR", folder.path("run")},
                                           {"XDG_CACHE_HOME", folder.path("cache")},
                                           {"XDG_STATE_HOME", folder.path("state")}});
    page = std::make_unique<LivePage>(*studio);
  }
  void build() {
    const Json built = page->get("build", {{"debug", true}});
    INFO(built["log"].get<std::string>());
    REQUIRE(built["built"] == true);
    page->wait("problems", [](const Json& p) { return p["good"] == true; });
  }
  Json debug(const std::function<bool(const Json&)>& holds) { return page->wait("debug", holds); }
  Json debug(const std::string& state) {
    return debug([&](const Json& d) { return d["state"] == state; });
  }
  /// Stands at this line of the source.
  Json stands(int line) {
    return debug([&](const Json& d) {
      return d["state"] == "stopped" && d["frames"][0]["file"] == "driver.cpp" &&
             d["frames"][0]["line"] == line;
    });
  }
  void run(const std::string& how) { page->get("debug-run", {{"how", how}}); }
  /// Attached, or refused by the system.
  Json attach() {
    page->get("debug-attach", {{"controller", "bot.driver"}});
    return debug([](const Json& d) {
      return d["state"] == "running" ||
             d["note"].get<std::string>().find("cannot") != std::string::npos;
    });
  }
  double time() {
    return page->wait("status", [](const Json&) { return true; })["time"].get<double>();
  }
};

}  // namespace

TEST_CASE("a controller is debugged from its source", "[studio][build][debug]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("gdb reads the sanitizers' memory for minutes");
  if (!gdb_is_there()) COGRSIM_SKIP("there is no gdb (Debian: apt install gdb)");
  Bench bench;
  LivePage& page = *bench.page;
  CHECK(bench.debug("off")["breakpoints"].empty());
  bench.build();

  // Breakpoints are there before the debugger, and say where they went.
  Json elsewhere = breakpoint(1);
  elsewhere["file"] = "/etc/hosts";
  page.get("debug-breakpoints",
           {{"breakpoints", {breakpoint(15), breakpoint(17), breakpoint(900), elsewhere}}});
  const Json attached = bench.attach();
  if (attached["state"] == "waiting")
    COGRSIM_SKIP(attached["note"].get<std::string>() + ": " + attached["help"].get<std::string>());
  REQUIRE(attached["state"] == "running");
  CHECK(attached["note"] == "");
  CHECK(attached["breakpoints"][0]["placed"] == 15);
  CHECK(attached["breakpoints"][1]["placed"] == 18);
  CHECK(attached["breakpoints"][1]["note"] == "line 17 has no code: it is at line 18");
  CHECK(attached["breakpoints"][2]["placed"].is_null());
  CHECK(attached["breakpoints"][2]["note"] == "there is no code on this line or below it");
  CHECK(attached["breakpoints"][3]["note"] == "there is no such source beside the scene");
  CHECK(page.ask("debug-variables")["ok"] == false);

  // The world waits at the first, far longer than the deadline.
  page.get("play");
  Json stop = bench.stands(15);
  CHECK(stop["reason"] == "breakpoint");
  CHECK(stop["crashed"] == false);
  CHECK_THAT(stop["frames"][0]["function"].get<std::string>(), Contains("Driver::update"));
  REQUIRE(stop["readings"].size() == 1);
  CHECK(stop["readings"][0]["sensor"] == "bot.angle");
  CHECK(stop["readings"][0]["values"][0]["unit"] == "rad");
  const double time = stop["time"];
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  CHECK(bench.debug([](const Json&) { return true; })["state"] == "stopped");
  CHECK(page.wait("status", [](const Json& s) {
    return s["waiting"].is_object();
  })["waiting"]["time"] == Approx(time));

  // Lines, functions, and the values in them.
  bench.run("over");
  bench.stands(16);
  bench.run("continue");
  stop = bench.stands(18);
  Json variables = page.get("debug-variables", {{"frame", 0}})["variables"];
  CHECK(named(variables, "tick")["argument"] == true);
  const Json calls = page.get("debug-evaluate", {{"expression", "calls_"}})["variable"];
  const int count = std::stoi(calls["value"].get<std::string>());
  CHECK(calls["type"] == "int");
  const Json speeds = named(variables, "speeds");
  CHECK_THAT(speeds["type"].get<std::string>(), Contains("std::vector<double"));
  const Json elements = page.get("debug-children", {{"of", speeds["children"]}})["variables"];
  REQUIRE(elements.size() == 2);
  CHECK(std::stod(elements[0]["value"].get<std::string>()) == Approx(0.25 * count));
  CHECK(std::stod(elements[1]["value"].get<std::string>()) == Approx(0.01));
  const Json members =
      page.get("debug-children", {{"of", named(variables, "this")["children"]}})["variables"];
  CHECK(named(members, "calls_")["value"] == std::to_string(count));  // "private" is no member
  CHECK(page.ask("debug-evaluate", {{"expression", "nothing_"}})["ok"] == false);
  CHECK(page.ask("debug-evaluate", {{"expression", "1\n-gdb-exit"}})["ok"] == false);

  bench.run("into");
  stop = bench.stands(6);  // and not in the vector's header, whose operator is called first
  CHECK(stop["frames"][0]["function"].get<std::string>().find("twice") != std::string::npos);
  CHECK(stop["frames"][1]["line"] == 18);
  CHECK(named(page.get("debug-variables", {{"frame", 0}})["variables"], "speed")["value"] ==
        elements[0]["value"]);
  CHECK(named(page.get("debug-variables", {{"frame", 1}})["variables"], "speeds")["type"] ==
        speeds["type"]);
  bench.run("out");
  bench.stands(18);

  // A condition; steps that leave the source end where it is entered next.
  page.get("debug-breakpoints",
           {{"breakpoints", {breakpoint(19, "calls_ == " + std::to_string(count + 5))}}});
  bench.run("continue");
  stop = bench.stands(19);
  CHECK(page.get("debug-evaluate", {{"expression", "calls_"}})["variable"]["value"] ==
        std::to_string(count + 5));
  CHECK(stop["time"].get<double>() == Approx(time + 0.05).margin(1e-9));
  bench.run("over");
  bench.stands(20);
  bench.run("over");
  stop = bench.stands(15);
  CHECK(stop["time"].get<double>() == Approx(time + 0.06).margin(1e-9));

  // It goes on, is paused from idleness and from work, and let go.
  page.get("debug-breakpoints", {{"breakpoints", Json::array()}});
  bench.run("continue");
  const double later = bench.time();
  page.wait("status", [&](const Json& s) { return s["time"].get<double>() > later + 0.1; });
  bench.run("pause");
  bench.debug("stopped");
  page.wait("status", [](const Json& s) { return s["waiting"].is_object(); });
  page.get("pause");
  page.get("debug-detach");
  CHECK(bench.debug("off")["note"] == "");
  page.wait("status",
            [&](const Json& s) { return s["waiting"].is_null() && s["state"] == "paused"; });
  page.get("step", {{"count", 50}});
  CHECK(children_running(bench.studio->pid(), "gdb").empty());
  CHECK(bench.studio->end() == 0);
}

TEST_CASE("a crash in the debugger shows its line, and a new process is debugged again",
          "[studio][build][debug]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("gdb reads the sanitizers' memory for minutes");
  if (!gdb_is_there()) COGRSIM_SKIP("there is no gdb (Debian: apt install gdb)");
  Bench bench;
  LivePage& page = *bench.page;
  bench.build();
  page.get("debug-breakpoints", {{"breakpoints", {breakpoint(15)}}});
  const Json attached = bench.attach();
  if (attached["state"] == "waiting") COGRSIM_SKIP(attached["note"].get<std::string>());
  REQUIRE(attached["state"] == "running");
  const Json process = attached["process"];
  page.get("play");
  bench.stands(15);
  page.get("debug-evaluate", {{"expression", "crash_ = 16"}});
  page.get("debug-breakpoints", {{"breakpoints", Json::array()}});
  bench.run("continue");
  const Json crash = bench.stands(19);
  CHECK(crash["crashed"] == true);
  CHECK(crash["reason"] == "SIGSEGV: Segmentation fault");
  CHECK(crash["frames"][0]["function"] == "Driver::update");
  bench.run("continue");
  const Json ended = bench.debug("waiting");
  CHECK(ended["note"] == "the controller's process was ended by SIGSEGV");
  page.wait("events", [](const Json& message) {
    for (const Json& event : message["events"])
      if (event["message"] == "crashed (SIGSEGV) in update") return true;
    return false;
  });

  // Its next process has the breakpoint before its first update.
  page.get("debug-breakpoints", {{"breakpoints", {breakpoint(16)}}});
  page.get("restart");
  const Json again = bench.stands(16);
  CHECK(again["process"] != process);
  CHECK(page.get("debug-evaluate", {{"expression", "calls_"}})["variable"]["value"] == "1");

  // A source that is saved now is newer than what runs.
  page.get("save-source", {{"name", "driver.cpp"}, {"text", std::string("\n") + kSource}});
  page.get("stop");
  CHECK_THAT(
      bench.debug([](const Json& d) { return d["state"] == "running"; })["note"].get<std::string>(),
      Contains("'driver.cpp' is newer than the library that runs"));

  // gdb dies: the run goes on, and says so.
  const auto debuggers = children_running(bench.studio->pid(), "gdb");
  REQUIRE(debuggers.size() == 1);
  ::kill(debuggers[0], SIGKILL);
  const Json gone = bench.debug("off");
  CHECK(gone["note"] == "gdb has ended (SIGKILL)");
  CHECK_FALSE(gone["help"] == "");
  page.get("restart");
  page.wait("status", [](const Json& s) { return s["time"].get<double>() > 0.1; });

  // The studio ends while the controller stands: nothing is left.
  page.get("debug-attach", {{"controller", "bot.driver"}});
  bench.debug("stopped");
  const auto last = children_running(bench.studio->pid(), "gdb");
  REQUIRE(last.size() == 1);
  CHECK(bench.studio->end() == 0);
  CHECK(::kill(last[0], 0) != 0);
}

TEST_CASE("a controller that runs in the debugger is stopped and restarted at once",
          "[studio][build][debug]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("gdb reads the sanitizers' memory for minutes");
  if (!gdb_is_there()) COGRSIM_SKIP("there is no gdb (Debian: apt install gdb)");
  Bench bench;
  LivePage& page = *bench.page;
  bench.build();
  Json attached = bench.attach();
  if (attached["state"] == "waiting") COGRSIM_SKIP(attached["note"].get<std::string>());
  for (const std::string what : {"stop", "restart"}) {
    INFO(what);
    REQUIRE(attached["state"] == "running");
    const Json process = attached["process"];
    page.get("play");
    page.wait("status", [](const Json& s) { return s["time"].get<double>() > 0.1; });
    const auto begin = std::chrono::steady_clock::now();
    page.get(what);
    attached = bench.debug(
        [&](const Json& d) { return d["state"] == "running" && d["process"] != process; });
    // The run waits 30 s for a debugger that waits for the run.
    CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(10));
  }
}

TEST_CASE("a watched call that does not return ends gdb alone", "[studio][build][debug]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("gdb reads the sanitizers' memory for minutes");
  if (!gdb_is_there()) COGRSIM_SKIP("there is no gdb (Debian: apt install gdb)");
  Bench bench;
  LivePage& page = *bench.page;
  bench.build();
  page.get("debug-breakpoints", {{"breakpoints", {breakpoint(15)}}});
  const Json attached = bench.attach();
  if (attached["state"] == "waiting") COGRSIM_SKIP(attached["note"].get<std::string>());
  page.get("play");
  bench.stands(15);
  const Json refused = page.ask("debug-evaluate", {{"expression", "(int)pause()"}});
  REQUIRE(refused["ok"] == false);
  CHECK_THAT(refused["error"]["message"].get<std::string>(), Contains("in time and was ended"));
  CHECK_THAT(refused["error"]["help"].get<std::string>(), Contains("press Debug again"));
  CHECK_THAT(bench.debug("off")["note"].get<std::string>(), Contains("gdb has ended"));
  CHECK(children_running(bench.studio->pid(), "gdb").empty());
  page.get("stop");
  CHECK(bench.attach()["state"] == "running");
}

TEST_CASE("the debugger is not for strangers, and says what it needs", "[studio][program][debug]") {
  const std::string scene = R"(<scene name="yard" version="1">
  <physics backend="bullet" step="1 ms"/>
  <assembly name="bot" xyz="0 0 10">
    <box name="hull" size="10 10 10 cm" mass="1 kg"/>
    <controller name="driver" plugin="rascal" rate="10 Hz"/>
    <controller name="inside" plugin="rascal" rate="10 Hz" isolation="none"/>
  </assembly>
</scene>
)";
  const Folder folder;
  folder.write("yard.scene.xml", scene);
  folder.write("bin/nothing", "");
  const std::map<std::string, std::string> environment = {{"XDG_RUNTIME_DIR", folder.path("run")},
                                                          {"XDG_STATE_HOME", folder.path("state")},
                                                          {"PATH", folder.path("bin")}};
  const std::vector<std::string> arguments = {folder.path("yard.scene.xml"), "--plugin-path",
                                              STUDIO_TEST_RASCALS};
  {
    const StudioProcess studio(arguments, environment);
    LivePage page(studio);
    const Json refused = page.ask("debug-attach", {{"controller", "bot.driver"}});
    CHECK(refused["error"]["code"] == "not-allowed");
    CHECK_THAT(refused["error"]["help"].get<std::string>(), Contains("--allow-build"));
  }
  auto allowed = arguments;
  allowed.push_back("--allow-build");
  const StudioProcess studio(allowed, environment);
  LivePage page(studio);
  page.wait("status", [](const Json& s) { return s["backend"] == "bullet"; });
  const auto note_of = [&](const std::string& controller) {
    page.get("debug-attach", {{"controller", controller}});
    return page.wait("debug", [&](const Json& d) {
      return d["controller"] == controller && d["state"] == "waiting";
    });
  };
  const Json missing = note_of("bot.driver");
  CHECK_THAT(missing["note"].get<std::string>(), Contains("'gdb' cannot be started"));
  CHECK_THAT(missing["help"].get<std::string>(), Contains("apt install gdb"));
  CHECK_THAT(note_of("bot.inside")["note"].get<std::string>(),
             Contains("has no process of its own"));
  CHECK_THAT(note_of("bot.nobody")["note"].get<std::string>(), Contains("has no controller"));
  page.get("play");
  page.wait("status", [](const Json& s) { return s["time"].get<double>() > 0.1; });
}

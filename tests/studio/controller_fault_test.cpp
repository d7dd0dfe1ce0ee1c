// Controllers that crash, end their process or do not return: the studio keeps running, and names
// them.
#include <catch2/catch.hpp>

#include <csignal>

#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "document_support.h"
#include "studio_process.h"

using namespace cogrsim::studio;
using namespace cogrsim::studio::testing;
using Catch::Matchers::Contains;

namespace {

// A robot whose controller does `does` from 0.1 s on; `more`: attributes of it.
std::string yard(const std::string& does, const std::string& more = {}) {
  return R"(<scene name="yard" version="1">
  <physics backend="bullet" step="1 ms"/>
  <assembly name="bot" xyz="0 0 10">
    <box name="hull" size="10 10 10 cm" mass="1 kg"/>
    <controller name="driver" plugin="rascal" rate="10 Hz" )" +
         more + R"(><set does=")" + does + R"(" from="0.1 s"/></controller>
  </assembly>
</scene>
)";
}

const char* const kRobotAlone = R"(<scene name="yard" version="1">
  <physics backend="bullet" step="1 ms"/>
  <assembly name="bot" xyz="0 0 10">
    <box name="hull" size="10 10 10 cm" mass="1 kg"/>
  </assembly>
</scene>
)";

/// The program on a scene, with a page; distinguished from others that run here.
struct Yard {
  Folder folder;
  std::string file;
  std::unique_ptr<StudioProcess> studio;
  std::unique_ptr<LivePage> page;

  explicit Yard(const std::string& scene, std::vector<std::string> arguments = {},
                std::map<std::string, std::string> environment = {}) {
    folder.write("yard.scene.xml", scene);
    file = folder.path("yard.scene.xml");
    start(std::move(arguments), std::move(environment));
  }
  void start(std::vector<std::string> arguments = {},
             std::map<std::string, std::string> environment = {}) {
    page.reset();
    studio.reset();
    arguments.insert(arguments.end(), {file, "--plugin-path", STUDIO_TEST_RASCALS});
    environment["XDG_RUNTIME_DIR"] = folder.path("run");
    environment["XDG_STATE_HOME"] = folder.path("state");
    studio = std::make_unique<StudioProcess>(arguments, environment);
    page = std::make_unique<LivePage>(*studio);
  }

  void play() {
    page->wait("status", [](const Json& s) { return s["backend"] == "bullet"; });
    page->get("speed", {{"factor", nullptr}});
    page->get("play");
  }
  Json waiting() {
    return page->wait("status", [](const Json& s) { return s["waiting"].is_object(); });
  }
  /// The event of the only fault there was.
  Json fault() {
    page->wait("events", [](const Json& message) {
      for (const Json& event : message["events"]) {
        if (event["kind"] == "fault") return true;
      }
      return false;
    });
    Json found;
    const Json all = page->get("events");
    for (const Json& event : all["events"]) {
      if (event["kind"] != "fault") continue;
      CHECK(found.is_null());
      found = event;
    }
    return found;
  }
  Json change(const std::string& text) {
    const Json document = page->wait("document", [](const Json& d) { return d["good"] == true; });
    return page->get("set-text", {{"version", document["version"]}, {"text", text}});
  }
};

}  // namespace

TEST_CASE("a controller's end leaves the studio and its run", "[studio][program][faults]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("sanitizers have messages of their own for a crash");
  struct Case {
    const char* does;
    const char* says;
  };
  const auto c = GENERATE(
      Case{"segv", "crashed (SIGSEGV) in update"}, Case{"overflow", "crashed (SIGSEGV) in update"},
      Case{"crash", "crashed (SIGABRT) in update"}, Case{"noexcept", "crashed (SIGABRT) in update"},
      Case{"exit", "ended its process (exit code 0) in update"},
      Case{"throw", "threw in update: on request"});
  INFO(c.does);
  Yard yard(::yard(c.does));
  yard.play();
  const Json fault = yard.fault();
  CHECK(fault["source"] == "bot.driver");
  CHECK(fault["time"].get<double>() == Approx(0.1));
  CHECK(fault["message"] == c.says);
  // The policy is that the run continues, and later requests are answered as usual.
  const Json later =
      yard.page->wait("status", [](const Json& s) { return s["time"].get<double>() > 0.5; });
  CHECK(later["state"] == "playing");
  yard.page->get("pause");
  yard.page->wait("status", [](const Json& s) { return s["state"] == "paused"; });
  CHECK(yard.page->get("reload")["reloaded"][0]["controller"] == "bot.driver");
  yard.change(kRobotAlone);
  yard.page->wait("scene", [](const Json& s) { return s["controllers"].empty(); });
  yard.page->get("stop");
  yard.page->wait("status", [](const Json& s) { return s["state"] == "stopped"; });
  CHECK(yard.studio->end() == 0);
}

TEST_CASE("a crash ends the run where the scene says so", "[studio][program][faults]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("sanitizers have messages of their own for a crash");
  Yard yard(::yard("segv", R"(on-fault="end-run")"));
  yard.play();
  const Json ended = yard.page->wait("status", [](const Json& s) { return s["state"] == "ended"; });
  CHECK_THAT(ended["ending"].get<std::string>(),
             Contains("a fault ended it") && Contains("crashed (SIGSEGV) in update"));
  yard.page->get("restart");
  yard.page->wait("status", [](const Json& s) { return s["state"] == "ended"; });
}

TEST_CASE("a crash before the start is a problem of the scene", "[studio][program][faults]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP("sanitizers have messages of their own for a crash");
  Yard yard(::yard("nothing"), {}, {{"RASCAL", "rascal.configure:segv"}});
  const Json problems =
      yard.page->wait("problems", [](const Json& p) { return !p["problems"].empty(); });
  CHECK_THAT(problems["problems"][0]["message"].get<std::string>(),
             Contains("controller 'rascal' of 'bot'") &&
                 Contains("crashed (SIGSEGV) while being configured"));
  CHECK(problems["problems"][0]["line"] == 5);
  yard.change(kRobotAlone);
  yard.play();
  yard.page->wait("status", [](const Json& s) { return s["time"].get<double>() > 0.1; });
}

TEST_CASE("a controller that does not return is reported, and ended when asked",
          "[studio][program][faults]") {
  Yard yard(::yard("hang", R"(deadline="none")"));
  yard.play();
  const Json status = yard.waiting();
  const Json waiting = status["waiting"];
  CHECK(waiting["kind"] == "controller");
  CHECK(waiting["name"] == "bot.driver");
  CHECK(waiting["of"] == "bot");
  CHECK(waiting["plugin"] == "rascal");
  CHECK(waiting["doing"] == "in update");
  CHECK(waiting["time"].get<double>() == Approx(0.1));
  CHECK(waiting["isolated"] == true);
  CHECK(waiting["limit"].is_null());
  CHECK(status["factor"] == 0.0);
  // Its duration keeps growing; a client that joins now is informed, too.
  const double seconds = waiting["seconds"];
  LivePage other(*yard.studio);
  other.wait("status", [&](const Json& s) {
    return s["waiting"].is_object() && s["waiting"]["seconds"].get<double>() > seconds;
  });

  // All is answered meanwhile.
  CHECK(yard.page->get("seek", {{"time", 0.05}})["time"].get<double>() == Approx(0.05));
  CHECK(yard.page->get("signals")["signals"].size() > 0);
  yard.page->get("live");
  yard.change(::yard("nothing"));
  yard.page->get("pause");
  yard.page->wait("status",
                  [](const Json& s) { return s["state"] == "paused" && s["waiting"].is_object(); });

  CHECK(yard.page->get("end-controller")["controller"] == "bot.driver");
  CHECK(yard.fault()["message"] ==
        "was ended by the user in update; it had not returned, and its process was killed");
  yard.page->wait("status",
                  [](const Json& s) { return s["waiting"].is_null() && s["state"] == "paused"; });
  CHECK_THAT(yard.page->ask("end-controller")["error"]["message"].get<std::string>(),
             Contains("no controller is waited for"));
  yard.page->get("play");
  yard.page->wait("status", [](const Json& s) { return s["time"].get<double>() > 0.5; });
}

TEST_CASE("stop does not wait for a controller that does not return", "[studio][program][faults]") {
  Yard yard(::yard("hang", R"(deadline="none")"));
  yard.play();
  yard.waiting();
  yard.page->get("stop");
  yard.page->wait("status", [](const Json& s) {
    return s["state"] == "stopped" && s["time"] == 0.0 && s["waiting"].is_null();
  });
  yard.play();
  yard.waiting();
  yard.page->get("restart");
  yard.waiting();
  CHECK(yard.studio->end() == 0);
}

TEST_CASE("a controller that does not return is ended at its deadline",
          "[studio][program][faults]") {
  Yard yard(::yard("hang", R"(deadline="1.5 s")"));
  yard.play();
  CHECK(yard.waiting()["waiting"]["limit"] == 1.5);
  CHECK(yard.fault()["message"] ==
        "hung in update; it did not return within 1.5 s, and its process was killed");
  yard.page->wait("status", [](const Json& s) {
    return s["waiting"].is_null() && s["time"].get<double>() > 0.5;
  });
}

TEST_CASE("a controller in the studio's process that does not return is reported as such",
          "[studio][program][faults]") {
  const bool by_scene = GENERATE(false, true);
  Yard yard(
      ::yard("hang", by_scene ? R"(isolation="none")" : ""),
      by_scene ? std::vector<std::string>() : std::vector<std::string>{"--isolation", "none"});
  yard.play();
  CHECK(yard.waiting()["waiting"]["isolated"] == false);
  const Json refused = yard.page->ask("end-controller");
  CHECK_THAT(refused["error"]["message"].get<std::string>(),
             Contains("controller 'bot.driver' of 'bot' runs in the studio's own process"));
  CHECK_THAT(refused["error"]["help"].get<std::string>(),
             Contains("Ctrl-C") && Contains("isolation=\"process\""));
  yard.change(kRobotAlone);
  yard.page->get("pause");
  yard.page->wait("status", [](const Json& s) { return s["state"] == "paused"; });
  // It ends nevertheless, as failed, and unsaved changes are offered.
  CHECK(yard.studio->end() == 1);
  yard.start();
  yard.page->wait("unsaved", [](const Json& u) { return u["offer"].is_object(); });
}

TEST_CASE("a state is the same wherever controllers run", "[studio][program][faults]") {
  const std::string scene = R"(<scene name="arm" version="1">
  <physics backend="bullet" step="1 ms"/>
  <assembly name="bot">
    <cylinder name="wheel" radius="10 cm" length="2 cm" xyz="0 0 1"/>
    <hinge name="axle" child="wheel" axis="0 0 1"/>
    <motor name="drive" joint="axle" mode="torque" max-torque="1 N*m"/>
    <controller name="driver" plugin="joint_pid"><set motors="drive" target="1 rad"/></controller>
  </assembly>
</scene>
)";
  std::vector<std::string> hashes;
  for (const char* where : {"process", "none"}) {
    Yard yard(scene, {"--isolation", where});
    yard.page->wait("status", [](const Json& s) { return s["backend"] == "bullet"; });
    yard.page->get("step", {{"count", 300}});
    hashes.push_back(yard.page->wait("status", [](const Json& s) {
      return s["step_count"] == 300 && s["state_hash"] != "";
    })["state_hash"]);
    if (hashes.size() > 1) break;
    const Json run =
        Json::parse(run_cogrsim({"run", yard.file, "--duration", "0.3 s", "--json", "-"}));
    hashes.push_back(run["state_hash"]);
  }
  CHECK(hashes[1] == hashes[0]);
  CHECK(hashes[2] == hashes[0]);
}

// A plugin that crashes where it is not in a process of its own: the last line of stderr says
// which, and when.
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>

#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "process.h"

using Catch::Contains;

namespace {

using Arguments = std::vector<std::string>;

const char* const kScene = R"(<scene name="yard" version="1">
  <physics backend="toy" step="1 ms" duration="0.3 s"/>
  <plane name="floor"/>
  <assembly name="bot" xyz="0 0 10">
    <box name="hull" size="10 10 10 cm" mass="1 kg"/>
    <sensor plugin="rascal_eye" name="eye" on="hull" rate="10 Hz"/>
    <controller name="driver" plugin="rascal" rate="10 Hz"><set does="DOES" from="0.1 s"/></controller>
  </assembly>
  <supervisor name="boss" plugin="rascal_boss" rate="10 Hz"/>
  <test name="flies"><always that="time ge 0 s"/></test>
</scene>
)";

// A folder with the scene, and the environment variable that commands the plugins.
struct Yard {
  TemporaryFolder folder;
  std::string scene = folder / "yard.scene.xml";

  explicit Yard(const std::string& does = "nothing") {
    std::string text = kScene;
    text.replace(text.find("DOES"), 4, does);
    std::ofstream(scene) << text;
  }
  Outcome run(Arguments arguments, const std::string& rascal = "") const {
    if (!rascal.empty()) setenv("RASCAL", rascal.c_str(), 1);
    arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
    Outcome outcome = cogrsim_run(arguments);
    unsetenv("RASCAL");
    return outcome;
  }
};

// The last error with its help.
std::string last_error(const std::string& text) {
  const auto at = text.rfind("\nerror: ");
  return at == std::string::npos ? text : text.substr(at + 1);
}

}  // namespace

TEST_CASE("a controller that crashes is named with its robot and the time", "[cli][crash]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP(cogrsim::test::kCatchesSignals);
  struct Case {
    const char* does;
    int signal;
    const char* more;
  };
  const auto c = GENERATE(Case{"segv", SIGSEGV, "SIGSEGV"}, Case{"overflow", SIGSEGV, "SIGSEGV"},
                          Case{"crash", SIGABRT, "SIGABRT"}, Case{"terminate", SIGABRT, "SIGABRT"},
                          Case{"noexcept", SIGABRT, "SIGABRT"});
  INFO(c.does);
  const Yard yard(c.does);
  const Outcome out = yard.run({"run", yard.scene});
  INFO(out.err);
  CHECK(out.status == 128 + c.signal);
  const std::string last = last_error(out.err);
  CHECK_THAT(last, Contains("error: controller 'bot.driver' of 'bot' (plugin 'rascal') in update at "
                            "0.1 s crashed") &&
                       Contains(c.more) && Contains("isolation=\"process\""));
  if (c.does == std::string("noexcept")) CHECK_THAT(out.err, Contains("on request"));
}

TEST_CASE("whatever of a plugin crashes is named", "[cli][crash]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP(cogrsim::test::kCatchesSignals);
  struct Case {
    const char* rascal;
    const char* who;
    const char* doing;
  };
  const auto c = GENERATE(
      Case{"rascal.load:segv", "library '", "rascal.so' while it was loaded"},
      Case{"rascal.make:segv", "controller 'bot.driver'", "while being configured at 0 s"},
      Case{"rascal.configure:overflow", "controller 'bot.driver'", "while being configured at 0 s"},
      Case{"rascal.unmake:segv", "controller 'bot.driver'", "while it was destroyed"},
      Case{"rascal_boss.configure:segv", "supervisor 'boss' (plugin 'rascal_boss')",
           "while being configured"},
      Case{"rascal_boss.update:overflow", "supervisor 'boss'", "in update at 0.1 s"},
      Case{"rascal_boss.unmake:segv", "supervisor 'boss'", "while it was destroyed"},
      Case{"rascal_eye.configure:segv", "sensor 'bot.eye' (plugin 'rascal_eye')",
           "while being configured"},
      Case{"rascal_eye.read:segv", "sensor 'bot.eye'", "in a reading at 0.1 s"},
      Case{"rascal_eye.unmake:segv", "sensor 'bot.eye'", "while it was destroyed"});
  INFO(c.rascal);
  const Yard yard;
  const Outcome out = yard.run({"run", yard.scene}, c.rascal);
  INFO(out.err);
  CHECK(out.status == 128 + SIGSEGV);
  CHECK_THAT(last_error(out.err), Contains("error: ") && Contains(c.who) && Contains(c.doing) &&
                                      Contains("crashed (SIGSEGV"));
}

TEST_CASE("a plugin's exit() is reported with its name", "[cli][crash]") {
  const Yard yard("exit");
  for (const char* command : {"run", "check"}) {
    const Outcome out = yard.run({command, yard.scene}, "rascal.load:exit");
    INFO(command << "\n" << out.err);
    CHECK(out.status == 1);
    CHECK_THAT(out.err, Contains("error: library '") && Contains("called exit()"));
  }
  const Outcome out = yard.run({"run", yard.scene, "--json", yard.folder / "a.json"});
  INFO(out.err);
  CHECK(out.status == 1);
  CHECK_THAT(out.err, Contains("error: controller 'bot.driver' of 'bot'") &&
                          Contains("in update at 0.1 s called exit()"));
}

TEST_CASE("tests, sweeps and recomputed readings name the plugin that crashed", "[cli][crash]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP(cogrsim::test::kCatchesSignals);
  const Yard yard("segv");
  const std::string who = "controller 'bot.driver' of 'bot' (plugin 'rascal')";
  const Outcome tested = yard.run({"test", yard.scene});
  INFO(tested.out << tested.err);
  CHECK(tested.status == 1);
  CHECK_THAT(tested.out, Contains(who) && Contains("at 0.1 s"));
  const Outcome swept =
      yard.run({"sweep", yard.scene, "--seeds", "1", "-o", yard.folder / "study"});
  INFO(swept.out << swept.err);
  CHECK_THAT(read_file(yard.folder / "study/results.csv"), Contains(who) && Contains("at 0.1 s"));

  const Yard good;
  REQUIRE(good.run({"run", good.scene, "--record", good.folder / "a.mcap"}).status == 0);
  const Outcome again =
      good.run({"replay", good.folder / "a.mcap", "--recompute", "--json", good.folder / "a.json"},
               "rascal_eye.read:segv");
  INFO(again.err);
  CHECK(again.status == 128 + SIGSEGV);
  CHECK_THAT(last_error(again.err),
             Contains("sensor 'bot.eye' (plugin 'rascal_eye')") && Contains("at 0.1 s"));
}

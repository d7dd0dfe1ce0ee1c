// The program as a user meets it: exit status, JSON contract, error texts, silence when piped.
#include <sys/stat.h>
#include <unistd.h>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../support/environment.h"
#include "../support/sanitizers.h"
#include "../support/temporary_folder.h"
#include "process.h"

using Catch::Contains;
using nlohmann::json;

namespace {

const std::string kScenes = COGRSIM_SCENES;
const std::string kFlight = kScenes + "/flight.scene.xml";
const std::string kEventful = kScenes + "/eventful.scene.xml";

using Arguments = std::vector<std::string>;

// A subcommand with the toy backends in reach.
Outcome with_toys(Arguments arguments, double interrupt_after = 0.0) {
  arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
  return cogrsim_run(arguments, interrupt_after);
}

json json_of(const Outcome& outcome) {
  INFO(outcome.out << outcome.err);
  return json::parse(outcome.out);
}

const char* const kRunKeys[] = {
    "scene",      "file",   "backend",         "step",      "steps",
    "time",       "status", "energy",          "wall_time", "realtime_factor",
    "state_hash", "bodies", "joints",          "contacts",  "diagnostics",
    "measures",   "events", "events_left_out", "drawn"};

}  // namespace

TEST_CASE("help shows examples and is no error", "[cli][program]") {
  const Outcome all = cogrsim_run({"--help"});
  CHECK(all.status == 0);
  for (const char* command : {"run", "compare", "check", "explain", "schema", "plugins"}) {
    INFO(command);
    CHECK_THAT(all.out, Contains(command));
    const Outcome help = cogrsim_run({command, "--help"});
    CHECK(help.status == 0);
    CHECK_THAT(help.out, Contains("Examples:") && Contains(std::string("cogrsim ") + command));
  }
  CHECK(cogrsim_run({"help"}).out == all.out);
  CHECK(cogrsim_run({"help", "run"}).out == cogrsim_run({"run", "--help"}).out);
  CHECK_THAT(cogrsim_run({"--version"}).out, Contains("cogrsim "));
}

TEST_CASE("wrong usage exits with 2 and names a remedy", "[cli][program]") {
  const struct {
    Arguments arguments;
    const char* text;
  } cases[] = {
      {{}, "Usage"},
      {{"rum", kFlight}, "did you mean 'run'"},
      {{"help", "rum"}, "did you mean 'run'"},
      {{"completion", "tcsh"}, "bash"},
      {{"run"}, "scene is required"},
      {{"run", kFlight, "--frob"}, "--frob"},
      {{"run", kFlight, "--duratoin", "1"}, "did you mean '--duration'?"},
      {{"run", kFlight, "kFlight"}, "'kFlight' is an argument too many"},
      {{"run", kFlight, "--duration", "0"}, "more than 0 s"},
      {{"run", kFlight, "--duration", "-1"}, "more than 0 s"},
      {{"run", kFlight, "--duration", "soon"}, "not a time"},
      {{"run", kFlight, "--step", "0"}, "from 1 ns to 1 s"},
      {{"run", kFlight, "--step", "-1 ms"}, "from 1 ns to 1 s"},
      {{"run", kFlight, "--step", "2 s"}, "from 1 ns to 1 s"},
      {{"run", kFlight, "--step", "1 kg"}, "unknown unit 'kg'"},
      {{"run", kFlight, "--step", "1ms", "--step", "2ms"}, "one step"},
      {{"run", kFlight, "--speed", "0"}, "not a speed"},
      {{"run", kFlight, "--from", "a.snap", "--inputs", "a.mcap"}, "from the start"},
      {{"run", kFlight, "--watch", "--inputs", "a.mcap"}, "for one run"},
      {{"run", kFlight, "--seed", "x"}, "not a seed"},
      {{"run", kFlight, "--set", "h"}, "name=value"},
      {{"run", kFlight, "--set", "h=1 m", "--set", "h=2 m"}, "set twice"},
      {{"compare", kFlight, "--backends", "toy"}, "at least two"},
      {{"compare", kFlight, "--threshold", "1 s"}, "length"},
      {{"compare", kFlight, "--threshold", "0"}, "greater than zero"},
      {{"compare", kFlight, "--step", "3ms,2ms"}, "evenly"},
      {{"compare", kFlight, "--rows", "0"}, "--rows"},
      {{"compare", kFlight, "--json", "same", "--report", "same"}, "same file"},
      {{"check"}, "required"},
      {{"run", kFlight, "--json", ""}, "its value is empty"},
      {{"run", kFlight, "--backend", ""}, "its value is empty"},
      {{"check", ""}, "its value is empty"},
      {{"--plugin-path", "", "plugins"}, "its value is empty"},
      {{"check", kFlight, "--format", "xml"}, "--format"},
      {{"explain", "CG9999"}, "no code 'CG9999'"},
  };
  for (const auto& item : cases) {
    std::string line;
    for (const std::string& argument : item.arguments) line += argument + " ";
    INFO(line);
    const Outcome outcome = cogrsim_run(item.arguments);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains(item.text));
  }
}

TEST_CASE("run keeps its JSON contract", "[cli][program]") {
  const Outcome outcome = with_toys({"run", kFlight, "--json", "-"});
  REQUIRE(outcome.status == 0);
  const json result = json_of(outcome);
  for (const char* key : kRunKeys) {
    INFO(key);
    CHECK(result.contains(key));
  }
  CHECK(result["scene"] == "flight");
  CHECK(result["file"] == kFlight);
  CHECK(result["backend"] == "toy");
  CHECK(result["status"] == "completed");
  CHECK(result["step"] == 1e-3);
  CHECK(result["steps"] == 1000);
  CHECK(result["time"].get<double>() == Approx(1.0));
  CHECK(result["state_hash"].get<std::string>().size() == 16);
  const json& crate = result["bodies"]["crate"];
  // g t^2 / 2 in a second, which the toy gets right
  CHECK(crate["position"][2].get<double>() == Approx(10.0 - 0.5 * 9.81).epsilon(1e-12));
  CHECK(crate["linear_velocity"][0].get<double>() == Approx(1.0));
  CHECK(crate["orientation"] == json({1.0, 0.0, 0.0, 0.0}));
  CHECK(crate["angular_velocity"].size() == 3);
  CHECK(result["bodies"].contains("floor"));
  CHECK(result["contacts"].is_array());
  // digits enough for the same bits
  const double speed = crate["linear_velocity"][2].get<double>();
  char digits[40];
  std::snprintf(digits, sizeof digits, "%.17g", speed);
  CHECK_THAT(outcome.out, Contains(digits));
  CHECK_THAT(outcome.err, !Contains("completed"));
}

TEST_CASE("two runs are bit-identical, and other options make other runs", "[cli][program]") {
  const auto hash = [](Arguments arguments) {
    arguments.insert(arguments.begin(), {"run", kFlight, "--json", "-"});
    return json_of(with_toys(arguments))["state_hash"].get<std::string>();
  };
  const std::string first = hash({});
  CHECK(first == hash({}));
  CHECK(first == hash({"--speed", "20"}));
  CHECK(first == hash({"--duration", "1000 ms"}));
  CHECK(first != hash({"--duration", "0.5"}));
  CHECK(first != hash({"--step", "2 ms"}));
  CHECK(first != hash({"--set", "h=20 m"}));
  CHECK(first != hash({"--backend", "toy_euler"}));
}

TEST_CASE("a summary for people, and nothing on stderr when piped", "[cli][program]") {
  const Outcome outcome = with_toys({"run", kFlight});
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.out, Contains("flight on toy") && Contains("crate") && Contains("wall time"));
  CHECK(outcome.out.find('\033') == std::string::npos);
  CHECK(outcome.err.find('\r') == std::string::npos);
  CHECK(outcome.err.find('%') == std::string::npos);
}

TEST_CASE("a terminal gets colours and a progress line, NO_COLOR is heeded", "[cli][program]") {
  const Arguments arguments = {"run", kFlight, "--speed", "1", "--plugin-path", COGRSIM_TOYS};
  const Outcome live = cogrsim_on_terminal(arguments);
  CHECK(live.status == 0);
  CHECK_THAT(live.out, Contains("\033[1m") && Contains("s left") && Contains("%"));
  const Outcome plain = cogrsim_on_terminal(arguments, {"NO_COLOR=1"});
  CHECK(plain.out.find("\033[1m") == std::string::npos);
  CHECK_THAT(plain.out, Contains("%"));
}

TEST_CASE("messages of a run appear while it runs", "[cli][program]") {
  const Arguments arguments = {"run", kEventful,       "--events",  "--speed",
                               "1",   "--plugin-path", COGRSIM_TOYS};
  const Outcome live = cogrsim_on_terminal(arguments, {"NO_COLOR=1"});
  INFO(live.out);
  REQUIRE(live.status == 0);
  // Each on a line that was cleared before, and the progress line is drawn again behind it.
  const auto comes = live.out.find("\033[K     0.4 s  enter"), goes = live.out.find("it goes");
  REQUIRE(comes != std::string::npos);
  REQUIRE(goes != std::string::npos);
  CHECK(comes < live.out.find("it comes"));
  CHECK(live.out.find("% ", comes) < goes);
  CHECK(live.out.find("% ", goes) != std::string::npos);
  for (std::size_t at = live.out.find('%'); at != std::string::npos;
       at = live.out.find('%', at + 1)) {
    const std::string after = live.out.substr(at, live.out.find_first_of("\r\n", at) - at);
    CHECK_THAT(after, !Contains("warning") && !Contains("enter"));
  }
  const auto entered = live.out.find("enter ");
  CHECK(entered < live.out.find("leave "));
  CHECK(live.out.find("leave ") < live.out.find("eventful on toy"));
}

TEST_CASE("events are printed as they occur and are in the JSON", "[cli][program]") {
  const Outcome printed = with_toys({"run", kEventful, "--events"});
  CHECK(printed.status == 0);
  CHECK_THAT(printed.out, Catch::Matches("[^]*0\\.4[0-9]* s +enter +gate +crate\n[^]*"));
  CHECK_THAT(printed.out, Catch::Matches("[^]*0\\.6[0-9]* s +leave +gate +crate\n[^]*"));
  CHECK_THAT(printed.err, Contains("it comes") && Contains("it goes"));
  CHECK(with_toys({"run", kEventful}).out.find("enter") == std::string::npos);

  const Outcome both = with_toys({"run", kEventful, "--events", "--json", "-"});
  CHECK_THAT(both.err, Contains("leave"));
  const json result = json_of(both);
  REQUIRE(result["events"].size() == 3);
  const json& enter = result["events"][0];
  CHECK(enter["kind"] == "enter");
  CHECK(enter["source"] == "gate");
  CHECK(enter["subject"] == "crate");
  CHECK(enter["message"] == "");
  // The region begins at 0.4 m and the crate makes 1 m/s: seen within the step that brings it in.
  CHECK(enter["time"].get<double>() == Approx(0.4).margin(2e-3));
  CHECK(result["events"][1]["kind"] == "leave");
  CHECK(result["events"][2]["kind"] == "raised");
  CHECK(result["events"][2]["source"] == "gone");
  CHECK(result["events_left_out"] == 0);
}

TEST_CASE("events and messages are bounded and the omitted ones are counted", "[cli][program]") {
  const Outcome outcome = with_toys({"run", kScenes + "/noisy.scene.xml", "--json", "-"});
  REQUIRE(outcome.status == 0);
  const json result = json_of(outcome);
  CHECK(result["events"].size() == 10000);
  // Twelve rules raise one at every millisecond of a second, give or take the first and the last.
  CHECK(result["events_left_out"].get<int>() == Approx(2000).margin(36));
  std::size_t lines = 0;
  for (auto at = outcome.err.find("again"); at != std::string::npos;
       at = outcome.err.find("again", at + 1)) {
    ++lines;
  }
  CHECK(lines == 20);
  CHECK_THAT(outcome.err, Contains("more messages, see --json"));
}

TEST_CASE("measures of the scene stand in summary and JSON", "[cli][program]") {
  const Outcome outcome = with_toys({"run", kEventful, "--json", "-"});
  const json measures = json_of(outcome)["measures"];
  CHECK(measures.size() == 3);
  CHECK(measures["path"].get<double>() == Approx(1.0));
  // sqrt(1 + (g t)^2) = 5 at sqrt(24) / g, seen with the step that reaches it.
  CHECK(measures["fast"].get<double>() == Approx(std::sqrt(24.0) / 9.81).margin(1.1e-3));
  CHECK(measures["never"].is_null());
  const Outcome plain = with_toys({"run", kEventful});
  CHECK_THAT(plain.out, Contains("measures  path 1.00 m, fast 0.5 s, never -\n"));
  CHECK(with_toys({"run", kFlight}).out.find("measures") == std::string::npos);
}

TEST_CASE("Ctrl-C ends a run with the result so far", "[cli][program]") {
  const Outcome outcome =
      with_toys({"run", kFlight, "--speed", "1", "--duration", "60", "--json", "-"}, 0.7);
  CHECK(outcome.status == 128 + SIGINT);
  const json result = json_of(outcome);
  CHECK(result["status"] == "stopped");
  CHECK(result["time"].get<double>() < 10.0);
  CHECK(result["bodies"].contains("crate"));
}

TEST_CASE("Ctrl-C ends tests and leaves nothing behind", "[cli][program]") {
  const TemporaryFolder folder;
  setenv("TMPDIR", (folder / "").c_str(), 1);
  const Outcome outcome =
      with_toys({"test", kScenes + "/endless.scene.xml", "-o", folder / "recordings"}, 1.0);
  unsetenv("TMPDIR");
  INFO(outcome.out << outcome.err);
  CHECK(outcome.status == 128 + SIGINT);
  CHECK_THAT(outcome.err, Contains("interrupted: 0 of 1 cases"));
  CHECK(folder.files().empty());
}

TEST_CASE("a scene that explodes: status, body and time", "[cli][program]") {
  const Outcome outcome =
      with_toys({"run", kScenes + "/explodes.scene.xml", "--backend", "toy", "--json", "-"});
  CHECK(outcome.status == 1);
  const json result = json_of(outcome);
  CHECK(result["status"] == "diverged");
  CHECK(result["time"].get<double>() == Approx(0.25).margin(1.1e-3));
  REQUIRE(result["diagnostics"].size() >= 1);
  const std::string text = result["diagnostics"].dump();
  CHECK_THAT(text, Contains("ball"));
  CHECK_THAT(outcome.err, Contains("ball") && Contains("0.2"));
}

TEST_CASE("a scene that does not compile still gives JSON", "[cli][program]") {
  for (const std::string& scene :
       {kScenes + "/broken.scene.xml", kScenes + "/missing.scene.xml", kScenes}) {
    INFO(scene);
    const Outcome outcome = with_toys({"run", scene, "--json", "-"});
    CHECK(outcome.status == 1);
    const json result = json_of(outcome);
    for (const char* key : kRunKeys) CHECK(result.contains(key));
    CHECK(result["status"] == "failed");
    REQUIRE(result["diagnostics"].size() >= 1);
    CHECK(result["diagnostics"][0]["severity"] == "error");
    CHECK_THAT(result["diagnostics"][0]["code"].get<std::string>(), Contains("CG"));
    CHECK_THAT(outcome.err, Contains("error"));
  }
}

TEST_CASE("an unknown backend: what exists and the folders searched", "[cli][program]") {
  const Outcome outcome = with_toys({"run", kFlight, "--backend", "newton", "--json", "-"});
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.err, Contains("newton") && Contains("toy_euler") && Contains(COGRSIM_TOYS));
  CHECK(json_of(outcome)["status"] == "failed");
}

TEST_CASE("a backend that the scene asks for and that is not there is shown in its file",
          "[cli][program]") {
  const std::string scene = kScenes + "/no_such_backend.scene.xml";
  for (const char* command : {"run", "check"}) {
    INFO(command);
    const Outcome outcome = with_toys({command, scene});
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.out + outcome.err, Contains("CG0901") &&
                                              Contains("no_such_backend.scene.xml:2:21") &&
                                              Contains("2 |   <physics backend=\"newton\"/>"));
  }
  // With another backend named, the scene's is not needed.
  CHECK(with_toys({"run", scene, "--backend", "toy", "--duration", "0.01"}).status == 0);
}

TEST_CASE("options of a backend that lacks what it needs say what, and how to get it",
          "[cli][program]") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "ghost");
  std::ofstream(folder / "ghost/backend.json")
      << R"({"name": "ghost", "engine": "Ghost", "protocol": 1, "command": ["no_such_program"],
             "needs": [{"program": "no_such_program", "install": "apt install no-such"}]})";
  std::ofstream(folder / "ghostly.so") << "no library";
  const auto check = [&](const std::string& physics, const std::string& body) {
    const std::string scene = folder / "a.scene.xml";
    std::ofstream(scene) << "<scene name=\"a\" version=\"1\">" << physics << "<assembly name=\"A\">"
                         << body
                         << "<sphere name=\"b\" radius=\"1\" mass=\"1 kg\"/></assembly></scene>";
    return cogrsim_run({"check", scene, "--plugin-path", folder / ""});
  };
  for (const auto& [physics, body] :
       {std::pair<std::string, std::string>{"<physics><ghost/></physics>", ""},
        {"<physics backend=\"ghost\"><ghost x=\"1\"/></physics>", ""},
        {"", "<ghost/>"}}) {
    INFO(physics << body);
    const Outcome lacks = check(physics, body);
    CHECK(lacks.status == 1);
    CHECK_THAT(lacks.out, Contains("CG0910") &&
                              Contains("no_such_program is not installed (apt install no-such)"));
    CHECK_THAT(lacks.out, !Contains("unknown element"));
  }
  CHECK_THAT(check("<physics><ghostly/></physics>", "").out,
             Contains("CG0902") && Contains("not a shared library"));
  CHECK_THAT(check("<physics><ghots/></physics>", "").out, Contains("unknown element <ghots>"));
}

TEST_CASE("all backends are those that run the scene, and a comparison says which do not",
          "[cli][program]") {
  const TemporaryFolder folder;
  for (const auto& [name, program] : {std::pair("ghost", "no_such_program"), {"idle", "true"}}) {
    std::filesystem::create_directory(folder / name);
    std::ofstream(folder / (name + std::string("/backend.json")))
        << R"({"name": ")" << name << R"(", "engine": "E", "protocol": 1, "command": [")" << program
        << "\"]}";
  }
  const auto compare = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"compare", kScenes + "/hinged.scene.xml", "--duration", "0.01",
                               "--plugin-path", folder / "", "--json", folder / "c.json"});
    const Outcome outcome = with_toys(more);
    INFO(outcome.err);
    CHECK(outcome.status == 0);
    return outcome.err;
  };
  const std::string all = compare({"--backends", "all"});
  CHECK_THAT(all, Contains("'ghost' is left out") && Contains("no_such_program is not installed"));
  CHECK_THAT(all, Contains("'idle' is left out") && Contains("ended its process"));
  CHECK_THAT(all, Contains("'toy' is left out"));
  const json result = json::parse(read_file(folder / "c.json"));
  CHECK(result["runs"].size() >= 2);
  std::string notes;
  for (const json& note : result["diagnostics"]) notes += note["message"].get<std::string>();
  CHECK_THAT(notes, Contains("'ghost' is left out"));
  // Those that are named come first, and once.
  compare({"--backends", "cogrsim,all"});
  const json named = json::parse(read_file(folder / "c.json"));
  CHECK(named["runs"][0]["backend"] == "cogrsim");
  CHECK(named["runs"].size() == result["runs"].size());
}

TEST_CASE("a comparison without names takes the backends in libraries", "[cli][program]") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "idle");
  std::ofstream(folder / "idle/backend.json")
      << R"({"name": "idle", "engine": "E", "protocol": 1, "command": ["true"]})";
  const Outcome outcome = with_toys({"compare", kFlight, "--duration", "0.01", "--plugin-path",
                                     folder / "", "--json", folder / "c.json"});
  CHECK(outcome.status == 0);
  const json result = json::parse(read_file(folder / "c.json"));
  for (const json& run : result["runs"]) CHECK(run["backend"] != "idle");
  CHECK_THAT(with_toys({"run", kFlight, "--backend", "all"}).err, Contains("cogrsim compare"));
}

TEST_CASE("a backend that cannot do what the scene needs says where", "[cli][program]") {
  const std::string scene = kScenes + "/hinged.scene.xml";
  const Outcome run = with_toys({"run", scene, "--backend", "toy"});
  CHECK(run.status == 1);
  CHECK_THAT(run.err, Contains("CG0801") && Contains("hinged.scene.xml"));
  const Outcome check = with_toys({"check", scene, "--backend", "toy"});
  CHECK(check.status == 1);
  CHECK_THAT(check.out, Contains("CG0801") && Contains("hinged.scene.xml"));
}

TEST_CASE("output is written whole or not at all", "[cli][program]") {
  const TemporaryFolder folder;
  const Outcome good = with_toys({"run", kFlight, "--json", folder / "out.json"});
  CHECK(good.status == 0);
  CHECK_THAT(good.out, Contains("crate"));
  CHECK(json::parse(read_file(folder / "out.json"))["status"] == "completed");
  CHECK(folder.files() == std::vector<std::string>{"out.json"});

  const Outcome nowhere = with_toys({"run", kFlight, "--json", folder / "no/such/out.json"});
  CHECK(nowhere.status == 1);
  CHECK_THAT(nowhere.err, Contains("cannot write") && Contains("no/such"));
  CHECK(nowhere.out.empty());

  const Outcome a_folder = with_toys({"compare", kFlight, "--report", folder / ""});
  CHECK(a_folder.status == 1);
  CHECK_THAT(a_folder.err, Contains("it is a folder"));
  CHECK(with_toys({"run", kFlight, "--json", "/dev/null"}).status == 1);
  CHECK(with_toys({"run", kFlight, "--json", "/dev/full"}).status == 1);
}

TEST_CASE("compare measures a known difference", "[cli][program]") {
  const TemporaryFolder folder;
  const Outcome outcome =
      with_toys({"compare", kFlight, "--backends", "toy,toy_euler", "--threshold", "2mm", "--json",
                 folder / "c.json", "--report", folder / "c.html"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.out, Contains("toy_euler against toy") && Contains("crate") &&
                              Contains("diverged by more than 2 mm"));
  const json result = json::parse(read_file(folder / "c.json"));
  CHECK(result["status"] == "completed");
  REQUIRE(result["runs"].size() == 2);
  for (const json& run : result["runs"]) {
    for (const char* key : {"backend", "status", "wall_time", "realtime_factor", "energy",
                            "contacts", "linear_momentum", "deepest_penetration", "joint_error"}) {
      CHECK(run.contains(key));
    }
  }
  REQUIRE(result["bodies"].size() == 2);
  // semi-implicit Euler falls g dt t / 2 further
  const json& position = result["bodies"][0]["position"];
  CHECK(position["max"].get<double>() == Approx(0.5 * 9.81 * 1e-3).epsilon(1e-9));
  CHECK(position["end"].get<double>() == position["max"].get<double>());
  // of a ramp: max / sqrt(3), but for the sampling
  CHECK(position["rms"].get<double>() == Approx(0.5 * 9.81 * 1e-3 / std::sqrt(3.0)).epsilon(1e-3));
  // crosses 2 mm at t = 2 * 2e-3 / (g dt)
  CHECK(result["first_over"]["time"].get<double>() == Approx(4e-3 / 9.81e-3).margin(1.1e-3));

  const std::string page = read_file(folder / "c.html");
  CHECK_THAT(page, Contains("Dygraph") && Contains("data:image/svg+xml;base64,") &&
                       Contains("Energy") && Contains("crate") && Contains("</html>"));
  for (const char* outside : {"src=\"http", "href=\"http", "<link", "@import", "url(http"}) {
    INFO(outside);
    CHECK(page.find(outside) == std::string::npos);
  }
}

TEST_CASE("several steps show the order of convergence", "[cli][program]") {
  const json result = json_of(with_toys({"compare", kFlight, "--backends", "toy,toy_euler",
                                         "--step", "4ms", "--step", "2ms,1ms", "--json", "-"}));
  CHECK(result["runs"][0]["step"] == 4e-3);
  bool seen = false;
  for (const json& series : result["convergence"]) {
    REQUIRE(series["points"].size() == 3);
    if (series["name"] != "toy_euler" && series["kind"] != "between") continue;
    seen = true;
    CHECK(series["points"][0]["order"].get<double>() == Approx(1.0).epsilon(0.02));
  }
  CHECK(seen);
}

TEST_CASE("a comparison ends with the run that ends first", "[cli][program]") {
  const Outcome outcome = with_toys(
      {"compare", kScenes + "/explodes.scene.xml", "--backends", "toy_euler,toy", "--json", "-"});
  CHECK(outcome.status == 1);
  const json result = json_of(outcome);
  CHECK(result["status"] == "diverged");
  CHECK(result["runs"][0]["status"] == "stopped");
  CHECK(result["runs"][1]["status"] == "diverged");
  CHECK_THAT(result["ended_early"].get<std::string>(), Contains("toy: diverged"));
  CHECK(result["time"].get<double>() < 0.26);
}

TEST_CASE("Ctrl-C ends a comparison with the result so far", "[cli][program]") {
  // Late enough that it runs, on a busy machine too.
  const double when = cogrsim::test::kSanitized ? 6.0 : 2.0;
  const Outcome outcome = with_toys(
      {"compare", kFlight, "--backends", "toy,toy_euler", "--duration", "1e6", "--json", "-"},
      when);
  CHECK(outcome.status == 128 + SIGINT);
  const json result = json_of(outcome);
  CHECK(result["status"] == "stopped");
  CHECK(result["ended_early"] == "interrupted");
  CHECK(result["samples"].get<int>() >= 1);
}

TEST_CASE("check distinguishes good from bad scenes, in three formats", "[cli][program]") {
  const Outcome good = with_toys({"check", kFlight});
  CHECK(good.status == 0);
  CHECK_THAT(good.out, Contains("good") && Contains("3 bodies"));
  const std::string broken = kScenes + "/broken.scene.xml";
  const Outcome bad = with_toys({"check", kFlight, broken});
  CHECK(bad.status == 1);
  CHECK_THAT(bad.out, Contains("broken.scene.xml:3:") && Contains("1 error") && Contains("good"));
  const Outcome as_json = with_toys({"check", broken, "--format", "json"});
  CHECK(as_json.status == 1);
  CHECK(json_of(as_json)[0]["line"] == 3);
  const Outcome as_sarif = with_toys({"check", broken, "--format", "sarif"});
  CHECK(json_of(as_sarif)["version"] == "2.1.0");
}

TEST_CASE("json, quiet and color mean the same in every command", "[cli][program]") {
  const cogrsim::test::TemporaryFolder folder;
  const std::string run = folder / "run.mcap";
  REQUIRE(with_toys({"run", kFlight, "-b", "toy", "-d", "0.1", "--record", run}).status == 0);
  struct Case {
    std::vector<std::string> words;
    bool colored = true;
  };
  const std::vector<Case> cases = {
      {{"run", kFlight, "-b", "toy", "-d", "0.1"}},
      {{"compare", kFlight, "-b", "toy,toy_euler", "-d", "0.1"}},
      {{"check", kFlight}},
      {{"info", run}},
      {{"plugins"}},
      {{"schema"}, false}};
  for (const Case& c : cases) {
    INFO(c.words.front());
    const auto with = [&](std::vector<std::string> more) {
      std::vector<std::string> all = c.words;
      all.insert(all.end(), more.begin(), more.end());
      return c.words.front() == "info" ? cogrsim_run(all) : with_toys(all);  // it loads no plugin
    };
    const Outcome text = with({}), dash = with({"--json", "-"}), alone = with({"--json"});
    CHECK(text.status == 0);
    CHECK_NOTHROW(json_of(dash));
    CHECK_NOTHROW(json_of(alone));
    const std::string file = folder / (c.words.front() + ".json");
    const Outcome both = with({"--json", file});
    CHECK(both.status == 0);
    CHECK_FALSE(json::parse(read_file(file), nullptr, false).is_discarded());
    if (c.colored) CHECK(both.out.empty() == text.out.empty());
    const Outcome quiet = with({"-q", "--json"});
    CHECK_NOTHROW(json_of(quiet));
    if (!c.colored) continue;
    const Outcome silent = with({"--quiet"});
    // The findings of a check are warnings.
    CHECK((silent.out.empty() || c.words.front() == "check"));
    CHECK_THAT(silent.out, !Contains("good"));
    CHECK(silent.status == 0);
    CHECK_THAT(with({"--color", "always"}).out, Contains("\033["));
    CHECK_THAT(text.out + with({"--color", "never"}).out, !Contains("\033["));
  }
  const Outcome bad = with_toys({"check", kScenes + "/broken.scene.xml", "-q"});
  CHECK(bad.status == 1);
  CHECK_THAT(bad.out, Contains("broken.scene.xml:3:"));
  const Outcome before = cogrsim_run({"info", "--json", run});
  CHECK(before.status == 0);  // the recording is the command's, which needs one
  CHECK_NOTHROW(json_of(before));
}

TEST_CASE("explain and schema print their documented output", "[cli][program]") {
  const Outcome list = cogrsim_run({"explain"});
  CHECK(list.status == 0);
  CHECK_THAT(list.out, Contains("CG0101"));
  const Outcome one = cogrsim_run({"explain", "cg0101"});
  CHECK(one.status == 0);
  CHECK(one.out.size() > 40);
  const Outcome schema = cogrsim_run({"schema"});
  CHECK(schema.status == 0);
  CHECK_THAT(schema.out, Contains("schema"));
  CHECK_THAT(cogrsim_run({"schema", "--reference"}).out, Contains("#"));
}

TEST_CASE("plugins lists plugins and refused files", "[cli][program]") {
  const TemporaryFolder folder;
  std::ofstream(folder / "letter.so") << "dear loader, this is not a library\n";
  const Outcome text = with_toys({"plugins", "--plugin-path", folder / ""});
  CHECK(text.status == 0);
  CHECK_THAT(text.out,
             Contains("backend toy") && Contains("sensor encoder") && Contains("built in"));
  CHECK_THAT(text.out, Contains("letter.so") && Contains("refused") && Contains("explode-at"));
  CHECK_THAT(text.out, Contains("joint.hinge") && Contains("a toy has no joints"));
  const json result = json_of(with_toys({"plugins", "--json", "--plugin-path", folder / ""}));
  bool toy = false;
  for (const json& plugin : result["plugins"]) {
    for (const char* key : {"kind", "name", "version", "author", "summary", "path", "parameters"}) {
      CHECK(plugin.contains(key));
    }
    if (plugin["name"] != "toy") continue;
    toy = true;
    CHECK(plugin["capabilities"]["joint.hinge"]["support"] == "unsupported");
    CHECK(plugin["world_options"][0]["unit"] == "s");
  }
  CHECK(toy);
  REQUIRE(result["refused"].size() == 1);
  CHECK_THAT(result["refused"][0]["path"].get<std::string>(), Contains("letter.so"));
}

TEST_CASE("a global --plugin-path may stand before the subcommand", "[cli][program]") {
  const Outcome outcome = cogrsim_run({"--plugin-path", COGRSIM_TOYS, "plugins"});
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.out, Contains("backend toy"));
}

TEST_CASE("the doctor names what is missing and what is broken, with the cure", "[cli][program]") {
  const auto finding = [](const json& findings, const std::string& name) -> json {
    for (const json& each : findings["findings"])
      if (each["name"] == name) return each;
    return nullptr;
  };
  const json well = json_of(with_toys({"doctor", "--json"}));
  CHECK(finding(well, "toy")["state"] == "good");
  for (const json& each : well["findings"]) {
    INFO(each.dump());
    CHECK((each["state"] == "good" || each["state"] == "missing"));
    CHECK((each["state"] == "good" || each["remedy"].is_string()));
  }
  // Programs that are not there are no fault; what is there and cannot be loaded is one.
  const cogrsim::test::TemporaryFolder folder;
  const cogrsim::test::EnvironmentVariable path("PATH", folder / ".");
  const Outcome without = cogrsim_run({"doctor", "--json"});
  CHECK(without.status == 0);
  CHECK(finding(json_of(without), "gnuplot")["state"] == "missing");
  CHECK_THAT(finding(json_of(without), "gnuplot")["remedy"].get<std::string>(),
             Contains("apt install gnuplot-nox"));
  folder.write("torn.so", "not a library");
  const Outcome torn = cogrsim_run({"doctor", "--plugin-path", folder / "."});
  CHECK(torn.status == 1);
  CHECK_THAT(torn.out, Contains("broken") && Contains("torn") && Contains("1 broken"));
}

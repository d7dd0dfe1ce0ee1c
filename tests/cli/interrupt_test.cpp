// Every command ended by Ctrl-C and by SIGTERM: its outputs are whole, or what was there before, and
// it ends by the signal, so that a shell's loop ends too.
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../support/environment.h"
#include "policy/policy_support.h"
#include "process.h"

using Catch::Contains;
using cogrsim::test::EnvironmentVariable;
using nlohmann::json;

namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

// It does not end by itself; the sensor makes a mark once the run has begun.
const char* const kScene = R"(<scene name="yard" version="1">
  <physics backend="toy" step="1 ms" duration="1e6 s" gravity="0 0 0"/>
  <assembly name="bot" xyz="0 0 1">
    <box name="hull" size="10 10 10 cm" mass="1 kg"/>
    <sensor plugin="rascal_eye" name="eye" on="hull" rate="10 Hz"/>
  </assembly>
  <plot name="path" y="bot.hull.x"/>
  <test name="stays"><always that="time ge 0 s"/></test>
  <test name="fails" duration="1000 s"><always that="time lt 0.05 s"/></test>
</scene>
)";

const std::string kOld = "what was there before\n";

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

// A store that takes connections and never answers.
class SilentStore {
 public:
  SilentStore() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(socket_, 8) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no socket");
    }
    port_ = ntohs(address.sin_port);
  }
  ~SilentStore() { close(socket_); }
  SilentStore(const SilentStore&) = delete;
  SilentStore& operator=(const SilentStore&) = delete;
  std::string address() const { return "http://127.0.0.1:" + std::to_string(port_) + "/dav"; }
  bool was_asked() const {
    pollfd wait{socket_, POLLIN, 0};
    return poll(&wait, 1, 0) == 1;
  }

 private:
  int socket_;
  int port_ = 0;
};

// What all commands read, made once.
struct Inputs {
  TemporaryFolder folder;
  cogrsim::test::PolicyFolder policy;
  std::string scene = folder / "yard.scene.xml", run = folder / "long.mcap",
              brief = folder / "brief.mcap", package = folder / "yard-1.0.0.cogrsim.zip",
              robot = folder / "yard.urdf", programs = folder / "programs";

  Inputs() {
    put(scene, kScene);
    put(robot, R"(<robot name="yard"><link name="base"/></robot>)");
    fs::create_directory(programs);
    const auto make = [](Arguments arguments) {
      arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
      const Outcome made = cogrsim_run(arguments);
      INFO(made.err);
      REQUIRE(made.status == 0);
    };
    make({"run", scene, "-d", "0.2", "--record", brief});
    make({"run", scene, "-d", "100", "--record", run});
    make({"push", scene, "-o", package});
    // Programs that take their input, say their number and never end.
    for (const char* name : {"gnuplot", "ffmpeg"}) {
      const std::string path = programs + "/" + name;
      put(path, "#!/bin/sh\ncat > /dev/null\necho $$ > \"$RASCAL_MARK\"\nexec sleep 100000\n");
      fs::permissions(path, fs::perms::owner_all);
    }
  }
};

// One start of a command, in an empty folder of its own.
struct Attempt {
  const Inputs& in;
  SilentStore store = {};
  TemporaryFolder folder = {};
  std::string mark = in.folder / "mark";

  std::string operator/(const std::string& name) const { return folder / name; }
  std::string text(const std::string& name) const { return read_file(folder / name); }
  bool marked() const { return fs::exists(mark); }
  // The child's process id: it must have ended.
  bool marked_with_number() const { return !read_file(mark).empty(); }
  /// Unfinished outputs have such names.
  bool writes(const std::string& stem) const {
    for (const std::string& name : folder.files()) {
      if (name.rfind("." + stem + ".", 0) == 0) return true;
    }
    return false;
  }
};

enum class Ends { by_signal, by_itself };

struct Case {
  std::string title;
  Arguments
      arguments;  // the first is the command; SCENE, LONG, BRIEF, PACKAGE, STORE, @NAME: files
  std::function<bool(const Attempt&, const RunningProgram&)> at_work;
  std::function<void(const Attempt&, const Outcome&)> check;
  const char* rascal = "rascal_eye.read:mark";
  Ends ends = Ends::by_signal;
};

// ---- at work

bool marked(const Attempt& attempt, const RunningProgram&) { return attempt.marked(); }
bool started_program(const Attempt& attempt, const RunningProgram&) {
  return attempt.marked_with_number();
}
bool prints(const Attempt&, const RunningProgram& program) { return program.waits_in_a_write(); }
bool asks_store(const Attempt& attempt, const RunningProgram&) { return attempt.store.was_asked(); }
bool reads_long(const Attempt& attempt, const RunningProgram& program) {
  return program.has_open(fs::canonical(attempt.in.run));
}
std::function<bool(const Attempt&, const RunningProgram&)> writes(const std::string& stem) {
  return [stem](const Attempt& attempt, const RunningProgram&) { return attempt.writes(stem); };
}

// ---- the files afterwards

using Files = std::vector<std::string>;

// No file has changed, and none is new.
void unchanged(const Attempt& attempt, const Outcome&) {
  for (const std::string& name : attempt.folder.files()) {
    INFO(name);
    const bool old = fs::is_regular_file(attempt / name);
    CHECK((old ? attempt.text(name) == kOld : fs::is_empty(attempt / name)));
  }
}

void has(const Attempt& attempt, Files expected) {
  Files there = attempt.folder.files();
  std::sort(there.begin(), there.end());
  std::sort(expected.begin(), expected.end());
  CHECK(there == expected);
}

void nothing(const Attempt& attempt, const Outcome&) { has(attempt, {}); }

// Whatever came of the little time that there was.
void old_or_whole_page(const Attempt& attempt, const Outcome&) {
  has(attempt, {"a.html"});
  if (attempt.text("a.html") != kOld) CHECK_THAT(attempt.text("a.html"), Contains("</html>"));
}

void whole_page(const Attempt& attempt, const Outcome&) {
  has(attempt, {"a.html"});
  CHECK_THAT(attempt.text("a.html"), Contains("</html>"));
}

void gone(const Attempt& attempt) {
  const pid_t program = std::atoi(read_file(attempt.mark).c_str());
  const bool there = program > 0 && kill(program, 0) == 0;
  CHECK_FALSE(there);
  if (there) kill(program, SIGKILL);
}

void unchanged_and_gone(const Attempt& attempt, const Outcome& outcome) {
  unchanged(attempt, outcome);
  gone(attempt);
}

void whole_run(const Attempt& attempt, const Outcome&) {
  has(attempt, {"a.json", "a.mcap", "a.snap"});
  const json result = json::parse(attempt.text("a.json"));
  CHECK(result["status"] == "stopped");
  const Outcome info = cogrsim_run({"info", attempt / "a.mcap", "--json"});
  CHECK(json::parse(info.out)["complete"] == true);
  // Recordings keep times in nanoseconds.
  CHECK(json::parse(info.out)["end"].get<double>() ==
        Approx(result["time"].get<double>()).margin(1e-9));
  CHECK(attempt.text("a.snap") == kOld);  // of a time that was not reached
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"run",
       {"run", "SCENE", "--json", "@a.json", "--record", "@a.mcap", "--save-at", "1e5", "@a.snap",
        "--overwrite"},
       marked,
       whole_run},
      {"run --plots that draws",
       {"run", "SCENE", "-d", "0.2", "--json", "@a.json", "--record", "@a.mcap", "--plots",
        "@plots", "--overwrite"},
       started_program,
       [](const Attempt& attempt, const Outcome&) {
         has(attempt, {"a.json", "a.mcap", "plots"});
         CHECK(json::parse(attempt.text("a.json"))["status"] == "completed");
         const Outcome info = cogrsim_run({"info", attempt / "a.mcap", "--json"});
         CHECK(json::parse(info.out)["complete"] == true);
         CHECK(fs::is_empty(attempt / "plots"));
         gone(attempt);
       },
       ""},
      {"run that loads",
       {"run", "SCENE", "--json", "@a.json", "--overwrite"},
       marked,
       unchanged,
       "rascal_eye.load:stay"},
      {"run whose sensor does not return",
       {"run", "SCENE", "--json", "@a.json", "--overwrite"},
       marked,
       [](const Attempt& attempt, const Outcome& outcome) {
         unchanged(attempt, outcome);
         CHECK_THAT(outcome.err, Contains("did not return: sensor 'bot.eye'"));
       },
       "rascal_eye.read:stay"},
      {"run --watch",
       {"run", "SCENE", "--watch", "--json", "@a.json", "--overwrite"},
       marked,
       [](const Attempt& attempt, const Outcome& outcome) {
         CHECK(outcome.status == 0);  // of the last run
         CHECK(json::parse(attempt.text("a.json"))["status"] == "stopped");
       },
       "rascal_eye.read:mark",
       Ends::by_itself},
      {"compare",
       {"compare", "SCENE", "-b", "toy,toy_euler", "--json", "@a.json", "--report", "@a.html",
        "--overwrite"},
       marked,
       [](const Attempt& attempt, const Outcome&) {
         has(attempt, {"a.html", "a.json"});
         CHECK(json::parse(attempt.text("a.json"))["ended_early"] == "interrupted");
         CHECK_THAT(attempt.text("a.html"), Contains("</html>"));
       }},
      {"replay --json",
       {"replay", "LONG", "--json", "@a.json", "--overwrite"},
       writes("a"),
       unchanged},
      {"replay --csv", {"replay", "LONG", "--csv", "@tables"}, reads_long, unchanged},
      {"replay --recompute",
       {"replay", "LONG", "--recompute", "--json", "@a.json", "--overwrite"},
       marked,
       unchanged},
      {"replay --verify", {"replay", "LONG", "--verify"}, marked, nothing},
      {"replay --render",
       {"replay", "LONG", "--render", "top", "-o", "@pictures"},
       [](const Attempt& attempt, const RunningProgram&) {
         return fs::exists(attempt / "pictures/top_000001.png");
       },
       [](const Attempt& attempt, const Outcome&) {
         for (const auto& entry : fs::directory_iterator(attempt / "pictures")) {
           INFO(entry.path());
           CHECK(entry.path().filename().string().rfind("top_", 0) == 0);
           CHECK(read_file(entry.path()).ends_with("IEND\xae\x42\x60\x82"));
         }
       }},
      {"map of a scene", {"map", "SCENE", "-o", "@a.svg", "--overwrite"}, marked, unchanged},
      {"map of a recording",
       {"map", "LONG", "--trail", "bot", "-o", "@a.svg", "--overwrite"},
       reads_long,
       unchanged},
      {"map, a film",
       {"map", "BRIEF", "--every", "0.1", "-o", "@a.gif", "--overwrite"},
       started_program,
       unchanged_and_gone},
      {"map, a film of a long recording",
       {"map", "LONG", "--every", "0.01", "-o", "@a.gif", "--overwrite"},
       writes("a"),
       unchanged},
      {"render of a scene", {"render", "SCENE", "-o", "@a.png", "--overwrite"}, marked, unchanged},
      {"render, a film",
       {"render", "BRIEF", "--every", "0.1", "-o", "@a.gif", "--overwrite"},
       started_program,
       unchanged_and_gone},
      {"render, a film of a long recording",
       {"render", "LONG", "--every", "0.01", "-o", "@a.gif", "--overwrite"},
       writes("a"),
       unchanged},
      {"plot",
       {"plot", "LONG", "--y", "bot.hull.x", "-o", "@a.json", "--overwrite"},
       reads_long,
       unchanged},
      {"plot that draws",
       {"plot", "BRIEF", "--y", "bot.hull.x", "-o", "@a.png", "--overwrite"},
       started_program,
       unchanged_and_gone},
      {"sweep",
       {"sweep", "SCENE", "--seeds", "1..4", "--backends", "toy", "-o", "@study"},
       marked,
       [](const Attempt& attempt, const Outcome& outcome) {
         CHECK_THAT(outcome.out, Contains("0 of 4 runs done"));
         const std::string csv = attempt.text("study/results.csv");
         CHECK(csv.rfind("seed,backend,status", 0) == 0);
         CHECK(csv.back() == '\n');
         CHECK(attempt.text("study/results.sqlite").rfind("SQLite format 3", 0) == 0);
       }},
      {"test",
       {"test", "SCENE", "--backends", "toy", "--filter", "stays", "--junit", "@a.xml", "-o",
        "@recordings", "--overwrite"},
       marked,
       [](const Attempt& attempt, const Outcome& outcome) {
         has(attempt, {"a.xml"});
         CHECK_THAT(attempt.text("a.xml"), Contains("</testsuites>"));
         CHECK_THAT(outcome.err, Contains("interrupted: 0 of 1 cases"));
       }},
      {"test that records",
       {"test", "SCENE", "--backends", "toy", "--filter", "fails", "-o", "@recordings"},
       [](const Attempt& attempt, const RunningProgram&) {
         return fs::exists(attempt / "recordings/yard.fails.toy.seed1.mcap");
       },
       [](const Attempt& attempt, const Outcome&) {
         const std::string file = attempt / "recordings/yard.fails.toy.seed1.mcap";
         CHECK(json::parse(cogrsim_run({"info", file, "--json"}).out)["complete"] == true);
       }},
      {"check", {"check", "SCENE"}, marked, nothing, "rascal_eye.load:stay"},
      {"info --extract",
       {"info", "BRIEF", "--extract", "@scene"},
       prints,
       [](const Attempt& attempt, const Outcome&) {
         CHECK(attempt.text("scene/yard.scene.xml") == kScene);
       }},
      {"import", {"import", "ROBOT"}, prints, nothing},
      {"export", {"export", "SCENE", "-o", "-", "--format", "mjcf"}, prints, nothing},
      {"policy", {"policy", "check", "CARD"}, prints, nothing},
      {"transfer",
       {"transfer", "CARD", "--seeds", "1..4", "-b", "cogrsim", "-d", "100000", "-o", "@study"},
       [](const Attempt& attempt, const RunningProgram&) {
         return fs::exists(attempt / "study/results.sqlite");
       },
       [](const Attempt& attempt, const Outcome& outcome) {
         CHECK_THAT(outcome.err, Contains("0 of 4 runs done"));
         CHECK_THAT(outcome.out, Contains("0 of 0"));
         CHECK(attempt.text("study/results.csv").rfind("command,seed,backend,status", 0) == 0);
       }},
      {"plugins", {"plugins"}, prints, nothing},
      {"doctor", {"doctor"}, prints, nothing},
      {"schema", {"schema"}, prints, nothing},
      {"explain", {"explain"}, prints, nothing},
      {"help", {"help", "--reference"}, prints, nothing},
      {"completion", {"completion", "bash"}, prints, nothing},
      {"new",
       {"new", "controller", "walker", "--into", "@."},
       prints,
       [](const Attempt& attempt, const Outcome&) {
         has(attempt, {"walker"});
         CHECK(fs::exists(attempt / "walker/CMakeLists.txt"));
       }},
      {"bundle of a scene", {"bundle", "SCENE", "-o", "@a.html", "--force"}, marked, whole_page},
      {"bundle of a recording",
       {"bundle", "LONG", "-o", "@a.html", "--force"},
       reads_long,
       old_or_whole_page},
      {"push -o", {"push", "SCENE", "-o", "@a.zip", "--force"}, prints, unchanged},
      {"push", {"push", "SCENE", "--to", "STORE"}, asks_store, nothing},
      {"pull of a file",
       {"pull", "PACKAGE", "--into", "@."},
       prints,
       [](const Attempt& attempt, const Outcome&) {
         has(attempt, {"yard-1.0.0"});
         CHECK(attempt.text("yard-1.0.0/yard.scene.xml") == kScene);
       }},
      {"pull", {"pull", "yard", "--from", "STORE", "--into", "@."}, asks_store, nothing},
      {"list", {"list", "STORE"}, asks_store, nothing},
      {"studio",
       {"studio", "SCENE", "--no-open"},
       [](const Attempt&, const RunningProgram& program) { return program.printed(); },
       [](const Attempt&, const Outcome& outcome) { CHECK(outcome.status == 0); },
       "rascal_eye.read:mark",
       Ends::by_itself},
  };
  return all;
}

Outcome interrupt(const Case& c, const Attempt& attempt, int signal) {
  Arguments arguments = c.arguments;
  for (std::string& argument : arguments) {
    if (argument == "SCENE") argument = attempt.in.scene;
    if (argument == "ROBOT") argument = attempt.in.robot;
    if (argument == "LONG") argument = attempt.in.run;
    if (argument == "BRIEF") argument = attempt.in.brief;
    if (argument == "PACKAGE") argument = attempt.in.package;
    if (argument == "CARD") argument = attempt.in.policy.path("arm.policy.yaml");
    if (argument == "STORE") argument = attempt.store.address();
    if (argument[0] != '@') continue;
    argument = attempt / argument.substr(1);
    const std::string ending = fs::path(argument).extension();
    if (ending.size() > 1) put(argument, kOld);
  }
  for (const char* command : {"run", "compare", "replay", "map", "render", "sweep", "test", "check",
                              "plugins", "schema", "bundle", "push", "studio", "export"}) {
    if (arguments[0] == command) arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
  }
  fs::remove(attempt.mark);
  const auto* const function = c.at_work.target<bool (*)(const Attempt&, const RunningProgram&)>();
  const bool full = function != nullptr && *function == prints;
  return cogrsim_interrupted(
      arguments, signal, [&](const RunningProgram& program) { return c.at_work(attempt, program); },
      full);
}

}  // namespace

TEST_CASE("every command is interrupted in the next test", "[cli][interrupt]") {
  std::set<std::string> tried;
  for (const Case& c : cases()) tried.insert(c.arguments[0]);
  const std::set<std::string> there = listed_commands();
  CHECK(there.size() > 10);
  for (const std::string& command : there) {
    INFO("write an entry for 'cogrsim " << command << "'");
    CHECK(tried.count(command) == 1);
  }
}

TEST_CASE("an interrupted command leaves whole outputs, and ends by the signal",
          "[cli][interrupt]") {
  const Inputs in;
  const EnvironmentVariable home("HOME", in.folder / "home"),
      cache("XDG_CACHE_HOME", in.folder / "cache"), state("XDG_RUNTIME_DIR", in.folder / "state"),
      path("PATH", in.programs + ":" + std::getenv("PATH"));
  const std::set<std::string> there = listed_commands();
  for (const Case& c : cases()) {
    if (there.count(c.arguments[0]) == 0) continue;  // built without the studio, or without sharing
    for (const int signal : {SIGINT, SIGTERM}) {
      const Attempt attempt{in};
      const EnvironmentVariable rascal("RASCAL", c.rascal), mark("RASCAL_MARK", attempt.mark);
      const Outcome outcome = interrupt(c, attempt, signal);
      INFO(c.title << ", signal " << signal << "\n" << outcome.err);
      CHECK(outcome.signal == (c.ends == Ends::by_signal ? signal : 0));
      if (c.check) c.check(attempt, outcome);
    }
  }
}

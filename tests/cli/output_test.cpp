// Every command pointed at what it must not replace: docs/guide/security.md. And what a scene may
// write.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include <catch2/catch.hpp>

#include "policy/policy_support.h"
#include "process.h"

using Catch::Contains;

namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

const std::string kFlight = std::string(COGRSIM_SCENES) + "/flight.scene.xml";

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

Outcome with_toys(Arguments arguments) {
  arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
  return cogrsim_run(arguments);
}

// A folder with one of each: a scene, a recording, a figure, a snapshot, a package.
struct Inputs {
  TemporaryFolder folder;
  cogrsim::test::PolicyFolder policy;
  std::string scene = folder / "a.scene.xml", recorded = folder / "b.scene.xml",
              run = folder / "run.mcap", figure = folder / "figure.json", snap = folder / "a.snap",
              package = folder / "a-1.0.0.cogrsim.zip", robot = folder / "a.urdf",
              sizes = folder / "sizes.yaml", mesh = folder / "m/part.obj",
              without_meshes = folder / "flight.scene.xml";

  Inputs() {
    std::string text = read_file(kFlight);
    put(without_meshes, text);
    text.insert(text.find('>', text.find("<scene")) + 1, "\n  <import href=\"a.urdf\"/>");
    text.insert(text.rfind("</scene>"), "<instance of=\"A\" xyz=\"50 50 50\"/>\n");
    text.insert(text.rfind("</scene>"), R"(<plot name="path" y="ball.z"/>
  <test name="fails"><always that="ball.z gt 100 m"/></test>
)");
    put(scene, text);
    put(sizes, "mass: 2\n");
    fs::create_directory(folder / "m");
    put(mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    put(robot, R"(<robot name="a" xmlns:xacro="x"><link name="base"><inertial>
  <mass value="${xacro.load_yaml('sizes.yaml')['mass']}"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
  <visual><geometry><mesh filename="m/part.obj"/></geometry></visual></link></robot>)");
    text.insert(text.rfind("</scene>"), "<record file=\"kept.mcap\"/>\n");
    put(recorded, text);
    REQUIRE(with_toys({"run", scene, "-b", "toy", "-d", "0.1", "--record", run, "--save-at", "0.05",
                       snap})
                .status == 0);
    REQUIRE(cogrsim_run({"plot", run, "-o", figure}).status == 0);
    REQUIRE(with_toys({"push", scene, "-o", package}).status == 0);
  }

  std::vector<std::pair<std::string, std::string>> by_argument() const {
    return {{"SCENE", scene},
            {"RECORDED", recorded},
            {"RUN", run},
            {"FIGURE", figure},
            {"SNAP", snap},
            {"PACKAGE", package},
            {"ROBOT", robot},
            {"FLIGHT", without_meshes},
            {"CARD", policy.path("arm.policy.yaml")}};
  }

  // With the files that a scene or a robot names.
  std::vector<std::pair<std::string, std::string>> read_for_argument() const {
    auto all = by_argument();
    for (const char* argument : {"SCENE", "RECORDED", "ROBOT"})
      for (const std::string& file : {robot, sizes, mesh}) all.emplace_back(argument, file);
    return all;
  }
};

// An option that names an output of a command. Its files are found by running it.
struct Case {
  const char* option;
  const char* ending;                 // of the file that is named; "/": it is a folder
  Arguments arguments;                // SCENE, RUN ... and OUT stand for files
  const char* force = "--overwrite";  // empty: there is no such option
  bool again = true;                  // its own outputs are replaced
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"--json", ".json", {"run", "SCENE", "-d", "0.1", "--json", "OUT"}},
      {"--record", ".mcap", {"run", "SCENE", "-d", "0.1", "--record", "OUT"}},
      {"--save-at", ".snap", {"run", "SCENE", "-d", "0.1", "--save-at", "0.05", "OUT"}},
      {"--save-at",
       ".snap",
       {"run", "SCENE", "-d", "0.2", "--from", "SNAP", "--save-at", "0.15", "OUT"}},
      {"--plots", "/", {"run", "SCENE", "-d", "0.1", "--plots", "OUT"}},
      {"--output-dir", "/", {"run", "RECORDED", "-d", "0.1", "--output-dir", "OUT"}},
      {"--json",
       ".json",
       {"compare", "SCENE", "-b", "toy,toy_euler", "-d", "0.1", "--json", "OUT"}},
      {"--report",
       ".html",
       {"compare", "SCENE", "-b", "toy,toy_euler", "-d", "0.1", "--report", "OUT"}},
      {"--table",
       ".md",
       {"compare", "SCENE", "-b", "toy,toy_euler", "-d", "0.1", "--table", "OUT"}},
      {"--table",
       ".tex",
       {"compare", "SCENE", "-b", "toy,toy_euler", "-d", "0.1", "--table", "OUT"}},
      {"-o,--output", ".json", {"plot", "RUN", "-o", "OUT"}},
      {"-o,--output", ".png", {"plot", "RUN", "-o", "OUT"}},
      {"-o,--output", ".json", {"plot", "FIGURE", "-o", "OUT"}},
      {"-o,--output", "/", {"plot", "RUN", "--format", "svg", "-o", "OUT"}},
      {"--extract", "/", {"info", "RUN", "--extract", "OUT"}},
      {"--json", ".json", {"replay", "RUN", "--json", "OUT"}},
      {"--json", ".json", {"info", "RUN", "--json", "OUT"}},
      // A list has no place for the mark of its own outputs.
      {"--json", ".json", {"check", "SCENE", "--json", "OUT"}, "--overwrite", false},
      {"--json", ".json", {"test", "SCENE", "--backends", "toy", "--json", "OUT"}},
      {"--json", ".json", {"schema", "--json", "OUT"}},
      {"--json", ".json", {"plugins", "--json", "OUT"}},
      {"--json", ".json", {"doctor", "--json", "OUT"}},
      {"--json", ".json", {"policy", "run", "CARD", "-b", "cogrsim", "-d", "0.1", "--json", "OUT"}},
      {"--json",
       ".json",
       {"transfer", "CARD", "-b", "cogrsim", "--seeds", "1", "-d", "0.1", "--json", "OUT"}},
      {"--report",
       ".html",
       {"transfer", "CARD", "-b", "cogrsim", "--seeds", "1", "-d", "0.1", "--report", "OUT"}},
      {"--markdown",
       ".md",
       {"transfer", "CARD", "-b", "cogrsim", "--seeds", "1", "-d", "0.1", "--markdown", "OUT"}},
      {"--latex",
       ".tex",
       {"transfer", "CARD", "-b", "cogrsim", "--seeds", "1", "-d", "0.1", "--latex", "OUT"}},
      {"-o,--output",
       "/",
       {"transfer", "CARD", "-b", "cogrsim", "--seeds", "1", "-d", "0.1", "-o", "OUT"}},
      {"--csv", "/", {"replay", "RUN", "--csv", "OUT"}},
      {"--ros2", ".mcap", {"replay", "RUN", "--ros2", "OUT"}},
      {"-o,--output", "/", {"replay", "RUN", "--render", "top", "--at", "0.05", "-o", "OUT"}},
      {"-o,--output", "/", {"sweep", "SCENE", "--seeds", "1", "--backends", "toy", "-o", "OUT"}},
      {"--junit", ".xml", {"test", "SCENE", "--backends", "toy", "--junit", "OUT"}},
      {"-o,--output,--out", "/", {"test", "SCENE", "--backends", "toy", "-o", "OUT"}},
      {"-o,--output", ".svg", {"map", "RUN", "-o", "OUT"}},
      {"-o,--output", ".gif", {"map", "RUN", "--every", "0.05", "-o", "OUT"}},
      {"-o,--output", ".png", {"render", "RUN", "-o", "OUT"}},
      {"-o,--output", ".html", {"bundle", "RUN", "-o", "OUT"}},
      {"-o,--output", ".html", {"bundle", "SCENE", "-b", "toy", "-d", "0.1", "-o", "OUT"}},
      {"-o,--output", ".zip", {"push", "SCENE", "-o", "OUT"}, "--overwrite", false},
      {"-o,--output", "/", {"push", "SCENE", "-o", "OUT"}, "--force", false},
      {"-o,--output", ".scene.xml", {"import", "ROBOT", "-o", "OUT"}},
      {"--report", ".json", {"import", "ROBOT", "--report", "OUT"}},
      {"--report", ".html", {"import", "ROBOT", "--report", "OUT"}},
      {"-o,--output", ".urdf", {"export", "SCENE", "-o", "OUT"}, "--overwrite", false},
      {"--report", ".json", {"export", "FLIGHT", "-o", "-", "--format", "sdf", "--report", "OUT"}},
      {"--report", ".html", {"export", "FLIGHT", "-o", "-", "--format", "sdf", "--report", "OUT"}},
      {"--into", "/", {"pull", "PACKAGE", "--into", "OUT"}, "", false},
      {"--into", "/", {"new", "controller", "walker", "--into", "OUT"}, "", false},
  };
  return all;
}

bool evades(const Case& c, const std::string& file) {
  return c.arguments[0] == "import" && file.rfind("meshes/", 0) == 0;
}

bool is_folder(const Case& c) { return c.ending[0] == '/'; }

Outcome attempt(const Inputs& in, const Case& c, const std::string& out, bool force) {
  Arguments arguments = c.arguments;
  for (std::string& argument : arguments) {
    for (const auto& [name, file] : in.by_argument()) {
      if (argument == name) argument = file;
    }
    if (argument == "OUT") argument = out;
  }
  if (force && c.force[0] != '\0') arguments.emplace_back(c.force);
  for (const char* other : {"plot", "map", "info", "pull", "new", "import"}) {
    if (arguments.front() == other) return cogrsim_run(arguments);
  }
  return with_toys(arguments);
}

// Everything below a folder: names, kinds, contents.
std::map<std::string, std::string> state_of(const std::string& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& path = entry.path();
    const fs::file_status status = entry.symlink_status();
    all[path.lexically_relative(folder)] = fs::is_symlink(status)
                                               ? "link to " + fs::read_symlink(path).string()
                                           : fs::is_directory(status)    ? "folder"
                                           : fs::is_regular_file(status) ? "file " + read_file(path)
                                                                         : "device";
  }
  return all;
}

const std::string kFolder = "a folder";

struct Obstacle {
  std::string what;
  std::function<void(const std::string& path)> put;
};

const std::vector<Obstacle>& obstacles() {
  static const std::vector<Obstacle> all = {
      {"a foreign file", [](const std::string& path) { put(path, "mine\n"); }},
      {"a link to a foreign file",
       [](const std::string& path) {
         put(path + ".target", "mine\n");
         fs::create_symlink(path + ".target", path);
       }},
      {"a link to nothing",
       [](const std::string& path) { fs::create_symlink(path + ".target", path); }},
      {"a link to a device",
       [](const std::string& path) { fs::create_symlink("/dev/null", path); }},
      {"a pipe", [](const std::string& path) { REQUIRE(mkfifo(path.c_str(), 0600) == 0); }},
      {kFolder,
       [](const std::string& path) {
         fs::create_directory(path);
         put(path + "/inside", "mine\n");
       }},
  };
  return all;
}

void check_refused(const Outcome& outcome) {
  CHECK(outcome.status != 0);
  // The result of a test has the reason why there is no recording.
  CHECK_THAT(outcome.err + outcome.out, Contains("error") || Contains("cannot write"));
}

// An obstacle at `path`, the output of the command.
void check_refuses(const Inputs& in, const Case& c, const std::string& folder,
                   const std::string& out, bool force) {
  INFO(out << (force ? " and forced" : ""));
  struct stat null_before {
  }, null_after{};
  REQUIRE(stat("/dev/null", &null_before) == 0);
  const auto before = state_of(folder), inputs_before = state_of(in.folder / "");
  const Outcome refused = attempt(in, c, out, force);
  INFO(refused.out << refused.err);
  check_refused(refused);
  CHECK(state_of(folder) == before);
  CHECK(state_of(in.folder / "") == inputs_before);
  REQUIRE(stat("/dev/null", &null_after) == 0);
  CHECK(null_after.st_ino == null_before.st_ino);
}

// An import gives a mesh another name where its own is taken: nothing that was there changes.
void check_evades(const Inputs& in, const Case& c, const std::string& folder,
                  const std::string& out) {
  for (const bool force : {false, true}) {
    const auto before = state_of(folder), inputs_before = state_of(in.folder / "");
    const Outcome outcome = attempt(in, c, out, force);
    INFO(outcome.out << outcome.err);
    const auto after = state_of(folder);
    CHECK(std::includes(after.begin(), after.end(), before.begin(), before.end()));
    CHECK(state_of(in.folder / "") == inputs_before);
  }
}

// The first argument of what `--help` says an option takes; empty: a flag.
std::string type_in_help(const std::string& line, const std::string& option) {
  const std::string rest = line.substr(line.find(option) + option.size());
  if (rest.rfind("  ", 0) == 0 || rest.size() < 2) return {};
  if (rest[1] == '[') return rest.substr(1, rest.find(']'));
  return rest.substr(1, rest.find_first_of(" :=[", 1) - 1);
}

}  // namespace

TEST_CASE("every option that names a file is in the next test", "[cli][output]") {
  // The other options take no file.
  const std::set<std::string> no_files = {"",
                                          "T",
                                          "N",
                                          "N/OF",
                                          "DT",
                                          "NAME",
                                          "B",
                                          "X|max",
                                          "A,B",
                                          "X",
                                          "K",
                                          "TEXT",
                                          "SIGNAL",
                                          "COLUMN",
                                          "F",
                                          "CAMERA|VIEW",
                                          "LIST",
                                          "LIST|lacking",
                                          "LANGUAGE",
                                          "SIZE",
                                          "1..5|1,3",
                                          "text|json",
                                          "PIXELS",
                                          "X,Y,X,Y",
                                          "NAME,...",
                                          "WHAT,...",
                                          "WxH",
                                          "ADDRESS",
                                          "WORKING.policy.yaml",
                                          // Lies above the robot that it names: tests/policy.
                                          "NAME.policy.yaml",
                                          "KEY=VALUE",
                                          "MB",
                                          "STORE",
                                          "V",
                                          "URL",
                                          "S",
                                          "Excludes",
                                          "process|none",
                                          "urdf|sdf|mjcf",
                                          "SEEDS",
                                          "none|position|torque|velocity",
                                          "auto|always|never",
                                          "KEY"};
  // --copy-meshes takes the name of a folder beside the scene: tests/import.
  const std::set<std::string> inputs = {"--plugin-path", "--from", "--include", "--srdf",
                                        "--copy-meshes", "--merge",
                                        "--robot",       "--network",     "--inputs"};
  std::set<std::string> tried;
  for (const Case& c : cases()) tried.insert(c.arguments[0] + " " + c.option);
  std::size_t outputs = 0;
  for (const std::string& command : listed_commands()) {
    std::istringstream help(cogrsim_run({command, "--help"}).out);
    for (std::string line; std::getline(help, line);) {
      if (line.rfind("  -", 0) != 0) continue;
      const std::string option = line.substr(2, line.find(' ', 2) - 2);
      const std::string type = type_in_help(line, option);
      if (command == "list" && option == "--json") continue;  // it takes a server: tests/share
      if (no_files.count(type) == 1 || inputs.count(option) == 1) continue;
      INFO("write an entry for 'cogrsim " << command << " " << option << "', which takes a '"
                                          << type << "'");
      CHECK(tried.count((option == "--output-dir" ? "run" : command) + (" " + option)) == 1);
      ++outputs;
    }
  }
  CHECK(outputs > 15);
}

TEST_CASE("no command replaces an input, a device, a link, a folder or a foreign file",
          "[cli][output]") {
  const Inputs in;
  const std::set<std::string> there = listed_commands();
  for (const Case& c : cases()) {
    if (there.count(c.arguments[0]) == 0) continue;  // built without the studio, or without sharing
    INFO(c.arguments[0] << " " << c.option << " of " << c.arguments[1] << ", " << c.ending);
    const auto name_out = [&](const TemporaryFolder& folder) {
      const std::string out = folder / (is_folder(c) ? "out" : std::string("out") + c.ending);
      if (is_folder(c)) fs::create_directory(out);
      return out;
    };
    // Its outputs.
    std::vector<std::string> files;
    int good = 0;
    {
      const TemporaryFolder folder;
      const std::string out = name_out(folder);
      const Outcome fresh = attempt(in, c, out, false);
      INFO(fresh.out << fresh.err);
      good = fresh.status;
      REQUIRE(good == (c.arguments[0] == "test" ? 1 : 0));
      for (const auto& entry : fs::recursive_directory_iterator(is_folder(c) ? out : folder / "")) {
        if (!entry.is_directory()) files.push_back(entry.path().lexically_relative(folder / ""));
      }
      CHECK_FALSE(files.empty());
      CHECK((attempt(in, c, out, false).status == good) == c.again);
    }
    for (const std::string& file : files) {
      for (const Obstacle& obstacle : obstacles()) {
        for (const bool force : {false, true}) {
          if (force && c.force[0] == '\0') continue;
          // A folder takes the package in.
          if (c.arguments[0] == "push" && !is_folder(c) && obstacle.what == kFolder) continue;
          INFO(obstacle.what << " in place of " << file);
          const TemporaryFolder folder;
          const std::string out = name_out(folder);
          fs::create_directories(fs::path(folder / file).parent_path());
          obstacle.put(folder / file);
          if (evades(c, file)) {
            if (!force) check_evades(in, c, folder / "", out);
            continue;
          }
          // The table of a study grows, and is never replaced.
          const bool foreign = &obstacle == &obstacles().front() && file != "out/results.sqlite";
          if (!force || !foreign) {
            check_refuses(in, c, folder / "", out, force);
            continue;
          }
          const Outcome forced = attempt(in, c, out, true);
          INFO(forced.err);
          CHECK(forced.status == good);
          CHECK(read_file(folder / file) != "mine\n");
        }
      }
      for (const auto& [argument, input] : in.read_for_argument()) {
        if (std::count(c.arguments.begin(), c.arguments.end(), argument) == 0) continue;
        INFO("its " << argument << " " << input << " in place of " << file);
        const TemporaryFolder folder;
        const std::string out = name_out(folder);
        fs::create_directories(fs::path(folder / file).parent_path());
        fs::create_hard_link(input, folder / file);
        if (evades(c, file))
          check_evades(in, c, folder / "", out);
        else
          check_refuses(in, c, folder / "", out, true);
        if (!is_folder(c)) check_refuses(in, c, folder / "", input, true);
      }
    }
    const TemporaryFolder folder;
    check_refuses(in, c, folder / "", "/dev/null", true);
    if (!is_folder(c)) continue;
    for (const Obstacle& obstacle : obstacles()) {
      INFO(obstacle.what << " in place of the folder");
      if (obstacle.what == kFolder) continue;
      // Where there is no folder, push is named the file itself.
      if (c.arguments[0] == "push" && &obstacle == &obstacles().front()) continue;
      const TemporaryFolder target;
      obstacle.put(target / "out");
      check_refuses(in, c, target / "", target / "out", true);
    }
  }
}

TEST_CASE("extracting a scene spares the one that was edited", "[cli][output]") {
  const Inputs in;
  put(in.scene, read_file(in.scene) + "<!-- edited -->\n");
  const std::string edited = read_file(in.scene);
  const std::string folder = fs::path(in.scene).parent_path();
  const Outcome refused = cogrsim_run({"info", in.run, "--extract", folder});
  CHECK(refused.status == 1);
  CHECK(read_file(in.scene) == edited);
  CHECK(cogrsim_run({"info", in.run, "--extract", in.folder / "new"}).status == 0);
  CHECK(cogrsim_run({"info", in.run, "--extract", in.folder / "new"}).status == 0);  // the same
  CHECK(cogrsim_run({"info", in.run, "--extract", folder, "--overwrite"}).status == 0);
  CHECK(read_file(in.scene) != edited);
}

TEST_CASE("outputs that a scene names stay in its folder", "[cli][output]") {
  const TemporaryFolder folder;
  const std::string inner = folder / "scene";
  fs::create_directory(inner);
  fs::create_directory(folder / "elsewhere");
  fs::create_directory_symlink(folder / "elsewhere", inner + "/link");
  put(folder / "elsewhere/taken.mcap", "mine\n");
  fs::create_symlink(folder / "elsewhere/taken.mcap", inner + "/link.mcap");
  REQUIRE(mkfifo((inner + "/pipe.mcap").c_str(), 0600) == 0);
  put(inner + "/notes.mcap", "mine\n");
  const auto with_record = [&](const std::string& file) {
    std::string text = read_file(kFlight);
    text.insert(text.rfind("</scene>"), "<record file=\"" + file + "\"/>\n");
    put(inner + "/a.scene.xml", text);
    return with_toys({"run", inner + "/a.scene.xml", "-b", "toy", "-d", "0.1"});
  };
  for (const std::string& file :
       {std::string("../x.mcap"), folder / "x.mcap", std::string("link/x.mcap"),
        std::string("link.mcap"), std::string("pipe.mcap"), std::string("notes.mcap"),
        std::string("/dev/null"), std::string("x.sh"), std::string("a.scene.xml"),
        std::string(".bashrc"), std::string("none/../../x.mcap")}) {
    INFO(file);
    const Outcome refused = with_record(file);
    CHECK(refused.status == 1);
    CHECK_THAT(refused.err, Contains("error"));
    CHECK(read_file(inner + "/notes.mcap") == "mine\n");
    CHECK(read_file(folder / "elsewhere/taken.mcap") == "mine\n");
    CHECK_FALSE(fs::exists(folder / "x.mcap"));
    CHECK_FALSE(fs::exists(folder / "elsewhere/x.mcap"));
    CHECK_FALSE(fs::exists(inner + "/x.sh"));
  }
  const Outcome good = with_record("b.mcap");
  INFO(good.err);
  CHECK(good.status == 0);
  CHECK(fs::is_regular_file(inner + "/b.mcap"));
  Arguments arguments = {"run",          inner + "/a.scene.xml", "-b", "toy", "-d", "0.1",
                         "--output-dir", folder / "elsewhere"};
  CHECK(with_toys(arguments).status == 0);
  CHECK(fs::is_regular_file(folder / "elsewhere/b.mcap"));
}

TEST_CASE("an import copies meshes into a folder beside its scene only", "[cli][output]") {
  const TemporaryFolder folder;
  put(folder / "a.urdf", R"(<robot name="a"><link name="base"><visual><geometry>
<mesh filename="a.obj"/></geometry></visual></link></robot>)");
  put(folder / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const auto into = [&](const std::string& name) {
    return cogrsim_run({"import", folder / "a.urdf", "-o", folder / "scene/a.scene.xml",
                        "--copy-meshes", name, "--overwrite"});
  };
  fs::create_directory(folder / "scene");
  for (const char* name : {"..", "../outside", "/tmp", "a/../../outside"}) {
    INFO(name);
    const Outcome refused = into(name);
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err, Contains("is not a folder beside the scene"));
  }
  CHECK(fs::is_empty(folder / "scene"));
  CHECK(into("shapes").status == 0);
  CHECK(fs::exists(folder / "scene/shapes/a.obj"));
  CHECK_FALSE(fs::exists(folder / "outside"));
}

TEST_CASE("an import writes through no link and opens no pipe", "[cli][output]") {
  TemporaryFolder folder;
  const std::string robot = folder.write("robot/a.urdf",
                                         "<robot name='a'><link name='l'><visual><geometry><mesh "
                                         "filename='m.stl'/></geometry></visual></link></robot>");
  folder.write("robot/m.stl",
               "solid m\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\nendsolid m\n");
  fs::create_directories(folder.path / "other");
  fs::create_directories(folder.path / "link");
  fs::create_directories(folder.path / "pipe/meshes");
  fs::create_directory_symlink(folder.path / "other", folder.path / "link/meshes");
  REQUIRE(::mkfifo((folder / "pipe/meshes/m.stl").c_str(), 0600) == 0);
  REQUIRE(::mkfifo((folder / "pair.srdf").c_str(), 0600) == 0);
  const Outcome linked = cogrsim_run({"import", robot, "-o", folder / "link/a.scene.xml"});
  CHECK(linked.status != 0);
  CHECK_THAT(linked.err, Contains("a link leads out of the folder"));
  CHECK(fs::is_empty(folder.path / "other"));
  const Outcome piped = cogrsim_run({"import", robot, "-o", folder / "pipe/a.scene.xml"});
  // It is no copy of the mesh, which gets another name.
  CHECK(piped.status == 0);
  CHECK(fs::is_fifo(folder.path / "pipe/meshes/m.stl"));
  CHECK(fs::is_regular_file(folder.path / "pipe/meshes/m_2.stl"));
  const Outcome pairs = cogrsim_run({"import", robot, "--srdf", folder / "pair.srdf"});
  CHECK(pairs.status != 0);
  CHECK_THAT(pairs.err, Contains("not a regular file"));
}

TEST_CASE("an import parts links that start inside each other, and knows who runs it", "[cli]") {
  const TemporaryFolder folder;
  const auto link = [](const std::string& name, const std::string& shape) {
    return "<link name=\"" + name + R"("><inertial><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>)" +
           shape + "</link>\n";
  };
  const auto box = [](const std::string& edge) {
    return "<collision><geometry><box size=\"" + edge + ' ' + edge + ' ' + edge +
           "\"/></geometry></collision>";
  };
  // A range of 5 rad, which engines that measure angles within one turn may refuse.
  const std::string hinge = R"(<axis xyz="0 1 0"/><limit lower="-1" upper="4" effort="9"
velocity="9"/></joint>)";
  put(folder / "a.urdf", "<robot name=\"a\">" + link("base", box("0.2")) + link("upper", "") +
                             link("fore", box("0.1")) + R"(
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>)" +
                             hinge + R"(
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
<origin xyz="0.1 0 0"/>)" + hinge +
                             "</robot>");
  const std::string scene = folder / "a.scene.xml";
  const Outcome made = cogrsim_run({"import", folder / "a.urdf", "-o", scene});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.err, Contains("links 'base' and 'fore': start 50 mm inside each other"));
  CHECK_THAT(read_file(scene), Contains(R"(<collide between="base fore" with="false"/>)"));
  CHECK_THAT(cogrsim_run({"check", scene}).out, !Contains("CG2001"));

  // A pair that the model itself asks for comes after the prototype: so does what parts it.
  put(folder / "b.xml", R"(<mujoco><default><geom contype="0" conaffinity="0"/></default><worldbody>
<body name="a"><freejoint/><geom name="ga" size="0.1"/>
<body name="b" pos="0.3 0 0"><joint axis="0 1 0"/><geom size="0.01"/>
<body name="c" pos="-0.2 0 0"><joint axis="0 1 0"/><geom name="gc" size="0.1"/></body></body></body>
</worldbody><contact><pair geom1="ga" geom2="gc"/></contact></mujoco>)");
  const std::string asked = folder / "b.scene.xml";
  CHECK_THAT(cogrsim_run({"import", folder / "b.xml", "-o", asked}).err,
             Contains("links 'a' and 'c': start 100 mm inside each other"));
  CHECK_THAT(cogrsim_run({"check", asked}).out, !Contains("CG2001"));

  std::istringstream lines(made.err);
  std::size_t engines = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool runs = line.find(" runs it") != std::string::npos;
    if (!runs && line.find(" does not run it: ") == std::string::npos) continue;
    ++engines;
    std::string engine;
    std::istringstream(line) >> engine;
    INFO(line);
    CHECK(cogrsim_run({"run", scene, "-b", engine, "-d", "0.01"}).status == (runs ? 0 : 1));
  }
  CHECK(engines > 0);
}

TEST_CASE("a run leaves out what its engine lacks, on request and said in its head", "[cli]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "a.scene.xml", json = folder / "a.json";
  // The toys have no friction of rolling.
  put(scene, R"(<scene name="a" version="1"><physics step="1 ms" duration="0.01 s"/>
  <sphere name="ball" radius="5 cm" mass="1 kg" rolling-friction="1 mm"/>
  <test name="starts"><expect that="ball.x" equals="0 m" tolerance="1 mm"/></test></scene>)");
  const Outcome refused = with_toys({"run", scene, "-b", "toy"});
  CHECK(refused.status == 1);
  CHECK_THAT(refused.err, Contains("--without contact.rolling-friction leaves it out of a run"));
  const std::string left_out = "contact.rolling-friction (1 material)";
  const std::string what = "contact.rolling-friction";
  for (const std::string& without : {std::string("lacking"), what}) {
    INFO(without);
    const Outcome run =
        with_toys({"run", scene, "-b", "toy", "--without", without, "--json", json});
    CHECK(run.status == 0);
    CHECK_THAT(run.out, Contains("left out  " + left_out));
    CHECK_THAT(read_file(json), Contains(R"("feature": ")" + what));
  }
  const Outcome compared =
      with_toys({"compare", scene, "-b", "toy,cogrsim", "--without", "lacking", "--json", json});
  CHECK(compared.status == 0);
  const std::string& out = compared.out;
  REQUIRE(out.find(left_out) != std::string::npos);
  CHECK(out.find(left_out) == out.rfind(left_out));  // the other engine has it
  const Outcome tested = with_toys({"test", scene, "--backends", "toy", "--without", "lacking"});
  CHECK_THAT(tested.out, Contains("toy without " + left_out));
  CHECK(tested.status == 0);
  Arguments sweep = {"sweep", scene, "-b", "toy", "-o", folder / "study", "--without", "lacking"};
  const Outcome swept = with_toys(sweep);
  CHECK(swept.status == 0);
  CHECK_THAT(swept.out, Contains("toy without " + left_out));
  sweep.back() = "couplings";
  CHECK_THAT(with_toys(sweep).err, Contains("is of another study: without was"));
  CHECK(with_toys({"check", scene, "-b", "toy", "--without", "lacking"}).status == 0);
  const Outcome wrong = with_toys({"run", scene, "--without", "lacking,coupling"});
  CHECK(wrong.status == 2);
  CHECK_THAT(wrong.err, Contains("did you mean 'couplings'?"));
}

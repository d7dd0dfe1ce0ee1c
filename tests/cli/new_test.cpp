// cogrsim new: names, folders, and what is written. That the projects build and pass their tests is
// shown by tests/package.
#include <sys/stat.h>
#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "../support/skip.h"
#include "new/new_names.h"
#include "process.h"

using Catch::Contains;
using cogrsim::PluginKind;
using namespace cogrsim::cli;

namespace {

namespace fs = std::filesystem;

Outcome make(const TemporaryFolder& into, const std::string& kind, const std::string& name) {
  return cogrsim_run({"new", kind, name, "--into", into / ""});
}

}  // namespace

TEST_CASE("names of plugins that can be had", "[cli][new]") {
  for (const char* name : {"a", "wall_follower", "x2", "my__robot_", "newer", "tests", "classy"}) {
    INFO(name);
    CHECK(check_plugin_name(PluginKind::controller, name));
  }
  const std::string longest(kLongestPluginName, 'a');
  CHECK(check_plugin_name(PluginKind::controller, longest));
  for (const std::string name :
       {"", "Robot", "my-robot", "2x", "_x", "a b", "a/b", "../a", "class", "co_await", "test",
        "install", "all", "a.b", "r\303\266bi", "-x", "a\nb"}) {
    INFO(name);
    const auto good = check_plugin_name(PluginKind::controller, name);
    REQUIRE_FALSE(good);
    CHECK_FALSE(good.error().hint.empty());
  }
  CHECK_FALSE(check_plugin_name(PluginKind::controller, longest + "a"));
  // A sensor of the SDK would be used instead; an engine's options are in an element of its name.
  CHECK_FALSE(check_plugin_name(PluginKind::sensor, "lidar"));
  CHECK(check_plugin_name(PluginKind::controller, "lidar"));
  CHECK_FALSE(check_plugin_name(PluginKind::backend, "sphere"));
  CHECK(check_plugin_name(PluginKind::sensor, "sphere"));
}

TEST_CASE("a name that cannot be had suggests one that can", "[cli][new]") {
  CHECK(suggested_name("MyRobot") == "my_robot");
  CHECK(suggested_name("my-robot") == "my_robot");
  CHECK(suggested_name("IRSensor2 front") == "ir_sensor2_front");
  CHECK(suggested_name("2wheels") == "wheels");
  CHECK(suggested_name("../x/") == "x");
  CHECK(suggested_name("--").empty());
  const auto bad = check_plugin_name(PluginKind::controller, "WallFollower");
  REQUIRE_FALSE(bad);
  CHECK_THAT(bad.error().text(), Contains("'wall_follower' would do"));
}

TEST_CASE("classes are called after plugins", "[cli][new]") {
  CHECK(class_name("wall_follower") == "WallFollower");
  CHECK(class_name("x") == "X");
  CHECK(class_name("my__robot_2_") == "MyRobot2");
  CHECK(class_name("n_a_n") == "NANPlugin");
}

TEST_CASE("every kind is made whole, with nothing left to fill in", "[cli][new]") {
  const TemporaryFolder into;
  for (const std::string kind : {"controller", "supervisor", "sensor", "backend"}) {
    INFO(kind);
    const std::string name = "my_" + kind;
    const Outcome made = make(into, kind, name);
    INFO(made.err);
    REQUIRE(made.status == 0);
    CHECK(made.err.empty());
    CHECK_THAT(made.out, Contains("cmake -B build -DCMAKE_PREFIX_PATH=/") && Contains("ctest"));
    for (const char* file : {"/CMakeLists.txt", "/README.md", "/.gitignore"}) {
      CHECK(fs::exists((into / name) + file));
    }
    CHECK(fs::exists((into / name) + "/" + name + ".scene.xml"));
    int files = 0;
    for (const auto& entry : fs::directory_iterator(into / name)) {
      INFO(entry.path().string());
      const std::string text = read_file(entry.path().string());
      CHECK_FALSE(text.empty());
      CHECK(text.find('@') == std::string::npos);
      CHECK(entry.path().string().find('@') == std::string::npos);
      // As the others of the user's files.
      struct stat info {};
      REQUIRE(stat(entry.path().c_str(), &info) == 0);
      CHECK((info.st_mode & S_IRUSR) != 0);
      ++files;
    }
    CHECK(files >= 6);
    CHECK_THAT(read_file((into / name) + "/README.md"), Contains("# " + name + "\n"));
  }
  // Only the four folders, no drafts.
  CHECK(into.files().size() == 4);
}

TEST_CASE("a backend in another language is made whole, and flies", "[cli][new]") {
  const TemporaryFolder into;
  for (const auto& [language, program] :
       {std::pair<std::string, std::string>{"js", "node"}, {"python", "python3"}}) {
    INFO(language);
    const std::string name = "my_" + language, folder = into / name;
    const Outcome made =
        cogrsim_run({"new", "backend", name, "--language", language, "--into", into / ""});
    INFO(made.err);
    REQUIRE(made.status == 0);
    CHECK_THAT(made.out, Contains("test " + name + ".scene.xml --backends " + name + " "));
    for (const char* file : {"/backend.json", "/README.md", "/.gitignore", "/expectations.json"})
      CHECK(fs::exists(folder + file));
    CHECK_FALSE(fs::exists(folder + "/CMakeLists.txt"));  // nothing is built
    for (const auto& entry : fs::directory_iterator(folder)) {
      INFO(entry.path().string());
      CHECK(read_file(entry.path().string()).find("@NAME@") == std::string::npos);
    }
    if (std::system((program + " --version > /dev/null 2>&1").c_str()) != 0) continue;
    const Outcome flown = cogrsim_run(
        {"test", folder + "/" + name + ".scene.xml", "--backends", name, "--plugin-path", folder});
    INFO(flown.err);
    CHECK(flown.status == 0);
  }
  const Outcome wrong =
      cogrsim_run({"new", "backend", "x", "--language", "cobol", "--into", into / ""});
  CHECK(wrong.status == 2);
  CHECK_THAT(wrong.err, Contains("there are c++, js and python"));
  CHECK(cogrsim_run({"new", "sensor", "x", "--language", "js", "--into", into / ""}).status == 2);
}

TEST_CASE("new replaces no file and no full folder", "[cli][new]") {
  const TemporaryFolder into;
  fs::create_directory(into / "full");
  std::ofstream(into / "full/notes.txt") << "mine";
  std::ofstream(into / "file") << "mine";
  fs::create_directory(into / "empty");
  fs::create_symlink("nowhere", into / "link");
  const Outcome full = make(into, "sensor", "full");
  CHECK(full.status == 1);
  CHECK_THAT(full.err, Contains("full' is there already") && Contains("--into"));
  CHECK(read_file(into / "full/notes.txt") == "mine");
  CHECK(fs::directory_iterator(into / "full") != fs::directory_iterator());
  CHECK(make(into, "sensor", "file").status == 1);
  CHECK(read_file(into / "file") == "mine");
  CHECK(make(into, "sensor", "link").status == 1);
  CHECK(fs::is_symlink(into / "link"));
  CHECK(make(into, "sensor", "empty").status == 0);
  CHECK(fs::exists(into / "empty/README.md"));
  // A folder that is not there yet is made.
  CHECK(cogrsim_run({"new", "sensor", "deep", "--into", into / "a/b"}).status == 0);
  CHECK(fs::exists(into / "a/b/deep/README.md"));
}

TEST_CASE("new names the folder that cannot be written", "[cli][new]") {
  const Outcome nowhere = cogrsim_run({"new", "sensor", "x", "--into", "/proc/nowhere"});
  CHECK(nowhere.status == 1);
  CHECK_THAT(nowhere.err, Contains("cannot make the folder '/proc/nowhere/x'"));
  const TemporaryFolder into;
  std::ofstream(into / "file") << "mine";
  const Outcome below_file = cogrsim_run({"new", "sensor", "x", "--into", into / "file"});
  CHECK(below_file.status == 1);
  CHECK_THAT(below_file.err, Contains("cannot make"));
}

TEST_CASE("new reports a read-only folder", "[cli][new]") {
  const TemporaryFolder into;
  const auto make_as_nobody = [&](const char* name) {
    return cogrsim_run_unprivileged({"new", "sensor", name, "--into", into / ""});
  };
  fs::permissions(into.path, fs::perms(0777));
  const Outcome free = make_as_nobody("free");
  if (free.status == 127) COGRSIM_SKIP("the user nobody cannot reach " COGRSIM_PROGRAM);
  CHECK(free.status == 0);
  fs::permissions(into.path, fs::perms(0555));
  const Outcome closed = make_as_nobody("closed");
  CHECK(closed.status == 1);
  CHECK_THAT(closed.err,
             Contains("cannot make the folder '" + into / "closed'") && Contains("ermission"));
  CHECK_FALSE(fs::exists(into / "closed"));
}

TEST_CASE("new explains itself", "[cli][new]") {
  const Outcome nothing = cogrsim_run({"new"});
  CHECK(nothing.status == 2);
  CHECK_THAT(nothing.err, Contains("controller") && Contains("supervisor") && Contains("sensor") &&
                              Contains("backend") && Contains("cogrsim new controller"));
  const Outcome kind = cogrsim_run({"new", "controler", "x"});
  CHECK(kind.status == 2);
  CHECK_THAT(kind.err, Contains("did you mean 'controller'?"));
  const Outcome name = cogrsim_run({"new", "sensor"});
  CHECK(name.status == 2);
  CHECK_THAT(name.err, Contains("needs a name"));
  const Outcome path = cogrsim_run({"new", "sensor", "a/b"});
  CHECK(path.status == 2);
  CHECK_THAT(path.err, Contains("--into"));
  const Outcome list = cogrsim_run({"new", "--list"});
  CHECK(list.status == 0);
  CHECK(list.err.empty());
  CHECK_THAT(list.out, Contains("controller") && Contains("backend"));
  const Outcome help = cogrsim_run({"new", "--help"});
  CHECK(help.status == 0);
  CHECK_THAT(help.out, Contains("Examples:") && Contains("cogrsim new controller"));
}

TEST_CASE("a plugin of the same name is reported", "[cli][new]") {
  const TemporaryFolder into;
  const Outcome made =
      cogrsim_run({"new", "controller", "toy", "--into", into / "", "--plugin-path", COGRSIM_TOYS});
  CHECK(made.status == 0);
  CHECK_THAT(made.err, Contains("there is a plugin 'toy' already") && Contains("toy.so"));
}

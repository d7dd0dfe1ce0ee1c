// Every command pointed at what it must not replace: docs/security.md. And what a scene may write.
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "process.h"

using Catch::Contains;

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

const std::string kFlight = std::string(COGRSIM_SCENES) + "/flight.scene.xml";

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

Outcome with_toys(Words words, double interrupt_after = 0.0) {
  words.insert(words.end(), {"--plugin-path", COGRSIM_TOYS});
  return cogrsim_run(words, interrupt_after);
}

// A folder with one of each: a scene, a recording, a figure, a study's table.
struct Inputs {
  TemporaryFolder folder;
  std::string scene = folder / "a.scene.xml", run = folder / "run.mcap",
              figure = folder / "figure.json", snap = folder / "a.snap";

  Inputs() {
    fs::copy_file(kFlight, scene);
    REQUIRE(with_toys(
                {"run", scene, "-b", "toy", "-d", "0.2", "--record", run, "--save-at", "0.1", snap})
                .status == 0);
    REQUIRE(cogrsim_run({"plot", run, "--y", "ball.z", "-o", figure}).status == 0);
  }
};

struct Case {
  const char* name;
  const char* ending;  // of the output
  const char* input;   // which member OUT may name, too
  Words words;         // SCENE, RUN, FIGURE, SNAP, OUT stand for files
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"run --json", ".json", "SCENE", {"run", "SCENE", "-b", "toy", "-d", "0.1", "--json", "OUT"}},
      {"run --record",
       ".mcap",
       "SCENE",
       {"run", "SCENE", "-b", "toy", "-d", "0.1", "--record", "OUT"}},
      {"run --save-at",
       ".snap",
       "SCENE",
       {"run", "SCENE", "-b", "toy", "-d", "0.1", "--save-at", "0.05", "OUT"}},
      {"run --from --save-at",
       ".snap",
       "SNAP",
       {"run", "SCENE", "-b", "toy", "-d", "0.2", "--from", "SNAP", "--save-at", "0.15", "OUT"}},
      {"compare --json",
       ".json",
       "SCENE",
       {"compare", "SCENE", "-b", "toy,toy_euler", "-d", "0.1", "--json", "OUT"}},
      {"compare --report",
       ".html",
       "SCENE",
       {"compare", "SCENE", "-b", "toy,toy_euler", "-d", "0.1", "--report", "OUT"}},
      {"replay --json", ".json", "RUN", {"replay", "RUN", "--json", "OUT"}},
      {"plot", ".json", "RUN", {"plot", "RUN", "--y", "ball.z", "-o", "OUT"}},
      {"plot of a figure", ".json", "FIGURE", {"plot", "FIGURE", "-o", "OUT"}},
      {"map", ".svg", "RUN", {"map", "RUN", "-o", "OUT"}},
      {"render", ".png", "RUN", {"render", "RUN", "-o", "OUT"}},
  };
  return all;
}

Outcome attempt(const Inputs& in, const Case& c, const std::string& out) {
  Words words = c.words;
  for (std::string& word : words) {
    if (word == "SCENE") word = in.scene;
    if (word == "RUN") word = in.run;
    if (word == "FIGURE") word = in.figure;
    if (word == "SNAP") word = in.snap;
    if (word == "OUT") word = out;
  }
  const std::string& command = words.front();
  if (command == "plot" || command == "map") return cogrsim_run(words);
  return with_toys(words);
}

}  // namespace

TEST_CASE("no command replaces an input, a device, a link, a folder or a foreign file",
          "[cli][output]") {
  const Inputs in;
  for (const Case& c : cases()) {
    INFO(c.name);
    const std::string base = in.folder / (std::string("out") + std::to_string(&c - cases().data()));
    const std::string good = base + c.ending;
    {
      const Outcome fresh = attempt(in, c, good);
      INFO(fresh.err);
      REQUIRE(fresh.status == 0);
      CHECK(fs::file_size(good) > 0);
      const Outcome again = attempt(in, c, good);
      INFO(again.err);
      CHECK(again.status == 0);
    }
    const std::string input = std::string(c.input) == "SCENE"    ? in.scene
                              : std::string(c.input) == "RUN"    ? in.run
                              : std::string(c.input) == "FIGURE" ? in.figure
                                                                 : in.snap;
    const std::string foreign = base + "f" + c.ending, link = base + "l" + c.ending,
                      folder = base + "d" + c.ending, pipe = base + "p" + c.ending,
                      hard = base + "h" + c.ending;
    put(foreign, "mine\n");
    fs::create_symlink(foreign, link);
    fs::create_directory(folder);
    fs::create_hard_link(input, hard);
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    const std::string before = read_file(input);
    std::vector<std::string> targets = {link, folder, pipe, hard, "/dev/null"};
    for (const bool overwrite : {false, true}) {
      Case asked = c;
      if (overwrite) asked.words.push_back("--overwrite");
      if (!overwrite) {
        const Outcome refused = attempt(in, asked, foreign);
        INFO(refused.err);
        CHECK(refused.status != 0);
        CHECK(read_file(foreign) == "mine\n");
      }
      for (const std::string& target : targets) {
        // The names of pictures and recordings say what they are.
        if (target == "/dev/null" &&
            (c.words[0] == "plot" || c.words[0] == "map" || c.words[0] == "render"))
          continue;
        INFO(target << (overwrite ? " with --overwrite" : ""));
        const Outcome refused = attempt(in, asked, target);
        CHECK(refused.status != 0);
        CHECK_THAT(refused.err, Contains("error:"));
      }
    }
    CHECK(read_file(input) == before);
    CHECK(fs::is_symlink(link));
    CHECK(fs::is_fifo(pipe));
    CHECK(fs::is_empty(folder));
    CHECK(fs::is_character_file("/dev/null"));
    Case asked = c;
    asked.words.push_back("--overwrite");
    CHECK(attempt(in, asked, foreign).status == 0);
    CHECK(read_file(foreign) != "mine\n");
  }
}

TEST_CASE("a picture spares the tables and results beside it", "[cli][output]") {
  const Inputs in;
  for (const char* name : {"speed.csv", "speed.json", "speed.gp"}) {
    const std::string path = in.folder / name;
    put(path, "mine\n");
    const Outcome refused =
        cogrsim_run({"plot", in.run, "--y", "ball.z", "-o", in.folder / "speed.png"});
    INFO(name << "\n" << refused.err);
    CHECK(refused.status == 1);
    CHECK(read_file(path) == "mine\n");
    CHECK_FALSE(fs::exists(in.folder / "speed.png"));
    fs::remove(path);
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

TEST_CASE("a sweep spares a foreign table", "[cli][output]") {
  const Inputs in;
  const std::string study = in.folder / "study";
  fs::create_directory(study);
  for (const char* name : {"results.csv", "results.sqlite"}) {
    const std::string path = study + "/" + name;
    put(path, "mine\n");
    const Outcome refused =
        with_toys({"sweep", in.scene, "--seeds", "1..2", "--backends", "toy", "-o", study});
    INFO(refused.err);
    CHECK(refused.status != 0);
    CHECK(read_file(path) == "mine\n");
    fs::remove(path);
  }
}

TEST_CASE("what a scene names for writing stays in its folder", "[cli][output]") {
  const TemporaryFolder folder;
  const std::string inner = folder / "scene";
  fs::create_directory(inner);
  fs::create_directory(folder / "elsewhere");
  fs::create_directory_symlink(folder / "elsewhere", inner + "/way");
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
       {std::string("../x.mcap"), folder / "x.mcap", std::string("way/x.mcap"),
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
  Words words = {"run",          inner + "/a.scene.xml", "-b", "toy", "-d", "0.1",
                 "--output-dir", folder / "elsewhere"};
  CHECK(with_toys(words).status == 0);
  CHECK(fs::is_regular_file(folder / "elsewhere/b.mcap"));
}

TEST_CASE("an interrupted replay leaves what was there, and ends by the signal", "[cli][output]") {
  const TemporaryFolder folder;
  REQUIRE(with_toys({"run", kFlight, "-b", "toy", "-d", "60", "--record", folder / "long.mcap"})
              .status == 0);
  REQUIRE(cogrsim_run({"replay", folder / "long.mcap", "--at", "0", "--json", folder / "a.json"})
              .status == 0);
  const std::string before = read_file(folder / "a.json");
  const Outcome cut =
      cogrsim_run({"replay", folder / "long.mcap", "--json", folder / "a.json"}, 0.3);
  // A fast machine is through before.
  if (cut.status != 0) {
    CHECK(cut.status == 128 + SIGINT);
    CHECK(read_file(folder / "a.json") == before);
  }
  CHECK(folder.files().size() == 2);
}

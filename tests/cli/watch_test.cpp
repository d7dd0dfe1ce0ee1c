// cogrsim run --watch: what restarts a run, what is printed, and how it ends.
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "process.h"
#include "watch/watch_files.h"

using Catch::Contains;
using cogrsim::cli::WatchedFiles;

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Long enough for a busy machine; nothing waits for it unless something is wrong.
constexpr double kPatience = 60.0;  // [s]

// A program that runs until it is asked to end; both its streams come in one text.
class Running {
 public:
  explicit Running(std::vector<std::string> args) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    std::vector<char*> arguments = {const_cast<char*>(COGRSIM_PROGRAM)};
    for (std::string& arg : args) arguments.push_back(arg.data());
    arguments.push_back(nullptr);
    child_ = fork();
    if (child_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      execv(COGRSIM_PROGRAM, arguments.data());
      _exit(127);
    }
    close(ends[1]);
    pipe_ = ends[0];
  }
  ~Running() {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
    close(pipe_);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  // Reads until `text` has come, behind the text of the previous call.
  bool says(const std::string& text) {
    const auto deadline = Clock::now() + std::chrono::duration<double>(kPatience);
    for (;;) {
      const std::size_t at = said_.find(text, seen_);
      if (at != std::string::npos) {
        seen_ = at + text.size();
        return true;
      }
      pollfd wait{pipe_, POLLIN, 0};
      if (poll(&wait, 1, 50) > 0) {
        char buffer[4096];
        const ssize_t count = read(pipe_, buffer, sizeof buffer);
        if (count > 0) said_.append(buffer, static_cast<std::size_t>(count));
        if (count <= 0) return false;
      } else if (Clock::now() > deadline) {
        return false;
      }
    }
  }

  int count(const std::string& text) const {
    int n = 0;
    for (std::size_t at = 0; (at = said_.find(text, at)) != std::string::npos; ++at) ++n;
    return n;
  }

  // Exit status after the signal, when all that hold its pipe have gone; 128 + n: killed by signal n.
  int end(int signal = SIGINT) {
    kill(child_, signal);
    says("there is never such a text");  // to the end of what it says
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  const std::string& said() const { return said_; }
  pid_t pid() const { return child_; }

 private:
  pid_t child_ = -1;
  int pipe_ = -1;
  std::string said_;
  std::size_t seen_ = 0;
};

void write(const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
}

// As editors do that never leave half a file.
void replace(const std::string& path, const std::string& text) {
  write(path + ".new", text);
  fs::rename(path + ".new", path);
}

std::string flight(const std::string& height, const std::string& more = {},
                   const std::string& duration = "0.1 s") {
  return "<scene name=\"flight\" version=\"1\">\n"
         "  <physics backend=\"toy\" step=\"1 ms\" duration=\"" +
         duration +
         "\"/>\n"
         "  <sphere name=\"ball\" radius=\"10 cm\" mass=\"1 kg\" xyz=\"0 0 " +
         height + "\"/>\n" + more + "</scene>\n";
}

std::vector<std::string> watch(const std::string& scene, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"run", scene, "--watch", "--plugin-path", COGRSIM_TOYS};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// Height of the ball at the end of the latest run that was written.
double height_in(const std::string& json) {
  return nlohmann::json::parse(read_file(json))["bodies"]["ball"]["position"][2].get<double>();
}

const char* const kOver = "the run is over; it restarts";
const char* const kFailed = "the run failed; it restarts";
const char* const kRestarting = "changed: restarting";

// A robot whose controller does so, and gets the name of a file.
std::string rascal(const std::string& does, const std::string& notes = "") {
  return "  <assembly name=\"bot\" xyz=\"5 0 9\"><box name=\"box\" size=\"1 1 1\" mass=\"1 kg\"/>"
         "<controller plugin=\"rascal\" rate=\"100 Hz\"><set does=\"" +
         does + "\" notes=\"" + notes + "\"/></controller></assembly>\n";
}

// Printed when a run has begun.
const char* const kTicks = "  <on every=\"10 ms\"><log message=\"it ticks\"/></on>\n";

}  // namespace

TEST_CASE("a changed scene is run again, and Ctrl-C ends", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml", json = folder / "result.json";
  // The result is a file that the scene names, and is rewritten by each run.
  const auto at = [](const char* height) {
    return flight(height, rascal("nothing", "result.json"));
  };
  write(scene, at("10"));
  Running run(watch(scene, {"--json", json}));
  REQUIRE(run.says(kOver));
  // It fell for 0.1 s: 4.9 cm.
  CHECK(height_in(json) == Approx(10.0 - 0.5 * 9.81 * 0.01));
  // What changes by itself would be named, alone or beside the scene: it is not a reason for a run.
  const std::string restarting = "watch: " + scene + " changed: restarting";
  write(scene, at("20"));
  REQUIRE(run.says(restarting));
  REQUIRE(run.says(kOver));
  CHECK(height_in(json) == Approx(20.0 - 0.5 * 9.81 * 0.01));
  replace(scene, at("30"));
  REQUIRE(run.says(restarting));
  REQUIRE(run.says(kOver));
  CHECK(height_in(json) == Approx(30.0 - 0.5 * 9.81 * 0.01));
  CHECK(run.end() == 0);
  CHECK(run.count(kRestarting) == 2);
}

TEST_CASE("a scene with errors is reported, and its change waited for", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml";
  write(scene, flight("10 kg"));
  Running run(watch(scene));
  REQUIRE(run.says("flight.scene.xml:3:"));
  REQUIRE(run.says(kFailed));
  write(scene, "<scene");
  REQUIRE(run.says(kRestarting));
  REQUIRE(run.says(kFailed));
  write(scene, flight("10"));
  REQUIRE(run.says(kRestarting));
  REQUIRE(run.says(kOver));
  write(scene, flight("10 kg"));
  REQUIRE(run.says(kFailed));
  // The latest run's: it failed.
  CHECK(run.end() == 1);
}

TEST_CASE("imports and files that are missing are watched", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml";
  write(scene,
        flight("10",
               "  <import href=\"parts/crate.xml\"/>\n  <instance of=\"Crate\" name=\"c\"/>\n"));
  Running run(watch(scene));
  REQUIRE(run.says("parts/crate.xml"));
  REQUIRE(run.says(kFailed));
  const std::string crate =
      "<scene name=\"parts\" version=\"1\"><prototype name=\"Crate\"><box name=\"box\" "
      "size=\"1 1 1\" mass=\"1 kg\" xyz=\"5 0 9\"/></prototype></scene>\n";
  fs::create_directory(folder / "parts");
  write(folder / "parts/crate.xml", crate);
  REQUIRE(run.says("crate.xml changed"));
  INFO(run.said());
  REQUIRE(run.says(kOver));
  fs::remove(folder / "parts/crate.xml");
  REQUIRE(run.says("crate.xml (gone) changed"));
  REQUIRE(run.says(kFailed));
  CHECK(run.end() == 1);
  CHECK(run.count(kRestarting) == 2);
}

TEST_CASE("a run in progress is ended by a change", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml", json = folder / "result.json";
  write(scene, flight("10", kTicks, "1000 s"));
  Running run(watch(scene, {"--speed", "1", "--json", json}));
  REQUIRE(run.says("it ticks"));
  write(scene, flight("20", kTicks, "1000 s"));
  REQUIRE(run.says(kRestarting));
  // The result of the first run is not needed.
  CHECK(run.count("stopped") == 0);
  CHECK_FALSE(fs::exists(json));
  REQUIRE(run.says("it ticks"));
  // Ctrl-C on the second: the usual end of a run.
  CHECK(run.end() == 0);
  CHECK(run.count("stopped") == 1);
  CHECK(nlohmann::json::parse(read_file(json))["status"] == "stopped");
}

TEST_CASE("a plugin that was rebuilt is loaded again", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml", plugins = folder / "plugins";
  write(scene, flight("10"));
  Running run({"run", scene, "--watch", "--plugin-path", plugins});
  // Not built yet.
  REQUIRE(run.says(kFailed));
  fs::create_directory(plugins);
  fs::copy_file(std::string(COGRSIM_TOYS) + "/toy.so", plugins + "/toy.so");
  REQUIRE(run.says("toy.so"));
  REQUIRE(run.says(kOver));
  // Half of a library: as a linker that was interrupted leaves it.
  const std::string whole = read_file(plugins + "/toy.so");
  replace(plugins + "/toy.so", whole.substr(0, 1000));
  REQUIRE(run.says("toy.so changed"));
  REQUIRE(run.says(kFailed));
  replace(plugins + "/toy.so", whole);
  REQUIRE(run.says("toy.so changed"));
  REQUIRE(run.says(kOver));
  // One that is not in use does not matter: neither it nor the folder is named.
  write(plugins + "/other.so", "x");
  replace(plugins + "/toy.so", whole);
  REQUIRE(run.says("watch: " + plugins + "/toy.so changed: restarting"));
  REQUIRE(run.says(kOver));
  CHECK(run.end() == 0);
  CHECK(run.count(kRestarting) == 4);
}

TEST_CASE("a plugin that crashes or hangs ends no watch", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml";
  write(scene, flight("10", rascal("crash")));
  Running run(watch(scene));
  REQUIRE(run.says("was ended by signal 6"));
  REQUIRE(run.says(kFailed));
  write(scene, flight("10", rascal("hang")));
  REQUIRE(run.says("the plugin hangs"));
  write(scene, flight("10", rascal("nothing")));
  REQUIRE(run.says("was killed"));
  REQUIRE(run.says(kOver));
  CHECK(run.end() == 0);
}

TEST_CASE("watching makes no sense of", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml";
  write(scene, flight("10"));
  const Outcome json = cogrsim_run(watch(scene, {"--json", "-"}));
  CHECK(json.status == 2);
  CHECK_THAT(json.err, Contains("--watch") && Contains("several"));
  const Outcome nothing = cogrsim_run(watch(folder / "nothing.scene.xml"));
  CHECK(nothing.status == 1);
  CHECK_THAT(nothing.err, Contains("cannot watch") && Contains("nothing.scene.xml"));
  REQUIRE(mkfifo((folder / "fifo").c_str(), 0600) == 0);
  const Outcome fifo = cogrsim_run(watch(folder / "fifo"));
  CHECK(fifo.status == 1);
  CHECK_THAT(fifo.err, Contains("not an ordinary file"));
  const Outcome whole_folder = cogrsim_run(watch(folder / ""));
  CHECK(whole_folder.status == 1);
  CHECK_THAT(whole_folder.err, Contains("name the scene file in it"));
}

TEST_CASE("a watch that is killed leaves no run behind", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml";
  write(scene, flight("10", kTicks, "1000 s"));
  Running run(watch(scene, {"--speed", "1"}));
  REQUIRE(run.says("it ticks"));
  // The pipe ends only when the run, which holds it too, has ended.
  CHECK(run.end(SIGKILL) == 128 + SIGKILL);
}

TEST_CASE("the end of a run is noticed whatever started the program", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string scene = folder / "flight.scene.xml";
  write(scene, flight("10"));
  // A child process inherits ignored signals.
  std::signal(SIGCHLD, SIG_IGN);
  Running run(watch(scene));
  std::signal(SIGCHLD, SIG_DFL);
  REQUIRE(run.says(kOver));
  CHECK(run.end() == 0);
}

TEST_CASE("files are compared by their metadata", "[cli][watch]") {
  const TemporaryFolder folder;
  const std::string file = folder / "a.txt", late = folder / "late.txt", ours = folder / "ours.txt";
  write(file, "one");
  write(ours, "one");
  WatchedFiles files({ours});
  files.add({file, late, ours});
  CHECK(files.size() == 2);
  files.settle();
  CHECK(files.poll().empty());
  write(file, "three");
  CHECK(files.poll().empty());  // it may still be growing
  CHECK(files.poll() == std::vector<std::string>{file});
  files.settle();
  write(late, "x");
  write(ours, "two");
  files.poll();
  CHECK(files.poll() == std::vector<std::string>{late});
  files.settle();
  // The same size and the same time, but another file.
  const auto time = fs::last_write_time(file);
  write(folder / "b.txt", "seven");
  fs::last_write_time(folder / "b.txt", time);
  fs::rename(folder / "b.txt", file);
  files.poll();
  CHECK(files.poll() == std::vector<std::string>{file});
  files.settle();
  // Emptied, and filled a little later: no change while it is empty.
  write(file, "");
  for (int i = 0; i < 4; ++i) CHECK(files.poll().empty());
  write(file, "again");
  files.poll();
  CHECK(files.poll() == std::vector<std::string>{file});
  // Written in pieces: no change before the last.
  files.settle();
  const std::string text = "what an editor writes, a bit at a time";
  for (std::size_t i = 0; i <= text.size(); ++i) {
    write(file, text.substr(0, i));
    CHECK(files.poll().empty());
  }
  CHECK(files.poll() == std::vector<std::string>{file});
  // Gone for a short time, and back as it was.
  files.settle();
  fs::rename(file, folder / "away.txt");
  for (int i = 0; i < 4; ++i) CHECK(files.poll().empty());
  fs::rename(folder / "away.txt", file);
  for (int i = 0; i < 12; ++i) CHECK(files.poll().empty());
  // One that stays away is waited for, not for ever.
  fs::remove(file);
  for (int i = 0; i < 8; ++i) CHECK(files.poll().empty());
  CHECK(files.poll() == std::vector<std::string>{file});
  write(file, "there again");
  files.settle();
  // Files that are not named any more do not count.
  files.settle();
  files.keep_only({late});
  write(file, "ignored");
  files.poll();
  CHECK(files.poll().empty());
}

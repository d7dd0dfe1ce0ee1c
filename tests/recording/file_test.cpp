// Recorders and their files: permission to write, and disks that fail.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

RecorderOptions to(const std::string& path) {
  RecorderOptions options;
  options.path = path;
  return options;
}

std::string refusal(Simulation& simulation, const std::string& path) {
  const auto recorder = Recorder::start(simulation, to(path));
  REQUIRE_FALSE(recorder);
  return recorder.error().text();
}

std::size_t files_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

// Runs `work` in a process of its own; its exit status, or 128 + the signal that ended it.
int in_child(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

TEST_CASE("two recorders to one file are refused") {
  const Folder folder;
  const std::string path = folder / "run.mcap";
  const auto first = simulate(busy_scene().build(), "bullet");
  const auto second = simulate(busy_scene().build(), "bullet");
  {
    const auto recorder = Recorder::start(*first, to(path));
    REQUIRE(recorder);
    CHECK(refusal(*second, path).find("is being written by another recorder") != std::string::npos);
    // From another process too.
    const int status = in_child([&] { return Recorder::start(*second, to(path)) ? 0 : 3; });
    CHECK(status == 3);
    CHECK(files_in(folder.path) == 1);
    first->step();
    REQUIRE((*recorder)->finish(RunStatus::stopped));
  }
  CHECK(opened(path)->info().status == "stopped");
  // Once it is finished, the file may be replaced.
  const auto recorder = Recorder::start(*second, to(path));
  REQUIRE(recorder);
}

TEST_CASE("a file that cannot be written is refused before the run") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  CHECK(refusal(*simulation, folder / "none/run.mcap").find("No such file or directory") !=
        std::string::npos);
  CHECK(refusal(*simulation, folder.path).find("it is a folder") != std::string::npos);
  CHECK(refusal(*simulation, "/dev/full").find("it is a device, pipe or socket") !=
        std::string::npos);
  CHECK(files_in(folder.path) == 0);
}

TEST_CASE("an existing file is replaced only by a recording that has begun") {
  const Folder folder;
  const std::string path = folder / "run.mcap";
  write_all(path, "precious");
  const auto simulation = simulate(busy_scene().build(), "bullet");
  CHECK(refusal(*simulation, path).find("--overwrite") != std::string::npos);
  RecorderOptions allowed = to(path);
  allowed.rules.overwrite = true;
  RecorderOptions wrong = allowed;
  wrong.every = -1.0;
  CHECK_FALSE(Recorder::start(*simulation, wrong));
  CHECK(read_all(path) == "precious");
  // No space even for the beginning: the old one stays.
  const int status = in_child([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    return Recorder::start(*simulation, allowed) ? 0 : 3;
  });
  CHECK(status == 3);
  CHECK(read_all(path) == "precious");
  CHECK(files_in(folder.path) == 1);
  const auto recorder = Recorder::start(*simulation, allowed);
  REQUIRE(recorder);
  CHECK(read_all(path).substr(1, 4) == "MCAP");
}

TEST_CASE("a full disk is reported and leaves a recording that can be read") {
  if (kThreadSanitized)
    COGRSIM_SKIP("the sanitizer knows no threads in a child of a process that has some");
  const Folder folder;
  const std::string path = folder / "run.mcap";
  const SceneModelPtr scene = busy_scene().build();
  const int status = in_child([&] {
    ::signal(SIGXFSZ, SIG_IGN);  // writing beyond the limit fails then like a full disk
    const rlimit limit{800000, 800000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    SimulationOptions settings;
    settings.backend = "bullet";
    auto simulation = Simulation::create(scene, settings, loader());
    auto recorder = Recorder::start(**simulation, to(path));
    if (!recorder) return 1;
    for (int i = 0; i < 20000 && (*recorder)->problem().empty(); ++i) (*simulation)->step();
    const std::string problem = (*recorder)->problem();
    if (problem.find("File too large") == std::string::npos) return 2;
    // The run continues without the recorder, at its own speed.
    for (int i = 0; i < 100; ++i) (*simulation)->step();
    const auto finished = (*recorder)->finish(RunStatus::completed);
    if (finished) return 3;
    if (finished.error().message.find(" frames: ") == std::string::npos) return 4;
    return 0;
  });
  REQUIRE(status == 0);
  CHECK(std::filesystem::file_size(path) <= 800000);
  const auto recording = opened(path);
  CHECK(recording->info().complete);
  CHECK(recording->frame_count() > 20);
  for (std::size_t i = 0; i < recording->frame_count(); ++i) REQUIRE(recording->frame(i));
}

TEST_CASE("frames beyond the queue's limit are left out and counted") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  RecorderOptions options = to(folder / "run.mcap");
  options.queue_limit = 20000;  // a few frames
  auto recorder = Recorder::start(*simulation, options);
  REQUIRE(recorder);
  // Far faster than the writer looks by itself, and too little to wake it.
  for (int i = 0; i < 300; ++i) simulation->step();
  CHECK((*recorder)->problem().find("frames are left out") != std::string::npos);
  const auto finished = (*recorder)->finish(RunStatus::completed);
  REQUIRE_FALSE(finished);
  const auto recording = opened(folder / "run.mcap");
  CHECK(recording->frame_count() > 1);
  CHECK(recording->frame_count() < 301);
  CHECK(finished.error().message.find("lacks " + std::to_string(301 - recording->frame_count()) +
                                      " of 301 frames") != std::string::npos);
  for (std::size_t i = 0; i < recording->frame_count(); ++i) REQUIRE(recording->frame(i));
  CHECK(recording->info().dropped == 301 - recording->frame_count());
}

TEST_CASE("a recorder that has ended costs nothing") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  bool contacts = false;
  simulation->observe({}, [&](const FramePtr& frame) { contacts = !frame->contacts.empty(); });
  auto recorder = Recorder::start(*simulation, to(folder / "run.mcap"));
  REQUIRE(recorder);
  // Boxes lie on the plane by then; for the recorder their contacts are taken from the engine.
  while (!contacts && simulation->step_count() < 2000) simulation->step();
  REQUIRE(contacts);
  REQUIRE((*recorder)->finish(RunStatus::running));
  simulation->step();
  CHECK_FALSE(contacts);
}

TEST_CASE("a killed recorder leaves its whole chunks") {
  if (kThreadSanitized)
    COGRSIM_SKIP("the sanitizer knows no threads in a child of a process that has some");
  const Folder folder;
  const std::string path = folder / "run.mcap";
  const SceneModelPtr scene = busy_scene().build();
  const pid_t child = ::fork();
  if (child == 0) {
    SimulationOptions settings;
    settings.backend = "bullet";
    auto simulation = Simulation::create(scene, settings, loader());
    auto recorder = Recorder::start(**simulation, to(path));
    for (;;) (*simulation)->step();
  }
  // Until there is something to lose, in the middle of it.
  for (int i = 0; i < 600; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::error_code error;
    if (std::filesystem::file_size(path, error) > 600000 && !error) break;
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const auto recording = opened(path);
  CHECK_FALSE(recording->info().complete);
  CHECK(recording->info().status == "");
  CHECK(recording->info().damage.find("cut off") != std::string::npos);
  REQUIRE(recording->frame_count() > 50);
  for (std::size_t i = 0; i < recording->frame_count(); ++i) {
    const auto frame = recording->frame(i);
    REQUIRE(frame);
    REQUIRE((*frame)->step == i);
  }
  CHECK(recording->recompute(*loader(), [](const Frame&) { return true; }));
}

TEST_CASE("a truncated recording opens with its readable frames") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  RecorderOptions options = to(folder / "run.mcap");
  record(*simulation, options, 800);
  const std::string bytes = read_all(folder / "run.mcap");
  write_all(folder / "cut.mcap", bytes.substr(0, bytes.size() * 9 / 10));
  const auto recording = opened(folder / "cut.mcap");
  CHECK_FALSE(recording->info().complete);
  CHECK(recording->frame_count() < 801);
  for (std::size_t i = 0; i < recording->frame_count(); ++i) REQUIRE(recording->frame(i));
  // Before the first frame there is nothing to show, which is reported.
  write_all(folder / "stub.mcap", bytes.substr(0, 2000));
  const auto stub = Recording::open(folder / "stub.mcap");
  REQUIRE_FALSE(stub);
  CHECK(stub.error().message.find("cut off") != std::string::npos);
}

TEST_CASE("recordings of other programs and of newer versions are distinguished") {
  const Folder folder;
  const auto simulation = simulate(busy_scene().build(), "bullet");
  record(*simulation, to(folder / "run.mcap"), 2);
  std::string bytes = read_all(folder / "run.mcap");
  // The metadata entry "format" = "1"; metadata have no checksum of their own.
  const std::string entry("\x06\0\0\0format\x01\0\0\0001", 15);
  const std::size_t at = bytes.find(entry);
  REQUIRE(at != std::string::npos);
  bytes[at + 14] = '9';
  write_all(folder / "newer.mcap", bytes);
  const auto newer = Recording::open(folder / "newer.mcap");
  REQUIRE_FALSE(newer);
  CHECK(newer.error().message.find("of a newer version (format 9") != std::string::npos);
  std::string other = read_all(folder / "run.mcap");
  const std::size_t profile = other.find("cogrsim");
  other[profile] = 'X';
  write_all(folder / "other.mcap", other);
  const auto foreign = Recording::open(folder / "other.mcap");
  REQUIRE_FALSE(foreign);
  CHECK(foreign.error().message.find("no recording of CogRSim") != std::string::npos);
}

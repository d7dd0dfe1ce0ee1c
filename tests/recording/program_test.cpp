// The program's commands about recordings, as a user's shell runs them.
#include <catch2/catch.hpp>

#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include <nlohmann/json.hpp>

#include "../cli/process.h"

namespace {

const std::string kScene = COGRSIM_RECORDING_SCENES "/judged.scene.xml";

using Json = nlohmann::json;

}  // namespace

TEST_CASE("a run is recorded, described and shown again") {
  const TemporaryFolder folder;
  const std::string file = folder / "run.mcap";
  const Outcome run = cogrsim_run(
      {"run", kScene, "--backend", "bullet", "--record", file, "--json", folder / "run.json"});
  INFO(run.err);
  REQUIRE(run.status == 0);

  const Outcome info = cogrsim_run({"info", file, "--json"});
  REQUIRE(info.status == 0);
  const Json about = Json::parse(info.out);
  CHECK(about["scene"] == "judged");
  CHECK(about["frames"] == 1001);
  CHECK(about["status"] == "completed");
  CHECK(about["seed"] == 11);
  // The scene, and what it imports.
  REQUIRE(about["attachments"].size() == 2);
  CHECK(about["attachments"][1]["name"] == "parts/lamp.scene.xml");
  REQUIRE(cogrsim_run({"info", file, "--extract", folder / "scene"}).status == 0);
  CHECK(read_file(folder / "scene/judged.scene.xml") == read_file(kScene));

  // The last frame is the end of the run itself.
  const Outcome last = cogrsim_run({"replay", file, "--at", "1", "--json", "-"});
  REQUIRE(last.status == 0);
  const Json frame = Json::parse(last.out);
  const Json result = Json::parse(read_file(folder / "run.json"));
  CHECK(frame["bodies"] == result["bodies"]);
  CHECK(frame["joints"] == result["joints"]);
  CHECK(frame["contacts"] == result["contacts"]);
  CHECK(frame["sensors"]["angle"]["values"].size() == 2);

  CHECK(cogrsim_run({"replay", file, "--verify"}).status == 0);
  REQUIRE(cogrsim_run({"replay", file, "--csv", folder / "tables"}).status == 0);
  const std::string angles = read_file(folder / "tables/sensors_angle.csv");
  // A head and a reading every 10 ms of a second.
  CHECK(std::count(angles.begin(), angles.end(), '\n') == 101);
}

TEST_CASE("a killed run leaves a recording that can be used") {
  const TemporaryFolder folder;
  const std::string file = folder / "run.mcap";
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl(COGRSIM_PROGRAM, "cogrsim", "run", kScene.c_str(), "--backend", "bullet", "--duration",
            "100000 s", "--record", file.c_str(), nullptr);
    ::_exit(127);
  }
  for (int i = 0; i < 1200; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
    std::error_code error;
    if (std::filesystem::file_size(file, error) > 500000 && !error) break;
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const Outcome info = cogrsim_run({"info", file, "--json"});
  INFO(info.err);
  REQUIRE(info.status == 0);
  const Json about = Json::parse(info.out);
  CHECK(about["complete"] == false);
  CHECK(about["status"] == nullptr);
  REQUIRE(about["frames"] > 100);
  const Outcome replay = cogrsim_run({"replay", file, "--at", "0.1", "--json", "-"});
  CHECK(replay.status == 0);
  CHECK(Json::parse(replay.out)["step"] == 100);
  CHECK(replay.err.find("using what is readable") != std::string::npos);
}

TEST_CASE("wrong arguments and files are reported") {
  const TemporaryFolder folder;
  CHECK(cogrsim_run({"replay", "run.mcap"}).status == 2);
  CHECK(cogrsim_run({"replay", "run.mcap", "--json", "-", "--at", "noon"}).status == 2);
  const Outcome missing = cogrsim_run({"info", folder / "none.mcap"});
  CHECK(missing.status == 1);
  CHECK(missing.err.find("No such file") != std::string::npos);
  const Outcome other = cogrsim_run({"info", kScene});
  CHECK(other.status == 1);
  CHECK(other.err.find("is no MCAP file") != std::string::npos);
  const Outcome folder_is_missing =
      cogrsim_run({"run", kScene, "--backend", "bullet", "--record", folder / "none/run.mcap"});
  CHECK(folder_is_missing.status == 1);
  CHECK(folder_is_missing.err.find("cannot write") != std::string::npos);
  CHECK(cogrsim_run({"replay", "--help"}).out.find("Examples:") != std::string::npos);
}

TEST_CASE("a live run takes an address of this machine, and nothing else") {
  for (const char* wrong : {"example.org", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:65536", "0",
                            "[::1", "[::1]8765", "127.0.0.1:http", "another.scene.xml"}) {
    const Outcome run = cogrsim_run({"run", kScene, "--live", wrong});
    INFO(wrong << '\n' << run.err);
    CHECK(run.status == 2);
    CHECK_THAT(run.err, Catch::Contains("is not an address to listen at"));
  }
  // An address of documentation, which no machine has.
  const Outcome foreign =
      cogrsim_run({"run", kScene, "--backend", "bullet", "--live", "192.0.2.1:8765"});
  CHECK(foreign.status == 1);
  CHECK_THAT(foreign.err, Catch::Contains("cannot listen at 192.0.2.1:8765"));
  const Outcome alone = cogrsim_run({"run", kScene, "--live-origin", "https://viewer.example"});
  CHECK(alone.status == 2);
  CHECK_THAT(alone.err, Catch::Contains("only a run with --live has clients"));
}

TEST_CASE("a live run ends by itself where a duration is asked for") {
  const Outcome run = cogrsim_run({"run", kScene, "--backend", "bullet", "--live", "--duration",
                                   "0.1", "--speed", "max", "--json", "-"});
  INFO(run.err);
  CHECK(run.status == 0);
  CHECK_THAT(run.err, Catch::Contains("live: ws://127.0.0.1:"));
  CHECK(Json::parse(run.out)["status"] == "completed");
}

#include "cogrsim/core/run_program.h"

#include <catch2/catch.hpp>

#include <cstdlib>

using cogrsim::ProgramOptions;
using cogrsim::run_program;

TEST_CASE("a program's output and exit status are returned", "[program]") {
  const auto end = run_program({"sh", "-c", "echo out; echo err >&2; cat; exit 3"});
  REQUIRE(end);
  CHECK(end->status == 3);
  CHECK_FALSE(end->killed);
  CHECK(end->output == "out\nerr\n");
}

TEST_CASE("a program that is not there is an error of the system", "[program]") {
  const auto end = run_program({"cogrsim-no-such-program"});
  REQUIRE_FALSE(end);
  CHECK(end.error() == std::errc::no_such_file_or_directory);
}

TEST_CASE("a program runs in its folder and without some variables", "[program]") {
  setenv("COGRSIM_PROGRAM_TEST_A", "there", 1);
  ProgramOptions options;
  options.folder = "/";
  options.unset = {"COGRSIM_PROGRAM_TEST"};
  const auto end = run_program({"sh", "-c", "pwd; echo ${COGRSIM_PROGRAM_TEST_A:-none}"}, options);
  unsetenv("COGRSIM_PROGRAM_TEST_A");
  REQUIRE(end);
  CHECK(end->output == "/\nnone\n");
}

TEST_CASE("of a long output the end is returned", "[program]") {
  ProgramOptions options;
  options.most_output = 10;
  const auto end = run_program({"seq", "1000"}, options);
  REQUIRE(end);
  CHECK(end->output.size() >= 10);
  CHECK(end->output.size() <= 20);
  CHECK(end->output.substr(end->output.size() - 9) == "999\n1000\n");
}

// The second process keeps the pipe open: that run_program() returns shows that both have ended.
TEST_CASE("a cancelled program is killed with the processes that it started", "[program]") {
  ProgramOptions options;
  options.cancelled = [] { return true; };
  const auto end = run_program({"sh", "-c", "sleep 1000 & wait"}, options);
  REQUIRE(end);
  CHECK(end->killed);
  CHECK(end->status == 128);
}

TEST_CASE("a program that takes too long is killed", "[program]") {
  ProgramOptions options;
  options.longest = std::chrono::seconds(0);
  const auto end = run_program({"sleep", "1000"}, options);
  REQUIRE(end);
  CHECK(end->killed);
}

#include <catch2/catch.hpp>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "../support/temporary_folder.h"
#include "trajectory_player/trajectory.h"

using namespace trajectory_player;

namespace {

std::string first_error(const std::string& text) {
  const auto parsed = parse_trajectory(text, "arm.csv");
  return parsed.errors.empty() ? "" : parsed.errors.front();
}

}  // namespace

TEST_CASE("rows are read, with units, comments, CRLF and a byte order mark") {
  const auto parsed = parse_trajectory(
      "\xEF\xBB\xBF# made by hand\r\ntime [ms], elbow [deg] ,grip\r\n\r\n0, 0, "
      "1\r\n500,+90,-2e-1\r\n",
      "arm.csv");
  REQUIRE(parsed.errors.empty());
  const auto& t = parsed.trajectory;
  CHECK(t.columns == std::vector<std::string>{"elbow", "grip"});
  CHECK(t.times == std::vector<double>{0.0, 0.5});
  CHECK(t.rows[1][0] == Approx(1.57079632679));
  CHECK(t.rows[1][1] == Approx(-0.2));
}

TEST_CASE("errors name file, line, column and the expected text") {
  CHECK(first_error("") == "arm.csv: empty: expected a header row: time, then motor names");
  CHECK(first_error("time,a\n") == "arm.csv: no rows after the header");
  CHECK(first_error("t,a\n0,1\n").find("arm.csv:1: expected the first column to be 'time'") == 0);
  CHECK(first_error("time\n0\n") == "arm.csv:1: expected at least one motor name after 'time'");
  CHECK(first_error("time,a,a\n0,1,1\n") == "arm.csv:1: column 'a' appears twice");
  CHECK(
      first_error("time,a [furlong]\n0,1\n").find("arm.csv:1: column 2: unknown unit 'furlong'") ==
      0);
  CHECK(first_error("time,a\n0,1\n1,2,3\n") ==
        "arm.csv:3: expected 2 fields as in the header, found 3");
  CHECK(first_error("time,a\n0,1x\n") == "arm.csv:2: column 'a': expected a number, found '1x'");
  CHECK(first_error("time,a\n0,nan\n") == "arm.csv:2: column 'a': expected a number, found 'nan'");
  CHECK(first_error("time,a\n0,\n") == "arm.csv:2: column 'a': expected a number, found ''");
  CHECK(first_error("time,a\n1,0\n1,0\n") ==
        "arm.csv:3: expected a time after that of the previous row");
}

TEST_CASE("many errors are reported, ten at most") {
  std::string text = "time,a\n";
  for (int i = 0; i < 100; ++i) text += "x,y\n";
  CHECK(parse_trajectory(text, "arm.csv").errors.size() == 10);
}

TEST_CASE("sampling is linear, holds or loops") {
  const auto t = parse_trajectory("time,a\n1,0\n2,10\n4,0\n", "arm.csv").trajectory;
  std::vector<double> out;
  const auto at = [&](double time, AtEnd end) {
    sample(t, time, end, out);
    return out.at(0);
  };
  CHECK(at(0, AtEnd::hold) == 0);
  CHECK(at(1.5, AtEnd::hold) == Approx(5));
  CHECK(at(2, AtEnd::hold) == Approx(10));
  CHECK(at(3, AtEnd::hold) == Approx(5));
  CHECK(at(9, AtEnd::hold) == 0);
  // The period is 3 s: 1 + 3 + 0.5 is where 1.5 was.
  CHECK(at(4.5, AtEnd::loop) == Approx(5));
  CHECK(at(5.0, AtEnd::loop) == Approx(10));
}

TEST_CASE("files are found below the scene's folder only") {
  namespace fs = std::filesystem;
  const cogrsim::test::TemporaryFolder there;
  const fs::path& base = there.path;
  fs::create_directories(base / "scene" / "data");
  fs::create_directories(base / "scene2");
  std::ofstream(base / "scene" / "data" / "a.csv") << "time,a\n0,1\n";
  std::ofstream(base / "scene2" / "b.csv") << "time,a\n0,1\n";
  fs::create_symlink(base / "scene2" / "b.csv", base / "scene" / "link.csv");
  const std::string folder = (base / "scene").string();

  CHECK(load_trajectory(folder, "data/a.csv").errors.empty());
  CHECK(load_trajectory(folder, "data/../data/a.csv").errors.empty());
  const auto error = [&](const std::string& path) {
    const auto parsed = load_trajectory(folder, path);
    return parsed.errors.empty() ? "" : parsed.errors.front();
  };
  CHECK(error("../scene2/b.csv").find("outside the scene's folder") != std::string::npos);
  CHECK(error("link.csv").find("outside the scene's folder") != std::string::npos);
  CHECK(error("/etc/hostname").find("relative to the scene's folder") != std::string::npos);
  CHECK(error("none.csv").find("does not exist") != std::string::npos);
  CHECK(error("data").find("does not exist") != std::string::npos);
}

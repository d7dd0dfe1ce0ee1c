#include "cogrsim/core/parameter.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

using namespace cogrsim;
using Catch::Matchers::Contains;

namespace {
ParameterTable speed_and_side() {
  return {parameter("speed", 0.2, "m/s", "cruising speed").range(0.0, 2.0),
          parameter("side", "left", "wall to follow").one_of({"left", "right"}),
          parameter("laps", 3, "rounds"),
          parameter("waypoints", std::vector<double>{}, "m", "x y pairs")};
}
}  // namespace

TEST_CASE("defaults fill what is not given", "[parameter]") {
  const auto got = complete_parameters(speed_and_side(), {{"laps", std::int64_t{5}}});
  REQUIRE(got);
  CHECK(std::get<double>(got->at("speed")) == 0.2);
  CHECK(std::get<std::string>(got->at("side")) == "left");
  CHECK(std::get<std::int64_t>(got->at("laps")) == 5);
  CHECK(got->size() == 4);
}

TEST_CASE("an integer may stand for a number and a whole number for an integer", "[parameter]") {
  const auto whole =
      complete_parameters(speed_and_side(), {{"speed", std::int64_t{1}}, {"laps", -4.0}});
  REQUIRE(whole);
  CHECK(std::get<double>(whole->at("speed")) == 1.0);
  CHECK(std::get<std::int64_t>(whole->at("laps")) == -4);
  const auto message = [](double laps) {
    const auto got = complete_parameters(speed_and_side(), {{"laps", laps}});
    REQUIRE_FALSE(got);
    return got.error().message;
  };
  CHECK(message(1.5) == "parameter 'laps' must be a whole number, not 1.5");
  // No integer holds these, or not for certain the one that was written.
  CHECK(message(1e300) == "parameter 'laps' must be a whole number, not 1e+300");
  CHECK(message(std::numeric_limits<double>::infinity()) ==
        "parameter 'laps' must be a whole number, not inf");
  CHECK(message(std::nan("")) == "parameter 'laps' must be a whole number, not nan");
  CHECK(message(9007199254740994.0) ==
        "parameter 'laps' must be a whole number, not 9007199254740994");
}

TEST_CASE("a number may stand for a list of one", "[parameter]") {
  for (const ParameterValue& given : {ParameterValue(2.0), ParameterValue(std::int64_t{2})}) {
    const auto got = complete_parameters(speed_and_side(), {{"waypoints", given}});
    REQUIRE(got);
    CHECK(std::get<std::vector<double>>(got->at("waypoints")) == std::vector<double>{2.0});
  }
  // The bounds of the elements hold for it too; nothing but numbers becomes a list.
  const ParameterTable table = {
      parameter("gains", std::vector<double>{}, "1", "one per wheel").range(0.0, 5.0)};
  const auto big = complete_parameters(table, {{"gains", 6.0}});
  REQUIRE_FALSE(big);
  CHECK(big.error().message == "parameter 'gains' is 6, but must be 0 to 5");
  CHECK_FALSE(complete_parameters(table, {{"gains", true}}));
  CHECK_FALSE(complete_parameters(table, {{"gains", std::string("6")}}));
}

TEST_CASE("bad values name the parameter and what is allowed", "[parameter]") {
  const auto message = [](const Parameters& given) {
    const auto got = complete_parameters(speed_and_side(), given);
    REQUIRE_FALSE(got);
    return got.error().message;
  };
  CHECK(message({{"speed", 3.0}}) == "parameter 'speed' is 3 m/s, but must be 0 to 2 m/s");
  CHECK_THAT(message({{"speed", std::nan("")}}), Contains("NaN"));
  CHECK_THAT(message({{"waypoints", std::vector<double>{0, std::nan("")}}}), Contains("NaN"));
  CHECK_THAT(message({{"side", std::string("lft")}}),
             Contains("left, right") && Contains("did you mean 'left'"));
  CHECK_THAT(message({{"sped", 1.0}}),
             Contains("speed, side, laps, waypoints") && Contains("did you mean 'speed'"));
}

TEST_CASE("all problems are reported at once", "[parameter]") {
  const auto got =
      complete_parameters(speed_and_side(), {{"speed", -1.0}, {"side", true}, {"x", 1.0}});
  REQUIRE_FALSE(got);
  const std::string& text = got.error().message;
  CHECK(std::count(text.begin(), text.end(), '\n') == 2);
  CHECK_THAT(text, Contains("'speed'") && Contains("'side'") && Contains("'x'"));
}

TEST_CASE("a required parameter must be set", "[parameter]") {
  const ParameterTable table = {parameter("file", "", "where the targets are").must_be_set()};
  const auto got = complete_parameters(table, {});
  REQUIRE_FALSE(got);
  CHECK(got.error().message == "parameter 'file' must be set: where the targets are");
  CHECK(complete_parameters(table, {{"file", std::string("a.csv")}}));
}

TEST_CASE("a one-sided range reads as one", "[parameter]") {
  const double infinite = std::numeric_limits<double>::infinity();
  const ParameterTable table = {parameter("gain", 1.0, "1", "").range(0.0, infinite)};
  const auto got = complete_parameters(table, {{"gain", -2.0}});
  REQUIRE_FALSE(got);
  CHECK(got.error().message == "parameter 'gain' is -2, but must be at least 0");
}

TEST_CASE("nearest_name finds typing mistakes, not unrelated names", "[parameter]") {
  const std::vector<std::string> names = {"sphere", "cylinder", "box"};
  CHECK(nearest_name("bxo", names) == "box");  // swapped neighbours count once
  CHECK(nearest_name("cylnder", names) == "cylinder");
  CHECK(nearest_name("bx", names) == "box");
  CHECK(nearest_name("wheel", names).empty());
  CHECK(nearest_name("", names).empty());
  CHECK(nearest_name(std::string(1000000, 'x'), names).empty());
}

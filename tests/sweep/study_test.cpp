// Values of studies, from arguments and from files.
#include <cmath>

#include <catch2/catch.hpp>

#include "cogrsim/dsl/study.h"

using namespace cogrsim;
using Catch::Contains;

namespace {

std::vector<std::string> texts(const std::string& arguments) {
  const auto values = dsl::parse_study_values(arguments);
  INFO(arguments << ": " << (values ? "" : values.error().text()));
  REQUIRE(values);
  std::vector<std::string> out;
  for (const dsl::StudyValue& value : *values) out.push_back(value.text);
  return out;
}

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("values are lists and ranges", "[sweep][study]") {
  CHECK(texts("3cm..5cm:5") == Texts{"3 cm", "3.5 cm", "4 cm", "4.5 cm", "5 cm"});
  CHECK(texts("3cm,4 cm") == Texts{"3 cm", "4 cm"});
  CHECK(texts("1..3") == Texts{"1", "2", "3"});
  CHECK(texts("1..100:3:log") == Texts{"1", "10", "100"});
  CHECK(texts("-1..1:3, 7") == Texts{"-1", "0", "1", "7"});
  CHECK(texts("10cm..1m:2") == Texts{"0.1 m", "1 m"});
  CHECK(texts("0..1:11")[3] == "0.3");  // and not 0.30000000000000004
  CHECK(texts("round, square") == Texts{"round", "square"});
  CHECK(texts("[1, 2], [3, 4]") == Texts{"[1, 2]", "[3, 4]"});
  CHECK(texts("../meshes/a.obj") == Texts{"../meshes/a.obj"});
  const auto values = dsl::parse_study_values("90deg, 3 rpm, soft");
  REQUIRE(values);
  CHECK((*values)[0].number == Approx(std::acos(0.0)));
  CHECK((*values)[0].unit == "rad");
  CHECK(std::isnan((*values)[2].number));
}

TEST_CASE("wrong values are refused with the right notation", "[sweep][study]") {
  const struct {
    const char *arguments, *text;
  } cases[] = {
      {"", "no values"},
      {"1,,2", "empty value"},
      {"3cm..5cm", "how many values"},
      {"3cm..5cm:1", "'1' is not a number of values"},
      {"3cm..5cm:many", "'many' is not a number of values"},
      {"3cm..5kg:3", "from a length to a mass"},
      {"3cm..5:3", "from a length to a plain number"},
      {"3cm..wide:3", "'wide' is not a number with a known unit"},
      {"3parsec..5parsec:3", "known unit"},
      {"5..1", "ends before it begins"},
      {"1..1000000", "more than 100000"},
      {"3cm..3cm:2", "the same"},
      {"-1..1:3:log", "contains 0"},
      {"1..2:3:lin", "only 'log'"},
      {"3cm,30mm", "twice"},
      {"a,b,a", "twice"},
  };
  for (const auto& item : cases) {
    INFO(item.arguments);
    const auto values = dsl::parse_study_values(item.arguments);
    REQUIRE_FALSE(values);
    CHECK_THAT(values.error().text(), Contains(item.text));
  }
}

TEST_CASE("seeds are whole numbers and ranges of them", "[sweep][study]") {
  using Seeds = std::vector<std::uint64_t>;
  CHECK(dsl::parse_seeds("1..4").value() == Seeds{1, 2, 3, 4});
  CHECK(dsl::parse_seeds("7, 1..2").value() == Seeds{7, 1, 2});
  CHECK(dsl::parse_seeds("5..6,1..4,9,7..8").value() == Seeds{5, 6, 1, 2, 3, 4, 9, 7, 8});
  CHECK(dsl::parse_seeds("18446744073709551615").value() == Seeds{18446744073709551615ull});
  CHECK(dsl::parse_seeds("18446744073709551614..18446744073709551615").value().size() == 2);
  CHECK(dsl::parse_seeds("1..5,9").value() == Seeds{1, 2, 3, 4, 5, 9});
  CHECK(dsl::parse_seeds("1 3 7").value() == Seeds{1, 3, 7});
  CHECK(dsl::parse_seeds(" 1 .. 3, 9  11\n").value() == Seeds{1, 2, 3, 9, 11});
  for (const char* arguments :
       {"1..5..9", "1,,2", ",1", "1,", "1...3", "", "-1", "1.5", "4..1", "1..", "..4", "a", "1,1",
        "1..3,2", "2,1..3", "5..9,1..5", "1..900900,20,20", "0..18446744073709551615"}) {
    INFO(arguments);
    CHECK_FALSE(dsl::parse_seeds(arguments));
  }
}

TEST_CASE("a study file is read whole", "[sweep][study]") {
  const auto result = dsl::read_study(COGRSIM_SCENES "/good_study.xml");
  for (const Diagnostic& d : result.diagnostics) UNSCOPED_INFO(d.message);
  REQUIRE(result.study);
  CHECK_THAT(result.study->scene, Catch::EndsWith("scenes/trial.scene.xml"));
  CHECK(result.study->seeds.size() == 2);
  CHECK(result.study->backends == Texts{"toy", "toy_euler"});
  CHECK(result.study->until == 0.5);
  REQUIRE(result.study->variations.size() == 1);
  CHECK(result.study->variations[0].values.size() == 3);
  REQUIRE(result.study->measures.size() == 2);
  CHECK(result.study->measures[1].take == MeasureModel::Take::first_time);
  CHECK(dsl::is_study(COGRSIM_SCENES "/good_study.xml"));
  CHECK_FALSE(dsl::is_study(COGRSIM_SCENES "/trial.scene.xml"));
  CHECK_FALSE(dsl::is_study(COGRSIM_SCENES "/nowhere.xml"));
}

TEST_CASE("every error of a study file is reported with its line", "[sweep][study]") {
  const auto result = dsl::read_study(COGRSIM_SCENES "/bad_study.xml");
  CHECK_FALSE(result.study);
  const struct {
    int line;
    const char *code, *text;
  } expected[] = {
      {1, "CG0301", "no scene"},    {1, "CG0507", "end before they begin"},
      {1, "CG0203", "speed"},       {2, "CG0507", "from a length to a mass"},
      {3, "CG0507", "empty value"}, {4, "CG0201", "<mesure>"},
      {5, "CG0204", "signal="},     {6, "CG0508", "median"},
  };
  CHECK(result.diagnostics.size() == std::size(expected));
  for (const auto& item : expected) {
    INFO(item.text);
    CHECK(std::any_of(result.diagnostics.begin(), result.diagnostics.end(), [&](const auto& d) {
      return d.line == item.line && d.code == item.code &&
             d.message.find(item.text) != std::string::npos;
    }));
  }
}

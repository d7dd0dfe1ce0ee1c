// Provenance, and engines named with their own options.
#include <catch2/catch.hpp>

#include "cogrsim/physics/backend_choice.h"
#include "cogrsim/physics/provenance.h"

using namespace cogrsim;
using Catch::Matchers::Contains;

namespace {

Provenance whole() {
  Provenance out;
  out.backend = "toy";
  out.engine = "Toy \"engine\"";
  out.version = "1.2";
  out.solver = "none";
  out.formulation = "maximal coordinates";
  out.integrator = "Euler";
  out.cogrsim_version = "0.1.0";
  for (const StepStage stage : kStepStages) out[stage] = {ComputedBy::engine, to_string(stage)};
  out[StepStage::restitution] = {ComputedBy::none, "impacts do not bounce"};
  out.options = {{"iterations", std::int64_t{50}}, {"erp", 0.2}};
  out.assembly_options["bot"] = {{"formulation", std::string("reduced")}};
  return out;
}

ParameterTable table() {
  return {parameter("iterations", 10, "sweeps").range(1, 1000),
          parameter("margin", 0.04, "m", "of shapes").range(0.0, 1.0),
          parameter("solver", "si", "which").one_of({"si", "dantzig"}),
          parameter("warm", true, "or cold")};
}

}  // namespace

TEST_CASE("a provenance is complete or names what it lacks", "[provenance]") {
  CHECK(check_provenance(whole()));
  Provenance lacking = whole();
  lacking.solver.clear();
  lacking[StepStage::friction] = {};
  lacking[StepStage::joints] = {ComputedBy::engine, ""};
  const auto checked = check_provenance(lacking);
  REQUIRE_FALSE(checked);
  CHECK_THAT(checked.error().message, Contains("solver") && Contains("friction") &&
                                          Contains("joints") && !Contains("motors"));
}

TEST_CASE("a provenance comes back from its text", "[provenance]") {
  const Provenance before = whole();
  const auto after = parse_provenance(to_json_text(before));
  REQUIRE(after);
  CHECK(to_json_text(*after) == to_json_text(before));
  CHECK((*after)[StepStage::restitution].by == ComputedBy::none);
  CHECK(option_text(after->options.at("erp")) == "0.2");
  // Version 0.1 wrote "nobody".
  std::string old = to_json_text(before);
  const std::string none = "\"by\":\"none\"";
  const std::size_t found = old.find(none);
  REQUIRE(found != std::string::npos);
  old.replace(found, none.size(), "\"by\":\"nobody\"");
  const auto read = parse_provenance(old);
  REQUIRE(read);
  CHECK(to_json_text(*read) == to_json_text(before));
  for (const char* bad : {"", "7", "{}", "[", "{\"backend\":\"x\"}", "null"}) {
    INFO(bad);
    CHECK_FALSE(parse_provenance(bad));
  }
}

TEST_CASE("engines are split at commas outside of brackets", "[backend_choice]") {
  using Names = std::vector<std::string>;
  CHECK(split_backend_choices("bullet,cogrsim") == Names{"bullet", "cogrsim"});
  CHECK(split_backend_choices(" bullet  cogrsim ") == Names{"bullet", "cogrsim"});
  CHECK(split_backend_choices("bullet,bullet(solver=dantzig iterations=50),ode") ==
        Names{"bullet", "bullet(solver=dantzig iterations=50)", "ode"});
  CHECK(split_backend_choices("bullet (erp=0.1, cfm=0) ode") ==
        Names{"bullet(erp=0.1, cfm=0)", "ode"});
  CHECK(split_backend_choices("").empty());
}

TEST_CASE("a choice has a name and options", "[backend_choice]") {
  const auto choice = parse_backend_choice("bullet( solver=dantzig, iterations = 50 margin=1 mm)");
  REQUIRE(choice);
  CHECK(choice->name == "bullet");
  CHECK(choice->options == std::map<std::string, std::string>{
                               {"solver", "dantzig"}, {"iterations", "50"}, {"margin", "1 mm"}});
  const auto values = option_values(*choice, table());
  REQUIRE(values);
  CHECK(std::get<std::int64_t>(values->at("iterations")) == 50);
  CHECK(std::get<double>(values->at("margin")) == Approx(1e-3));
  CHECK(values->count("warm") == 0);  // only what was given
  for (const char* bad : {"", "(a=1)", "bullet(", "bullet)", "bullet(a)", "bullet(a=)",
                          "bullet(=1)", "bullet(a=1 a=2)", "bullet(a=1)x"}) {
    INFO(bad);
    CHECK_FALSE(parse_backend_choice(bad));
  }
}

TEST_CASE("an unknown or wrong engine option is an error that lists the options",
          "[backend_choice]") {
  const auto error = [](const char* text) {
    const auto values = option_values(*parse_backend_choice(text), table());
    REQUIRE_FALSE(values);
    return values.error().message;
  };
  CHECK_THAT(error("toy(itertions=5)"), Contains("itertions") && Contains("iterations"));
  CHECK_THAT(error("toy(iterations=0)"), Contains("iterations"));
  CHECK_THAT(error("toy(iterations=many)"), Contains("iterations"));
  CHECK_THAT(error("toy(solver=lemke)"), Contains("dantzig"));
  CHECK_THAT(error("toy(margin=3 deg)"), Contains("margin"));
  CHECK_THAT(error("toy(warm=yes)"), Contains("warm"));
  // A value may hold blanks ("1 mm"), so a name without a value is detected where the value is
  // read.
  CHECK_THAT(error("toy(solver=dantzig warm)"), Contains("dantzig warm"));
}

// Units, dimensions, numbers, and lists of numbers.
#include <catch2/catch.hpp>

#include <clocale>
#include <cmath>

#include "values/number_list.h"
#include "values/value.h"

using namespace cogrsim::dsl;
using cogrsim::units::combined_unit;

namespace {

const ExpressionEvaluator kPlain = [](std::string_view inside, std::size_t begin,
                                      std::optional<ExpressionFault>& fault) {
  Value v = evaluate(inside, {}, fault);
  if (fault) fault->begin += begin;
  return v;
};

std::vector<double> si(const std::string& text, NumberSyntax syntax = {}) {
  std::optional<ExpressionFault> fault;
  std::vector<double> out;
  for (const NumberEntry& e : parse_numbers(text, syntax, kPlain, fault)) out.push_back(e.value);
  INFO(text << ": " << (fault ? fault->message : ""));
  CHECK_FALSE(fault);
  return out;
}

std::string fault_code(const std::string& text, NumberSyntax syntax = {}) {
  std::optional<ExpressionFault> fault;
  parse_numbers(text, syntax, kPlain, fault);
  return fault ? fault->code : "";
}

}  // namespace

TEST_CASE("numbers are read strictly and whatever the locale", "[units]") {
  CHECK(parse_number("1.5") == 1.5);
  CHECK(parse_number("-2e-3") == -2e-3);
  CHECK(parse_number("+.5") == 0.5);
  CHECK(parse_number("7.") == 7.0);
  CHECK(parse_number("1e-400") == 0.0);
  for (const char* bad : {"", "nan", "inf", "-inf", "NAN", "12abc", "1,5", "0x10", "1e", "--1",
                          "+-1", "1 2", " 1", "1e999", "-1e999", ".", "e5", "1.2.3", "infinity"}) {
    INFO(bad);
    CHECK_FALSE(parse_number(bad));
  }
  // A locale with a decimal comma, where the machine has one.
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  CHECK(parse_number("1.5") == 1.5);
  CHECK(number_text(1.5) == "1.5");
  CHECK(number_text(100000.0) == "100000");  // not 1e+05: it may be part of a name
  CHECK(number_text(-3e6) == "-3000000");
  CHECK(number_text(1e20) == "1e+20");
  std::setlocale(LC_NUMERIC, before.c_str());
}

TEST_CASE("products and quotients have the usual unit of their dimension", "[units]") {
  CHECK(combined_unit("m/s", '*', "s") == "m");
  CHECK(combined_unit("rad/s", '*', "s") == "rad");
  CHECK(combined_unit("m/s^2", '*', "s") == "m/s");
  CHECK(combined_unit("m", '*', "m") == "m^2");
  CHECK(combined_unit("m", '/', "m/s") == "s");
  CHECK(combined_unit("rad", '/', "s") == "rad/s");
  CHECK(combined_unit("N", '*', "m") == "N*m");
  CHECK(combined_unit("N", '*', "m/s") == "W");
  CHECK(combined_unit("N", '*', "s") == "N*s");
  CHECK(combined_unit("m", '*', "s") == "m*s");
  CHECK(combined_unit("W", '/', "m^3") == "W/(m^3)");
  CHECK(combined_unit("m", '/', "m") == "1");
  CHECK(combined_unit("1", '*', "s") == "s");
  CHECK(combined_unit("m", '*', "1") == "m");
  CHECK(combined_unit("1", '/', "s") == "Hz");
  CHECK(combined_unit("", '*', "s") == "");
  CHECK(combined_unit("counts", '*', "s") == "counts*s");
}

TEST_CASE("units compose and keep their last bit", "[units]") {
  CHECK(parse_unit("cm")->to_si(57) == 0.57);
  CHECK(parse_unit("deg")->to_si(180) == Approx(3.14159265358979323846).epsilon(0));
  CHECK(parse_unit("kg/m^3")->dimension == dim::kDensity);
  CHECK(parse_unit("N*m")->dimension == dim::kTorque);
  CHECK(parse_unit("N/(m*s)")->dimension == dim::kIntegralGain);
  CHECK(parse_unit("N*m*s/rad")->dimension == dim::kAngularDamping);
  CHECK(parse_unit("g/cm^3")->to_si(1) == Approx(1000).epsilon(1e-15));
  CHECK(parse_unit("m/s^2")->dimension == dim::kAcceleration);
  CHECK(parse_unit("m*s^-2")->dimension == dim::kAcceleration);
  CHECK(parse_unit("1/s")->dimension == dim::kFrequency);
  CHECK(parse_unit("rpm")->to_si(60) == Approx(2 * 3.14159265358979323846).epsilon(1e-15));
  CHECK(parse_unit("V*s/rad")->dimension == dim::kBackEmf);
  for (const char* bad :
       {"", "x", "m/", "/s", "m**2", "m^", "m^a", "kg m", "M", "1/", "N/(m*s", "m^99"}) {
    INFO(bad);
    CHECK_FALSE(parse_unit(bad));
  }
}

TEST_CASE("every dimension's own unit can be read back", "[units]") {
  for (const Dimension d : {dim::kLength,
                            dim::kMass,
                            dim::kTime,
                            dim::kAngle,
                            dim::kSpeed,
                            dim::kAcceleration,
                            dim::kAngularSpeed,
                            dim::kFrequency,
                            dim::kDensity,
                            dim::kInertia,
                            dim::kForce,
                            dim::kTorque,
                            dim::kStiffness,
                            dim::kAngularStiffness,
                            dim::kDamping,
                            dim::kAngularDamping,
                            dim::kIntegralGain,
                            dim::kAngularIntegralGain,
                            dim::kVoltage,
                            dim::kCurrent,
                            dim::kResistance,
                            dim::kTorqueConstant,
                            dim::kBackEmf,
                            dim::kForceConstant,
                            Dimension{2, -1, 3, -2, 1}}) {
    INFO(unit_of(d));
    const auto unit = parse_unit(unit_of(d));
    REQUIRE(unit);
    CHECK(unit->dimension == d);
    CHECK(unit->to_si(3.5) == 3.5);
  }
}

TEST_CASE("radians may be left out only where mass is involved", "[units]") {
  CHECK(fits(parse_unit("N*m*s")->dimension, dim::kAngularDamping));
  CHECK(fits(parse_unit("N*m")->dimension, dim::kAngularStiffness));
  CHECK_FALSE(fits(dim::kFrequency, dim::kAngularSpeed));
  CHECK_FALSE(fits(dim::kNone, dim::kAngle));
  CHECK_FALSE(fits(dim::kAngularStiffness, dim::kTorque));
}

TEST_CASE("one unit applies to the list, or each entry has its own", "[units]") {
  CHECK(si("24 14 4 cm") == std::vector<double>{0.24, 0.14, 0.04});
  CHECK(si("24 cm 14 cm 40 mm") == std::vector<double>{0.24, 0.14, 0.04});
  CHECK(si("1 2 3") == std::vector<double>{1, 2, 3});
  CHECK(si("-9 cm 0 ${-(4 cm)/2}") == std::vector<double>{-0.09, 0.0, -0.02});
  CHECK(si("0 0 5 cm") == std::vector<double>{0, 0, 0.05});
  CHECK(si("${[1, 2, 3]} cm").size() == 3);
  CHECK(si("-${2} 0 0") == std::vector<double>{-2, 0, 0});
  CHECK(si("").empty());
  CHECK(fault_code("24 cm 14 4") == "CG0505");
  CHECK(fault_code("24 14 cm 4") == "CG0505");
  CHECK(si("${1 m} 2 3") == std::vector<double>{1, 2, 3});
  CHECK(fault_code("${1 m} 2 cm 3") == "CG0505");
  CHECK(fault_code("5cm") == "CG0501");
  CHECK(fault_code("1,5") == "CG0501");
  CHECK(fault_code("cm") == "CG0501");
  CHECK(fault_code("3 kgs") == "CG0504");
  CHECK(fault_code("3 cm cm") == "CG0501");
  CHECK(fault_code("${1 m} cm") == "CG0502");
  CHECK(fault_code("${1") == "CG0511");
  CHECK(fault_code("${1}${2}") == "CG0501");
  NumberSyntax dots;
  dots.dots = true;
  CHECK(si("2 .. 80 cm", dots) == std::vector<double>{0.02, 0.8});
  CHECK(si("2..80 cm", dots) == std::vector<double>{0.02, 0.8});
  CHECK(fault_code("2 80 cm", dots) == "CG0501");
  CHECK(fault_code("2 .. .. 80 cm", dots) == "CG0501");
  NumberSyntax commas;
  commas.commas = true;
  CHECK(si("0 0, 1 0; 1 1", commas) == std::vector<double>{0, 0, 1, 0, 1, 1});
}

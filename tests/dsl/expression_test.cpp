// The expressions in ${…}: values, dimensions, faults, totality.
#include <catch2/catch.hpp>

#include <cmath>

#include "syntax/element.h"
#include "values/value.h"

using namespace cogrsim::dsl;

namespace {

struct Result {
  Value value;
  std::optional<ExpressionFault> fault;
};

Result run(const std::string& text, const Scope* scope = nullptr,
           cogrsim::RandomStream* random = nullptr) {
  Result r;
  r.value = evaluate(text, {scope, random}, r.fault);
  return r;
}

double number(const std::string& text, const Scope* scope = nullptr) {
  const Result r = run(text, scope);
  INFO(text << ": " << (r.fault ? r.fault->message : ""));
  REQUIRE(r.value.as_number());
  return r.value.as_number()->value;
}

Dimension dimension(const std::string& text) {
  const Result r = run(text);
  INFO(text << ": " << (r.fault ? r.fault->message : ""));
  REQUIRE(r.value.as_number());
  return r.value.as_number()->dimension;
}

bool truth(const std::string& text) {
  const Result r = run(text);
  INFO(text << ": " << (r.fault ? r.fault->message : ""));
  REQUIRE(r.value.as_boolean());
  return *r.value.as_boolean();
}

std::string code(const std::string& text) {
  const Result r = run(text);
  return r.fault ? r.fault->code : "";
}

}  // namespace

TEST_CASE("operators bind as in mathematics", "[expression]") {
  CHECK(number("1 + 2 * 3") == 7);
  CHECK(number("(1 + 2) * 3") == 9);
  CHECK(number("2 ^ 3 ^ 2") == 512);
  CHECK(number("-2 ^ 2") == -4);
  CHECK(number("2 ^ -1") == 0.5);
  CHECK(number("10 - 4 - 3") == 3);
  CHECK(number("12 / 3 / 2") == 2);
  CHECK(number("7 % 3") == 1);
  CHECK(number("-1 % 4") == 3);
  CHECK(number("2 * -3") == -6);
  CHECK(number("1e3 + .5") == 1000.5);
  CHECK(truth("1 lt 2 and 2 lt 3 or false"));
  CHECK(truth("not 1 gt 2"));
  CHECK(truth("1 + 1 eq 2"));
  CHECK(truth("'a' eq 'a' and 'a' ne 'b'"));
}

TEST_CASE("functions", "[expression]") {
  CHECK(number("min(3, 1, 2)") == 1);
  CHECK(number("max([3, 1, 2])") == 3);
  CHECK(number("abs(-3)") == 3);
  CHECK(number("sqrt(9)") == 3);
  CHECK(number("sin(90 deg)") == Approx(1.0));
  CHECK(number("cos(pi * 1 rad)") == Approx(-1.0));
  CHECK(number("tan(45 deg)") == Approx(1.0));
  CHECK(number("atan2(1, 1)") == Approx(0.78539816339744830962));
  CHECK(number("floor(2.7) + ceil(2.1) + round(2.5)") == 8);
  CHECK(number("if(1 lt 2, 3, 4)") == 3);
  CHECK(number("if(false, 1 / 0, 5)") == 5);
  CHECK(number("if(true, 5, sqrt(-1))") == 5);
  CHECK_FALSE(truth("false and 1 / 0 gt 1"));
}

TEST_CASE("dimensions go through expressions", "[expression]") {
  CHECK(dimension("2 m * 3 m") == Dimension{2, 0, 0, 0, 0});
  CHECK(dimension("2 m/s * 3 s") == dim::kLength);
  CHECK(dimension("6 N*m / 2 m") == dim::kForce);
  CHECK(dimension("1 m / 1 m").none());
}

TEST_CASE("units in expressions", "[expression]") {
  CHECK(number("30 deg") == Approx(0.52359877559829887308));
  CHECK(number("(4-2)*30 deg") == Approx(1.0471975511965977462));
  CHECK(number("10 cm/2") == 0.05);
  CHECK(dimension("sqrt(4 m^2)") == dim::kLength);
  CHECK(dimension("(2 m)^3") == Dimension{3, 0, 0, 0, 0});
  CHECK(dimension("0 + 2 m") == dim::kLength);
  CHECK(dimension("max(0, 2 m)") == dim::kLength);
  CHECK(dimension("-(2 kg)") == dim::kMass);
  CHECK(truth("2 m gt 0"));
  CHECK(truth("10 cm eq 100 mm"));
  Scope scope;
  scope.set("s", Value::number(4));
  scope.set("n", Value::number(5));
  CHECK(number("2 m / s", &scope) == 0.5);  // blanks: divided by the variable
  CHECK(number("2 m/s", &scope) == 2);      // none: the unit
  CHECK(number("10 cm/n", &scope) == 0.02);
  CHECK(code("1 m + 1") == "CG0513");
  CHECK(code("1 m + 1 kg") == "CG0513");
  CHECK(code("1 m lt 1 s") == "CG0513");
  CHECK(code("sin(1)") == "CG0513");
  CHECK(code("2 ^ (1 m)") == "CG0513");
  CHECK(code("floor(1 m)") == "CG0513");
}

TEST_CASE("names are looked up outwards, until a prototype's border", "[expression]") {
  Scope outer;
  outer.set("a", Value::number(1));
  Scope inner(&outer);
  inner.set("b", Value::number(2));
  Scope closed(&inner, true);
  CHECK(number("a + b", &inner) == 3);
  CHECK(run("a", &closed).fault->code == "CG0512");
  CHECK(outer.unused().empty());
  Scope poisoned;
  poisoned.set("p", Value::poison());
  const Result r = run("p + 1 m", &poisoned);
  CHECK(r.value.is_poison());
  CHECK_FALSE(r.fault);  // the failure was reported already
}

TEST_CASE("lists and texts", "[expression]") {
  const Result r = run("[['left', 1], ['right', -1]]");
  REQUIRE(r.value.as_list());
  REQUIRE(r.value.as_list()->size() == 2);
  CHECK(to_text(r.value) == "[[left, 1], [right, -1]]");
  CHECK(to_text(run("'a' + 'b'").value) == "ab");
  CHECK(run("[1] + [2, 3]").value.as_list()->size() == 3);
  CHECK(run("[]").value.as_list()->empty());
}

TEST_CASE("drawing is seeded, ordered, and refused without a stream", "[expression]") {
  cogrsim::RandomStream a(7, "x"), b(7, "x");
  const Value first = run("uniform(1 m, 2 m)", nullptr, &a).value;
  REQUIRE(first.as_number());
  CHECK(first.as_number()->dimension == dim::kLength);
  CHECK(first.as_number()->value >= 1.0);
  CHECK(first.as_number()->value < 2.0);
  CHECK(run("uniform(1 m, 2 m)", nullptr, &b).value.as_number()->value == first.as_number()->value);
  CHECK(run("normal(0, 3 mm)", nullptr, &a).value.as_number()->dimension == dim::kLength);
  CHECK(code("uniform(0, 1)") == "CG0513");
  CHECK(run("uniform(2, 1)", nullptr, &a).fault->code == "CG0513");
}

TEST_CASE("faults point at what is wrong", "[expression]") {
  const Result r = run("1 + raduis * 2");
  REQUIRE(r.fault);
  CHECK(r.fault->code == "CG0512");
  CHECK(r.fault->begin == 4);
  CHECK(r.fault->length == 6);
  for (const char* bad :
       {"",   " ",    "1 +", "(1", "1)",  "[1, 2", "1 2", "a b",  "1 == 2", "1 < 2", "&",
        "f(", "'abc", "1,5", ",",  "if(", "*",     "lt",  "1 lt", "not",    "§"}) {
    INFO(bad);
    const Result broken = run(bad);
    CHECK(broken.fault);
    CHECK(broken.value.is_poison());
    if (broken.fault) CHECK_FALSE(broken.fault->message.empty());
  }
  CHECK(code("1 / 0") == "CG0514");
  CHECK(code("10 ^ 400") == "CG0514");
  CHECK(code("sqrt(-1)") == "CG0514");
  CHECK(code("3 zorkmids") == "CG0504");
  CHECK(code("12abc") == "CG0501");
  CHECK(code("foo(1)") == "CG0512");
  CHECK(code("min()") == "CG0513");
  CHECK(code("(1 m)^50 * (1 m)^50 * (1 m)^50 * (1 m)^50") == "CG0513");
}

TEST_CASE("deep nesting ends in a fault, not in a crash", "[expression]") {
  for (const char* piece : {"(", "[", "-", "not ", "abs(", "2^", "if(true,"}) {
    std::string text;
    for (int i = 0; i < 10000; ++i) text += piece;
    INFO(piece);
    CHECK(run(text).fault);
  }
}

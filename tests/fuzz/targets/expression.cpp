#include <cmath>

#include "cogrsim/core/random.h"
#include "cogrsim/dsl/study.h"
#include "syntax/element.h"
#include "targets.h"
#include "values/value.h"

namespace cogrsim::fuzz {
namespace {

using namespace dsl;

const Scope& names() {
  static const Scope* const scope = [] {
    auto* made = new Scope;
    made->set("n", Value::number(3.0));
    made->set("r", Value::number(0.04, dim::kLength));
    made->set("a", Value::number(0.5, dim::kAngle));
    made->set("side", Value::text("left"));
    made->set("on", Value::boolean(true));
    made->set("ys", Value::list({Value::number(1.0), Value::number(2.0)}));
    made->set("bad", Value::poison());
    return made;
  }();
  return *scope;
}

void evaluate_text(std::string_view text) {
  RandomStream random(7, "fuzz");
  std::optional<ExpressionFault> fault;
  const Value value = evaluate(text, {&names(), &random}, fault);
  if (fault) {
    require(value.is_poison(), "what is faulty has no value");
    require(fault->begin <= text.size(), "a fault lies within the text");
    require(!fault->message.empty() && !fault->code.empty(), "a fault has a code and a reason");
    return;
  }
  if (const Quantity* number = value.as_number()) {
    require(std::isfinite(number->value), "a number is finite");
  }
  to_text(value);
  describe(value);
}

}  // namespace

void expression(std::string_view input) {
  if (input.size() > 4096) return;
  evaluate_text(input);
  units::parse_number(input);
  units::parse_unit(input);
  if (const auto values = parse_study_values(input)) {
    require(!values->empty() && values->size() <= 100000, "a study has values, but not too many");
  }
  if (const auto seeds = parse_seeds(input)) require(!seeds->empty(), "a list of seeds has some");
}

}  // namespace cogrsim::fuzz

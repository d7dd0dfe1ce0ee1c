// Operators and functions of expressions, on values that are already there.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/parameter.h"
#include "values/value.h"

namespace cogrsim::dsl {

/// A value, or what is wrong. Poison in gives poison out, without a problem.
struct Outcome {
  Value value;
  const char* code = "CG0513";
  std::string problem = {};
  std::string help = {};
};

/// + - * / % ^ on numbers; + also joins texts and lists. A plain 0 goes with every dimension.
Outcome arithmetic(char op, const Value& a, const Value& b);
/// lt le gt ge eq ne; eq and ne also on texts and truth values.
Outcome comparison(std::string_view op, const Value& a, const Value& b);
Outcome logic(const Value& a, const Value& b, bool both);
Outcome negation(const Value& a);

bool is_function(std::string_view name);
const std::vector<std::string>& function_names();
/// `random` may be nullptr: drawing is then a problem.
Outcome call(std::string_view name, const ValueList& arguments, RandomStream* random);

}  // namespace cogrsim::dsl

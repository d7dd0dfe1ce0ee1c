#include "values/functions.h"

#include <algorithm>
#include <cmath>

#include "values/number_list.h"

namespace cogrsim::dsl {
namespace {

Outcome problem(std::string text, std::string help = {}, const char* code = "CG0513") {
  Outcome out;
  out.code = code;
  out.problem = std::move(text);
  out.help = std::move(help);
  return out;
}
Outcome good(Value v) {
  Outcome out;
  out.value = std::move(v);
  return out;
}
Outcome number(double value, Dimension dimension) {
  if (!std::isfinite(value)) {
    return problem("the result is not a finite number", {}, "CG0514");
  }
  return good(Value::number(value, dimension));
}

bool plain_zero(const Quantity& q) { return q.value == 0.0 && q.dimension.none(); }

/// The dimension both share; a plain 0 takes the other's.
std::optional<Dimension> common(const Quantity& a, const Quantity& b) {
  if (a.dimension == b.dimension) return a.dimension;
  if (plain_zero(a)) return b.dimension;
  if (plain_zero(b)) return a.dimension;
  return std::nullopt;
}

std::string unit_help(const Quantity& a, const Quantity& b) {
  const Quantity& plain = a.dimension.none() ? a : b;
  const Quantity& other = a.dimension.none() ? b : a;
  if (!plain.dimension.none() || other.dimension.none()) return {};
  return "give the number a unit, e.g. \"" + number_text(plain.value) + " " +
         unit_of(other.dimension) + "\"";
}

/// Exponents beyond what any physics needs are refused, so that they cannot overflow.
std::optional<Dimension> scaled_sum(const Dimension& a, int na, const Dimension& b, int nb) {
  Dimension out;
  bool fits_in = true;
  const auto add = [&](std::int8_t x, std::int8_t y, std::int8_t& to) {
    const int sum = x * na + y * nb;
    if (sum < -60 || sum > 60) fits_in = false;
    to = static_cast<std::int8_t>(std::clamp(sum, -60, 60));
  };
  add(a.m, b.m, out.m);
  add(a.kg, b.kg, out.kg);
  add(a.s, b.s, out.s);
  add(a.ampere, b.ampere, out.ampere);
  add(a.angle, b.angle, out.angle);
  add(a.byte, b.byte, out.byte);
  if (!fits_in) return std::nullopt;
  return out;
}

Outcome power(const Quantity& base, const Quantity& exponent) {
  if (!exponent.dimension.none()) {
    return problem("an exponent must be a plain number, not " + describe(exponent.dimension));
  }
  Dimension d;
  if (!base.dimension.none()) {
    const double n = exponent.value;
    if (n == 0.5) {
      return call("sqrt", {Value::number(base.value, base.dimension)}, nullptr);
    }
    if (n != std::floor(n) || std::abs(n) > 20) {
      return problem(describe(base.dimension) + " needs a small whole exponent");
    }
    const auto product = scaled_sum(base.dimension, static_cast<int>(n), {}, 0);
    if (!product) return problem("the dimension's exponents grow too large");
    d = *product;
  }
  return number(std::pow(base.value, exponent.value), d);
}

const char* verb(char op) {
  switch (op) {
    case '+':
      return "added to";
    case '-':
      return "subtracted from";
    default:
      return "combined with";
  }
}

Outcome wrong_count(std::string_view name, const char* wanted, std::size_t found) {
  return problem(std::string(name) + " takes " + wanted + ", found " + std::to_string(found));
}

Outcome need_number(std::string_view name, const Value& v) {
  return problem(std::string(name) + " takes numbers, found " + describe(v),
                 v.as_text() ? nearly_number_help(*v.as_text()) : "");
}

Outcome trigonometry(std::string_view name, const Quantity& q) {
  if (q.dimension != dim::kAngle && !plain_zero(q)) {
    return problem(std::string(name) + " takes an angle, found " + describe(q.dimension),
                   q.dimension.none() ? "write the angle's unit, or multiply by \"1 rad\"" : "");
  }
  const double value = name == "sin"   ? std::sin(q.value)
                       : name == "cos" ? std::cos(q.value)
                                       : std::tan(q.value);
  return number(value, {});
}

Outcome least_or_greatest(bool least, const ValueList& arguments) {
  // min([…]) unpacks its list.
  const ValueList* list = arguments.size() == 1 ? arguments[0].as_list() : nullptr;
  const ValueList& all = list ? *list : arguments;
  const char* name = least ? "min" : "max";
  if (all.empty()) return wrong_count(name, "at least one argument", 0);
  Quantity best;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].is_poison()) return good(Value::poison());
    const Quantity* q = all[i].as_number();
    if (!q) return need_number(name, all[i]);
    if (i == 0) {
      best = *q;
      continue;
    }
    const auto dimension = common(best, *q);
    if (!dimension) {
      return problem(std::string(name) + " takes values of one dimension, found " +
                         describe(best.dimension) + " and " + describe(q->dimension),
                     unit_help(best, *q));
    }
    best.value = least ? std::min(best.value, q->value) : std::max(best.value, q->value);
    best.dimension = *dimension;
  }
  return number(best.value, best.dimension);
}

Outcome draw(std::string_view name, const Quantity& a, const Quantity& b, RandomStream* random) {
  const auto dimension = common(a, b);
  if (!dimension) {
    return problem(std::string(name) + " takes two values of one dimension, found " +
                       describe(a.dimension) + " and " + describe(b.dimension),
                   unit_help(a, b));
  }
  if (!random) return problem("random numbers cannot be drawn here");
  if (name == "uniform") {
    if (a.value > b.value) {
      return problem("uniform: the first bound is above the second", "swap them");
    }
    return number(random->uniform(a.value, b.value), *dimension);
  }
  if (b.value < 0.0) return problem("normal: the standard deviation is negative");
  return number(random->normal(a.value, b.value), *dimension);
}

Outcome choose(const ValueList& arguments) {
  if (arguments.size() != 3) return wrong_count("if", "three arguments", arguments.size());
  if (arguments[0].is_poison()) return good(Value::poison());
  const bool* condition = arguments[0].as_boolean();
  if (!condition) {
    return problem("the first argument of if must be true or false, found " +
                   describe(arguments[0]));
  }
  return good(arguments[*condition ? 1 : 2]);
}

}  // namespace

Outcome arithmetic(char op, const Value& a, const Value& b) {
  if (a.is_poison() || b.is_poison()) return good(Value::poison());
  const Quantity* x = a.as_number();
  const Quantity* y = b.as_number();
  if (op == '+' && a.as_text() && b.as_text()) {
    if (a.as_text()->size() + b.as_text()->size() > kLongestText) {
      return problem("the text grows too long",
                     "a text has at most " + std::to_string(kLongestText) + " bytes");
    }
    return good(Value::text(*a.as_text() + *b.as_text()));
  }
  if (op == '+' && a.as_list() && b.as_list()) {
    if (a.as_list()->size() + b.as_list()->size() > kLongestList) {
      return problem("the list grows too long");
    }
    ValueList both = *a.as_list();
    both.insert(both.end(), b.as_list()->begin(), b.as_list()->end());
    return good(Value::list(std::move(both)));
  }
  if (!x || !y) {
    const Value& other = x ? b : a;
    return problem(std::string("'") + op + "' takes numbers, found " + describe(other),
                   other.as_text() ? nearly_number_help(*other.as_text()) : "");
  }
  switch (op) {
    case '+':
    case '-':
    case '%': {
      const auto dimension = common(*x, *y);
      if (!dimension) {
        return problem((op == '-' ? describe(y->dimension) : describe(x->dimension)) +
                           " cannot be " + verb(op) + " " +
                           (op == '-' ? describe(x->dimension) : describe(y->dimension)),
                       unit_help(*x, *y));
      }
      if (op == '%') {
        if (y->value == 0.0) return problem("division by zero", {}, "CG0514");
        // The result has the divisor's sign, so that -1 % 4 counts round.
        const double r = std::fmod(x->value, y->value);
        return number(r != 0.0 && (r < 0.0) != (y->value < 0.0) ? r + y->value : r, *dimension);
      }
      return number(op == '+' ? x->value + y->value : x->value - y->value, *dimension);
    }
    case '*':
    case '/': {
      if (op == '/' && y->value == 0.0) return problem("division by zero", {}, "CG0514");
      const auto dimension = scaled_sum(x->dimension, 1, y->dimension, op == '*' ? 1 : -1);
      if (!dimension) return problem("the dimension's exponents grow too large");
      return number(op == '*' ? x->value * y->value : x->value / y->value, *dimension);
    }
    default:
      return power(*x, *y);
  }
}

Outcome comparison(std::string_view op, const Value& a, const Value& b) {
  if (a.is_poison() || b.is_poison()) return good(Value::poison());
  const bool equality = op == "eq" || op == "ne";
  if (equality && ((a.as_text() && b.as_text()) || (a.as_boolean() && b.as_boolean()))) {
    const bool same =
        a.as_text() ? *a.as_text() == *b.as_text() : *a.as_boolean() == *b.as_boolean();
    return good(Value::boolean(same == (op == "eq")));
  }
  const Quantity* x = a.as_number();
  const Quantity* y = b.as_number();
  if (!x || !y) {
    return problem(describe(a) + " cannot be compared with " + describe(b));
  }
  if (!common(*x, *y)) {
    return problem(describe(x->dimension) + " cannot be compared with " + describe(y->dimension),
                   unit_help(*x, *y));
  }
  const double l = x->value, r = y->value;
  const bool holds = op == "lt"   ? l < r
                     : op == "le" ? l <= r
                     : op == "gt" ? l > r
                     : op == "ge" ? l >= r
                     : op == "eq" ? l == r
                                  : l != r;
  return good(Value::boolean(holds));
}

Outcome logic(const Value& a, const Value& b, bool both) {
  if (a.is_poison() || b.is_poison()) return good(Value::poison());
  const bool* x = a.as_boolean();
  const bool* y = b.as_boolean();
  if (!x || !y) {
    return problem(std::string("\"") + (both ? "and" : "or") + "\" takes true or false, found " +
                   describe(x ? b : a));
  }
  return good(Value::boolean(both ? *x && *y : *x || *y));
}

Outcome negation(const Value& a) {
  if (a.is_poison()) return good(Value::poison());
  const bool* x = a.as_boolean();
  if (!x) return problem("\"not\" takes true or false, found " + describe(a));
  return good(Value::boolean(!*x));
}

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = {"if",   "min",   "max",     "abs",   "sqrt",
                                                 "sin",  "cos",   "tan",     "atan2", "floor",
                                                 "ceil", "round", "uniform", "normal"};
  return names;
}

bool is_function(std::string_view name) {
  const auto& all = function_names();
  return std::find(all.begin(), all.end(), name) != all.end();
}

Outcome call(std::string_view name, const ValueList& arguments, RandomStream* random) {
  if (name == "if") return choose(arguments);
  if (name == "min" || name == "max") return least_or_greatest(name == "min", arguments);
  for (const Value& v : arguments) {
    if (v.is_poison()) return good(Value::poison());
  }
  const bool two = name == "atan2" || name == "uniform" || name == "normal";
  if (arguments.size() != (two ? 2u : 1u)) {
    return wrong_count(name, two ? "two arguments" : "one argument", arguments.size());
  }
  for (const Value& v : arguments) {
    if (!v.as_number()) return need_number(name, v);
  }
  const Quantity& a = *arguments[0].as_number();
  if (two) {
    const Quantity& b = *arguments[1].as_number();
    if (name != "atan2") return draw(name, a, b, random);
    if (!common(a, b)) {
      return problem("atan2 takes two values of one dimension, found " + describe(a.dimension) +
                         " and " + describe(b.dimension),
                     unit_help(a, b));
    }
    return number(std::atan2(a.value, b.value), dim::kAngle);
  }
  if (name == "sin" || name == "cos" || name == "tan") return trigonometry(name, a);
  if (name == "abs") return number(std::abs(a.value), a.dimension);
  if (name == "sqrt") {
    if (a.value < 0.0) return problem("the root of a negative number", {}, "CG0514");
    const Dimension& d = a.dimension;
    if (d.m % 2 || d.kg % 2 || d.s % 2 || d.ampere % 2 || d.angle % 2 || d.byte % 2) {
      return problem("sqrt of " + describe(d) + " has no dimension");
    }
    const auto half = [](std::int8_t x) { return static_cast<std::int8_t>(x / 2); };
    return number(std::sqrt(a.value),
                  {half(d.m), half(d.kg), half(d.s), half(d.ampere), half(d.angle), half(d.byte)});
  }
  // floor, ceil, round: the unit of the whole number would be ambiguous.
  if (!a.dimension.none()) {
    return problem(
        std::string(name) + " takes a plain number, found " + describe(a.dimension),
        "divide by a unit first: " + std::string(name) + "(x / 1 " + unit_of(a.dimension) + ")");
  }
  return number(name == "floor"  ? std::floor(a.value)
                : name == "ceil" ? std::ceil(a.value)
                                 : std::round(a.value),
                {});
}

}  // namespace cogrsim::dsl

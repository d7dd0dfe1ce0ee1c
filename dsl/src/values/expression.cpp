// The expressions inside ${…}, computed while they are read. The operators are in the tables below;
//
//   primary = number [unit] | 'text' | name | name "(" list ")" | "(" all ")" | "[" list "]"
//
// A unit follows its number and is read as far as it goes without a blank: "2 m/s" is a speed,
// "2 m / s" divides by something called s.
#include <algorithm>
#include <cmath>
#include <functional>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/expression.h"
#include "syntax/element.h"
#include "syntax/text.h"
#include "values/functions.h"
#include "values/number_list.h"

namespace cogrsim::dsl {
namespace {

using expression::in_word;
using expression::Operator;

constexpr int kDeepest = 100;  // nested brackets and signs

class Parser : expression::Parser<Parser, Value, kDeepest> {
  friend expression::Parser<Parser, Value, kDeepest>;
  enum Level { kOr = 1, kAnd, kNot, kCompare, kSum, kProduct, kSign, kPower };
  static constexpr Operator kPrefix[] = {
      {"not", kNot, kNot}, {"-", kSign, kSign}, {"+", kSign, kSign}};
  static constexpr Operator kInfix[] = {{"or", kOr, kAnd},
                                        {"and", kAnd, kNot},
                                        {"lt", kCompare, kSum, false},
                                        {"le", kCompare, kSum, false},
                                        {"gt", kCompare, kSum, false},
                                        {"ge", kCompare, kSum, false},
                                        {"eq", kCompare, kSum, false},
                                        {"ne", kCompare, kSum, false},
                                        {"+", kSum, kProduct},
                                        {"-", kSum, kProduct},
                                        {"*", kProduct, kSign},
                                        {"/", kProduct, kSign},
                                        {"%", kProduct, kSign},
                                        {"^", kPower, kSign}};

 public:
  Parser(std::string_view text, const Environment& environment,
         std::optional<ExpressionFault>& fault)
      : expression::Parser<Parser, Value, kDeepest>(text),
        environment_(environment),
        fault_(fault) {}

  Value run() {
    Value v = nested(kOr);
    skip_blanks();
    if (!fault_ && at_ < text_.size()) unexpected();
    return fault_ ? Value::poison() : v;
  }

 private:
  Value fail(const char* code, std::size_t begin, std::size_t length, std::string message,
             std::string help = {}) {
    if (!fault_) {
      fault_ = ExpressionFault{code, begin, std::max<std::size_t>(1, length), std::move(message),
                               std::move(help)};
    }
    at_ = text_.size();  // unwinds every loop
    return Value::poison();
  }
  Value unexpected() {
    skip_blanks();
    if (at_ >= text_.size()) {
      return fail("CG0511", text_.empty() ? 0 : text_.size() - 1, 1,
                  text_.empty() ? "an empty expression" : "the expression ends too early");
    }
    const char c = text_[at_];
    std::string help;
    if (c == '<' || c == '>' || c == '=' || c == '!') {
      help = "the comparison operators are lt le gt ge eq ne";
    } else if (c == '&' || c == '|') {
      help = "write \"and\" and \"or\"";
    } else if (c == ',') {
      help = "numbers have a decimal point: 1.5";
    } else if (c == '$' || c == '{') {
      std::size_t begin = std::min(text_.find_first_not_of("${", at_), text_.size()), end = begin;
      while (end < text_.size() && in_word(text_[end])) ++end;
      help = "inside an expression a parameter is written as its name alone";
      if (end > begin) help += ": " + std::string(text_.substr(begin, end - begin));
    }
    std::size_t length = 1;
    while (at_ + length < text_.size() &&
           (static_cast<unsigned char>(text_[at_ + length]) & 0xC0) == 0x80) {
      ++length;
    }
    std::string found(text_.substr(at_, length));
    if (plain_minus(found) == "-") help = "the minus sign is \"-\"";
    if (const std::string_view word = peek_word(); !word.empty()) found = std::string(word);
    return fail("CG0511", at_, found.size(), "\"" + found + "\" was not expected here", help);
  }

  /// The value of an operation over text from `begin` to here, or its fault.
  Value finish(std::size_t begin, Outcome outcome) {
    if (outcome.problem.empty()) return bounded(begin, std::move(outcome.value));
    if (skipping_ > 0) return Value::poison();
    std::size_t end = at_;
    while (end > begin && is_blank(text_[end - 1])) --end;
    return fail(outcome.code, begin, end - begin, std::move(outcome.problem),
                std::move(outcome.help));
  }
  /// A text or list that was made here, unless it or all of them grow too large.
  Value bounded(std::size_t begin, Value value) {
    if (value.as_text() == nullptr && value.as_list() == nullptr) return value;
    constexpr std::size_t kMost = 64 * kLongestList;
    const std::size_t size = size_of(value, kMost + 1);
    if (size > kMost) {
      return fail("CG0511", begin, at_ - begin, "the list grows too long",
                  "it has at most 100000 entries, with those of the lists inside");
    }
    if (environment_.budget == nullptr) return value;
    if (kWorkOfValue * size > *environment_.budget) {
      *environment_.budget = 0;
      return fail("CG0511", begin, at_ - begin,
                  "the expressions of this scene make too much text and too many lists",
                  "64 MB in all are the limit");
    }
    *environment_.budget -= kWorkOfValue * size;
    return value;
  }

  // ---- grammar

  Value too_deep(const Operator* op) {
    return fail("CG0511", at_, 1,
                op == nullptr        ? "brackets are nested too deep"
                : op->level == kNot  ? "too many \"not\""
                : op->level == kSign ? "too many signs"
                                     : "too many powers");
  }

  template <class Operand>
  Value prefix(std::size_t begin, const Operator& op, const Operand& operand) {
    return finish(begin, op.level == kNot ? negation(operand())
                                          : arithmetic(op.text[0], Value::number(0.0), operand()));
  }

  template <class Operand>
  Value infix(std::size_t begin, const Operator& op, Value left, const Operand& right) {
    if (op.level == kCompare) return finish(begin, comparison(op.text, left, right()));
    if (op.level > kCompare) return finish(begin, arithmetic(op.text[0], left, right()));
    // The right side does not count where the left side decides.
    const bool both = op.level == kAnd;
    const bool decided = left.as_boolean() && *left.as_boolean() != both;
    skipping_ += decided;
    const Value other = right();
    skipping_ -= decided;
    if (fault_) return Value::poison();
    return decided ? left : finish(begin, logic(left, other, both));
  }

  Value primary() {
    if (here() >= text_.size()) return unexpected();
    const char c = text_[at_];
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) {
      return parse_number_with_unit();
    }
    if (c == '\'' || c == '"') return parse_quoted(c);
    if (take("(")) {
      Value v = nested(kOr);
      if (!fault_ && !take(")")) return missing(")");
      return v;
    }
    if (take("[")) {
      ValueList entries;
      const std::size_t begin = at_ - 1;
      return parse_list("]", entries) ? bounded(begin, Value::list(std::move(entries)))
                                      : Value::poison();
    }
    if (is_letter(c)) return parse_name();
    return unexpected();
  }

  Value missing(std::string_view bracket) {
    skip_blanks();
    if (at_ < text_.size()) return unexpected();
    return fail("CG0511", text_.size() - 1, 1,
                "a '" + std::string(bracket) + "' is missing at the end");
  }

  bool parse_list(std::string_view close, ValueList& out) {
    if (take(close)) return true;
    do {
      out.push_back(nested(kOr));
      if (fault_) return false;
    } while (take(","));
    if (take(close)) return true;
    missing(close);
    return false;
  }

  Value parse_quoted(char quote) {
    const std::size_t begin = at_++;
    const std::size_t end = text_.find(quote, at_);
    if (end == std::string_view::npos) {
      return fail("CG0511", begin, text_.size() - begin, "the text's closing quote is missing");
    }
    std::string text(text_.substr(at_, end - at_));
    at_ = end + 1;
    return Value::text(std::move(text));
  }

  Value parse_number_with_unit() {
    const std::size_t begin = at_;
    std::size_t end = at_;
    while (end < text_.size() && (is_digit(text_[end]) || text_[end] == '.')) ++end;
    if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
      std::size_t digits = end + 1;
      if (digits < text_.size() && (text_[digits] == '+' || text_[digits] == '-')) ++digits;
      if (digits < text_.size() && is_digit(text_[digits])) {
        while (digits < text_.size() && is_digit(text_[digits])) ++digits;
        end = digits;
      }
    }
    const std::optional<double> number = parse_number(text_.substr(begin, end - begin));
    at_ = end;
    if (!number || (end < text_.size() && is_letter(text_[end]))) {
      while (at_ < text_.size() && in_word(text_[at_])) ++at_;
      const std::string word(text_.substr(begin, at_ - begin));
      const std::string unit(text_.substr(end, at_ - end));
      std::string help;
      if (number && parse_unit(unit)) {
        help =
            "did you mean \"" + std::string(text_.substr(begin, end - begin)) + " " + unit + "\"?";
      }
      return fail("CG0501", begin, word.size(), "\"" + word + "\" is not a number", help);
    }
    // The longest stretch of unit characters that makes a unit.
    std::size_t unit_begin = at_;
    while (unit_begin < text_.size() && text_[unit_begin] == ' ') ++unit_begin;
    std::optional<Unit> unit;
    const std::size_t unit_end = expression::longest_known(
        text_, unit_begin,
        [](char c) { return in_word(c) || c == '*' || c == '/' || c == '^' || c == '-'; },
        // Not in the middle of a word or before a call: "3 min(…)" is not a minute.
        [](char last, char next) { return next == '(' || (is_letter(last) && in_word(next)); },
        [&](std::string_view name) {
          unit = is_letter(name[0]) ? parse_unit(name) : std::nullopt;
          return unit.has_value();
        });
    if (unit) {
      at_ = unit_end;
      return Value::number(unit->to_si(*number), unit->dimension);
    }
    // A word behind a number that is not an operator was meant as a unit.
    const std::string_view word = peek_word();
    if (!word.empty() && std::none_of(std::begin(kInfix), std::end(kInfix),
                                      [&](const Operator& op) { return op.text == word; })) {
      const std::string near = nearest_unit(word);
      return fail("CG0504", at_, word.size(), "\"" + std::string(word) + "\" is not a unit",
                  near.empty() ? "to multiply, write *" : "did you mean \"" + near + "\"?");
    }
    return Value::number(*number);
  }

  /// if(c, a, b): the branch not taken is read but cannot fail, so that a condition can prevent a
  /// division by zero.
  Value parse_if(std::size_t begin) {
    ValueList parts;
    if (take(")")) return finish(begin, call("if", parts, nullptr));
    do {
      const bool* condition = parts.empty() ? nullptr : parts[0].as_boolean();
      const bool skip = condition && parts.size() == (*condition ? 2u : 1u);
      skipping_ += skip;
      parts.push_back(nested(kOr));
      skipping_ -= skip;
      if (fault_) return Value::poison();
    } while (take(","));
    if (!take(")")) return missing(")");
    return finish(begin, call("if", parts, nullptr));
  }

  Value parse_name() {
    const std::size_t begin = at_;
    const std::string name(peek_word());
    at_ += name.size();
    if (take("(")) {
      if (name == "if") return parse_if(begin);
      ValueList arguments;
      if (!parse_list(")", arguments)) return Value::poison();
      if (!is_function(name)) {
        const std::string near = nearest_name(name, function_names());
        return fail("CG0512", begin, name.size(), "there is no function \"" + name + "\"",
                    near.empty() ? "" : "did you mean \"" + near + "\"?");
      }
      return finish(begin, call(name, arguments, environment_.random));
    }
    if (name == "true") return Value::boolean(true);
    if (name == "false") return Value::boolean(false);
    if (environment_.scope) {
      if (const Value* v = environment_.scope->find(name)) return *v;
    }
    if (name == "pi") return Value::number(kPi);
    std::string help;
    if (is_function(name)) {
      help = name + " is a function: " + name + "(…)";
    } else {
      std::vector<std::string> known;
      if (environment_.scope) known = environment_.scope->names();
      const std::string near = nearest_name(name, known);
      if (!near.empty()) {
        help = "did you mean \"" + near + "\"?";
      } else if (name == "nan" || name == "inf") {
        help = "values must be finite numbers";
      } else if (known.empty()) {
        help = "no parameters are visible here; text is written in quotes: '" + name + "'";
      } else {
        std::sort(known.begin(), known.end());
        known.erase(std::unique(known.begin(), known.end()), known.end());
        help = "visible here: ";
        for (std::size_t i = 0; i < known.size() && i < 12; ++i) {
          help += (i ? ", " : "") + known[i];
        }
        if (known.size() > 12) help += ", …";
      }
    }
    return fail("CG0512", begin, name.size(), "unknown name \"" + name + "\"", help);
  }

  const Environment& environment_;
  std::optional<ExpressionFault>& fault_;
  int skipping_ = 0;  // inside a branch that does not count
};

}  // namespace

Value evaluate(std::string_view expression, const Environment& environment,
               std::optional<ExpressionFault>& fault) {
  fault.reset();
  return Parser(expression, environment, fault).run();
}

}  // namespace cogrsim::dsl

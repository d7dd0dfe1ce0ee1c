#include "signals/arithmetic.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/expression.h"
#include "signals/node.h"

namespace cogrsim {
namespace {

constexpr int kDeepest = 50;

using expression::in_word;
using expression::is_blank;
using expression::is_digit;
using expression::is_letter;
using expression::Operator;

struct Number final : Signal::Node {
  /// An empty `unit_text` means a number without a unit.
  Number(double v, std::string written, const units::Unit& u, std::string unit_text)
      : number(u.to_si(v)), of(u.dimension), without_unit(unit_text.empty()) {
    text = quantity = without_unit ? std::move(written) : fmt::format("{} {}", written, unit_text);
    unit = without_unit || of.none() ? "1" : units::unit_of(of);
  }
  double value(const Frame&) const override { return number; }
  std::uint64_t revision(const Frame&) const override { return 0; }
  std::optional<units::Dimension> dimension() const override { return of; }
  bool constant() const override { return true; }
  bool bare() const override { return without_unit; }
  double number;
  units::Dimension of;
  bool without_unit;
};

/// A function of one number. Trigonometric ones take an angle, or a number without unit in rad.
struct FunctionSpec {
  const char* name;
  double (*of)(double);
  bool keeps_unit;  ///< else the result has no unit
  bool takes_angle;
};
constexpr FunctionSpec kFunctions[] = {
    {"abs", [](double x) { return std::abs(x); }, true, false},
    {"sin", [](double x) { return std::sin(x); }, false, true},
    {"cos", [](double x) { return std::cos(x); }, false, true},
    {"exp", [](double x) { return std::exp(x); }, false, false},
};

enum class Operation { none, sum, product };

// Kind of the root of an expression; only a sum or a product may need brackets.
Operation operation_of(const SignalNode& node);
// Text of a node inside another one. Brackets are only added where the meaning would change
// otherwise, so that the text is never nested deeper than the original and stays within the limit.
std::string operand(const SignalNode& node, bool bracket) {
  return bracket ? "(" + node->text + ")" : node->text;
}

/// -a, and functions of a.
struct Unary final : Signal::Node {
  /// Without a function: -a.
  Unary(SignalNode of, const FunctionSpec* what) : a(std::move(of)), function(what) {
    text = function ? fmt::format("{}({})", function->name, a->text)
                    : "-" + operand(a, operation_of(a) != Operation::none);
    quantity = keeps_unit() ? a->quantity : text;
    unit = keeps_unit() ? a->unit : "1";
    needs = a->needs;
  }
  bool keeps_unit() const { return !function || function->keeps_unit; }
  double value(const Frame& frame) const override {
    const double v = a->value(frame);
    if (!function) return -v;
    const double result = function->of(v);
    return std::isfinite(result) ? result : kNaN;  // infinity could not be compared or averaged
  }
  std::uint64_t revision(const Frame& frame) const override { return a->revision(frame); }
  std::optional<units::Dimension> dimension() const override {
    return keeps_unit() ? a->dimension() : units::Dimension{};
  }
  bool constant() const override { return a->constant(); }
  bool bare() const override { return keeps_unit() && a->bare(); }
  SignalNode a;
  const FunctionSpec* function;
};

struct Binary final : Signal::Node {
  Binary(SignalNode first, char op, SignalNode second, std::string unit_text)
      : a(std::move(first)), b(std::move(second)), sign(op) {
    const Operation left = operation_of(a), right = operation_of(b);
    // Blanks next to * and / end the unit of a number.
    text = fmt::format("{} {} {}", operand(a, product() && left == Operation::sum), sign,
                       operand(b, product() ? right != Operation::none : right == Operation::sum));
    quantity = a->quantity == b->quantity ? a->quantity : text;
    unit = std::move(unit_text);
    needs = a->needs | b->needs;
    all_bare = a->bare() && b->bare();
    of = combined();
  }
  double value(const Frame& frame) const override {
    const double x = a->value(frame), y = b->value(frame);
    switch (sign) {
      case '+':
        return x + y;
      case '-':
        return x - y;
      case '*':
        return x * y;
      default:
        return y == 0.0 ? kNaN : x / y;  // infinity could not be compared or averaged
    }
  }
  std::uint64_t revision(const Frame& frame) const override {
    return a->revision(frame) * 0x9e3779b97f4a7c15u + b->revision(frame);
  }
  std::optional<units::Dimension> dimension() const override { return of; }
  std::optional<units::Dimension> combined() const {
    const auto left = a->dimension(), right = b->dimension();
    if (!product()) return a->bare() || !left ? right : left;
    if (!left || !right) return std::nullopt;
    const int power = sign == '*' ? 1 : -1;
    const auto sum = [power](int x, int y) {
      return static_cast<std::int8_t>(std::clamp(x + power * y, -100, 100));
    };
    return units::Dimension{sum(left->m, right->m),         sum(left->kg, right->kg),
                            sum(left->s, right->s),         sum(left->ampere, right->ampere),
                            sum(left->angle, right->angle), sum(left->byte, right->byte)};
  }
  bool constant() const override { return a->constant() && b->constant(); }
  bool bare() const override { return all_bare; }
  bool product() const { return sign == '*' || sign == '/'; }
  SignalNode a, b;
  char sign;
  bool all_bare = false;  // cached, because every operator of a long expression uses it
  std::optional<units::Dimension> of;
};

Operation operation_of(const SignalNode& node) {
  const auto* binary = dynamic_cast<const Binary*>(node.get());
  if (binary == nullptr) return Operation::none;
  return binary->product() ? Operation::product : Operation::sum;
}

bool is_pure(const std::string& unit) { return unit == "1"; }

class Arithmetic : expression::Parser<Arithmetic, Result<SignalNode>, kDeepest> {
  using Parser = expression::Parser<Arithmetic, Result<SignalNode>, kDeepest>;
  friend Parser;
  enum Level { kSum, kProduct, kSign };
  static constexpr Operator kPrefix[] = {{"-", kSign, kSign}};
  static constexpr Operator kInfix[] = {
      {"+", kSum, kProduct}, {"-", kSum, kProduct}, {"*", kProduct, kSign}, {"/", kProduct, kSign}};

 public:
  using Leaf = std::function<Result<SignalNode>(const std::string&)>;
  Arithmetic(const std::string& text, const Leaf& leaf) : Parser(text), leaf_(leaf) {}

  Result<SignalNode> parse() {
    auto all = nested(kSum);
    if (!all) return all;
    if (here() < text_.size()) return misplaced();
    return all;
  }

 private:
  bool blank(std::size_t i) const { return i < text_.size() && is_blank(text_[i]); }
  // A plus or minus between terms has blanks on both sides.
  bool sign_between() const {
    return (next() == '+' || next() == '-') && at_ > 0 && blank(at_ - 1) && blank(at_ + 1);
  }
  static bool usable(const Result<SignalNode>& node) { return node.has_value(); }
  bool applies(const Operator& op) const {
    return &op == kPrefix || op.level != kSum || sign_between();
  }

  tl::unexpected<Error> misplaced() const {
    return fail(fmt::format("'{}' does not belong at character {} of '{}'", text_.substr(at_, 1),
                            at_ + 1, text_),
                "", "one attribute holds one signal; put blanks around + and -: a.x - b.x");
  }

  tl::unexpected<Error> too_deep(const Operator*) const {
    return fail("the signal has too many brackets inside each other", "",
                fmt::format("{} are the limit", kDeepest));
  }

  template <class Operand>
  Result<SignalNode> prefix(std::size_t, const Operator&, const Operand& operand) {
    auto of = operand();
    if (!of) return of;
    return SignalNode(std::make_shared<Unary>(*of, nullptr));
  }

  template <class Operand>
  Result<SignalNode> infix(std::size_t, const Operator& op, Result<SignalNode> left,
                           const Operand& right_of) {
    const auto right = right_of();
    if (!right) return right;
    return op.level == kSum ? added(*left, op.text[0], *right)
                            : multiplied(*left, op.text[0], *right);
  }

  Result<SignalNode> added(const SignalNode& a, char sign, const SignalNode& b) const {
    const bool number_a = a->bare(), number_b = b->bare();
    const auto da = a->dimension(), db = b->dimension();
    // An unknown unit (of a plugin's channel) is accepted.
    const bool fit = a->unit == b->unit || number_a || number_b || a->unit.empty() ||
                     b->unit.empty() || (da && db && *da == *db);
    if (!fit) {
      return fail(fmt::format("'{}' is in {} and '{}' in {}", a->text,
                              is_pure(a->unit) ? "pure numbers" : a->unit, b->text,
                              is_pure(b->unit) ? "pure numbers" : b->unit),
                  "", "only signals of the same unit are added or subtracted");
    }
    return std::make_shared<Binary>(a, sign, b, number_a || a->unit.empty() ? b->unit : a->unit);
  }

  static SignalNode multiplied(const SignalNode& a, char sign, const SignalNode& b) {
    return std::make_shared<Binary>(a, sign, b, units::combined_unit(a->unit, sign, b->unit));
  }

  Result<SignalNode> primary() {
    if (take("(")) return closed(nested(kSum));
    for (const FunctionSpec& function : kFunctions) {
      const std::string name = std::string(function.name) + "(";
      if (text_.substr(at_, name.size()) != name) continue;
      at_ += name.size();
      auto of = closed(nested(kSum));
      if (!of) return of;
      const auto dimension = (*of)->dimension();
      const bool fits = function.keeps_unit || !dimension || dimension->none() ||
                        (function.takes_angle && *dimension == units::dim::kAngle);
      if (fits) return SignalNode(std::make_shared<Unary>(*of, &function));
      return fail(fmt::format("{}({}): the argument has the unit {}", function.name, (*of)->text,
                              (*of)->unit),
                  "",
                  function.takes_angle
                      ? "it takes an angle, for example sin(2 rad/s * time)"
                      : "it takes a number without unit, for example exp(-1 * time / 2 s)");
    }
    if (is_digit(next())) return number();
    return signal();
  }

  Result<SignalNode> closed(Result<SignalNode> inside) {
    if (inside && !take(")"))
      return fail(fmt::format("a bracket of '{}' is not closed", text_), "", "every ( needs its )");
    return inside;
  }

  Result<SignalNode> number() {
    double value = 0.0;
    const char* begin = text_.data() + at_;
    const auto [rest, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc{} || !std::isfinite(value)) return misplaced();
    at_ += static_cast<std::size_t>(rest - begin);
    const std::string written(begin, rest);
    const std::size_t behind = at_;
    const std::size_t end = expression::longest_known(
        text_, here(),
        [&](char c) { return in_name(c) || std::string_view("^*/()-").find(c) != npos; },
        // At the end of a token: "m" in "m/robot.x".
        [&](char last, char next) { return in_name(last) && in_name(next); },
        [](std::string_view name) { return letter(name[0]) && units::parse_unit(name); });
    if (end == at_) {
      if (letter(next())) return unknown_unit(written);
      at_ = behind;
      return SignalNode(std::make_shared<Number>(value, written, units::Unit(), ""));
    }
    const std::string name(text_.substr(at_, end - at_));
    at_ = end;
    return SignalNode(std::make_shared<Number>(value, written, *units::parse_unit(name), name));
  }
  static constexpr auto npos = std::string_view::npos;
  static bool letter(char c) { return is_letter(c) && c != '_'; }
  static bool in_name(char c) { return in_word(c) || c == '.'; }

  tl::unexpected<Error> unknown_unit(const std::string& number) const {
    std::size_t end = at_;
    while (end < text_.size() && in_word(text_[end]) && text_[end] != '_') ++end;
    const std::string token(text_.substr(at_, end - at_)), near = units::nearest_unit(token);
    return fail(fmt::format("there is no unit '{}'", token), "",
                near.empty() ? "write one such as m, cm, deg, s, m/s or N*m"
                             : fmt::format("did you mean {} {}?", number, near));
  }

  // Text up to the next operator outside of brackets: distance(a, b), scan[3].
  Result<SignalNode> signal() {
    const std::size_t start = at_;
    int open = 0;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '(' || c == '[') {
        ++open;
      } else if (c == ')' || c == ']') {
        if (open == 0) break;
        --open;
      } else if (open == 0 && (c == '*' || c == '/' || sign_between())) {
        break;
      }
    }
    std::size_t end = at_;
    while (end > start && blank(end - 1)) --end;
    if (end == start && at_ < text_.size()) return misplaced();
    if (end == start && start > 0) {
      return fail(fmt::format("something is missing at the end of '{}'", text_));
    }
    const std::string name(text_.substr(start, end - start));
    if (name == "pi") return SignalNode(std::make_shared<Number>(kPi, name, units::Unit(), ""));
    return leaf_(name);
  }

  const Leaf& leaf_;
};

}  // namespace

Result<SignalNode> parse_arithmetic(
    const std::string& text, const std::function<Result<SignalNode>(const std::string&)>& signal) {
  return Arithmetic(text, signal).parse();
}

}  // namespace cogrsim

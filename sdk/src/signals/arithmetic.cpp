#include "signals/arithmetic.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "signals/node.h"

namespace cogrsim {
namespace {

constexpr int kDeepest = 50;

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

class Arithmetic {
 public:
  using Leaf = std::function<Result<SignalNode>(const std::string&)>;
  Arithmetic(const std::string& text, const Leaf& leaf) : text_(text), leaf_(leaf) {}

  Result<SignalNode> parse() {
    auto all = sum();
    if (!all) return all;
    skip();
    if (at_ < text_.size()) return misplaced();
    return all;
  }

 private:
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  char next() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool blank(std::size_t i) const {
    return i < text_.size() && std::isspace(static_cast<unsigned char>(text_[i]));
  }
  // A plus or minus between terms has blanks on both sides.
  bool sign_between() const {
    return (next() == '+' || next() == '-') && at_ > 0 && blank(at_ - 1) && blank(at_ + 1);
  }

  tl::unexpected<Error> misplaced() const {
    return fail(fmt::format("'{}' does not belong at character {} of '{}'", text_.substr(at_, 1),
                            at_ + 1, text_),
                "", "one attribute holds one signal; put blanks around + and -: a.x - b.x");
  }

  Result<SignalNode> sum() {
    auto left = product();
    while (left) {
      skip();
      if (!sign_between()) break;
      const char sign = text_[at_++];
      auto right = product();
      if (!right) return right;
      left = added(*left, sign, *right);
    }
    return left;
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

  Result<SignalNode> product() {
    auto left = factor();
    while (left) {
      skip();
      if (next() != '*' && next() != '/') break;
      const char sign = text_[at_++];
      auto right = factor();
      if (!right) return right;
      const std::string &ua = (*left)->unit, &ub = (*right)->unit;
      std::string unit;
      if (is_pure(ub)) {
        unit = ua;
      } else if (sign == '*') {
        unit = is_pure(ua) ? ub : fmt::format("{}*{}", ua, ub);
      } else {
        unit = ua == ub ? "1" : fmt::format("{}/({})", ua, ub);
      }
      left = SignalNode(std::make_shared<Binary>(*left, sign, *right, std::move(unit)));
    }
    return left;
  }

  Result<SignalNode> factor() {
    skip();
    if (++depth_ > kDeepest) {
      return fail("the signal has too many brackets inside each other", "",
                  fmt::format("{} are the limit", kDeepest));
    }
    auto made = inner_factor();
    --depth_;
    return made;
  }

  Result<SignalNode> inner_factor() {
    if (next() == '-') {
      ++at_;
      auto of = factor();
      if (!of) return of;
      return SignalNode(std::make_shared<Unary>(*of, nullptr));
    }
    if (next() == '(') {
      ++at_;
      return closed(sum());
    }
    for (const FunctionSpec& function : kFunctions) {
      const std::string name = std::string(function.name) + "(";
      if (text_.compare(at_, name.size(), name) != 0) continue;
      at_ += name.size();
      auto of = closed(sum());
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
    if (std::isdigit(static_cast<unsigned char>(next()))) return number();
    return signal();
  }

  Result<SignalNode> closed(Result<SignalNode> inside) {
    if (!inside) return inside;
    skip();
    if (next() != ')') {
      return fail(fmt::format("a bracket of '{}' is not closed", text_), "", "every ( needs its )");
    }
    ++at_;
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
    skip();
    const std::string name = unit_name();
    if (name.empty()) {
      const bool letter = std::isalpha(static_cast<unsigned char>(next())) != 0;
      if (letter) return unknown_unit(written);
      at_ = behind;
      return SignalNode(std::make_shared<Number>(value, written, units::Unit(), ""));
    }
    at_ += name.size();
    return SignalNode(std::make_shared<Number>(value, written, *units::parse_unit(name), name));
  }

  // The longest text from here that is a unit and ends at the end of a token: "m" in "m/robot.x".
  std::string unit_name() const {
    const auto in_word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
    };
    std::size_t end = at_;
    while (end < text_.size() && (in_word(text_[end]) || std::strchr("^*/()-", text_[end]))) ++end;
    for (; end > at_; --end) {
      if (end < text_.size() && in_word(text_[end]) && in_word(text_[end - 1])) continue;
      std::string name = text_.substr(at_, end - at_);
      if (std::isalpha(static_cast<unsigned char>(name[0])) && units::parse_unit(name)) return name;
    }
    return {};
  }

  tl::unexpected<Error> unknown_unit(const std::string& number) const {
    std::size_t end = at_;
    while (end < text_.size() && std::isalnum(static_cast<unsigned char>(text_[end]))) ++end;
    const std::string token = text_.substr(at_, end - at_), near = units::nearest_unit(token);
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
    return leaf_(text_.substr(start, end - start));
  }

  const std::string& text_;
  const Leaf& leaf_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Result<SignalNode> parse_arithmetic(
    const std::string& text, const std::function<Result<SignalNode>(const std::string&)>& signal) {
  return Arithmetic(text, signal).parse();
}

}  // namespace cogrsim

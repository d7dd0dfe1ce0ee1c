#include "signals/arithmetic.h"

#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "signals/node.h"

namespace cogrsim {
namespace {

constexpr int kDeepest = 50;

struct Number final : Signal::Node {
  explicit Number(double v) : number(v) {
    text = quantity = fmt::format("{}", v);
    unit = "1";
  }
  double value(const Frame&) const override { return number; }
  std::uint64_t revision(const Frame&) const override { return 0; }
  double number;
};

/// -a and abs(a).
struct Unary final : Signal::Node {
  Unary(SignalNode of, bool absolute) : a(std::move(of)), abs(absolute) {
    text = fmt::format(abs ? "abs({})" : "-({})", a->text);
    quantity = a->quantity;
    unit = a->unit;
    needs = a->needs;
  }
  double value(const Frame& frame) const override {
    const double v = a->value(frame);
    return abs ? std::abs(v) : -v;
  }
  std::uint64_t revision(const Frame& frame) const override { return a->revision(frame); }
  SignalNode a;
  bool abs;
};

struct Binary final : Signal::Node {
  Binary(SignalNode left, char op, SignalNode right, std::string unit_text)
      : a(std::move(left)), b(std::move(right)), sign(op) {
    const bool product = sign == '*' || sign == '/';
    text = product ? fmt::format("({}){}({})", a->text, sign, b->text)
                   : fmt::format("{} {} {}", a->text, sign, b->text);
    quantity = a->quantity == b->quantity ? a->quantity : text;
    unit = std::move(unit_text);
    needs = a->needs | b->needs;
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
        return x / y;
    }
  }
  std::uint64_t revision(const Frame& frame) const override {
    return a->revision(frame) * 0x9e3779b97f4a7c15u + b->revision(frame);
  }
  SignalNode a, b;
  char sign;
};

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
  // Between terms, a plus or minus has blanks on both sides.
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
    const bool number_a = dynamic_cast<const Number*>(a.get()) != nullptr;
    const bool number_b = dynamic_cast<const Number*>(b.get()) != nullptr;
    // A unit that is not known (a plugin's channel) is taken on trust.
    const bool fit =
        a->unit == b->unit || number_a || number_b || a->unit.empty() || b->unit.empty();
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
      return SignalNode(std::make_shared<Unary>(*of, false));
    }
    if (next() == '(') {
      ++at_;
      return closed(sum());
    }
    if (text_.compare(at_, 4, "abs(") == 0) {
      at_ += 4;
      auto of = closed(sum());
      if (!of) return of;
      return SignalNode(std::make_shared<Unary>(*of, true));
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
    return SignalNode(std::make_shared<Number>(value));
  }

  // Up to the next operator; what is in brackets belongs to it: distance(a, b), scan[3].
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

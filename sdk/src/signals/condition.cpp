#include "cogrsim/signals/condition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "cogrsim/core/expression.h"
#include "core/trimmed.h"
#include "signals/node.h"
#include "signals/parse.h"

namespace cogrsim {

struct Condition::Node {
  std::string text;
  FrameContents needs;
  std::vector<Signal> signals;

  virtual ~Node() = default;
  virtual Truth truth(const Frame& frame) const = 0;
  enum class Kind { one, all, any };
  virtual Kind kind() const { return Kind::one; }
};

namespace {

using ConditionNode = std::shared_ptr<const Condition::Node>;
using ParsedCondition = Result<ConditionNode>;
using units::Dimension;

constexpr int kDeepestCondition = 50;
constexpr const char* kUsage =
    "write a condition such as time lt 2 s, or distance(a, b) lt 20 cm and not inside(a, goal)";

enum class Relation { lt, le, gt, ge, eq, ne };
constexpr std::array<const char*, 6> kKeywords = {"lt", "le", "gt", "ge", "eq", "ne"};
constexpr std::array<const char*, 6> kSigns = {"<", "<=", ">", ">=", "==", "!="};

struct Unknown final : Condition::Node {
  Truth truth(const Frame&) const override { return Truth::unknown; }
};

Truth truth_of(bool value) { return value ? Truth::yes : Truth::no; }

void add_signal(std::vector<Signal>& signals, const Signal& signal) {
  const bool there = std::any_of(signals.begin(), signals.end(),
                                 [&](const Signal& s) { return s.text() == signal.text(); });
  if (!there) signals.push_back(signal);
}

struct Comparison final : Condition::Node {
  Comparison(SignalNode left, Relation relation, SignalNode right)
      : a(std::move(left)), b(std::move(right)), how(relation) {
    text = fmt::format("{} {} {}", a->text, kKeywords[static_cast<std::size_t>(how)], b->text);
    needs = a->needs | b->needs;
    for (const SignalNode& side : {a, b})
      if (!side->constant()) add_signal(signals, Signal(side));
  }
  Truth truth(const Frame& frame) const override {
    const double x = a->value(frame), y = b->value(frame);
    if (std::isnan(x) || std::isnan(y)) return Truth::unknown;
    switch (how) {
      case Relation::lt:
        return truth_of(x < y);
      case Relation::le:
        return truth_of(x <= y);
      case Relation::gt:
        return truth_of(x > y);
      case Relation::ge:
        return truth_of(x >= y);
      case Relation::eq:
        return truth_of(x == y);
      default:
        return truth_of(x != y);
    }
  }
  SignalNode a, b;
  Relation how;
};

/// Whether a signal is not 0.
struct NotZero final : Condition::Node {
  explicit NotZero(SignalNode of) : a(std::move(of)) {
    text = a->text;
    needs = a->needs;
    if (!a->constant()) signals.emplace_back(a);
  }
  Truth truth(const Frame& frame) const override {
    const double x = a->value(frame);
    return std::isnan(x) ? Truth::unknown : truth_of(x != 0.0);
  }
  SignalNode a;
};

struct Not final : Condition::Node {
  explicit Not(ConditionNode of) : a(std::move(of)) {
    text = a->kind() != Kind::one ? "not (" + a->text + ")" : "not " + a->text;
    needs = a->needs;
    signals = a->signals;
  }
  Truth truth(const Frame& frame) const override {
    const Truth inner = a->truth(frame);
    return inner == Truth::unknown ? inner : truth_of(inner == Truth::no);
  }
  ConditionNode a;
};

/// The conjunction or disjunction of several conditions.
struct Several final : Condition::Node {
  Several(std::vector<ConditionNode> of, bool both) : parts(std::move(of)), all(both) {
    for (const ConditionNode& part : parts) {
      if (!text.empty()) text += all ? " and " : " or ";
      // `and` has a higher precedence than `or`.
      const bool bracket = part->kind() == Kind::any || (all && part->kind() == Kind::all);
      text += bracket ? "(" + part->text + ")" : part->text;
      needs = needs | part->needs;
      for (const Signal& signal : part->signals) add_signal(signals, signal);
    }
  }
  Truth truth(const Frame& frame) const override {
    const Truth decides = all ? Truth::no : Truth::yes;
    bool unknown = false;
    for (const ConditionNode& part : parts) {
      const Truth one = part->truth(frame);
      if (one == decides) return decides;
      unknown = unknown || one == Truth::unknown;
    }
    return unknown ? Truth::unknown : truth_of(all);
  }
  Kind kind() const override { return all ? Kind::all : Kind::any; }
  std::vector<ConditionNode> parts;
  bool all;
};

using expression::Operator;

bool in_name(char c) {
  return expression::in_word(c) || c == '.' || c == '-' || static_cast<unsigned char>(c) >= 0x80;
}

/// A keyword or comparison operator outside of all brackets.
struct Token {
  std::size_t at = 0, length = 0;
  std::string_view text;
};

/// All keywords and comparison operators of `text` outside of brackets.
std::vector<Token> tokens(std::string_view text) {
  std::vector<Token> found;
  int open = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    std::size_t length = 1;
    if (c == '(' || c == '[') {
      ++open;
    } else if (c == ')' || c == ']') {
      --open;
    } else if (in_name(c)) {
      while (i + length < text.size() && in_name(text[i + length])) ++length;
      if (open == 0) found.push_back({i, length, text.substr(i, length)});
    } else if (std::string_view("<>=!").find(c) != std::string_view::npos) {
      if (i + 1 < text.size() && text[i + 1] == '=') length = 2;
      if (open == 0) found.push_back({i, length, text.substr(i, length)});
    }
    i += length;
  }
  return found;
}

class ConditionParser : expression::Parser<ConditionParser, ParsedCondition, kDeepestCondition> {
  using Parser = expression::Parser<ConditionParser, ParsedCondition, kDeepestCondition>;
  friend Parser;
  enum Level { kOr, kAnd, kNot, kComparison };
  static constexpr Operator kPrefix[] = {{"not", kNot, kComparison}};
  static constexpr Operator kInfix[] = {{"or", kOr, kAnd}, {"and", kAnd, kNot}};

 public:
  explicit ConditionParser(const SignalScope& scope) : Parser(""), scope_(scope) {}

  /// A condition, or the inside of its brackets.
  ParsedCondition parse(const std::string& text) {
    const std::string all = trimmed(text);
    const auto outer = std::tuple(text_, at_, std::exchange(tokens_, tokens(all)));
    text_ = all;
    at_ = 0;
    before_ = {};
    ParsedCondition made = nested(kOr);
    std::tie(text_, at_, tokens_) = outer;
    return made;
  }

 private:
  static bool usable(const ParsedCondition& made) { return made.has_value(); }
  bool applies(const Operator& op) const {
    const std::size_t end = at_ + op.text.size();
    return end == text_.size() || !in_name(text_[end]);
  }
  static tl::unexpected<Error> too_deep(const Operator*) {
    return fail("the condition has too many brackets inside each other", "",
                fmt::format("{} are the limit", kDeepestCondition));
  }

  template <class Operand>
  ParsedCondition prefix(std::size_t, const Operator& op, const Operand& operand) {
    std::size_t nots = 1;
    while (take_operator(kPrefix, kNot, kNot)) ++nots;
    before_ = op.text;
    ParsedCondition made = operand();
    for (; made && nots > 0; --nots) made = ConditionNode(std::make_shared<Not>(*made));
    return made;
  }

  template <class Operand>
  ParsedCondition infix(std::size_t, const Operator& op, ParsedCondition left,
                        const Operand& right_of) {
    std::vector<ConditionNode> parts = {*left};
    do {
      before_ = op.text;
      ParsedCondition right = right_of();
      if (!right) return right;
      parts.push_back(std::move(*right));
    } while (take_operator(kInfix, op.level, op.level));
    return ConditionNode(std::make_shared<Several>(std::move(parts), op.level == kAnd));
  }

  ParsedCondition primary() {
    if (text_.empty()) return fail("the condition is empty", "", kUsage);
    const std::size_t begin = at_;
    const auto end = std::find_if(tokens_.begin(), tokens_.end(), [&](const Token& token) {
      return token.at >= begin && (token.text == "and" || token.text == "or");
    });
    at_ = end == tokens_.end() ? text_.size() : end->at;
    const std::string part = trimmed(std::string(text_.substr(begin, at_ - begin)));
    if (!part.empty()) return comparison(part);
    const bool by_next = before_.empty() || (before_ == "or" && end != tokens_.end());
    return missing(begin, by_next ? end->text : before_);
  }

  /// An operand of `op` at `at`. The text of the error is that of all its operands.
  tl::unexpected<Error> missing(std::size_t at, std::string_view op) const {
    std::size_t begin = 0, end = text_.size();
    for (const Token& token : tokens_) {
      const bool ends = (token.text == "or" && op != "or") || (token.text == "and" && op == "not");
      if (ends && token.at < at) begin = token.at + token.length;
      if (ends && token.at >= at) end = std::min(end, token.at);
    }
    return fail(
        fmt::format("something is missing {} '{}' in '{}'", op == "not" ? "after" : "beside", op,
                    trimmed(std::string(text_.substr(begin, end - begin)))),
        "", kUsage);
  }

  ParsedCondition comparison(const std::string& text) {
    std::optional<Token> found;
    Relation relation = Relation::lt;
    for (const Token& token : tokens(text)) {
      const auto keyword = std::find(kKeywords.begin(), kKeywords.end(), token.text);
      const auto sign = std::find(kSigns.begin(), kSigns.end(), token.text);
      if (keyword == kKeywords.end() && sign == kSigns.end()) {
        if (token.text == "=" || token.text == "!")
          return fail(fmt::format("'{}' does not belong in '{}'", token.text, text), "",
                      token.text == "=" ? "write eq or ==" : "write not");
        continue;
      }
      if (found)
        return fail(fmt::format("'{}' compares more than two values", text), "",
                    "write two comparisons: 1 m lt a.x and a.x lt 2 m");
      found = token;
      relation = static_cast<Relation>(keyword != kKeywords.end() ? keyword - kKeywords.begin()
                                                                  : sign - kSigns.begin());
    }
    if (!found) return enclosed(text) ? parse(text.substr(1, text.size() - 2)) : alone(text);
    const std::string left = trimmed(text.substr(0, found->at));
    const std::string right = trimmed(text.substr(found->at + found->length));
    if (left.empty() || right.empty())
      return fail(fmt::format("something is missing beside '{}' in '{}'", found->text, text), "",
                  kUsage);
    auto a = parse_signal(scope_, left);
    if (!a) return tl::unexpected(a.error());
    auto b = parse_signal(scope_, right);
    if (!b) return tl::unexpected(b.error());
    if (auto fit = comparable(**a, **b); !fit) return tl::unexpected(fit.error());
    return ConditionNode(std::make_shared<Comparison>(*a, relation, *b));
  }

  /// Whether the closing bracket of the first bracket is the last character.
  static bool enclosed(const std::string& text) {
    if (text.front() != '(' || text.back() != ')') return false;
    int open = 0;
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
      open += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
      if (open == 0) return false;
    }
    return true;
  }

  ParsedCondition alone(const std::string& text) {
    auto a = parse_signal(scope_, text);
    if (!a) return tl::unexpected(a.error());
    const auto dimension = (*a)->dimension();
    if (dimension && !dimension->none())
      return fail(fmt::format("'{}' is {}, not a condition", text, units::describe(*dimension)), "",
                  fmt::format("compare it: {} lt 1 {}", text, units::unit_of(*dimension)));
    return ConditionNode(std::make_shared<NotZero>(*a));
  }

  static Result<> comparable(const Signal::Node& a, const Signal::Node& b) {
    if (a.constant() && b.constant())
      return fail(fmt::format("'{}' and '{}' are two numbers", a.text, b.text), "",
                  "a condition says something about a signal of the run");
    for (const auto& [number, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
      if (!number->bare()) continue;
      const auto dimension = other->dimension();
      const bool zero = number->value(Frame()) == 0.0;
      if (!dimension || zero || dimension->angle == 0) return {};
      const std::string unit = units::unit_of(*dimension);
      return fail(fmt::format("'{}' is {}, and '{}' has no unit", other->text,
                              units::describe(*dimension), number->text),
                  "",
                  *dimension == units::dim::kAngle
                      ? fmt::format("write {0} deg or {0} rad", number->text)
                      : fmt::format("write {} {}", number->text, unit));
    }
    const auto da = a.dimension(), db = b.dimension();
    // An unknown unit (of a plugin's channel) is accepted.
    if (!da || !db || units::fits(*da, *db) || units::fits(*db, *da)) return {};
    return fail(fmt::format("'{}' is {} and '{}' is {}", a.text, units::describe(*da), b.text,
                            units::describe(*db)),
                "", "only what is of the same kind can be compared");
  }

  const SignalScope& scope_;
  std::vector<Token> tokens_;  // of text_
  std::string_view before_;    // the operator before the operand
};

}  // namespace

Condition::Condition() {
  static const auto unknown = std::make_shared<const Unknown>();
  node_ = unknown;
}

Condition::Condition(std::shared_ptr<const Node> node) : node_(std::move(node)) {}

Result<Condition> Condition::parse(const SignalScope& scope, const std::string& text) {
  if (text.size() > kLongestSignal)
    return fail(fmt::format("a condition of {} characters is too long", text.size()), "",
                fmt::format("the limit is {}", kLongestSignal));
  int open = 0;
  for (std::size_t i = 0; i < text.size() && open >= 0; ++i)
    open += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
  if (open != 0)
    return fail(fmt::format("a bracket of '{}' is not {}", text, open > 0 ? "closed" : "opened"),
                "", "every ( needs its )");
  auto node = ConditionParser(scope).parse(text);
  if (!node) return tl::unexpected(node.error());
  return Condition(std::move(*node));
}

Truth Condition::evaluate(const Frame& frame) const { return node_->truth(frame); }
const std::string& Condition::text() const { return node_->text; }
FrameContents Condition::needs() const { return node_->needs; }
const std::vector<Signal>& Condition::signals() const { return node_->signals; }

}  // namespace cogrsim

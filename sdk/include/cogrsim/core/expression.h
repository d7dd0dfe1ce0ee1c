// The parser of all expressions: ${…} and xacro in scenes, signals, conditions. It has the tokens, the
// precedence of operators and the limit of depth; a language adds its table of operators, its
// operands and what operators do. Expressions are evaluated, or made into nodes, while they are read.
#pragma once

#include <climits>
#include <string_view>
#include <utility>

namespace cogrsim::expression {

/// White space as XML has it.
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
/// The first character of a name.
inline bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool in_word(char c) { return is_letter(c) || is_digit(c); }

/// The end of the longest text from `begin` for which `known(text)` holds, among those that consist
/// of characters with `allowed(c)` and do not end where `joined(last, next)` holds; `begin` if there
/// is none. Finds the unit behind a number.
template <class Allowed, class Joined, class Known>
std::size_t longest_known(std::string_view text, std::size_t begin, const Allowed& allowed,
                          const Joined& joined, const Known& known) {
  std::size_t end = begin;
  while (end < text.size() && allowed(text[end])) ++end;
  for (; end > begin; --end) {
    if (end < text.size() && joined(text[end - 1], text[end])) continue;
    if (known(text.substr(begin, end - begin))) break;
  }
  return end;
}

struct Operator {
  std::string_view text;  ///< a sign such as "*", or a word such as "and"
  int level;              ///< the higher, the tighter it binds
  int right;              ///< lowest level of the operators in its right operand
  bool repeated = true;   ///< whether another one of the same level may follow its right operand
};

/// A parser of a `Language`, which derives from it and has
///
///     static constexpr Operator kInfix[], kPrefix[];  // of two that begin alike, the longer first
///     Value primary();                    // an operand without operators before it
///     Value prefix(std::size_t begin, const Operator&, const Operand& operand);
///     Value infix(std::size_t begin, const Operator&, Value left, const Operand& right);
///     Value too_deep(const Operator*);    // nullptr: brackets
///
/// `begin` is the first character of the whole operation, at_ its end. `operand()` and `right()` parse
/// the operand behind the operator; each operator that is taken needs one call. An operator whose
/// `right` is not above its level may follow itself in its right operand: a ^ b ^ c is a ^ (b ^ c).
template <class Language, class Value, int kDeepest>
class Parser {
 protected:
  explicit Parser(std::string_view text) : text_(text) {}

  /// What `inside()` parses, one level deeper. Errors: more than kDeepest levels of brackets, prefix
  /// operators and operators that bind to the right. `of`: the operator, nullptr for brackets.
  template <class Inside>
  Value deeper(const Operator* of, const Inside& inside) {
    if (depth_ >= kDeepest) return self().too_deep(of);
    struct Level {
      explicit Level(int& depth) : depth_(depth) { ++depth_; }
      ~Level() { --depth_; }
      int& depth_;
    } const level(depth_);
    return inside();
  }

  /// The expression from here on, to the first operator of a level below `lowest`.
  Value nested(int lowest, const Operator* of = nullptr) {
    return deeper(of, [&] { return expression(lowest); });
  }

  Value expression(int lowest) {
    const std::size_t begin = here();
    const Operator* before = take_operator(Language::kPrefix, lowest, INT_MAX);
    Value left = before ? self().prefix(begin, *before, [&] { return operand_of(*before); })
                        : self().primary();
    // What binds tighter was read by an operand.
    int highest = before ? before->level : INT_MAX;
    while (self().usable(left)) {
      const Operator* const op = take_operator(Language::kInfix, lowest, highest);
      if (op == nullptr) break;
      left = self().infix(begin, *op, std::move(left), [&] { return operand_of(*op); });
      highest = op->repeated ? op->level : op->level - 1;
    }
    return left;
  }

  Value operand_of(const Operator& op) {
    return op.right > op.level ? expression(op.right) : nested(op.right, &op);
  }

  /// The operator here, if its level is in the range.
  template <class Table>
  const Operator* take_operator(const Table& table, int lowest, int highest) {
    skip_blanks();
    for (const Operator& op : table) {
      if (!starts(op.text) || !self().applies(op)) continue;
      if (op.level < lowest || op.level > highest) return nullptr;
      at_ += op.text.size();
      return &op;
    }
    return nullptr;
  }
  /// Whether what looks like an operator is one, with at_ before it.
  bool applies(const Operator&) const { return true; }

  /// False ends all operations, for languages whose values may be errors.
  bool usable(const Value&) const { return true; }

  // ---- tokens

  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  std::size_t here() {
    skip_blanks();
    return at_;
  }
  char next() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  /// A word ends where its letters and digits do.
  bool starts(std::string_view token) const {
    if (text_.substr(at_, token.size()) != token) return false;
    const std::size_t end = at_ + token.size();
    return !is_letter(token[0]) || end >= text_.size() || !in_word(text_[end]);
  }
  bool take(std::string_view token) {
    skip_blanks();
    if (!starts(token)) return false;
    at_ += token.size();
    return true;
  }
  /// The name here, or "".
  std::string_view peek_word() {
    skip_blanks();
    std::size_t end = at_;
    if (is_letter(next()))
      while (end < text_.size() && in_word(text_[end])) ++end;
    return text_.substr(at_, end - at_);
  }

  std::string_view text_;
  std::size_t at_ = 0;

 private:
  Language& self() { return static_cast<Language&>(*this); }

  int depth_ = 0;
};

}  // namespace cogrsim::expression

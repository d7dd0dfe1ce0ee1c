#include "import/expression.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/expression.h"
#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace {

constexpr std::size_t kLongestText = 1u << 20;
constexpr std::size_t kLongestList = 100000;
constexpr std::size_t kWorkOfEntry = 128;  // of a list
constexpr std::size_t kWorkOfStep = 25;    // of an operation

const char* kind_of(const PyValue& v) {
  static const char* const kKinds[] = {"None",   "a boolean", "a number",    "a number",
                                       "a text", "a list",    "a dictionary"};
  return kKinds[v.is.index()];
}

bool equal(const PyScope& scope, const PyValue& a, const PyValue& b, int depth = 0) {
  if (depth > 64) throw PyError{"values are nested too deep"};
  scope.spend(kWorkOfEntry);  // lists that hold one list twice grow with each level
  if (a.is_number() && b.is_number()) return a.number() == b.number();
  if (a.is.index() != b.is.index()) return false;
  if (const auto* s = std::get_if<std::string>(&a.is)) return *s == std::get<std::string>(b.is);
  if (const auto* l = std::get_if<std::shared_ptr<const PyList>>(&a.is)) {
    const PyList& other = *std::get<std::shared_ptr<const PyList>>(b.is);
    if ((*l)->size() != other.size()) return false;
    for (std::size_t i = 0; i < other.size(); ++i)
      if (!equal(scope, (**l)[i], other[i], depth + 1)) return false;
    return true;
  }
  return std::holds_alternative<std::monostate>(a.is);
}

PyValue integer_or(double value, bool integer) {
  if (!std::isfinite(value)) throw PyError{"the result is not a finite number"};
  if (integer && std::abs(value) < 9e15) return {static_cast<long long>(value)};
  return {value};
}

bool is_integer(const PyValue& v) {
  return std::holds_alternative<long long>(v.is) || std::holds_alternative<bool>(v.is);
}

bool less(const PyValue& a, const PyValue& b) {
  if (a.is_number() && b.is_number()) return a.number() < b.number();
  const auto *x = std::get_if<std::string>(&a.is), *y = std::get_if<std::string>(&b.is);
  if (x != nullptr && y != nullptr) return *x < *y;
  throw PyError{fmt::format("{} and {} have no order", kind_of(a), kind_of(b))};
}

/// A call with its arguments, as the functions below take it.
struct Call {
  const std::string& name;
  std::vector<PyValue> arguments;
  const PyScope& scope;

  double number(std::size_t i) const {
    if (i >= arguments.size()) throw PyError{name + "() has too few arguments"};
    return arguments[i].number();
  }
  const PyValue& only() const {
    if (arguments.size() != 1) throw PyError{name + "() has one argument"};
    return arguments[0];
  }
  bool is_text() const {
    return !arguments.empty() && std::holds_alternative<std::string>(arguments[0].is);
  }
};

PyValue round_of(const Call& call) {
  if (call.arguments.size() < 2) return integer_or(std::nearbyint(call.number(0)), true);
  const double scale = std::pow(10.0, call.number(1));
  return {std::nearbyint(call.number(0) * scale) / scale};
}

PyValue length_of(const Call& call) {
  const PyValue& value = call.only();
  if (const auto* s = std::get_if<std::string>(&value.is))
    return {static_cast<long long>(s->size())};
  if (const auto* l = std::get_if<std::shared_ptr<const PyList>>(&value.is))
    return {static_cast<long long>((*l)->size())};
  if (const auto* d = std::get_if<std::shared_ptr<const PyDict>>(&value.is))
    return {static_cast<long long>((*d)->size())};
  throw PyError{std::string(kind_of(value)) + " has no length"};
}

/// Of the arguments, or of the list that is the only argument: the one before which no other comes.
PyValue first_of(const Call& call, bool (*before)(const PyValue&, const PyValue&)) {
  const PyList* list = &call.arguments;
  if (list->size() == 1)
    if (const auto* l = std::get_if<std::shared_ptr<const PyList>>(&call.arguments[0].is))
      list = l->get();
  const PyList& all = *list;
  call.scope.spend(kWorkOfEntry * all.size());
  if (all.empty()) throw PyError{call.name + "() of nothing"};
  const PyValue* best = &all.front();
  for (const PyValue& v : all)
    if (before(v, *best)) best = &v;
  return *best;
}

PyValue load_yaml_of(const Call& call) {
  if (call.arguments.size() != 1 || !call.scope.load_yaml)
    throw PyError{"load_yaml() names one file"};
  return call.scope.load_yaml(call.arguments[0].text(call.scope));
}

PyValue argument_of(const Call& call) {
  if (call.arguments.size() != 1 || !call.scope.argument) throw PyError{"arg() names one argument"};
  return call.scope.argument(call.arguments[0].text(call.scope));
}

template <class Container>
PyValue empty_of(const Call& call) {
  if (!call.arguments.empty()) throw PyError{"there is no function '" + call.name + "' here"};
  return {std::make_shared<const Container>()};
}

PyValue nothing_of(const Call&) { return {std::string()}; }
PyValue error_of(const Call& call) {
  throw PyError{call.arguments.empty() ? "error" : call.arguments[0].text(call.scope)};
}

template <double (*function)(double)>
PyValue unary(const Call& call) {
  return {function(call.number(0))};
}
template <double (*function)(double, double)>
PyValue binary(const Call& call) {
  return {function(call.number(0), call.number(1))};
}
/// An integer.
template <double (*function)(double)>
PyValue rounded(const Call& call) {
  return integer_or(function(call.number(0)), true);
}

double radians(double v) { return v * kPi / 180.0; }
double degrees(double v) { return v * 180.0 / kPi; }

using Function = PyValue (*)(const Call&);
const std::map<std::string, Function>& functions() {
  static const std::map<std::string, Function> kFunctions = {
      {"sin", unary<std::sin>},
      {"cos", unary<std::cos>},
      {"tan", unary<std::tan>},
      {"asin", unary<std::asin>},
      {"acos", unary<std::acos>},
      {"atan", unary<std::atan>},
      {"sqrt", unary<std::sqrt>},
      {"exp", unary<std::exp>},
      {"log", unary<std::log>},
      {"fabs", unary<std::fabs>},
      {"radians", unary<radians>},
      {"degrees", unary<degrees>},
      {"atan2", binary<std::atan2>},
      {"hypot", binary<std::hypot>},
      {"pow", binary<std::pow>},
      {"abs",
       [](const Call& call) {
         const double x = call.number(0);  // throws without an argument
         return integer_or(std::abs(x), is_integer(call.arguments[0]));
       }},
      {"floor", rounded<std::floor>},
      {"ceil", rounded<std::ceil>},
      {"round", round_of},
      {"int",
       [](const Call& call) {
         const double x =
             call.is_text() ? literal(call.arguments[0].text(call.scope)).number() : call.number(0);
         return integer_or(std::trunc(x), true);
       }},
      {"float",
       [](const Call& call) -> PyValue {
         return {call.is_text() ? literal(call.arguments[0].text(call.scope)).number()
                                : call.number(0)};
       }},
      {"str", [](const Call& call) -> PyValue { return {call.only().text(call.scope)}; }},
      {"bool", [](const Call& call) -> PyValue { return {call.only().truth()}; }},
      {"len", length_of},
      {"min", [](const Call& call) { return first_of(call, less); }},
      {"max",
       [](const Call& call) {
         return first_of(call, [](const PyValue& a, const PyValue& b) { return less(b, a); });
       }},
      {"dict", empty_of<PyDict>},
      {"list", empty_of<PyList>},
      {"load_yaml", load_yaml_of},
      {"arg", argument_of},
      {"error", error_of},
      {"fatal_error", error_of},
      {"warning", nothing_of},
      {"message", nothing_of},
      {"print_location", nothing_of}};
  return kFunctions;
}

bool contains(const PyScope& scope, const PyValue& in, const PyValue& what) {
  if (const auto* l = std::get_if<std::shared_ptr<const PyList>>(&in.is))
    return std::any_of((*l)->begin(), (*l)->end(),
                       [&](const PyValue& v) { return equal(scope, v, what); });
  if (const auto* d = std::get_if<std::shared_ptr<const PyDict>>(&in.is))
    return (*d)->count(what.text(scope)) != 0;
  if (const auto* s = std::get_if<std::string>(&in.is)) {
    scope.spend(s->size());
    return s->find(what.text(scope)) != std::string::npos;
  }
  throw PyError{std::string(kind_of(in)) + " contains nothing"};
}

bool compared(const PyScope& scope, std::string_view op, const PyValue& a, const PyValue& b) {
  if (op == "<") return less(a, b);
  if (op == ">") return less(b, a);
  if (op == "<=") return !less(b, a);
  if (op == ">=") return !less(a, b);
  if (op == "in" || op == "not") return contains(scope, b, a) == (op == "in");
  return equal(scope, a, b) == (op != "!=");
}

PyValue added(const PyScope& scope, const PyValue& a, const PyValue& b) {
  const auto *s = std::get_if<std::string>(&a.is), *t = std::get_if<std::string>(&b.is);
  const auto* l = std::get_if<std::shared_ptr<const PyList>>(&a.is);
  const auto* m = std::get_if<std::shared_ptr<const PyList>>(&b.is);
  if (s != nullptr && t != nullptr) {
    if (s->size() + t->size() > kLongestText) throw PyError{"a text grows too long"};
    scope.spend(16 * (s->size() + t->size()));
    return {*s + *t};
  }
  if (l != nullptr && m != nullptr) {
    if ((*l)->size() + (*m)->size() > kLongestList) throw PyError{"a list grows too long"};
    scope.spend(kWorkOfEntry * ((*l)->size() + (*m)->size()));
    auto both = std::make_shared<PyList>(**l);
    both->insert(both->end(), (*m)->begin(), (*m)->end());
    return {std::shared_ptr<const PyList>(std::move(both))};
  }
  return integer_or(a.number() + b.number(), is_integer(a) && is_integer(b));
}

PyValue computed(const PyScope& scope, std::string_view op, const PyValue& a, const PyValue& b) {
  if (op == "+") return added(scope, a, b);
  if (op == "%" && std::holds_alternative<std::string>(a.is))
    throw PyError{"texts are not formatted here"};
  const bool divides = op == "/" || op == "//" || op == "%";
  if (divides && b.number() == 0.0) throw PyError{"a division by zero"};
  const bool integers = is_integer(a) && is_integer(b);
  const double x = a.number(), y = b.number();
  if (op == "-") return integer_or(x - y, integers);
  if (op == "*") return integer_or(x * y, integers);
  if (op == "/") return {x / y};
  if (op == "//") return integer_or(std::floor(x / y), integers);
  if (op == "%") return integer_or(x - y * std::floor(x / y), integers);
  return integer_or(std::pow(x, y), integers && y >= 0.0);
}

using expression::in_word;
using expression::Operator;

constexpr int kDeepest = 100;

class Parser : expression::Parser<Parser, PyValue, kDeepest> {
  friend expression::Parser<Parser, PyValue, kDeepest>;
  enum Level { kOr, kAnd, kNot, kCompare, kSum, kProduct, kSign, kPower };
  static constexpr Operator kPrefix[] = {
      {"not", kNot, kNot}, {"-", kSign, kSign}, {"+", kSign, kSign}};
  static constexpr Operator kInfix[] = {
      {"or", kOr, kAnd},       {"and", kAnd, kNot},    {"==", kCompare, kSum},
      {"!=", kCompare, kSum},  {"<=", kCompare, kSum}, {">=", kCompare, kSum},
      {"<", kCompare, kSum},   {">", kCompare, kSum},  {"in", kCompare, kSum},
      {"not", kCompare, kSum}, {"is", kCompare, kSum}, {"+", kSum, kProduct},
      {"-", kSum, kProduct},   {"**", kPower, kSign},  {"*", kProduct, kSign},
      {"//", kProduct, kSign}, {"/", kProduct, kSign}, {"%", kProduct, kSign}};

 public:
  Parser(std::string_view text, const PyScope& scope)
      : expression::Parser<Parser, PyValue, kDeepest>(text), scope_(scope) {}

  PyValue whole() {
    PyValue out = ternary();
    if (here() < text_.size())
      throw PyError{"'" + std::string(text_.substr(at_, 40)) + "' cannot stand here"};
    return out;
  }

 private:
  PyValue too_deep(const Operator*) const { throw PyError{"the expression is nested too deep"}; }

  void spend() const { scope_.spend(kWorkOfStep); }

  void need(std::string_view s) {
    if (!take(s)) throw PyError{"'" + std::string(s) + "' is missing"};
  }

  PyValue ternary() {
    return deeper(nullptr, [&] { return branches(); });
  }

  PyValue branches() {
    spend();
    // Both branches are computed; what is refused in the one that is not taken is forgotten.
    const std::size_t begin = at_;
    PyValue yes;
    std::string trouble;
    try {
      yes = expression(kOr);
    } catch (const PyError& error) {
      // Perhaps the branch of an "if" whose condition does not hold: find that "if".
      trouble = error.message;
      at_ = begin;
      const bool found = skip_to("if ");
      scope_.spend(at_ - begin);
      if (!found) throw;
    }
    if (!take("if")) return yes;
    const bool condition = expression(kOr).truth();
    if (!take("else")) throw PyError{"'else' is missing"};
    if (condition) {
      if (!trouble.empty()) throw PyError{trouble};
      try {
        ternary();
      } catch (const PyError&) {
        skip_to(",");
      }
      return yes;
    }
    return ternary();
  }

  /// To the word "if", or to a comma, on this level of brackets. False: to its end.
  bool skip_to(std::string_view wanted) {
    int open = 0;
    for (; at_ < text_.size(); ++at_) {
      const char c = next();
      if (c == '\'' || c == '"') {
        at_ = std::min(text_.find(c, at_ + 1), text_.size() - 1);
      } else if (c == '(' || c == '[' || c == '{') {
        ++open;
      } else if (c == ')' || c == ']' || c == '}') {
        if (--open < 0) return false;
      } else if (open == 0 && text_.substr(at_, wanted.size()) == wanted &&
                 (c == ',' || (at_ > 0 && is_blank(text_[at_ - 1])))) {
        return true;
      }
    }
    return false;
  }

  template <class Operand>
  PyValue prefix(std::size_t, const Operator& op, const Operand& operand) {
    spend();
    const PyValue of = operand();
    if (op.level == kNot) return {!of.truth()};
    if (op.text == "+") return of;
    return is_integer(of) ? integer_or(-of.number(), true) : PyValue{-of.number()};
  }

  template <class Operand>
  PyValue infix(std::size_t, const Operator& op, PyValue left, const Operand& right) {
    if (op.level == kCompare) return chain(op, std::move(left), right);
    const PyValue other = right();
    if (op.level > kCompare) return computed(scope_, op.text, left, other);
    return left.truth() == (op.level == kOr) ? left : other;
  }

  /// a < b <= c …, from behind the first sign.
  template <class Operand>
  PyValue chain(const Operator& first, PyValue left, const Operand& right_of) {
    bool holds = true;
    for (const Operator* op = &first; op; op = take_operator(kInfix, kCompare, kCompare)) {
      std::string_view test = op->text;
      if (test == "not" && !take("in")) throw PyError{"'in' is missing after 'not'"};
      if (test == "is" && take("not")) test = "!=";
      PyValue right = right_of();
      holds = holds && compared(scope_, test, left, right);
      left = std::move(right);
    }
    return {holds};
  }

  PyValue primary() {
    spend();
    std::string name;  // of what is not a value yet: a function, a module
    PyValue out;
    if (at_ < text_.size() && is_letter(text_[at_])) {
      name = identifier();
      if (!resolve(name, out)) {
        // math.pi, xacro.load_yaml(…), python.max(…), ns.property
        while (take(".")) {
          name += "." + identifier();
          if (resolve(name, out)) {
            name.clear();
            break;
          }
        }
      } else {
        name.clear();
      }
      if (!name.empty()) {
        for (const char* module : {"math.", "python.", "numpy.", "xacro."})
          if (name.compare(0, std::string_view(module).size(), module) == 0)
            name.erase(0, std::string_view(module).size());
        if (resolve(name, out)) name.clear();
      }
      if (!name.empty()) {
        if (!take("(")) throw PyError{"'" + name + "' is not defined"};
        out = call(name);
      }
    } else {
      out = atom();
    }
    while (true) {
      skip_blanks();
      if (at_ < text_.size() && text_[at_] == '[') {
        ++at_;
        const PyValue key = ternary();
        need("]");
        out = item(out, key);
      } else if (at_ + 1 < text_.size() && text_[at_] == '.' && is_letter(text_[at_ + 1])) {
        ++at_;
        out = item(out, PyValue{identifier()});
      } else {
        return out;
      }
    }
  }

  PyValue item(const PyValue& of, const PyValue& key) const {
    if (const auto* d = std::get_if<std::shared_ptr<const PyDict>>(&of.is)) {
      const auto it = (*d)->find(key.text(scope_));
      if (it == (*d)->end()) throw PyError{"there is no entry '" + key.text(scope_) + "'"};
      return it->second;
    }
    if (const auto* l = std::get_if<std::shared_ptr<const PyList>>(&of.is)) {
      const auto size = static_cast<double>((*l)->size());
      double i = key.number();
      if (i < 0.0) i += size;
      if (!(i >= 0.0 && i < size)) throw PyError{"an index is beyond the list"};
      return (**l)[static_cast<std::size_t>(i)];
    }
    if (const auto* s = std::get_if<std::string>(&of.is)) {
      double i = key.number();
      if (i < 0.0) i += static_cast<double>(s->size());
      if (!(i >= 0.0 && i < static_cast<double>(s->size())))
        throw PyError{"an index is beyond the text"};
      return {std::string(1, (*s)[static_cast<std::size_t>(i)])};
    }
    throw PyError{std::string(kind_of(of)) + " has no entries"};
  }

  std::string identifier() {
    skip_blanks();
    const std::size_t begin = at_;
    while (in_word(next())) ++at_;
    if (begin == at_) throw PyError{"a name is missing"};
    return std::string(text_.substr(begin, at_ - begin));
  }

  bool resolve(const std::string& name, PyValue& out) const {
    if (name == "True") return out = PyValue{true}, true;
    if (name == "False") return out = PyValue{false}, true;
    if (name == "None") return out = PyValue{}, true;
    if (scope_.look_up && scope_.look_up(name, out)) return scope_.spend(work_of(out)), true;
    if (name == "pi") return out = PyValue{kPi}, true;
    if (name == "e") return out = PyValue{2.71828182845904523536}, true;
    if (name == "tau") return out = PyValue{2.0 * kPi}, true;
    if (name == "inf") return out = PyValue{kInfinity}, true;
    return false;
  }

  /// Reads entries up to `close`. Returns whether there was a comma.
  template <class Entry>
  bool entries(std::string_view close, std::size_t most, const char* too_many, const Entry& entry) {
    bool comma = false;
    for (std::size_t count = 0; !take(close); ++count) {
      if (count == most) throw PyError{too_many};
      entry();
      if (take(",")) {
        comma = true;
      } else {
        need(close);
        break;
      }
    }
    return comma;
  }

  PyValue atom() {
    if (at_ >= text_.size()) throw PyError{"the expression ends too early"};
    const char c = text_[at_];
    if (c == '(' || c == '[') {
      ++at_;
      PyList list;
      const bool comma = entries(c == '(' ? ")" : "]", kLongestList, "a list grows too long",
                                 [&] { list.push_back(ternary()); });
      if (c == '(' && !comma && list.size() == 1) return list.front();
      return {std::make_shared<const PyList>(std::move(list))};
    }
    if (c == '{') {
      ++at_;
      PyDict dict;
      entries("}", kLongestList, "a dictionary grows too long", [&] {
        const PyValue key = ternary();
        need(":");
        dict[key.text(scope_)] = ternary();
      });
      return {std::make_shared<const PyDict>(std::move(dict))};
    }
    if (c == '\'' || c == '"') {
      const std::size_t end = text_.find(c, at_ + 1);
      if (end == std::string_view::npos) throw PyError{"a text has no end"};
      PyValue out{std::string(text_.substr(at_ + 1, end - at_ - 1))};
      at_ = end + 1;
      return out;
    }
    if (is_digit(c) || c == '.') {
      double number = 0.0;
      const auto [end, error] =
          std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
      if (error != std::errc()) throw PyError{"a number cannot be read"};
      const std::string_view word =
          text_.substr(at_, static_cast<std::size_t>(end - text_.data()) - at_);
      at_ += word.size();
      return integer_or(number, word.find_first_of(".eE") == std::string_view::npos);
    }
    throw PyError{"'" + std::string(text_.substr(at_, 40)) + "' cannot be understood"};
  }

  PyValue call(const std::string& name) {
    Call call{name, {}, scope_};
    entries(")", 1000, "a call has too many arguments",
            [&] { call.arguments.push_back(ternary()); });
    const auto function = functions().find(name);
    if (function == functions().end()) throw PyError{"there is no function '" + name + "' here"};
    return function->second(call);
  }

  const PyScope& scope_;
};

PyValue from_yaml(const YAML::Node& node, const PyScope& scope, int depth, std::size_t& left) {
  if (depth > 50) throw PyError{"the YAML file is nested too deep"};
  if (left == 0) throw PyError{"the YAML file has more than 100000 values"};
  --left;
  if (node.IsMap()) {
    PyDict out;
    for (const auto& entry : node)
      out[entry.first.Scalar()] = from_yaml(entry.second, scope, depth + 1, left);
    return {std::make_shared<const PyDict>(std::move(out))};
  }
  if (node.IsSequence()) {
    PyList out;
    for (const auto& entry : node) out.push_back(from_yaml(entry, scope, depth + 1, left));
    return {std::make_shared<const PyList>(std::move(out))};
  }
  if (!node.IsScalar()) return {};
  const std::string& text = node.Scalar();
  scope.spend(16 * text.size());
  const std::string& tag = node.Tag();
  const auto of = [&](double factor) { return PyValue{evaluate(text, scope).number() * factor}; };
  if (tag == "!degrees") return of(kPi / 180.0);
  if (tag == "!radians" || tag == "!meters" || tag == "!meter") return of(1.0);
  if (tag == "!millimeters" || tag == "!mm") return of(1e-3);
  if (tag == "!inches") return of(0.0254);
  if (tag == "!foot") return of(0.3048);
  if (tag == "!") return {text};  // quoted
  if (text.empty() || text == "~" || text == "null") return {};
  return literal(text);
}

}  // namespace

bool PyValue::truth() const {
  struct Visit {
    bool operator()(std::monostate) const { return false; }
    bool operator()(bool v) const { return v; }
    bool operator()(long long v) const { return v != 0; }
    bool operator()(double v) const { return v != 0.0; }
    bool operator()(const std::string& v) const { return !v.empty(); }
    bool operator()(const std::shared_ptr<const PyList>& v) const { return !v->empty(); }
    bool operator()(const std::shared_ptr<const PyDict>& v) const { return !v->empty(); }
  };
  return std::visit(Visit{}, is);
}

double PyValue::number() const {
  if (const auto* b = std::get_if<bool>(&is)) return *b ? 1.0 : 0.0;
  if (const auto* i = std::get_if<long long>(&is)) return static_cast<double>(*i);
  if (const auto* d = std::get_if<double>(&is)) return *d;
  throw PyError{std::string(kind_of(*this)) + " is not a number" +
                (std::holds_alternative<std::string>(is)
                     ? ": '" + std::get<std::string>(is).substr(0, 40) + "'"
                     : "")};
}

std::string PyValue::text(const PyScope& scope) const {
  struct Visit {
    const PyScope& scope;
    std::string operator()(std::monostate) const { return "None"; }
    std::string operator()(bool v) const { return v ? "True" : "False"; }
    std::string operator()(long long v) const { return std::to_string(v); }
    std::string operator()(double v) const {
      std::string out = fmt::format("{}", v);
      if (out.find_first_not_of("-0123456789") == std::string::npos) out += ".0";
      return out;
    }
    std::string operator()(const std::string& v) const { return v; }
    std::string operator()(const std::shared_ptr<const PyList>& v) const {
      std::string out = "[";
      for (const PyValue& e : *v) add(out, (out.size() > 1 ? ", " : "") + e.text(scope));
      return out + "]";
    }
    std::string operator()(const std::shared_ptr<const PyDict>& v) const {
      std::string out = "{";
      for (const auto& [key, e] : *v)
        add(out, (out.size() > 1 ? ", '" : "'") + key + "': " + e.text(scope));
      return out + "}";
    }
    void add(std::string& out, const std::string& entry) const {
      scope.spend(kWorkOfStep + entry.size());
      out += entry;
      if (out.size() > kLongestText) throw PyError{"a text grows too long"};
    }
  };
  return std::visit(Visit{scope}, is);
}

std::size_t work_of(const PyValue& value) {
  const auto* s = std::get_if<std::string>(&value.is);
  return s == nullptr ? 0 : s->size();
}

PyValue evaluate(std::string_view expression, const PyScope& scope) {
  if (expression.size() > (1u << 16)) throw PyError{"the expression is too long"};
  return Parser(expression, scope).whole();
}

PyValue literal(const std::string& text) {
  std::string_view word = text;
  while (!word.empty() && is_blank(word.front())) word.remove_prefix(1);
  while (!word.empty() && is_blank(word.back())) word.remove_suffix(1);
  if (word.size() >= 2 && word.front() == '\'' && word.back() == '\'')
    return {std::string(word.substr(1, word.size() - 2))};
  if (word == "true" || word == "True") return {true};
  if (word == "false" || word == "False") return {false};
  std::string_view digits = word;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  if (!digits.empty()) {
    long long integer = 0;
    auto done = std::from_chars(digits.data(), digits.data() + digits.size(), integer);
    if (done.ec == std::errc() && done.ptr == digits.data() + digits.size()) return {integer};
    double number = 0.0;
    const auto real = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (real.ec == std::errc() && real.ptr == digits.data() + digits.size()) return {number};
  }
  return {text};
}

PyValue parse_yaml(const std::string& text, const PyScope& scope) {
  // An alias names what stands elsewhere, and aliases of aliases grow without end.
  if (text.size() > (1u << 20)) throw PyError{"the YAML file has more than 1 MB"};
  scope.spend(256 * text.size());  // slow to parse
  try {
    std::size_t left = 100000;
    return from_yaml(YAML::Load(text), scope, 0, left);
  } catch (const YAML::Exception& e) {
    throw PyError{fmt::format("YAML line {}: {}", e.mark.line + 1, e.msg)};
  }
}

}  // namespace cogrsim::dsl::import

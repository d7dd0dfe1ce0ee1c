// The part of Python's expressions that xacro files use, over numbers, texts, lists and dictionaries.
//
//   ternary    = or [ "if" or "else" ternary ]
//   or         = and { "or" and }            and  = not { "and" not }        not = "not" not | compare
//   compare    = sum { ("==" | "!=" | "<" | ">" | "<=" | ">=" | [ "not" ] "in") sum }
//   sum        = term { ("+" | "-") term }   term = unary { ("*" | "/" | "//" | "%") unary }
//   unary      = ("-" | "+") unary | power   power = postfix [ "**" unary ]
//   postfix    = atom { "(" arguments ")" | "[" ternary "]" | "." name }
//   atom       = number | text | name | "(" ternary ")" | "[" … "]" | "{" … "}"
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace cogrsim::dsl::import {

struct PyValue;
struct PyScope;
using PyList = std::vector<PyValue>;
using PyDict = std::map<std::string, PyValue>;

/// Lists and dictionaries are shared and never changed.
struct PyValue {
  std::variant<std::monostate, bool, long long, double, std::string, std::shared_ptr<const PyList>,
               std::shared_ptr<const PyDict>>
      is;
  bool truth() const;
  bool is_number() const { return is.index() >= 1 && is.index() <= 3; }
  double number() const;     ///< of bool, integer or float; throws PyError
  /// As Python's str(). Each byte of lists and dictionaries is work.
  std::string text(const PyScope& scope) const;
};

struct PyError {
  std::string message;
};

/// What an expression may ask for.
struct PyScope {
  std::function<bool(const std::string& name, PyValue& out)> look_up;
  std::function<PyValue(const std::string& path)> load_yaml;
  std::function<PyValue(const std::string& name)> argument;
  /// Takes work, in the units of kMostWork; ends the evaluation by another exception than PyError.
  std::function<void(std::size_t work)> spend = [](std::size_t) {};
};

/// Throws PyError.
PyValue evaluate(std::string_view expression, const PyScope& scope);

/// A property's text as a value: an integer, a float, a boolean, or the text.
PyValue literal(const std::string& text);

/// A YAML file's content. Throws PyError.
PyValue parse_yaml(const std::string& text, const PyScope& scope);

/// The work of copying a value, in the units of kMostWork; lists and dictionaries are shared.
std::size_t work_of(const PyValue& value);

}  // namespace cogrsim::dsl::import

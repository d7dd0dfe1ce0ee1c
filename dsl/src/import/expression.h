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
  std::string text() const;  ///< as Python's str()
};

struct PyError {
  std::string message;
};

/// What an expression may ask for.
struct PyScope {
  std::function<bool(const std::string& name, PyValue& out)> look_up;
  std::function<PyValue(const std::string& path)> load_yaml;
  std::function<PyValue(const std::string& name)> argument;
  std::size_t* budget = nullptr;  ///< operations left; at 0 PyError is thrown
};

/// Throws PyError.
PyValue evaluate(std::string_view expression, const PyScope& scope);

/// A property's text as a value: an integer, a float, a boolean, or the text.
PyValue literal(const std::string& text);

/// A YAML file's content. Throws PyError.
PyValue parse_yaml(const std::string& text, const PyScope& scope);

}  // namespace cogrsim::dsl::import

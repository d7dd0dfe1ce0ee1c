#include "new/new_names.h"

#include <algorithm>
#include <cctype>
#include <iterator>

#include <fmt/format.h>

#include "cogrsim/dsl/schema.h"
#include "cogrsim/sensing/sensor.h"
#include "common/json_text.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

// Keywords and alternative tokens of C++20 (ISO/IEC 14882:2020, 5.5 and 5.11) in lower case.
constexpr const char* kKeywordsOfCpp[] = {"alignas",       "alignof",     "and",
                                          "and_eq",        "asm",         "auto",
                                          "bitand",        "bitor",       "bool",
                                          "break",         "case",        "catch",
                                          "char",          "char16_t",    "char32_t",
                                          "char8_t",       "class",       "co_await",
                                          "co_return",     "co_yield",    "compl",
                                          "concept",       "const",       "const_cast",
                                          "consteval",     "constexpr",   "constinit",
                                          "continue",      "decltype",    "default",
                                          "delete",        "do",          "double",
                                          "dynamic_cast",  "else",        "enum",
                                          "explicit",      "export",      "extern",
                                          "false",         "float",       "for",
                                          "friend",        "goto",        "if",
                                          "inline",        "int",         "long",
                                          "mutable",       "namespace",   "new",
                                          "noexcept",      "not",         "not_eq",
                                          "nullptr",       "operator",    "or",
                                          "or_eq",         "private",     "protected",
                                          "public",        "register",    "reinterpret_cast",
                                          "requires",      "return",      "short",
                                          "signed",        "sizeof",      "static",
                                          "static_assert", "static_cast", "struct",
                                          "switch",        "template",    "this",
                                          "thread_local",  "throw",       "true",
                                          "try",           "typedef",     "typeid",
                                          "typename",      "union",       "unsigned",
                                          "using",         "virtual",     "void",
                                          "volatile",      "wchar_t",     "while",
                                          "xor",           "xor_eq"};

// CMake refuses targets of these names, or makes them itself.
constexpr const char* kTargetsOfCMake[] = {"all",
                                           "clean",
                                           "depend",
                                           "edit_cache",
                                           "help",
                                           "install",
                                           "list_install_components",
                                           "package",
                                           "package_source",
                                           "preinstall",
                                           "rebuild_cache",
                                           "test",
                                           "none"};

template <std::size_t count>
bool is_one_of(const std::string& name, const char* const (&names)[count]) {
  return std::any_of(std::begin(names), std::end(names),
                     [&](const char* other) { return name == other; });
}

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_element_of_scenes(const std::string& name) {
  const Json schema = Json::parse(dsl::write_schema_json());
  const Json& elements = schema.at("elements");
  return std::any_of(elements.begin(), elements.end(),
                     [&](const Json& element) { return element.at("name") == name; });
}

}  // namespace

std::string suggested_name(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_lower(c) || is_digit(c)) {
      out += c;
    } else if (is_upper(c)) {
      // "MyIRSensor": a capital begins a word after a small letter, or before one.
      const bool after_small = i > 0 && (is_lower(text[i - 1]) || is_digit(text[i - 1]));
      const bool before_small = i > 0 && i + 1 < text.size() && is_lower(text[i + 1]);
      if ((after_small || before_small) && !out.empty() && out.back() != '_') out += '_';
      out += static_cast<char>(c - 'A' + 'a');
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  out.erase(0, std::min(out.find_first_not_of("_0123456789"), out.size()));
  if (out.size() > kLongestPluginName) out.resize(kLongestPluginName);
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

Result<> check_plugin_name(PluginKind kind, const std::string& name) {
  const std::string shown = printable(shortened(name, 80));
  const auto refuse = [&](const std::string& why, const std::string& other) {
    std::string hint = "names are small letters, digits and _, and begin with a letter";
    if (!other.empty() && other != name) hint = fmt::format("'{}' would do; {}", other, hint);
    return fail(fmt::format("'{}' is not a name for a {}: {}", shown, to_string(kind), why), "",
                hint);
  };
  if (name.empty()) return refuse("it is empty", "");
  if (name.find('/') != std::string::npos) {
    return fail(fmt::format("'{}' is a path, not a name", shown), "",
                "give the folder with --into FOLDER, and the name alone");
  }
  const bool letters = is_lower(name.front()) && std::all_of(name.begin(), name.end(), [](char c) {
                         return is_lower(c) || is_digit(c) || c == '_';
                       });
  if (!letters) {
    const std::string other = suggested_name(name);
    return refuse(is_digit(name.front()) ? "it begins with a digit" : "it has other characters",
                  other.empty() || !check_plugin_name(kind, other) ? "" : other);
  }
  if (name.size() > kLongestPluginName) {
    return fail(fmt::format("'{}' is too long: {} characters", shown, name.size()), "",
                fmt::format("at most {} can be had", kLongestPluginName));
  }
  const std::string with_kind = name + "_" + to_string(kind);
  if (is_one_of(name, kKeywordsOfCpp)) return refuse("it is a keyword of C++", with_kind);
  if (is_one_of(name, kTargetsOfCMake)) {
    return refuse("CMake itself has a target of this name", with_kind);
  }
  if (kind == PluginKind::sensor && built_in_sensor(name) != nullptr) {
    return refuse("CogRSim has a built-in sensor of this name, which would be used instead",
                  "my_" + name);
  }
  if (kind == PluginKind::backend && is_element_of_scenes(name)) {
    return refuse(fmt::format("scenes have an element <{}>, and an engine's options stand in one "
                              "that is called as its backend",
                              name),
                  with_kind);
  }
  return {};
}

std::string class_name(const std::string& plugin) {
  std::string out;
  bool begins = true, small = false;
  for (const char c : plugin) {
    if (c == '_') {
      begins = true;
      continue;
    }
    out += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    small = small || !begins;
    begins = false;
  }
  // In capitals alone it might be a macro: "n_a_n".
  if (!small && out.size() > 1) out += "Plugin";
  return out;
}

}  // namespace cogrsim::cli

// Diagnostics for programs: JSON and SARIF 2.1.0 (OASIS, 2020).
#include <map>

#include <nlohmann/json.hpp>

#include "cogrsim/dsl/compiler.h"
#include "report/diagnostics.h"

namespace cogrsim::dsl {
namespace {

using Json = nlohmann::ordered_json;

/// File names and source lines are bytes from outside: what is not UTF-8 is replaced, not thrown.
std::string dump(const Json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A path as a URI reference (RFC 3986): only unreserved characters and '/' stay.
std::string uri(const std::string& path) {
  static const char* kHex = "0123456789ABCDEF";
  std::string out;
  for (const char ch : path) {
    const auto c = static_cast<unsigned char>(ch);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '.' || c == '_' || c == '~' || c == '/';
    if (plain) {
      out += ch;
    } else {
      out += '%';
      out += kHex[c >> 4];
      out += kHex[c & 15];
    }
  }
  return out;
}

Json location(const std::string& file, int line, int column, int length) {
  Json region;
  if (line > 0) region["startLine"] = line;
  if (line > 0 && column > 0) {
    region["startColumn"] = column;
    if (length > 0) region["endColumn"] = column + length;
  }
  Json physical;
  physical["artifactLocation"]["uri"] = uri(file);
  if (!region.empty()) physical["region"] = region;
  Json out;
  out["physicalLocation"] = physical;
  return out;
}

}  // namespace

std::string to_json(const std::vector<Diagnostic>& diagnostics) {
  Json all = Json::array();
  for (const Diagnostic& d : diagnostics) {
    Json notes = Json::array();
    for (const DiagnosticNote& n : d.notes) {
      notes.push_back(
          {{"message", n.message}, {"file", n.file}, {"line", n.line}, {"column", n.column}});
    }
    all.push_back({{"severity", severity_name(d.severity)},
                   {"code", d.code},
                   {"message", d.message},
                   {"file", d.file},
                   {"line", d.line},
                   {"column", d.column},
                   {"length", d.length},
                   {"notes", notes},
                   {"help", d.help}});
  }
  return dump(all);
}

std::string to_sarif(const std::vector<Diagnostic>& diagnostics) {
  Json rules = Json::array();
  std::map<std::string, int> rule_index;
  Json results = Json::array();
  for (const Diagnostic& d : diagnostics) {
    if (!rule_index.count(d.code)) {
      rule_index[d.code] = static_cast<int>(rules.size());
      Json rule;
      rule["id"] = d.code;
      if (const CodeInfo* info = find_code(d.code)) {
        rule["shortDescription"]["text"] = info->title;
        rule["fullDescription"]["text"] = info->cause;
        rule["help"]["text"] = info->cure;
      }
      rules.push_back(rule);
    }
    Json result;
    result["ruleId"] = d.code;
    result["ruleIndex"] = rule_index[d.code];
    result["level"] = severity_name(d.severity);
    result["message"]["text"] = d.help.empty() ? d.message : d.message + "\n" + d.help;
    if (!d.file.empty()) {
      result["locations"] = Json::array({location(d.file, d.line, d.column, d.length)});
    }
    Json related = Json::array();
    for (const DiagnosticNote& n : d.notes) {
      if (n.file.empty()) continue;
      Json entry = location(n.file, n.line, n.column, 0);
      entry["message"]["text"] = n.message;
      related.push_back(entry);
    }
    if (!related.empty()) result["relatedLocations"] = related;
    results.push_back(result);
  }
  Json run;
  run["tool"]["driver"]["name"] = "cogrsim";
  run["tool"]["driver"]["rules"] = rules;
  run["columnKind"] = "unicodeCodePoints";
  run["results"] = results;
  Json sarif;
  sarif["$schema"] = "https://json.schemastore.org/sarif-2.1.0.json";
  sarif["version"] = "2.1.0";
  sarif["runs"] = Json::array({run});
  return dump(sarif);
}

}  // namespace cogrsim::dsl

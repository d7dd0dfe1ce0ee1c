// Documents made from the table of the protocol.
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "protocol.h"
#include "protocol_type.h"

namespace cogrsim::studio {
namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
  return text;
}

// Literals have their quotes.
void add_names(const FieldType& type, FieldType::Kind kind, std::set<std::string>& out) {
  const bool quoted = kind == FieldType::Kind::literal;
  if (type.kind == kind) out.insert(quoted ? "\"" + type.name + "\"" : type.name);
  for (const FieldType& part : type.parts) add_names(part, kind, out);
}

// ---- TypeScript

constexpr const char* kScriptHead =
    "// Made from the table of the protocol, server/protocol_table.cpp: see the test \"the page's "
    "types are those\n// of the table\". In words: PROTOCOL.md.\n";

std::string script_type(const char* type) { return replaced(type, "integer", "number"); }

std::string script_fields(const std::vector<ProtocolField>& fields, const std::string& indent) {
  std::string out;
  for (const ProtocolField& field : fields) {
    if (*field.doc) out += fmt::format("{}/** {} */\n", indent, field.doc);
    out += fmt::format("{}{}: {};\n", indent, field.name, script_type(field.type));
  }
  return out;
}

std::string script_object(const std::vector<ProtocolField>& fields) {
  if (fields.empty()) return "Record<string, never>";
  return "{\n" + script_fields(fields, "      ") + "    }";
}

// ---- Markdown

std::string cell(const std::string& text) { return replaced(text, "|", "\\|"); }

std::string bounds_text(const FieldBounds& b) {
  std::string out;
  if (b.above)
    out = fmt::format(", above {} to {}", b.least, b.most);
  else if (b.most < 1e9 && b.least > -1e9)
    out = fmt::format(", {} … {}", b.least, b.most);
  if (b.most_entries < std::numeric_limits<std::size_t>::max())
    out += fmt::format(", at most {}", b.most_entries);
  return out;
}

std::string field_text(const ProtocolField& field) {
  std::string out = fmt::format("`{}: {}`", field.name, field.type);
  if (field.standard) out += fmt::format(" = {}", field.standard);
  out += bounds_text(field.bounds);
  if (*field.doc) out += fmt::format(" ({})", field.doc);
  return out;
}

std::string fields_text(const std::vector<ProtocolField>& fields, std::size_t first = 0) {
  std::vector<std::string> all;
  for (std::size_t i = first; i < fields.size(); ++i) all.push_back(field_text(fields[i]));
  return cell(fmt::format("{}", fmt::join(all, ", ")));
}

bool is_operation(const ProtocolType& type) {
  return !type.fields.empty() && std::string_view(type.fields.front().name) == "op";
}

std::string requests_table(Section section) {
  std::string out = "| do | fields | answer | what it does |\n|---|---|---|---|\n";
  for (const ProtocolRequest& request : protocol_requests()) {
    if (request.section != section) continue;
    out += fmt::format("| `{}`{} | {} | {} | {} |\n", request.name, request.viewers ? " V" : "",
                       fields_text(request.fields), fields_text(request.answer), cell(request.doc));
  }
  return out;
}

std::string operations_table() {
  std::string out = "| op | fields | |\n|---|---|---|\n";
  for (const ProtocolType& type : protocol_types()) {
    if (!is_operation(type)) continue;
    out += fmt::format("| `{}` | {} | {} |\n", read_type(type.fields.front().type).name,
                       fields_text(type.fields, 1), cell(type.doc));
  }
  return out;
}

std::string topics_table() {
  std::string out = "| topic | when | fields |\n|---|---|---|\n";
  for (const ProtocolTopic& topic : protocol_topics()) {
    out += fmt::format("| `{}` | {} | `{}` |\n", topic.name, topic.when, topic.type);
  }
  return out;
}

std::string types_table() {
  std::string out = "| type | what it is |\n|---|---|\n";
  for (const ProtocolType& type : protocol_types()) {
    if (is_operation(type)) continue;
    std::string what =
        type.alias ? cell(fmt::format("`{}`", type.alias)) : fields_text(type.fields);
    if (*type.doc) what = cell(type.doc) + ": " + what;
    out += fmt::format("| `{}` | {} |\n", type.name, what);
  }
  return out;
}

std::string table_named(const std::string& name) {
  if (name == "session") return requests_table(Section::session);
  if (name == "start") return requests_table(Section::start);
  if (name == "run") return requests_table(Section::run);
  if (name == "numbers") return requests_table(Section::numbers);
  if (name == "document") return requests_table(Section::document);
  if (name == "debug") return requests_table(Section::debug);
  if (name == "operations") return operations_table();
  if (name == "topics") return topics_table();
  if (name == "types") return types_table();
  return fmt::format("there is no table '{}'\n", name);
}

// ---- the fuzzer's dictionary

void add_fields(const std::vector<ProtocolField>& fields, std::set<std::string>& out) {
  for (const ProtocolField& field : fields) {
    out.insert("\"" + field.plain_name() + "\":");
    add_names(read_type(field.type), FieldType::Kind::literal, out);
  }
}

}  // namespace

std::string protocol_types_typescript() {
  std::string out = kScriptHead;
  for (const ProtocolType& type : protocol_types()) {
    out += "\n";
    if (*type.doc) out += fmt::format("/** {} */\n", type.doc);
    if (type.alias)
      out += fmt::format("export type {} = {};\n", type.name, script_type(type.alias));
    else
      out += fmt::format("export interface {} {{\n{}}}\n", type.name,
                         script_fields(type.fields, "  "));
  }
  return out;
}

std::string protocol_typescript() {
  std::set<std::string> names;
  const auto add = [&](const char* type) {
    add_names(read_type(type), FieldType::Kind::named, names);
  };
  std::string topics;
  for (const ProtocolTopic& topic : protocol_topics()) {
    topics += fmt::format("  {}: {};\n", topic.name, topic.type);
    add(topic.type);
  }
  std::string requests;
  for (const ProtocolRequest& request : protocol_requests()) {
    requests += fmt::format("  /** {} */\n", request.doc);
    const bool quoted = std::string_view(request.name).find('-') != std::string_view::npos;
    requests += fmt::format("  {0}{1}{0}: {{\n    fields: {2};\n    answer: {3};\n  }};\n",
                            quoted ? "\"" : "", request.name, script_object(request.fields),
                            script_object(request.answer));
    for (const ProtocolField& field : request.fields) add(field.type);
    for (const ProtocolField& field : request.answer) add(field.type);
  }
  return fmt::format(
      "{}import type {{\n  {},\n}} from \"./protocol_types\";\n\n"
      "export type * from \"./protocol_types\";\n\n"
      "/** The protocol that this page speaks; `hello` answers the server's. */\n"
      "export const kProtocol = {};\n\n"
      "/** The messages that the server publishes unasked, by topic. */\n"
      "export interface Topics {{\n{}}}\n\n"
      "/** What a page asks, with its fields and the answer's. */\n"
      "export interface Requests {{\n{}}}\n\n"
      "export type RequestName = keyof Requests;\n"
      "export type Answer<Name extends RequestName> = Requests[Name][\"answer\"];\n"
      "export type Hello = Answer<\"hello\">;\n"
      "export type Paths = Answer<\"paths\">;\n",
      kScriptHead, fmt::join(names, ",\n  "), kProtocol, topics, requests);
}

std::string protocol_markdown(const std::string& page) {
  static const std::string kBegin = "<!-- table: ", kClose = " -->\n", kEnd = "<!-- end -->";
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t begin = page.find(kBegin, at);
    const std::size_t close = page.find(kClose, begin), end = page.find(kEnd, begin);
    if (begin == std::string::npos || close > end || end == std::string::npos) break;
    const std::size_t name = begin + kBegin.size();
    out += page.substr(at, close + kClose.size() - at);
    out += table_named(page.substr(name, close - name));
    at = end;
  }
  return out + page.substr(at);
}

std::string protocol_dictionary() {
  std::set<std::string> words;
  for (const ProtocolRequest& request : protocol_requests()) {
    words.insert(fmt::format("\"do\":\"{}\"", request.name));
    add_fields(request.fields, words);
  }
  for (const ProtocolType& type : protocol_types()) {
    if (is_operation(type) || std::string_view(type.name) == "CameraWish")
      add_fields(type.fields, words);
  }
  std::string out =
      "# The requests of a page, for -dict: made from apps/studio/server/protocol_table.cpp.\n";
  for (const std::string& word : words) {
    out += "\"" + replaced(word, "\"", "\\\"") + "\"\n";
  }
  return out;
}

}  // namespace cogrsim::studio

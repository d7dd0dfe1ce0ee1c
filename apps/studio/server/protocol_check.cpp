#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "protocol.h"
#include "protocol_type.h"

namespace cogrsim::studio {
namespace {

using Kind = FieldType::Kind;

class TypeReader {
 public:
  explicit TypeReader(std::string_view text) : text_(text) {}

  FieldType whole() {
    FieldType type = either();
    if (!text_.empty()) throw std::logic_error("no type: '" + std::string(text_) + "'");
    return type;
  }

 private:
  FieldType either() {
    FieldType first = with_brackets();
    if (!take(" | ")) return first;
    FieldType out{Kind::one_of, "", {std::move(first)}};
    do out.parts.push_back(with_brackets());
    while (take(" | "));
    return out;
  }

  FieldType with_brackets() {
    FieldType type = single();
    while (take("[]")) type = {Kind::list, "", {std::move(type)}};
    return type;
  }

  FieldType single() {
    if (take("(")) {
      FieldType type = either();
      expect(")");
      return type;
    }
    if (take("[")) {
      FieldType out{Kind::tuple, "", {}};
      do out.parts.push_back(either());
      while (take(", "));
      expect("]");
      return out;
    }
    if (take("\"")) {
      FieldType out{Kind::literal, std::string(text_.substr(0, text_.find('"'))), {}};
      text_.remove_prefix(out.name.size());
      expect("\"");
      return out;
    }
    if (take("Record<string, ")) {
      FieldType out{Kind::record, "", {either()}};
      expect(">");
      return out;
    }
    const auto end = std::find_if_not(text_.begin(), text_.end(),
                                      [](unsigned char c) { return std::isalnum(c) != 0; });
    const std::string name(text_.begin(), end);
    text_.remove_prefix(name.size());
    if (name.empty()) throw std::logic_error("no type: '" + std::string(text_) + "'");
    static const std::pair<const char*, Kind> kinds[] = {
        {"string", Kind::string},   {"integer", Kind::integer}, {"number", Kind::number},
        {"boolean", Kind::boolean}, {"null", Kind::null},       {"object", Kind::object}};
    for (const auto& [known, kind] : kinds)
      if (name == known) return {kind, "", {}};
    return {Kind::named, name, {}};
  }

  bool take(std::string_view what) {
    if (text_.substr(0, what.size()) != what) return false;
    text_.remove_prefix(what.size());
    return true;
  }
  void expect(std::string_view what) {
    if (!take(what)) throw std::logic_error(fmt::format("'{}' instead of '{}'", text_, what));
  }

  std::string_view text_;
};

const ProtocolType& type_named(const std::string& name) {
  for (const ProtocolType& type : protocol_types())
    if (type.name == name) return type;
  throw std::logic_error("there is no type '" + name + "'");
}

// The value of its first field, by which objects of several types are distinguished; "": none.
std::string mark_of(const FieldType& type) {
  if (type.kind != Kind::named) return {};
  const ProtocolType& named = type_named(type.name);
  if (named.alias || named.fields.empty()) return {};
  const FieldType first = read_type(named.fields.front().type);
  return first.kind == Kind::literal ? first.name : "";
}

std::string joined(const std::vector<std::string>& all, const char* last) {
  std::string out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    out += (i == 0 ? "" : i + 1 == all.size() ? last : ", ") + all[i];
  }
  return out;
}

std::string range_text(const FieldBounds& bounds) {
  constexpr double kNoBound = 1e9;  // against nonsense alone
  const bool low = bounds.least > -kNoBound, high = bounds.most < kNoBound;
  if (!low && !high) return {};
  if (bounds.above) return fmt::format(" above {} and at most {}", bounds.least, bounds.most);
  if (!high) return fmt::format(" from {}", bounds.least);
  return fmt::format(" from {} to {}", bounds.least, bounds.most);
}

std::string described(const FieldType& type, const FieldBounds& bounds, bool several = false) {
  switch (type.kind) {
    case Kind::string:
      return several ? "texts" : "text";
    case Kind::integer:
      return (several ? "whole numbers" : "a whole number") + range_text(bounds);
    case Kind::number:
      return (several ? "numbers" : "a number") + range_text(bounds);
    case Kind::boolean:
      return "true or false";
    case Kind::null:
      return "null";
    case Kind::literal:
      return "\"" + type.name + "\"";
    case Kind::list:
      return (several ? "lists of " : "a list of ") + described(type.parts[0], bounds, true) +
             (bounds.fewest_entries > 0 ? ", not an empty one" : "");
    case Kind::tuple:
      return fmt::format("{} of {} {}", several ? "lists" : "a list", type.parts.size(),
                         described(type.parts[0], bounds, true));
    case Kind::named:
      if (const ProtocolType& named = type_named(type.name); named.alias)
        return described(read_type(named.alias), bounds, several);
      [[fallthrough]];
    case Kind::object:
    case Kind::record:
      return several ? "objects" : "an object";
    case Kind::one_of:
      break;
  }
  std::vector<std::string> all;
  for (const FieldType& part : type.parts) {
    const std::string one = described(part, bounds, several);
    if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(one);
  }
  return joined(all, all.back() == "null" ? ", or " : " or ");
}

class Checker {
 public:
  // `strict`: an unknown field is an error, and standards are filled in.
  explicit Checker(bool strict) : strict_(strict) {}

  Result<> fields(const std::vector<ProtocolField>& all, Json& object, const std::string& path,
                  const std::string& owner) const {
    if (strict_) {
      if (auto known = known_only(all, object, path, owner); !known) return known;
    }
    for (const ProtocolField& field : all) {
      const std::string name = field.plain_name();
      const auto found = object.find(name);
      if (field.optional() && (found == object.end() || found->is_null())) {
        if (!strict_) continue;
        if (field.standard)
          object[name] = Json::parse(field.standard);
        else
          object.erase(name);
        continue;
      }
      const FieldType type = read_type(field.type);
      if (found == object.end()) {
        return fail(fmt::format("{} needs the field '{}': {}", owner, path + name,
                                described(type, field.bounds)));
      }
      if (auto good = value(type, *found, field.bounds, path + name); !good) return good;
    }
    return {};
  }

 private:
  Result<> known_only(const std::vector<ProtocolField>& all, const Json& object,
                      const std::string& path, const std::string& owner) const {
    std::vector<std::string> names;
    for (const ProtocolField& field : all) names.push_back(field.plain_name());
    for (const auto& [key, value] : object.items()) {
      const bool of_all = path.empty() && (key == "id" || key == "do");
      if (of_all || std::find(names.begin(), names.end(), key) != names.end()) continue;
      const std::string nearest = nearest_name(key.substr(0, 60), names);
      return fail(fmt::format("{} has no field '{}'", owner, path + key.substr(0, 60)), "",
                  !nearest.empty() ? fmt::format("did you mean '{}'?", nearest)
                  : names.empty()  ? "it has none"
                                   : "it has " + joined(names, " and "));
    }
    return {};
  }

  Result<> value(const FieldType& type, Json& json, const FieldBounds& bounds,
                 const std::string& path) const {
    const auto wrong = [&] {
      return fail(fmt::format("'{}' must be {}", path, described(type, bounds)));
    };
    switch (type.kind) {
      case Kind::string:
        return json.is_string() ? Result<>() : wrong();
      case Kind::boolean:
        return json.is_boolean() ? Result<>() : wrong();
      case Kind::object:
        return json.is_object() ? Result<>() : wrong();
      case Kind::literal:
        return json == type.name ? Result<>() : wrong();
      case Kind::null:  // what is not finite is written as null
        return json.is_null() || (json.is_number_float() && !std::isfinite(json.get<double>()))
                   ? Result<>()
                   : wrong();
      case Kind::integer:
      case Kind::number:
        return number(type.kind == Kind::integer, json, bounds) ? Result<>() : wrong();
      case Kind::list:
      case Kind::tuple:
        return list(type, json, bounds, path);
      case Kind::record:
        if (!json.is_object()) return wrong();
        for (auto& [key, one] : json.items()) {
          if (auto good = value(type.parts[0], one, bounds, path + "." + key); !good) return good;
        }
        return {};
      case Kind::named: {
        const ProtocolType& named = type_named(type.name);
        if (named.alias) return value(read_type(named.alias), json, bounds, path);
        if (!json.is_object()) return wrong();
        return fields(named.fields, json, path + ".", "'" + path + "'");
      }
      case Kind::one_of:
        break;
    }
    return one_of(type, json, bounds, path);
  }

  static bool number(bool whole, const Json& json, const FieldBounds& bounds) {
    constexpr double kMostExact = 9007199254740992.0;  // 2^53
    if (!json.is_number()) return false;
    const double v = json.get<double>();
    if (!std::isfinite(v) || v < bounds.least || v > bounds.most) return false;
    if (bounds.above && v <= bounds.least) return false;
    return !whole || (v == std::floor(v) && std::fabs(v) <= kMostExact);
  }

  Result<> list(const FieldType& type, Json& json, const FieldBounds& bounds,
                const std::string& path) const {
    const bool tuple = type.kind == Kind::tuple;
    if (!json.is_array() || json.size() < bounds.fewest_entries ||
        (tuple && json.size() != type.parts.size())) {
      return fail(fmt::format("'{}' must be {}", path, described(type, bounds)));
    }
    if (json.size() > bounds.most_entries)
      return fail(fmt::format("'{}' has at most {} entries", path, bounds.most_entries));
    for (std::size_t i = 0; i < json.size(); ++i) {
      auto good = value(type.parts[tuple ? i : 0], json[i], bounds, fmt::format("{}[{}]", path, i));
      if (!good) return good;
    }
    return {};
  }

  Result<> one_of(const FieldType& type, Json& json, const FieldBounds& bounds,
                  const std::string& path) const {
    std::vector<std::string> marks;
    for (const FieldType& part : type.parts) {
      const std::string mark = mark_of(part);
      if (mark.empty()) {
        if (value(part, json, bounds, path)) return {};
        continue;
      }
      marks.push_back(mark);
      const auto& first = type_named(part.name).fields.front();
      const auto found = json.is_object() ? json.find(first.name) : json.end();
      if (found != json.end() && *found == mark) return value(part, json, bounds, path);
    }
    if (marks.empty() || !json.is_object())
      return fail(fmt::format("'{}' must be {}", path, described(type, bounds)));
    const std::string name = type_named(type.parts.front().name).fields.front().name;
    const auto found = json.find(name);
    const std::string given =
        found != json.end() && found->is_string() ? found->get<std::string>().substr(0, 60) : "";
    const std::string nearest = nearest_name(given, marks);
    return fail(fmt::format("'{}.{}' must be {}", path, name, joined(marks, " or ")), "",
                nearest.empty() ? "" : fmt::format("did you mean '{}'?", nearest));
  }

  bool strict_;
};

}  // namespace

FieldType read_type(std::string_view text) { return TypeReader(text).whole(); }

std::string ProtocolField::plain_name() const {
  return std::string(name, std::string_view(name).size() - (optional() ? 1 : 0));
}

const ProtocolRequest* find_request(std::string_view name) {
  for (const ProtocolRequest& request : protocol_requests())
    if (request.name == name) return &request;
  return nullptr;
}

Error unknown_request(const std::string& name) {
  std::vector<std::string> names;
  for (const ProtocolRequest& request : protocol_requests()) names.push_back(request.name);
  const std::string shown = name.substr(0, 60), nearest = nearest_name(shown, names);
  return Error(fmt::format("there is no request '{}'", shown), "",
               nearest.empty() ? "" : fmt::format("did you mean '{}'?", nearest));
}

Result<> check_fields(const ProtocolRequest& request, Json& fields) {
  // A page of another protocol, too, gets the answer to its hello.
  if (request.section == Section::session) return {};
  return Checker(true).fields(request.fields, fields, "", fmt::format("'{}'", request.name));
}

Result<> check_answer(std::string_view request, const Json& answer) {
  const ProtocolRequest* const found = find_request(request);
  if (!found) return tl::unexpected<Error>(unknown_request(std::string(request)));
  Json copy = answer;
  return Checker(false).fields(found->answer, copy, "", fmt::format("the answer to '{}'", request));
}

Result<> check_topic(const Json& message) {
  for (const ProtocolTopic& topic : protocol_topics()) {
    if (message.value("topic", "") != topic.name) continue;
    Json copy = message;
    return Checker(false).fields(type_named(topic.type).fields, copy, "",
                                 fmt::format("the topic '{}'", topic.name));
  }
  return fail("there is no topic '" + message.value("topic", "") + "'");
}

}  // namespace cogrsim::studio

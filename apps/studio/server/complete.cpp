#include "complete.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

namespace cogrsim::studio {
namespace {

constexpr std::size_t kMostItems = 200;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool in_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == ':' ||
         (static_cast<unsigned char>(c) & 0x80) != 0;
}

/// The context of the cursor, found by reading from the start; any text is accepted.
struct Spot {
  enum class Kind { nothing, content, tag, end_tag, attribute, value } kind = Kind::content;
  std::vector<std::string> open;                  ///< elements around
  std::string tag;                                ///< the tag that is being written
  std::map<std::string, std::string> attributes;  ///< before the cursor
  std::string attribute;
  std::size_t begin = 0;  ///< byte offset of what is being written
};

// The rest of a start tag behind its name, from `at`. False: the cursor is in it.
bool read_attributes(const std::string& text, std::size_t cursor, std::size_t& at, Spot& spot) {
  bool closed = false;
  while (at < cursor && !closed) {
    if (is_blank(text[at])) {
      ++at;
      spot.kind = Spot::Kind::attribute;
      spot.begin = at;
    } else if (text[at] == '>') {
      ++at;
      closed = true;
      spot.open.push_back(spot.tag);
    } else if (text.compare(at, 2, "/>") == 0) {
      at += 2;
      closed = true;
    } else if (text[at] == '<') {
      closed = true;  // the previous tag is unfinished
      spot.open.push_back(spot.tag);
    } else if (in_name(text[at])) {
      spot.kind = Spot::Kind::attribute;
      spot.begin = at;
      std::string name;
      while (at < cursor && in_name(text[at])) name += text[at++];
      if (at >= cursor) return false;
      std::size_t next = at;
      while (next < cursor && is_blank(text[next])) ++next;
      if (next >= cursor || text[next] != '=') continue;
      ++next;
      while (next < cursor && is_blank(text[next])) ++next;
      if (next >= cursor || (text[next] != '"' && text[next] != '\'')) {
        spot.kind = Spot::Kind::nothing;
        at = next;
        continue;
      }
      const char quote = text[next];
      at = next + 1;
      spot.begin = at;
      const std::size_t end = text.find_first_of(std::string(1, quote) + "<", at);
      if (end == std::string::npos || end >= cursor) {
        spot.kind = Spot::Kind::value;
        spot.attribute = name;
        return false;
      }
      spot.attributes[name] = text.substr(at, end - at);
      at = end + (text[end] == quote ? 1 : 0);
      spot.kind = Spot::Kind::nothing;
    } else {
      ++at;
    }
  }
  return closed;
}

Spot find_spot(const std::string& text, std::size_t cursor) {
  Spot spot;
  std::size_t at = 0;
  const auto skip = [&](const char* end, std::size_t length) {
    const std::size_t found = text.find(end, at);
    if (found == std::string::npos || found + length > cursor) return false;
    at = found + length;
    return true;
  };
  spot.begin = cursor;
  while (at < cursor) {
    if (text[at] != '<') {
      ++at;
      continue;
    }
    spot.kind = Spot::Kind::nothing;
    if (text.compare(at, 4, "<!--") == 0) {
      if (!skip("-->", 3)) return spot;
    } else if (text.compare(at, 9, "<![CDATA[") == 0) {
      if (!skip("]]>", 3)) return spot;
    } else if (text.compare(at, 2, "<?") == 0) {
      if (!skip("?>", 2)) return spot;
    } else if (text.compare(at, 2, "</") == 0) {
      spot.begin = at + 2;
      spot.kind = Spot::Kind::end_tag;
      std::size_t end = at + 2;
      while (end < cursor && text[end] != '>' && text[end] != '<') ++end;
      if (end >= cursor) return spot;
      if (!spot.open.empty()) spot.open.pop_back();
      at = end + (text[end] == '>' ? 1 : 0);
    } else {
      spot.begin = ++at;
      spot.tag.clear();
      spot.attributes.clear();
      while (at < cursor && in_name(text[at])) spot.tag += text[at++];
      spot.kind = Spot::Kind::tag;
      if (at >= cursor) return spot;
      if (!read_attributes(text, cursor, at, spot)) return spot;
    }
    spot.kind = Spot::Kind::content;
    spot.begin = cursor;
  }
  spot.kind = Spot::Kind::content;
  spot.begin = cursor;
  return spot;
}

class Completer {
 public:
  Completer(const Json& schema, const std::vector<dsl::OutlineElement>& elements)
      : schema_(schema), elements_(elements) {}

  Json run(const std::string& text, std::size_t cursor) {
    spot_ = find_spot(text, cursor);
    written_ = text.substr(spot_.begin, cursor - spot_.begin);
    switch (spot_.kind) {
      case Spot::Kind::nothing:
        break;
      case Spot::Kind::content:
        for (const std::string& tag : allowed()) add_element(tag, "<");
        if (!spot_.open.empty())
          add("</" + spot_.open.back() + ">", "ends <" + spot_.open.back() + ">",
              "</" + spot_.open.back() + ">");
        break;
      case Spot::Kind::tag:
        for (const std::string& tag : allowed()) add_element(tag, "");
        break;
      case Spot::Kind::end_tag:
        if (!spot_.open.empty()) add(spot_.open.back(), "", spot_.open.back() + ">");
        break;
      case Spot::Kind::attribute:
        attributes();
        break;
      case Spot::Kind::value:
        values();
        break;
    }
    return std::move(items_);
  }
  std::size_t begin() const { return spot_.begin; }

 private:
  void add(const std::string& label, const std::string& detail, const std::string& insert) {
    if (items_.size() >= kMostItems || label.compare(0, written_.size(), written_) != 0) return;
    if (!listed_.insert(label).second) return;
    items_.push_back({{"label", label}, {"detail", detail}, {"insert", insert}});
  }

  const Json* element(const std::string& tag, bool with_attributes = false) const {
    const Json* found = nullptr;
    for (const Json& e : schema_["elements"]) {
      if (e["name"] != tag) continue;
      if (found == nullptr) found = &e;
      if (with_attributes && e.contains("when") &&
          spot_.attributes.count(e["when"].get<std::string>()) != 0)
        return &e;
    }
    return found;
  }

  std::vector<std::string> allowed() const {
    if (spot_.open.empty()) return {"scene"};
    // repeat, for and if hold what the element around them holds.
    for (auto at = spot_.open.rbegin(); at != spot_.open.rend(); ++at) {
      const Json* around = element(*at);
      if (around == nullptr) return {};
      if ((*around)["flow"] == true) continue;
      auto out = (*around)["children"].get<std::vector<std::string>>();
      if (out.empty()) return {};
      for (const Json& e : schema_["elements"])
        if (e["flow"] == true) out.push_back(e["name"].get<std::string>());
      if ((*around)["engine_blocks"] == true && schema_.contains("backends"))
        for (const Json& name : schema_["backends"]) out.push_back(name.get<std::string>());
      return out;
    }
    return {};
  }

  // With its required attributes.
  void add_element(const std::string& tag, const std::string& before) {
    const Json* e = element(tag);
    std::string insert = before + tag;
    if (e != nullptr)
      for (const Json& a : (*e)["attributes"])
        if (a["required"] == true) insert += " " + a["name"].get<std::string>() + "=\"\"";
    add(tag, e == nullptr ? "options of the engine" : (*e)["doc"].get<std::string>(), insert);
  }

  const Json* plugin_parameters() const {
    // The plugin of <set> is named by an element around it: the nearest one.
    if (!schema_.contains("plugins") || spot_.open.empty()) return nullptr;
    const auto found = schema_["plugins"].find(spot_.open.back() + "s");
    return found == schema_["plugins"].end() ? nullptr : &*found;
  }

  void attributes() {
    if (spot_.tag == "set") {
      if (const Json* plugins = plugin_parameters())
        for (const Json& plugin : *plugins)
          for (const Json& p : plugin["parameters"])
            if (spot_.attributes.count(p["name"].get<std::string>()) == 0)
              add(p["name"].get<std::string>(),
                  plugin["name"].get<std::string>() + ": " + p["doc"].get<std::string>(),
                  p["name"].get<std::string>() + "=\"" + p["default"].get<std::string>() + "\"");
      return;
    }
    const Json* e = element(spot_.tag, true);
    if (e == nullptr) return;
    for (const bool required : {true, false})
      for (const Json& a : (*e)["attributes"]) {
        const std::string name = a["name"].get<std::string>();
        if (a["required"] != required || spot_.attributes.count(name) != 0) continue;
        add(name, a["doc"].get<std::string>(), name + "=\"\"");
      }
  }

  void values() {
    const Json* e = element(spot_.tag, true);
    if (e == nullptr) return;
    const auto& list = (*e)["attributes"];
    const auto a = std::find_if(list.begin(), list.end(),
                                [&](const Json& one) { return one["name"] == spot_.attribute; });
    if (a == list.end()) return;
    const std::string kind = (*a)["kind"].get<std::string>();
    const bool listed =
        kind == "references" || kind == "numbers" || kind == "number" || kind == "range";
    if (listed) {  // what is being written is the last item
      const std::size_t blank = written_.find_last_of(" \t\r\n");
      if (blank != std::string::npos) {
        spot_.begin += blank + 1;
        written_.erase(0, blank + 1);
      }
    }
    if (a->contains("choices"))
      for (const Json& choice : (*a)["choices"]) add(choice, "", choice);
    if (kind == "boolean")
      for (const char* value : {"true", "false"}) add(value, "", value);
    if (kind == "reference" || kind == "references") names((*a)["wants"].get<std::string>());
    if (spot_.attribute == "plugin" && schema_.contains("plugins") &&
        schema_["plugins"].contains(spot_.tag + "s"))
      for (const Json& plugin : schema_["plugins"][spot_.tag + "s"])
        add(plugin["name"], "", plugin["name"]);
    if (spot_.attribute == "backend" && schema_.contains("backends"))
      for (const Json& name : schema_["backends"]) add(name, "", name);
    if (kind == "number" || kind == "numbers" || kind == "range") {
      // A unit, behind a number.
      const bool behind_digit =
          !written_.empty() && std::isdigit(static_cast<unsigned char>(written_.back())) != 0;
      if (!behind_digit)
        for (const Json& si : (*a)["units"])
          if (schema_["units"].contains(si.get<std::string>()))
            for (const Json& unit : schema_["units"][si.get<std::string>()]) add(unit, "", unit);
    }
    const std::string fallback = (*a)["default"].get<std::string>();
    if (written_.empty() && !fallback.empty()) add(fallback, "as if left out", fallback);
  }

  void names(const std::string& wants) {
    static const std::map<std::string, std::set<std::string>> kTags = {
        {"material", {"material"}},
        {"joint",
         {"hinge", "slider", "ball", "universal", "gimbal", "fixed", "cylindrical", "planar",
          "screw", "free"}},
        {"prototype", {"prototype"}},
        {"template", {"template"}},
        {"door", {"door"}},
        {"motor", {"motor", "servo"}},
        {"sensor",
         {"camera", "infrared", "lidar", "imu", "encoder", "contact", "force-torque", "pose",
          "sensor"}},
        {"place",
         {"box", "sphere", "cylinder", "capsule", "ellipsoid", "cone", "prism", "plane", "mesh",
          "heightmap", "body", "assembly", "instance", "frame"}}};
    const auto tags = kTags.find(wants);
    for (const dsl::OutlineElement& e : elements_) {
      if (e.name.empty() || e.id == 0) continue;
      if (tags != kTags.end() && tags->second.count(e.tag) == 0) continue;
      // From inside the same assembly the bare name will do.
      const std::string dotted = e.path.empty() ? e.name : e.path;
      add(e.name, e.tag + (dotted == e.name ? "" : " " + dotted), scoped(e, dotted));
      if (dotted != e.name) add(dotted, e.tag, dotted);
    }
  }

  std::string scoped(const dsl::OutlineElement& e, const std::string& dotted) const {
    const int parent = e.parent;
    if (parent <= 0) return e.name;
    const std::string& around = elements_[parent].tag;
    return std::find(spot_.open.begin(), spot_.open.end(), around) != spot_.open.end() ? e.name
                                                                                       : dotted;
  }

  const Json& schema_;
  const std::vector<dsl::OutlineElement>& elements_;
  Spot spot_;
  std::string written_;
  Json items_ = Json::array();
  std::set<std::string> listed_;
};

}  // namespace

Answer complete_at(const std::string& text, std::int64_t offset, const Json& schema,
                   const std::vector<dsl::OutlineElement>& elements) {
  // From code points to bytes and back.
  std::size_t cursor = 0;
  std::int64_t points = 0;
  while (cursor < text.size() && points < offset) {
    ++cursor;
    while (cursor < text.size() && (static_cast<unsigned char>(text[cursor]) & 0xC0) == 0x80)
      ++cursor;
    ++points;
  }
  if (offset < 0 || points < offset) return fail("the offset lies beyond the text");
  Completer completer(schema, elements);
  Json items = completer.run(text, cursor);
  std::int64_t from = 0;
  for (std::size_t i = 0; i < completer.begin(); ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) ++from;
  return Json{{"from", from}, {"items", std::move(items)}};
}

}  // namespace cogrsim::studio

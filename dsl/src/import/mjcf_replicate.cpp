// <replicate> of MJCF: copies of elements, each in a frame of its own.
//
// The frame of the copy i has the orientation R_i = euler(i e) and the origin p_i, where p_0 = 0 and
// p_(i+1) = p_i + R_i offset. Names in a copy end with `sep` and i, written with as many digits as the
// count has. Elements outside that refer to such a name are copied too, once for each copy.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "import/mjcf_reader.h"

namespace cogrsim::dsl::import {

namespace {

constexpr int kMostDepth = 200;
constexpr std::size_t kMostCopies = 200'000;

/// Whether an attribute holds the name of another element, but for assets and classes.
bool is_reference(std::string_view key) {
  constexpr std::array<std::string_view, 22> kReferences = {
      "joint",     "joint1",  "joint2",   "jointinparent", "body",    "body1",
      "body2",     "geom",    "geom1",    "geom2",         "site",    "site1",
      "site2",     "tendon",  "tendon1",  "tendon2",       "objname", "refname",
      "cranksite", "refsite", "actuator", "slidersite"};
  return std::find(kReferences.begin(), kReferences.end(), key) != kReferences.end();
}

/// Gives names in `e` the suffix; `only`: none but these, and references to them too.
void add_suffix(XmlElement& e, const std::string& suffix, const std::set<std::string>* only) {
  for (auto& [key, value] : e.attributes)
    if (!value.empty() && (key == "name" || (only != nullptr && is_reference(key))) &&
        (only == nullptr || only->count(value) != 0))
      value += suffix;
  for (auto& c : e.children) add_suffix(*c, suffix, only);
}

void collect_names(const XmlElement& e, std::set<std::string>& out) {
  if (const std::string* name = e.find("name"); name != nullptr && !name->empty())
    out.insert(*name);
  for (const auto& c : e.children) collect_names(*c, out);
}

bool refers_to(const XmlElement& e, const std::set<std::string>& names) {
  for (const auto& [key, value] : e.attributes)
    if (is_reference(key) && names.count(value) != 0) return true;
  return std::any_of(e.children.begin(), e.children.end(),
                     [&](const auto& c) { return refers_to(*c, names); });
}

std::size_t size_of(const XmlElement& e) {
  std::size_t out = 1;
  for (const auto& c : e.children) out += size_of(*c);
  return out;
}

}  // namespace

void MjcfReader::replicate(XmlElement& in, XmlElement& root, int depth) {
  if (depth > kMostDepth) context_.refuse(in.at, "CG1402", "bodies are nested too deep");
  std::vector<std::unique_ptr<XmlElement>> children;
  for (auto& c : in.children) {
    replicate(*c, root, depth + 1);
    if (c->name != "replicate") {
      children.push_back(std::move(c));
      continue;
    }
    for (auto& copy : copies_of(*c, root)) children.push_back(std::move(copy));
  }
  in.children = std::move(children);
}

std::vector<std::unique_ptr<XmlElement>> MjcfReader::copies_of(const XmlElement& e,
                                                               XmlElement& root) {
  std::vector<std::unique_ptr<XmlElement>> out;
  const double count = context_.number(e, "count", 0.0);
  if (!(count >= 1.0) || count != std::floor(count)) {
    context_.error(e.at, "CG1404", "<replicate> needs a count, a whole number above zero");
    return out;
  }
  const auto spend = [&](std::size_t elements) {
    const double made = static_cast<double>(elements) * count;
    if (made > static_cast<double>(kMostCopies - copies_))
      context_.refuse(e.at, "CG1402",
                      fmt::format("<replicate> makes more than {} elements", kMostCopies));
    copies_ += static_cast<std::size_t>(made);
  };
  spend(size_of(e));
  std::set<std::string> names;
  for (const auto& c : e.children) collect_names(*c, names);
  const Vec3 offset = context_.vec3(e, "offset", Vec3::Zero());
  const Vec3 euler = context_.vec3(e, "euler", Vec3::Zero());
  const std::string* given = e.find("sep");
  const std::string separator = given == nullptr ? "" : given->substr(0, 60);
  const std::size_t digits = fmt::format("{:.0f}", count).size();
  std::vector<std::string> suffixes;
  Vec3 p = Vec3::Zero();
  for (int i = 0; i < static_cast<int>(count); ++i) {
    suffixes.push_back(fmt::format("{}{:0{}}", separator, i, digits));
    auto frame = context_.copy(e);
    frame->name = "frame";
    const Quat q = turn(i * euler);
    frame->attributes = {{"pos", fmt::format("{} {} {}", p[0], p[1], p[2])},
                         {"quat", fmt::format("{} {} {} {}", q.w(), q.x(), q.y(), q.z())}};
    if (const std::string* inner = e.find("childclass"))
      frame->attributes.emplace_back("childclass", *inner);
    for (auto& c : frame->children) add_suffix(*c, suffixes.back(), nullptr);
    out.push_back(std::move(frame));
    p += q * offset;
  }
  // In this order, sensors follow the actuators to which they refer.
  for (const char* section : {"contact", "equality", "tendon", "actuator", "sensor"})
    for (auto& s : root.children) {
      if (s->name != section) continue;
      std::vector<std::unique_ptr<XmlElement>> list;
      for (auto& c : s->children) {
        if (!refers_to(*c, names)) {
          list.push_back(std::move(c));
          continue;
        }
        spend(size_of(*c));
        if (const std::string* name = c->find("name")) names.insert(*name);
        for (const std::string& suffix : suffixes) {
          list.push_back(context_.copy(*c));
          add_suffix(*list.back(), suffix, &names);
        }
      }
      s->children = std::move(list);
    }
  context_.exact(e.at, quoted_name(e), fmt::format("{} copies", count));
  return out;
}

}  // namespace cogrsim::dsl::import

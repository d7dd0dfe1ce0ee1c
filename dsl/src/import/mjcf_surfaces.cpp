// Contacts of MJCF: friction of pairs of geoms, and how soft contacts and stops are.
//
// Of two geoms the one with the higher priority says condim, friction, solref and solimp. Of equal ones
// the larger condim and each larger friction hold, and solref and solimp are mixed by solmix. A <pair>
// says its own. In a scene a pair of shapes has the larger friction by friction-combine="max"; what
// differs from that is a <contact> between materials.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "import/mjcf_reader.h"

namespace cogrsim::dsl::import {

namespace {

/// As many numbers of an attribute as there are; the others stay.
template <std::size_t N>
void take(Context& context, const XmlElement& source, const XmlElement& e, const char* name,
          std::array<double, N>& out) {
  const std::string* text = e.find(name);
  if (text == nullptr) return;
  const auto given = context.numbers(source, *text, 1, N, fmt::format("'{}'", name));
  if (given) std::copy(given->begin(), given->end(), out.begin());
}

/// As a list in the scene.
template <class Numbers>
std::string words(const Numbers& numbers) {
  return fmt::format("{}", fmt::join(numbers, " "));
}

}  // namespace

bool MjcfReader::Surface::operator==(const Surface& o) const {
  return std::tie(priority, dimensions, friction, mix, solref, solimp, margin, gap, of) ==
         std::tie(o.priority, o.dimensions, o.friction, o.mix, o.solref, o.solimp, o.margin, o.gap,
                  o.of);
}

// A contact of one dimension has no friction, of three sliding, of four spinning, of six rolling too.
MjcfReader::Frictions MjcfReader::Surface::frictions() const {
  const auto from = [&](double least, std::size_t i) {
    return dimensions >= least ? std::max(0.0, friction[i]) : 0.0;
  };
  return {from(3.0, 0), from(6.0, 2), from(4.0, 1)};
}

MujocoAttributes MjcfReader::Surface::of_mujoco() const {
  const Surface usual;
  MujocoAttributes out;
  const auto add = [&](const char* name, const auto& value, const auto& of_usual) {
    if (value != of_usual) out.emplace_back(name, words(value));
  };
  add("solref", solref, usual.solref);
  add("solimp", solimp, usual.solimp);
  for (const auto& [name, value, of_usual] : {std::tuple{"margin", margin, 0.0},
                                              {"gap", gap, 0.0},
                                              {"solmix", mix, 1.0},
                                              {"priority", priority, 0.0}})
    add(name, std::array{value}, std::array{of_usual});
  return out;
}

MjcfReader::Surface MjcfReader::Surface::with(const Surface& other) const {
  Surface out = priority >= other.priority ? *this : other;
  if (priority != other.priority) return out;
  out.dimensions = std::max(dimensions, other.dimensions);
  for (std::size_t i = 0; i < friction.size(); ++i)
    out.friction[i] = std::max(friction[i], other.friction[i]);
  return out;
}

int MjcfReader::surface_index(const Surface& surface) {
  const auto known = std::find(surfaces_.begin(), surfaces_.end(), surface);
  const auto index = static_cast<int>(known - surfaces_.begin());
  if (known == surfaces_.end()) surfaces_.push_back(surface);
  return index;
}

int MjcfReader::surface(const XmlElement& source, const XmlElement& e) {
  Surface out;
  out.priority = context_.number(e, "priority", 0.0);
  out.dimensions = context_.number(e, "condim", 3.0);
  take(context_, source, e, "friction", out.friction);
  out.mix = context_.number(e, "solmix", 1.0);
  take(context_, source, e, "solref", out.solref);
  take(context_, source, e, "solimp", out.solimp);
  out.margin = context_.number(e, "margin", 0.0);
  out.gap = context_.number(e, "gap", 0.0);
  // So many are not written by people; the search among them would take long.
  constexpr std::size_t kMost = 1000;
  if (surfaces_.size() > kMost) {
    Surface plain;
    plain.friction[0] = out.friction[0];
    out = plain;
    if (surfaces_.size() > 2 * kMost) return 0;
  }
  return surface_index(out);
}

// A <pair> holds for its two geoms alone: each has a surface of its own.
void MjcfReader::pair_surfaces() {
  std::map<std::string, RobotShape*> named;
  for (RobotLink& l : robot_.links)
    for (RobotShape& s : l.shapes)
      if (!s.name.empty()) named.emplace(s.name, &s);
  for (const XmlElement& e : pairs_) {
    const auto one = named.find(*e.find("geom1")), two = named.find(*e.find("geom2"));
    if (one == named.end() || two == named.end()) continue;
    const auto surface_at = [&](const RobotShape& s) { return surfaces_[std::size_t(s.material)]; };
    const Surface usual = surface_at(*one->second).with(surface_at(*two->second));
    Surface own = usual;
    own.dimensions = context_.number(e, "condim", own.dimensions);
    std::array<double, 5> all{own.friction[0], own.friction[0], own.friction[1], own.friction[2],
                              own.friction[2]};
    take(context_, e, e, "friction", all);
    own.friction = {all[0], all[2], all[3]};
    const std::string what =
        fmt::format("contact of '{}' and '{}'", *e.find("geom1"), *e.find("geom2"));
    context_.exact_unless(e.at, what,
                          all[0] != all[1] || all[3] != all[4]
                              ? "has the first of two frictions in all directions"
                              : "");
    if (own.frictions() == usual.frictions()) continue;
    const auto own_surface = [&](RobotShape& s) {
      Surface of = surface_at(s);
      of.of = s.name;
      s.material = surface_index(of);
      return s.material;
    };
    const int a = own_surface(*one->second), b = own_surface(*two->second);
    own_pairs_[std::minmax(a, b)] = own.frictions();
  }
}

void MjcfReader::surfaces() {
  pair_surfaces();
  // Which surfaces are used, and by how many geoms that move, or that stand in the world.
  std::vector<bool> stands;
  for (const RobotLink& l : robot_.links) stands.push_back(l.is_static);
  for (const RobotJoint& j : robot_.joints)
    if (j.type == RobotJoint::Type::fixed && (j.parent < 0 || stands[std::size_t(j.parent)]))
      stands[std::size_t(j.child)] = true;
  std::vector<std::size_t> moving(surfaces_.size()), standing(surfaces_.size());
  for (std::size_t i = 0; i < robot_.links.size(); ++i)
    for (const RobotShape& s : robot_.links[i].shapes)
      if (s.collides) ++(stands[i] ? standing : moving)[std::size_t(s.material)];
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    if (moving[i] + standing[i] > 0) used.push_back(i);

  std::vector<Frictions> own;
  for (const Surface& s : surfaces_) own.push_back(s.frictions());
  std::vector<int> material(surfaces_.size(), -1);
  constexpr std::size_t kMostContacts = 2000;
  std::size_t beyond = 0;
  const auto name_of_robot = scene_name(robot_.name);
  const bool has_ground =
      std::any_of(standing.begin(), standing.end(), [](std::size_t n) { return n > 0; });
  const bool same = same_softness(used, has_ground);
  const auto named = [&](std::size_t i) {
    if (material[i] < 0) {
      material[i] = static_cast<int>(robot_.materials.size());
      robot_.materials.push_back(
          {fmt::format("{}_surface_{}", name_of_robot, robot_.materials.size() + 1), own[i].sliding,
           own[i].rolling, own[i].spinning, CombineRule::max,
           same ? MujocoAttributes() : surfaces_[i].of_mujoco()});
    }
    return static_cast<std::size_t>(material[i]);
  };
  for (const std::size_t i : used)
    if (!same && !surfaces_[i].of_mujoco().empty()) named(i);
  for (std::size_t a = 0; a < used.size(); ++a)
    for (std::size_t b = a; b < used.size(); ++b) {
      const std::size_t i = used[a], k = used[b];
      if (moving[i] + moving[k] == 0) continue;
      const auto pair = own_pairs_.find(std::minmax(static_cast<int>(i), static_cast<int>(k)));
      const Frictions wanted =
          pair != own_pairs_.end() ? pair->second : surfaces_[i].with(surfaces_[k]).frictions();
      if (wanted == own[i].larger(own[k])) continue;
      if (robot_.contacts.size() >= kMostContacts) {
        ++beyond;
        continue;
      }
      const std::size_t first = named(i), second = named(k);
      robot_.contacts.push_back({first, second, wanted.sliding, wanted.rolling, wanted.spinning});
    }
  if (beyond > 0)
    context_.approximate({}, "friction of pairs",
                         fmt::format("{} pairs of kinds of geoms have the larger friction, where "
                                     "their condim or priority says otherwise",
                                     beyond));
  const bool has_priority = std::any_of(
      used.begin(), used.end(), [&](std::size_t i) { return surfaces_[i].priority != 0.0; });
  if (has_priority)
    context_.approximate({}, "priority of geoms",
                         "decides among the geoms of the file; where they meet others of a scene, "
                         "the larger friction holds");
  for (RobotLink& l : robot_.links)
    for (RobotShape& s : l.shapes) {
      if (s.material < 0) continue;
      const auto i = static_cast<std::size_t>(s.material);
      s.material = material[i];
      s.friction = own[i].sliding;
      s.rolling_friction = own[i].rolling;
      s.spinning_friction = own[i].spinning;
      s.friction_combine = CombineRule::max;
    }
}

bool MjcfReader::same_softness(const std::vector<std::size_t>& used, bool has_ground) {
  if (used.empty()) return true;
  const MujocoAttributes first = surfaces_[used.front()].of_mujoco();
  const bool same = !context_.options.prototype_only && (has_ground || first.empty()) &&
                    std::all_of(used.begin(), used.end(),
                                [&](std::size_t i) { return surfaces_[i].of_mujoco() == first; }) &&
                    std::all_of(first.begin(), first.end(), [](const auto& attribute) {
                      return attribute.first != "gap" && attribute.first != "solmix" &&
                             attribute.first != "priority";
                    });
  if (same) {
    for (const auto& [name, value] : first)
      of_mujoco({}, name + " of contacts", name.c_str(), value, "", "");
  } else if (std::any_of(used.begin(), used.end(),
                         [&](std::size_t i) { return !surfaces_[i].of_mujoco().empty(); })) {
    context_.exact({}, "softness of contacts",
                   "by materials, on the engine MuJoCo; others have rigid contacts");
  }
  return same;
}

MujocoAttributes MjcfReader::note_softness(const XmlElement& source, const XmlElement& e,
                                           const char* about, const char* suffix) {
  std::array<double, 2> solref{0.02, 1.0};
  std::array<double, 5> solimp{0.9, 0.95, 0.001, 0.5, 2.0};
  const std::string tail = suffix;
  take(context_, source, e, ("solref" + tail).c_str(), solref);
  take(context_, source, e, ("solimp" + tail).c_str(), solimp);
  MujocoAttributes out;
  const auto note = [&](const char* name, std::string value) {
    out.emplace_back(std::string(name) + about, value);
    Softness& all = softness_[out.back().first];
    if (all.values[value]++ == 0) all.at.emplace(value, source.at);
    ++all.count;
  };
  note("solref", words(solref));
  note("solimp", words(solimp));
  return out;
}

// The world has what most have, and the others say their own. A prototype has no world.
void MjcfReader::write_softness() {
  MujocoAttributes of_world;
  for (const auto& [name, all] : softness_) {
    const std::string usual = name.starts_with("solref") ? "0.02 1" : "0.9 0.95 0.001 0.5 2";
    const auto most =
        std::max_element(all.values.begin(), all.values.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    const std::string world = context_.options.prototype_only ? usual : most->first;
    of_world.emplace_back(name, world);
    if (!context_.options.prototype_only)
      of_mujoco(all.at.at(world), name, name.c_str(), world, usual, "");
    const auto has_it = all.values.find(world);
    const std::size_t others = all.count - (has_it == all.values.end() ? 0 : has_it->second);
    if (others > 0)
      context_.exact(
          all.at.begin()->second, name,
          fmt::format("{} of {} have their own, on the engine MuJoCo", others, all.count));
  }
  const auto keep_own = [&](MujocoAttributes& of) {
    of.erase(std::remove_if(of.begin(), of.end(),
                            [&](const auto& attribute) {
                              return std::find(of_world.begin(), of_world.end(), attribute) !=
                                     of_world.end();
                            }),
             of.end());
  };
  for (auto* const joints : {&robot_.joints, &robot_.loops})
    for (RobotJoint& j : *joints) {
      keep_own(j.of_mujoco);
      if (j.coupling) keep_own(j.coupling->of_mujoco);
    }
}

void MjcfReader::of_mujoco(const Source& at, const std::string& what, const char* name,
                           const std::string& value, const std::string& usual,
                           const std::string& differs) {
  auto& all = robot_.of_mujoco;  // of two <option> the later one holds
  all.erase(std::remove_if(all.begin(), all.end(), [&](const auto& a) { return a.first == name; }),
            all.end());
  if (value != usual) all.emplace_back(name, value);
  if (value == usual && differs.empty()) return;
  const std::string how =
      context_.options.prototype_only
          ? fmt::format(
                "acts on the engine MuJoCo alone, and belongs into <physics> of the scene: "
                "<mujoco {}=\"{}\"/>",
                name, value)
          : fmt::format(
                "{} on the engine MuJoCo, which has one; others have rigid contacts and stops",
                value);
  if (differs.empty() && !context_.options.prototype_only)
    context_.exact(at, what, how);
  else
    context_.left_out(at, what, differs.empty() ? how : differs + "; " + how);
}

}  // namespace cogrsim::dsl::import

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
  return std::tie(priority, dimensions, friction, mix, solref, solimp, margin, of) ==
         std::tie(o.priority, o.dimensions, o.friction, o.mix, o.solref, o.solimp, o.margin, o.of);
}

// A contact of one dimension has no friction, of three sliding, of four spinning, of six rolling too.
MjcfReader::Frictions MjcfReader::Surface::frictions() const {
  const auto from = [&](double least, std::size_t i) {
    return dimensions >= least ? std::max(0.0, friction[i]) : 0.0;
  };
  return {from(3.0, 0), from(6.0, 2), from(4.0, 1)};
}

MjcfReader::Surface MjcfReader::Surface::with(const Surface& other) const {
  Surface out = priority >= other.priority ? *this : other;
  out.margin = std::max(margin, other.margin);
  if (priority != other.priority) return out;
  out.dimensions = std::max(dimensions, other.dimensions);
  for (std::size_t i = 0; i < friction.size(); ++i)
    out.friction[i] = std::max(friction[i], other.friction[i]);
  constexpr double kNone = 1e-15;  // mjMINVAL
  const double share = mix >= kNone && other.mix >= kNone ? mix / (mix + other.mix)
                       : mix < kNone && other.mix < kNone ? 0.5
                       : mix < kNone                      ? 0.0
                                                          : 1.0;
  const bool times = solref[0] > 0.0 && other.solref[0] > 0.0;  // else stiffness and damping
  for (std::size_t i = 0; i < solref.size(); ++i)
    out.solref[i] = times ? share * solref[i] + (1.0 - share) * other.solref[i]
                          : std::min(solref[i], other.solref[i]);
  for (std::size_t i = 0; i < solimp.size(); ++i)
    out.solimp[i] = share * solimp[i] + (1.0 - share) * other.solimp[i];
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
  const auto named = [&](std::size_t i) {
    if (material[i] < 0) {
      material[i] = static_cast<int>(robot_.materials.size());
      robot_.materials.push_back(
          {fmt::format("{}_surface_{}", name_of_robot, robot_.materials.size() + 1), own[i].sliding,
           own[i].rolling, own[i].spinning, CombineRule::max});
    }
    return static_cast<std::size_t>(material[i]);
  };
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
  contact_softness(used, moving, standing);
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

// The engine MuJoCo has one softness of all contacts: that of the geoms with the highest priority on
// what stands, which is MuJoCo's default where the file has no ground.
void MjcfReader::contact_softness(const std::vector<std::size_t>& used,
                                  const std::vector<std::size_t>& moving,
                                  const std::vector<std::size_t>& standing) {
  std::size_t mover = surfaces_.size(), ground = surfaces_.size();
  for (const std::size_t i : used) {
    if (standing[i] > 0 && (ground == surfaces_.size() || standing[i] > standing[ground]))
      ground = i;
    if (moving[i] == 0) continue;
    if (mover == surfaces_.size() || std::pair(surfaces_[i].priority, moving[i]) >
                                         std::pair(surfaces_[mover].priority, moving[mover]))
      mover = i;
  }
  if (mover == surfaces_.size()) return;
  const Surface plain;
  const Surface& stands = ground < surfaces_.size() ? surfaces_[ground] : plain;
  const Surface chosen = surfaces_[mover].with(stands);
  std::size_t pairs = 0, solref = 0, solimp = 0, margin = 0;
  const auto compare = [&](const Surface& met) {
    ++pairs;
    solref += met.solref != chosen.solref;
    solimp += met.solimp != chosen.solimp;
    margin += met.margin != chosen.margin;
  };
  for (const std::size_t i : used) {
    if (moving[i] == 0) continue;
    for (const std::size_t k : used)
      if (k >= i || moving[k] == 0) compare(surfaces_[i].with(surfaces_[k]));
    if (ground == surfaces_.size()) compare(surfaces_[i].with(plain));
  }
  const auto say = [&](const char* name, const std::string& value, const std::string& usual,
                       std::size_t others) {
    of_mujoco(
        {}, fmt::format("{} of contacts", name), name, value, usual,
        others == 0 ? "" : fmt::format("{} of {} kinds of pairs have another", others, pairs));
  };
  say("solref", words(chosen.solref), words(plain.solref), solref);
  say("solimp", words(chosen.solimp), words(plain.solimp), solimp);
  say("margin", words(std::array{chosen.margin}), "0", margin);
}

void MjcfReader::note_softness(const XmlElement& source, const XmlElement& e, const char* about,
                               const char* suffix) {
  std::array<double, 2> solref{0.02, 1.0};
  std::array<double, 5> solimp{0.9, 0.95, 0.001, 0.5, 2.0};
  const std::string tail = suffix;
  take(context_, source, e, ("solref" + tail).c_str(), solref);
  take(context_, source, e, ("solimp" + tail).c_str(), solimp);
  const auto note = [&](const char* name, std::string value) {
    Softness& all = softness_[std::string(name) + about];
    if (all.values[value]++ == 0) all.at.emplace(value, source.at);
    ++all.count;
  };
  note("solref", words(solref));
  note("solimp", words(solimp));
}

void MjcfReader::write_softness() {
  for (const auto& [name, all] : softness_) {
    const auto most =
        std::max_element(all.values.begin(), all.values.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    const std::size_t others = all.count - most->second;
    of_mujoco(all.at.at(most->first), name, name.c_str(), most->first,
              name.starts_with("solref") ? "0.02 1" : "0.9 0.95 0.001 0.5 2",
              others == 0 ? "" : fmt::format("{} of {} have another", others, all.count));
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

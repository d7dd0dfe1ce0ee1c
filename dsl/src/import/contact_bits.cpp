// Which links touch each other, by the bits of their shapes and by their models.
//
// Two shapes touch where the contact type of one and the affinity of the other have a bit in common,
// or where a pair names them; links of one model only where one of them touches its own. A scene decides per pair of bodies. Bodies of which no shapes may touch
// are listed; where the list of those that do is the shorter one, that is written instead.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include "import/robot.h"

namespace cogrsim::dsl::import {

namespace {

using Pair = std::pair<int, int>;

class ContactBits {
 public:
  ContactBits(Context& context, RobotModel& robot) : context_(context), robot_(robot) {}

  void separate() {
    if (context_.result.format == "MJCF") report_bases();
    find_named_pairs();
    if (!find_classes()) return;
    silence_shapes();
    keep_off_the_ground();
    find_masks();
    count();
    report();
  }

 private:
  static constexpr std::size_t kMostClasses = 64, kMostPairs = 1000;
  using Mask = std::uint64_t;
  using Class = std::pair<unsigned, unsigned>;  // type, affinity

  static bool touch(const Class& a, const Class& b) {
    return (a.first & b.second) != 0 || (b.first & a.second) != 0;
  }
  static Class class_of(const RobotShape& s) { return {s.contact_type, s.contact_affinity}; }

  /// MuJoCo lets a body that stands in the world touch what a joint holds on it, a scene does not.
  void report_bases() {
    const auto meet = [&](const RobotLink& a, const RobotLink& b) {
      return std::any_of(a.shapes.begin(), a.shapes.end(), [&](const RobotShape& s) {
        return s.collides && std::any_of(b.shapes.begin(), b.shapes.end(), [&](const auto& o) {
                 return o.collides && touch(class_of(s), class_of(o));
               });
      });
    };
    std::set<std::pair<std::string, std::string>> apart;
    for (const auto& [a, b] : robot_.no_contact) apart.insert(std::minmax(a, b));
    for (const RobotJoint& j : robot_.joints) {
      if (j.parent < 0 || !robot_.stands(j.parent)) continue;
      const RobotLink &base = robot_.links[j.parent], &link = robot_.links[j.child];
      if (apart.count(std::minmax(base.name, link.name)) != 0 || !meet(base, link)) continue;
      context_.approximate(
          j.at, fmt::format("contact of '{}' and '{}'", base.name, link.name),
          fmt::format("they do not touch, as a joint holds one on the other: collide=\"true\" of "
                      "joint '{}' lets them, as MuJoCo does where a body stands in the world",
                      j.name));
    }
  }

  void find_named_pairs() {
    std::unordered_map<std::string, int> link_of;
    for (std::size_t i = 0; i < robot_.links.size(); ++i)
      for (const RobotShape& s : robot_.links[i].shapes)
        if (!s.name.empty()) link_of.emplace(s.name, static_cast<int>(i));
    for (const auto& [a, b] : robot_.touching) {
      const auto one = link_of.find(a), two = link_of.find(b);
      if (one == link_of.end() || two == link_of.end()) continue;  // left out with its shape
      named_shapes_.insert(a);
      named_shapes_.insert(b);
      if (one->second != two->second) named_.insert(std::minmax(one->second, two->second));
    }
  }

  /// Whether any bits matter.
  bool find_classes() {
    for (const RobotLink& l : robot_.links)
      for (const RobotShape& s : l.shapes)
        if (s.collides) classes_.emplace(class_of(s), classes_.size());
    std::set<int> models;
    const bool by_model =
        std::any_of(robot_.links.begin(), robot_.links.end(), [&](const RobotLink& l) {
          return l.model >= 0 && !l.self_collides && !models.insert(l.model).second;
        });
    const bool all_touch =
        !by_model && std::all_of(classes_.begin(), classes_.end(), [&](const auto& a) {
          return std::all_of(classes_.begin(), classes_.end(),
                             [&](const auto& b) { return touch(a.first, b.first); });
        });
    if (all_touch) return false;
    if (classes_.size() <= kMostClasses) return true;
    context_.approximate(
        {}, robot_.contact_rule,
        fmt::format("more than {} different ones: all shapes touch each other", kMostClasses));
    return false;
  }

  /// A shape that touches neither another one of the model nor what has the usual bits.
  void silence_shapes() {
    for (RobotLink& l : robot_.links)
      for (RobotShape& s : l.shapes) {
        if (!s.collides || named_shapes_.count(s.name) != 0) continue;
        const Class own = class_of(s);
        s.collides = touch(own, {robot_.usual_bits, robot_.usual_bits}) ||
                     std::any_of(classes_.begin(), classes_.end(),
                                 [&](const auto& c) { return touch(own, c.first); });
      }
  }

  /// Where some shapes of a link touch what stands in the world, and others are for contact within the
  /// robot alone (a box around a foot that walks on spheres), all would touch it. What the robot walks
  /// on matters more than contact within it: the others touch nothing. What some are for that lies
  /// around the robot, such as a thing to be grasped, they keep touching.
  void keep_off_the_ground() {
    find_trees();
    std::set<int> bases;  // parts of robots themselves
    for (const RobotJoint& j : robot_.joints) bases.insert(j.parent);
    std::set<Class> ground;
    for (std::size_t i = 0; i < robot_.links.size(); ++i)
      for (const RobotShape& s : robot_.links[i].shapes)
        if (s.collides && robot_.stands(static_cast<int>(i)) &&
            bases.count(static_cast<int>(i)) == 0)
          ground.insert(class_of(s));
    const Class usual{robot_.usual_bits, robot_.usual_bits};
    if (ground.empty()) ground.insert(usual);  // that of the scene
    const auto lands = [&](const RobotShape& s) {
      return std::any_of(ground.begin(), ground.end(),
                         [&](const Class& g) { return touch(class_of(s), g); });
    };
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      auto& shapes = robot_.links[i].shapes;
      if (robot_.stands(static_cast<int>(i)) ||
          !std::any_of(shapes.begin(), shapes.end(),
                       [&](const RobotShape& s) { return s.collides && lands(s); }))
        continue;
      for (RobotShape& s : shapes) {
        if (!s.collides || lands(s) || touch(class_of(s), usual) ||
            named_shapes_.count(s.name) != 0 || !is_for_own_tree(static_cast<int>(i), s))
          continue;
        s.collides = false;
        context_.approximate(
            s.at, fmt::format("contact of a shape of '{}'", robot_.links[i].name),
            "it touches nothing: in the source it touches links, but not the ground that other "
            "shapes of its link touch, and a scene decides that for all shapes of a body");
      }
    }
  }

  int tree_of(int link) {
    while (trees_[link] != link) link = trees_[link] = trees_[trees_[link]];
    return link;
  }

  /// Links that joints connect, and in which trees there are shapes of a class. The world connects
  /// nothing.
  void find_trees() {
    trees_.resize(robot_.links.size());
    std::iota(trees_.begin(), trees_.end(), 0);
    for (const auto* joints : {&robot_.joints, &robot_.loops})
      for (const RobotJoint& j : *joints)
        if (j.parent >= 0 && j.child >= 0 && !robot_.links[j.parent].is_ground)
          trees_[tree_of(j.child)] = tree_of(j.parent);
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      const int tree = tree_of(static_cast<int>(i));
      for (const RobotShape& s : robot_.links[i].shapes) {
        if (!s.collides) continue;
        int& only = only_tree_.emplace(class_of(s), tree).first->second;
        if (only != tree) only = -1;
      }
    }
  }

  /// Whether all that a shape touches is of its own tree.
  bool is_for_own_tree(int link, const RobotShape& shape) {
    const int tree = tree_of(link);
    return std::all_of(only_tree_.begin(), only_tree_.end(), [&](const auto& it) {
      return it.second == tree || !touch(class_of(shape), it.first);
    });
  }

  /// By their model.
  bool are_apart(int one, int two) const {
    const RobotLink &a = robot_.links[one], &b = robot_.links[two];
    return a.model >= 0 && a.model == b.model && !a.self_collides && !b.self_collides;
  }

  void find_masks() {
    std::vector<Mask> partners(classes_.size(), 0);
    for (const auto& [a, i] : classes_)
      for (const auto& [b, k] : classes_)
        if (touch(a, b)) partners[i] |= Mask{1} << k;
    for (const RobotLink& l : robot_.links) {
      Masks m;
      for (const RobotShape& s : l.shapes) {
        if (!s.collides) continue;
        const std::size_t c = classes_.at(class_of(s));
        m.own |= Mask{1} << c;
        m.some |= partners[c];
        m.all &= partners[c];
      }
      masks_.push_back(m);
    }
  }

  void count() {
    std::set<Pair> known;  // that never touch, or were reported
    std::unordered_map<std::string, int> index;
    for (std::size_t i = 0; i < robot_.links.size(); ++i)
      index.emplace(robot_.links[i].name, static_cast<int>(i));
    for (const RobotJoint& j : robot_.joints)
      if (j.parent >= 0) known.insert(std::minmax(j.parent, j.child));
    for (const RobotJoint& j : robot_.loops)
      if (j.parent >= 0) known.insert(std::minmax(j.parent, j.child));
    for (const auto& [a, b] : robot_.no_contact)
      known.insert(std::minmax(index.at(a), index.at(b)));
    const int n = static_cast<int>(robot_.links.size());
    for (int i = 0; i < n; ++i) {
      const Masks& a = masks_[i];
      if (a.own == 0) continue;
      for (int k = i + 1; k < n; ++k) {
        const Masks& b = masks_[k];
        if (b.own == 0 || (robot_.stands(i) && robot_.stands(k))) continue;
        const bool none = (a.some & b.own) == 0 || are_apart(i, k);
        const bool whole = (a.all & b.own) == b.own;
        if (!none && whole && touching_.size() > kMostPairs) continue;
        if (none && apart_.size() > kMostPairs) continue;
        if (known.count({i, k}) != 0) continue;
        const bool by_name = none && named_.count({i, k}) != 0;
        if (none && !by_name) {
          apart_.emplace_back(i, k);
        } else {
          if (!whole || by_name) ++partly_;
          if (touching_.size() <= kMostPairs) touching_.emplace_back(i, k);
        }
      }
    }
  }

  void report() {
    const auto named = [&](const Pair& p) {
      return std::pair(robot_.links[p.first].name, robot_.links[p.second].name);
    };
    if (apart_.empty() && partly_ == 0) return;
    std::string how;
    if (apart_.size() > touching_.size() && apart_.size() > kFew &&
        touching_.size() <= kMostPairs && !context_.options.prototype_only) {
      robot_.only_contact.emplace();
      for (const Pair& p : touching_) robot_.only_contact->push_back(named(p));
      how = fmt::format("{} pairs of bodies touch, others do not", touching_.size());
    } else if (apart_.size() <= kMostPairs) {
      for (const Pair& p : apart_) robot_.no_contact.push_back(named(p));
      how = fmt::format("{} pairs of bodies do not touch", apart_.size());
    } else {
      context_.approximate(
          {}, robot_.contact_rule,
          fmt::format("all bodies touch: more than {} pairs do not in the source", kMostPairs));
      return;
    }
    if (partly_ == 0)
      context_.exact({}, robot_.contact_rule, how);
    else
      context_.approximate(
          {}, robot_.contact_rule,
          fmt::format("{}; in {} pairs that do, all shapes touch, where in the source only some do",
                      how, partly_));
  }
  static constexpr std::size_t kFew = 10;  // that anybody would list one by one

  struct Masks {
    Mask own = 0, some = 0, all = ~Mask{0};  // classes of its shapes; that some, that all touch
  };
  Context& context_;
  RobotModel& robot_;
  std::map<Class, std::size_t> classes_;
  std::vector<int> trees_;          // of links: another one of the same tree, or itself
  std::map<Class, int> only_tree_;  // that has shapes of a class; -1: several
  std::vector<Masks> masks_;
  std::set<Pair> named_;
  std::set<std::string> named_shapes_;
  std::vector<Pair> apart_, touching_;
  std::size_t partly_ = 0;
};

}  // namespace

void separate_by_bits(Context& context, RobotModel& robot) {
  ContactBits(context, robot).separate();
}

}  // namespace cogrsim::dsl::import

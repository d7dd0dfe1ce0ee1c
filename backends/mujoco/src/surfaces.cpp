#include "surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "cogrsim/core/constants.h"

namespace cogrsim::mujoco {

namespace {

constexpr std::size_t kMostPairs = 100000;
constexpr double kMostDamping = 3.0;  // e = 0.024: softer does not bounce noticeably

/// Restitution of a spring that never pulls, damped by `ratio` of its critical damping.
double restitution_of(double ratio) {
  const double b = ratio, s = std::sqrt(std::abs(1.0 - b * b));
  if (b < 1.0) return std::exp(-b / s * std::atan2(2.0 * b * s, 2.0 * b * b - 1.0));
  if (b == 1.0) return std::exp(-2.0);
  return std::exp(-b / s * std::log((b + s) / (b - s)));
}

/// What MuJoCo is told of a pair, as attributes of a geom or pair.
class Terms {
 public:
  Terms(const SceneModel& model, const Options& options) : model_(model), options_(options) {}

  const SurfacePair& of(int material_a, int material_b) {
    const auto key = std::minmax(material_a, material_b);
    const auto [entry, is_new] = known_.try_emplace(key);
    if (is_new) entry->second = surface_pair(model_, material_a, material_b);
    return entry->second;
  }

  std::string text(const SurfacePair& surface, bool of_pair) const {
    // Without friction a contact has one row: a pyramid without width would have four equal ones.
    return fmt::format("condim=\"{}\" friction=\"{}{} 0.005 0.0001{}\" solref=\"{}\" {}",
                       surface.friction > 0 ? 3 : 1, surface.friction,
                       of_pair ? fmt::format(" {}", surface.friction) : "",
                       of_pair ? " 0.0001" : "", solref(surface.restitution), options_.contact);
  }

 private:
  std::string solref(double restitution) const {
    const double ratio = restitution > 0 ? damping_ratio(restitution) : kMostDamping;
    if (ratio >= kMostDamping) return options_.solref;
    // As stiff as bounces in some dozen steps.
    const double frequency = 1.0 / (4.0 * model_.physics.step);
    const double values[] = {-frequency * frequency, -2.0 * ratio * frequency};
    return numbers(values, 2);
  }

  const SceneModel& model_;
  const Options& options_;
  std::map<std::pair<int, int>, SurfacePair> known_;
};

bool same(const SurfacePair& a, const SurfacePair& b) {
  return a.friction == b.friction && a.restitution == b.restitution;
}

/// Geoms of one material that move, or that do not.
struct Group {
  int material = -1;
  bool mobile = false;
  double count = 0.0;
  int priority = -1;
  SurfacePair surface;  ///< that its priority brings about
};

}  // namespace

double damping_ratio(double restitution) {
  double low = 0.0, high = kMostDamping;  // restitution_of() falls
  if (restitution <= restitution_of(high)) return high;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of(middle) > restitution ? low : high) = middle;
  }
  return low;
}

Result<Surfaces> choose_surfaces(const SceneModel& model, const Options& options,
                                 const std::vector<SurfaceGeom>& geoms) {
  Terms terms(model, options);
  std::map<std::pair<int, bool>, int> numbers_of;
  std::vector<Group> groups;
  std::vector<int> group_of;
  for (const SurfaceGeom& geom : geoms) {
    const auto [entry, is_new] =
        numbers_of.try_emplace({geom.material, geom.mobile}, static_cast<int>(groups.size()));
    if (is_new) groups.push_back({geom.material, geom.mobile, 0.0, -1, {}});
    groups[static_cast<std::size_t>(entry->second)].count += 1.0;
    group_of.push_back(entry->second);
  }
  // From the highest priority down: next comes the group that serves most of its pairs with those
  // that are still without one by a single surface.
  std::vector<Group*> left;
  for (Group& group : groups) left.push_back(&group);
  while (!left.empty()) {
    double least = -1.0;
    std::size_t chosen = 0;
    SurfacePair surface;
    for (std::size_t i = 0; i < left.size(); ++i) {
      std::vector<std::pair<SurfacePair, double>> votes;
      double all = 0.0;
      for (const Group* other : left) {
        if (!left[i]->mobile && !other->mobile) continue;
        const double weight = left[i]->count * other->count * (other == left[i] ? 0.5 : 1.0);
        const SurfacePair& wanted = terms.of(left[i]->material, other->material);
        const auto vote = std::find_if(votes.begin(), votes.end(),
                                       [&](const auto& v) { return same(v.first, wanted); });
        vote == votes.end() ? void(votes.emplace_back(wanted, weight))
                            : void(vote->second += weight);
        all += weight;
      }
      const auto best =
          std::max_element(votes.begin(), votes.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
      const double lost = best == votes.end() ? 0.0 : all - best->second;
      if (least >= 0.0 && lost >= least) continue;
      least = lost;
      chosen = i;
      surface = best == votes.end() ? terms.of(left[i]->material, left[i]->material) : best->first;
    }
    left[chosen]->priority = static_cast<int>(left.size()) - 1;
    left[chosen]->surface = surface;
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(chosen));
  }

  Surfaces out;
  for (std::size_t i = 0; i < geoms.size(); ++i) {
    const Group& group = groups[static_cast<std::size_t>(group_of[i])];
    out.geoms.push_back(
        fmt::format("priority=\"{}\" {}", group.priority, terms.text(group.surface, false)));
  }
  // What that leaves wrong, pair by pair.
  const CollisionFilter filter(model);
  std::size_t count = 0;
  for (std::size_t a = 0; a < geoms.size(); ++a) {
    for (std::size_t b = a + 1; b < geoms.size(); ++b) {
      const Group& one = groups[static_cast<std::size_t>(group_of[a])];
      const Group& two = groups[static_cast<std::size_t>(group_of[b])];
      const SurfacePair& wanted = terms.of(one.material, two.material);
      if (same(wanted, (one.priority > two.priority ? one : two).surface)) continue;
      if (!filter.collide(geoms[a].body, geoms[b].body)) continue;
      if (++count > kMostPairs) {
        return fail("its materials differ in more than " + std::to_string(kMostPairs) +
                        " pairs of shapes, each of which MuJoCo must be told",
                    place_of(model, model.physics.origin), "use fewer materials, or fewer bodies");
      }
      out.pairs +=
          fmt::format("<pair geom1=\"g{}\" geom2=\"g{}\" {}/>\n", a, b, terms.text(wanted, true));
    }
  }
  return out;
}

}  // namespace cogrsim::mujoco

#include "surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace cogrsim::mujoco {

namespace {

/// Damping ratio of a spring and dashpot that never pulls and from which a body leaves with
/// `restitution` of the speed with which it came (Schwager and Poeschel, Phys. Rev. E 75, 051304,
/// 2007). At most 1: no restitution below exp(-2).
double damping_ratio(double restitution) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double b = 0.5 * (low + high), s = std::sqrt(1.0 - b * b);
    const double e = std::exp(-b / s * std::atan2(2.0 * b * s, 2.0 * b * b - 1.0));
    (e > restitution ? low : high) = b;
  }
  return low;
}

/// The surface of a pair, as attributes of a geom or pair.
class Terms {
 public:
  Terms(const SceneModel& model, const Options& options) : model_(model), options_(options) {}

  const SurfacePair& of(int material_a, int material_b) {
    const std::pair<int, int> key = std::minmax(material_a, material_b);
    const auto [entry, is_new] = known_.try_emplace(key);
    if (is_new) entry->second = surface_pair(model_, material_a, material_b);
    return entry->second;
  }

  std::string text(const SurfacePair& surface, bool of_pair) const {
    // Without friction a contact has one row: a pyramid without width would have four equal ones.
    const double slide = surface.friction, spin = surface.spinning_friction;
    const double roll = surface.rolling_friction;
    return fmt::format("condim=\"{}\" friction=\"{}{} {} {}{}\" solref=\"{}\" {}",
                       roll > 0    ? 6
                       : spin > 0  ? 4
                       : slide > 0 ? 3
                                   : 1,
                       slide, of_pair ? fmt::format(" {}", slide) : "", spin, roll,
                       of_pair ? fmt::format(" {}", roll) : "", solref(surface.restitution),
                       options_.contact);
  }

 private:
  std::string solref(double restitution) const {
    if (restitution <= std::exp(-2.0)) return options_.solref;
    // As stiff as bounces in some dozen steps.
    const double frequency = 1.0 / (4.0 * model_.physics.step);
    const double values[] = {-frequency * frequency, -2.0 * damping_ratio(restitution) * frequency};
    return numbers(values, 2);
  }

  const SceneModel& model_;
  const Options& options_;
  std::map<std::pair<int, int>, SurfacePair> known_;
};

bool same(const SurfacePair& a, const SurfacePair& b) {
  return a.friction == b.friction && a.restitution == b.restitution &&
         a.rolling_friction == b.rolling_friction && a.spinning_friction == b.spinning_friction;
}

}  // namespace

std::string surface_class(const SurfaceGeom& geom) {
  return fmt::format("s{}{}", geom.material, geom.mobile ? 'm' : 's');
}

Surfaces choose_surfaces(const SceneModel& model, const Options& options,
                         const std::vector<SurfaceGeom>& geoms) {
  Terms terms(model, options);
  std::map<int, int> moving;  // geoms by material; what is slick is so beside whatever there is
  for (const SurfaceGeom& geom : geoms)
    moving[geom.material] += geom.mobile && terms.of(geom.material, geom.material).friction > 0;
  const auto most =
      std::max_element(moving.begin(), moving.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const int usual = most == moving.end() ? -1 : most->first;
  // What is of the usual material and moves comes last; all else has the surface that is right where
  // it meets that. What is slick there is so everywhere, and comes first.
  const auto priority = [&](const SurfaceGeom& geom) {
    if (geom.mobile && geom.material == usual) return 0;
    return terms.of(usual, geom.material).friction > 0 ? 1 : 2;
  };
  Surfaces out;
  std::vector<SurfacePair> own;
  std::set<std::string> classes;
  for (const SurfaceGeom& geom : geoms) {
    own.push_back(terms.of(usual, geom.material));
    const std::string name = surface_class(geom);
    if (!classes.insert(name).second) continue;
    out.classes += fmt::format("<default class=\"{}\"><geom priority=\"{}\" {}/></default>\n", name,
                               priority(geom), terms.text(own.back(), false));
  }
  // The other pairs, one by one.
  const CollisionFilter filter(model);
  for (std::size_t a = 0; a < geoms.size(); ++a) {
    for (std::size_t b = a + 1; b < geoms.size(); ++b) {
      const SurfaceGeom &one = geoms[a], &two = geoms[b];
      if (!one.mobile && !two.mobile) continue;
      const SurfacePair& wanted = terms.of(one.material, two.material);
      const bool a_fits = priority(one) < priority(two) || same(wanted, own[a]);
      const bool b_fits = priority(two) < priority(one) || same(wanted, own[b]);
      if ((a_fits && b_fits) || !filter.collide(one.body, two.body)) continue;
      out.pairs +=
          fmt::format("<pair geom1=\"g{}\" geom2=\"g{}\" {}/>\n", a, b, terms.text(wanted, true));
    }
  }
  return out;
}

}  // namespace cogrsim::mujoco

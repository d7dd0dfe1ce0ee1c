#include "surfaces.h"

#include <fmt/format.h>
#include <mujoco/mjtnum.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

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

/// A contact as MuJoCo has it.
struct ContactLaw {
  std::array<double, 3> friction{};  ///< sliding, spinning, rolling
  std::array<double, 2> solref{};
  std::array<double, 5> solimp{};
  double margin = 0.0, gap = 0.0;
  bool operator==(const ContactLaw& o) const {
    return std::tie(friction, solref, solimp, margin, gap) ==
           std::tie(o.friction, o.solref, o.solimp, o.margin, o.gap);
  }
};
struct Own : ContactLaw {
  double mix = 1.0;
  std::int64_t priority = 0;
};

/// What MuJoCo makes of two geoms, see mj_contactParam().
ContactLaw combined(const Own& a, const Own& b) {
  ContactLaw out = a.priority >= b.priority ? a : b;
  out.margin = std::max(a.margin, b.margin);
  out.gap = std::max(a.gap, b.gap);
  if (a.priority != b.priority) return out;
  const bool a_has = a.mix >= mjMINVAL, b_has = b.mix >= mjMINVAL;
  const double share = a_has && b_has ? a.mix / (a.mix + b.mix) : 0.5 + 0.5 * (a_has - b_has);
  const bool times = a.solref[0] > 0.0 && b.solref[0] > 0.0;  // else stiffness and damping
  for (std::size_t i = 0; i < 3; ++i) out.friction[i] = std::max(a.friction[i], b.friction[i]);
  for (std::size_t i = 0; i < 2; ++i)
    out.solref[i] = times ? share * a.solref[i] + (1.0 - share) * b.solref[i]
                          : std::min(a.solref[i], b.solref[i]);
  for (std::size_t i = 0; i < 5; ++i)
    out.solimp[i] = share * a.solimp[i] + (1.0 - share) * b.solimp[i];
  return out;
}

std::string text(const ContactLaw& it, bool of_pair) {
  // Without friction a contact has one row: a pyramid without width would have four equal ones.
  const auto [slide, spin, roll] = it.friction;
  const int dimensions = roll > 0 ? 6 : spin > 0 ? 4 : slide > 0 ? 3 : 1;
  return fmt::format(
      "condim=\"{}\" friction=\"{}{} {} {}{}\" solref=\"{}\" solimp=\"{}\" margin=\"{}\" "
      "gap=\"{}\"",
      dimensions, slide, of_pair ? fmt::format(" {}", slide) : "", spin, roll,
      of_pair ? fmt::format(" {}", roll) : "", numbers(it.solref.data(), 2),
      numbers(it.solimp.data(), 5), it.margin, it.gap);
}

/// What the scene has for materials, and what holds between two.
class Terms {
 public:
  Terms(const SceneModel& model, const Options& options) : model_(model) {
    for (std::size_t m = 0; m < model.materials.size(); ++m) {
      Parameters all = options.with(model.materials[m].engine_options);
      for (const ParameterSpec& spec : element_option_table("material"))
        all.emplace(spec.name, spec.default_value);
      Own& own = own_.emplace_back();
      const auto& ref = std::get<std::vector<double>>(all.at("solref"));
      const auto& imp = std::get<std::vector<double>>(all.at("solimp"));
      std::copy_n(ref.begin(), 2, own.solref.begin());
      std::copy_n(imp.begin(), 5, own.solimp.begin());
      own.margin = std::get<double>(all.at("margin"));
      own.gap = std::get<double>(all.at("gap"));
      own.mix = std::get<double>(all.at("solmix"));
      own.priority = std::get<std::int64_t>(all.at("priority"));
      set_surface(own, static_cast<int>(m), static_cast<int>(m));
    }
  }

  const Own& of(int material) const { return own_[material]; }
  ContactLaw of(int a, int b) const {
    ContactLaw out = combined(own_[a], own_[b]);
    set_surface(out, a, b);
    return out;
  }

 private:
  void set_surface(ContactLaw& out, int a, int b) const {
    const SurfacePair surface = surface_pair(model_, a, b);
    out.friction = {surface.friction, surface.spinning_friction, surface.rolling_friction};
    if (surface.restitution <= std::exp(-2.0)) return;
    const double stiffness = bounce_stiffness(model_);
    out.solref = {stiffness, -2.0 * damping_ratio(surface.restitution) * std::sqrt(-stiffness)};
  }

  const SceneModel& model_;
  std::vector<Own> own_;
};

}  // namespace

Surfaces choose_surfaces(const SceneModel& model, const Options& options,
                         const std::vector<SurfaceGeom>& geoms) {
  const Terms terms(model, options);
  Surfaces out;
  std::map<int, std::vector<std::size_t>> by_material;
  for (std::size_t g = 0; g < geoms.size(); ++g) by_material[geoms[g].material].push_back(g);
  const CollisionFilter filter(model);
  for (auto one = by_material.begin(); one != by_material.end(); ++one) {
    const auto& [a, of_a] = *one;
    out.classes +=
        fmt::format("<default class=\"s{}\"><geom priority=\"{}\" solmix=\"{}\" {}/></default>\n",
                    a, terms.of(a).priority, terms.of(a).mix, text(terms.of(a), false));
    for (auto two = one; two != by_material.end(); ++two) {
      const auto& [b, of_b] = *two;
      const ContactLaw wanted = terms.of(a, b);
      if (wanted == combined(terms.of(a), terms.of(b))) continue;
      const std::string surface = text(wanted, true);
      for (const std::size_t i : of_a)
        for (const std::size_t k : of_b)
          if ((a != b || i < k) && (geoms[i].mobile || geoms[k].mobile) &&
              filter.collide(geoms[i].body, geoms[k].body))
            out.pairs += fmt::format("<pair geom1=\"g{}\" geom2=\"g{}\" {}/>\n", std::min(i, k),
                                     std::max(i, k), surface);
    }
  }
  return out;
}

}  // namespace cogrsim::mujoco

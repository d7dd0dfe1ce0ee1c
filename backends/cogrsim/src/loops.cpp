#include "loops.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mechanism.h"
#include "products.h"

namespace cogrsim::dynamics {
namespace {

// A row of which less than this, relative to the largest of its kind in its weld, is left beside the
// rows before it adds nothing.
constexpr double kAddsNothing = 1e-9;

struct Ends {
  const LinkMotion& ghost;
  const LinkMotion& master;
};
Ends ends_of(const Mechanism& mechanism, const Weld& weld) {
  return {mechanism.motions()[std::size_t(weld.ghost)],
          mechanism.motions()[std::size_t(weld.master)]};
}

void put(const Vec3& angular, const Vec3& linear, double* e) {
  Eigen::Map<Vec3>{e} = angular;
  Eigen::Map<Vec3>{e + 3} = linear;
}

// Where the ranges of two welds meet.
struct Overlap {
  int first, size;
};
Overlap overlap(const Weld& a, const Weld& b) {
  const int first = std::max(a.first, b.first);
  return {first, std::min(a.end, b.end) - first};
}

}  // namespace

void update_loops(const Mechanism& mechanism, Component& c) {
  const int n = c.size();
  const std::size_t nweld = c.welds.size();
  Loops& loops = c.loops;
  loops.G.setZero(Eigen::Index(6 * nweld), n);
  loops.W.setZero(Eigen::Index(6 * nweld), n);
  loops.factor.resize(36 * nweld * nweld);
  loops.kept.clear();
  const std::size_t stride = 6 * nweld;
  for (std::size_t w = 0; w < nweld; ++w) {
    const Weld& weld = c.welds[w];
    const Vec3 r = ends_of(mechanism, weld).ghost.X.p - c.origin;
    Eigen::Matrix<double, 6, 6> rest;
    for (int axis = 0; axis < 6; ++axis) {
      const Vec3 d = Vec3::Unit(axis % 3);
      const Spatial wrench = axis < 3 ? Spatial{d, Vec3::Zero()} : Spatial{r.cross(d), d};
      double* const g = loops.G.row(Eigen::Index(6 * w) + axis).data();
      double* const response = loops.W.row(Eigen::Index(6 * w) + axis).data();
      fill_row(c, weld.ghost_at, wrench, 1.0, g);
      fill_row(c, weld.master_at, wrench, -1.0, g);
      std::copy(g + weld.first, g + weld.end, response + weld.first);
      solve_mass(c, response, weld.ghost_at);
      if (c.tree[std::size_t(weld.ghost_at)] != c.tree[std::size_t(weld.master_at)])
        solve_mass(c, response, weld.master_at);
      for (int k = 0; k <= axis; ++k)
        rest(axis, k) = rest(k, axis) =
            product(loops.G.row(Eigen::Index(6 * w) + k).data() + weld.first, response + weld.first,
                    weld.end - weld.first);
    }
    // Turns and shifts have units of their own.
    std::array<double, 2> scale;
    for (int kind = 0; kind < 2; ++kind) {
      const double most = rest.diagonal().segment<3>(3 * kind).maxCoeff();
      scale[std::size_t(kind)] = most > 0.0 ? 1.0 / std::sqrt(most) : 0.0;
    }
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 6; ++k)
        rest(i, k) *= scale[std::size_t(i / 3)] * scale[std::size_t(k / 3)];

    // What the rows kept so far say of these six.
    const int before = int(loops.kept.size());
    int lead = before;
    for (int k = before; k-- > 0;)
      if (overlap(weld, c.welds[std::size_t(loops.kept[std::size_t(k)].weld)]).size > 0) lead = k;
    std::array<std::array<double, 6>, 6> own{};  // factor of the rows kept of this weld
    static thread_local std::vector<double> head;
    head.resize(6 * stride);
    for (int i = 0; i < 6; ++i) {
      double* const l = &head[std::size_t(i) * stride];
      const double* const g = loops.G.row(Eigen::Index(6 * w) + i).data();
      for (int k = lead; k < before; ++k) {
        const Loops::Kept& other = loops.kept[std::size_t(k)];
        const Overlap both = overlap(weld, c.welds[std::size_t(other.weld)]);
        double a = 0.0;
        if (both.size > 0)
          a = scale[std::size_t(i / 3)] * other.scale *
              product(g + both.first, loops.W.row(other.row).data() + both.first, both.size);
        const double* const ok = &loops.factor[std::size_t(k) * stride];
        const int from = std::max(lead, other.lead);
        l[k] = (a - product(ok + from, l + from, k - from)) * ok[k];
      }
      for (int k = 0; k <= i; ++k) {
        rest(i, k) -= product(l + lead, &head[std::size_t(k) * stride] + lead, before - lead);
        rest(k, i) = rest(i, k);
      }
    }
    std::array<bool, 6> taken{};
    for (int count = 0; count < 6; ++count) {
      int best = -1;
      for (int i = 0; i < 6; ++i)
        if (!taken[std::size_t(i)] && (best < 0 || rest(i, i) > rest(best, best))) best = i;
      if (!(rest(best, best) > kAddsNothing)) break;
      taken[std::size_t(best)] = true;
      const double inverse = 1.0 / std::sqrt(rest(best, best));
      for (int i = 0; i < 6; ++i) own[std::size_t(i)][std::size_t(count)] = rest(i, best) * inverse;
      const int place = before + count;
      double* const l = &loops.factor[std::size_t(place) * stride];
      std::copy_n(&head[std::size_t(best) * stride + std::size_t(lead)], before - lead, l + lead);
      std::copy_n(own[std::size_t(best)].data(), count, l + before);
      l[place] = inverse;
      loops.kept.push_back({int(w), int(6 * w) + best, lead, scale[std::size_t(best / 3)]});
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k)
          rest(i, k) -=
              own[std::size_t(i)][std::size_t(count)] * own[std::size_t(k)][std::size_t(count)];
    }
  }
}

void close_loops(const Component& c, double* x, const double* wanted) {
  const Loops& loops = c.loops;
  const int count = int(loops.kept.size());
  const std::size_t stride = 6 * c.welds.size();
  static thread_local std::vector<double> impulse;
  impulse.resize(std::size_t(count));
  double* const l = impulse.data();
  for (int i = 0; i < count; ++i) {
    const Loops::Kept& kept = loops.kept[std::size_t(i)];
    const Weld& weld = c.welds[std::size_t(kept.weld)];
    double value =
        product(loops.G.row(kept.row).data() + weld.first, x + weld.first, weld.end - weld.first);
    if (wanted) value -= wanted[kept.row];
    const double* const row = &loops.factor[std::size_t(i) * stride];
    l[i] = (kept.scale * value - product(row + kept.lead, l + kept.lead, i - kept.lead)) * row[i];
  }
  for (int i = count; i-- > 0;) {
    const Loops::Kept& kept = loops.kept[std::size_t(i)];
    const Weld& weld = c.welds[std::size_t(kept.weld)];
    const double* const row = &loops.factor[std::size_t(i) * stride];
    l[i] *= row[i];
    add_scaled(-l[i], row + kept.lead, i - kept.lead, l + kept.lead);
    add_scaled(-l[i] * kept.scale, loops.W.row(kept.row).data() + weld.first, weld.end - weld.first,
               x + weld.first);
  }
}

double find_loop_gaps(const Mechanism& mechanism, const Component& c, double* e) {
  double most = 0.0;
  for (std::size_t w = 0; w < c.welds.size(); ++w) {
    const Ends ends = ends_of(mechanism, c.welds[w]);
    const Eigen::AngleAxisd turn(ends.ghost.X.R * ends.master.X.R.transpose());
    // Of a small angle only the skew part keeps its digits.
    const Mat3 R = ends.ghost.X.R * ends.master.X.R.transpose();
    const Vec3 skew(0.5 * (R(2, 1) - R(1, 2)), 0.5 * (R(0, 2) - R(2, 0)),
                    0.5 * (R(1, 0) - R(0, 1)));
    const Vec3 angular = skew.norm() < 1e-3 ? skew : Vec3(turn.angle() * turn.axis());
    const Vec3 shift = ends.ghost.X.p - ends.master.X.p;
    put(angular, shift, e + 6 * w);
    most = std::max({most, angular.cwiseAbs().maxCoeff(), shift.cwiseAbs().maxCoeff()});
  }
  return most;
}

void find_loop_speeds(const Mechanism& mechanism, const Component& c, double* e) {
  for (std::size_t w = 0; w < c.welds.size(); ++w) {
    const Ends ends = ends_of(mechanism, c.welds[w]);
    put(ends.ghost.angular - ends.master.angular,
        ends.ghost.linear - ends.master.velocity_at(ends.ghost.X.p), e + 6 * w);
  }
}

void find_loop_bias(const Mechanism& mechanism, const Component& c, double* b) {
  for (std::size_t w = 0; w < c.welds.size(); ++w) {
    const Weld& weld = c.welds[w];
    const Ends ends = ends_of(mechanism, weld);
    const Vec3 at = ends.ghost.X.p;
    const auto acceleration = [&](int place, const LinkMotion& motion) -> Vec3 {
      const Spatial& a = c.bias[std::size_t(place)];
      return a.linear + a.angular.cross(at - c.origin) +
             motion.angular.cross(motion.velocity_at(at));
    };
    put(c.bias[std::size_t(weld.ghost_at)].angular - c.bias[std::size_t(weld.master_at)].angular,
        acceleration(weld.ghost_at, ends.ghost) - acceleration(weld.master_at, ends.master),
        b + 6 * w);
  }
}

void add_loop_rows(const Component& c, double factor, const double* x, double* e) {
  for (std::size_t w = 0; w < c.welds.size(); ++w) {
    const Weld& weld = c.welds[w];
    for (std::size_t i = 6 * w; i < 6 * w + 6; ++i)
      e[i] += factor * product(c.loops.G.row(Eigen::Index(i)).data() + weld.first, x + weld.first,
                               weld.end - weld.first);
  }
}

}  // namespace cogrsim::dynamics

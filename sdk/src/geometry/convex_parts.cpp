// Approximate convex decomposition.
//
// Of a solid S and a convex set H that contains it, the excess E(H) is the volume of H outside S. A part
// is S within a box, H is the hull of its surface. The part with the largest excess is cut in two by a
// plane x, y or z = c, that for which
//
//   E(H1) + E(H2) + 0.05 E(H) |V(H1) - V(H2)| / V(H)
//
// is least: the last term prefers halves where nothing else decides, as in a ring. Planes tried are those
// of flat faces and evenly spaced ones. Once there are twice the wanted number, parts are united again, the
// pair first that adds the least excess.
//
// Idea: Mamou, Volumetric hierarchical approximate convex decomposition, in Game Engine Gems 3, 2016.
// Otherwise here: E is counted in cells that can be reached from outside, so that thin walls and closed
// cavities count right; the surface is clipped exactly, so that boxes come out as boxes.
#include "cogrsim/geometry/convex_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "cogrsim/geometry/bounds.h"
#include "cogrsim/geometry/convex_hull.h"
#include "cogrsim/geometry/triangles.h"
#include "core/index.h"

namespace cogrsim::geometry {
namespace {

using Soup = std::vector<Triangle>;

double volume(const TriangleMesh& mesh) {
  double six = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = triangle(mesh, i);
    six += t[0].dot(t[1].cross(t[2]));
  }
  return six / 6.0;
}

/// Cells around a mesh, and which of their centres are outside the solid.
class Grid {
 public:
  Grid(const TriangleMesh& mesh, const Bounds& box, int cells) {
    const Vec3 size = box.high - box.low;
    cell_ = size.maxCoeff() / cells;
    // Centres are off the planes of faces, most of which have round numbers.
    low_ = box.low - cell_ * Vec3(1.37, 1.41, 1.43);
    for (int a = 0; a < 3; ++a) count_[a] = static_cast<int>(std::ceil(size[a] / cell_)) + 3;
    free_.assign(at(count_[0]) * at(count_[1]) * at(count_[2]), false);
    for (auto& walls : wall_) walls.assign(free_.size(), false);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      for (int a = 0; a < 3; ++a) add_walls(triangle(mesh, i), a);
    flood();
    below_.assign(free_.size(), 0);
    for (int x = 0; x < count_[0]; ++x)
      for (int y = 0; y < count_[1]; ++y)
        for (int z = 1; z < count_[2]; ++z)
          below_[index(x, y, z)] = below_[index(x, y, z - 1)] + (free_[index(x, y, z - 1)] ? 1 : 0);
  }

  /// Steps of cutting and measuring parts; each counts where it is taken.
  void count(std::size_t steps) const { steps_ += steps; }
  std::size_t steps() const { return steps_; }

  double cell() const { return cell_; }
  double low(int axis) const { return low_[axis]; }

  /// Whether all cells around a point are inside.
  bool inside(const Vec3& p) const {
    const Vec3 at = (p - low_) / cell_ - Vec3::Constant(0.5);
    for (int i = 0; i < 8; ++i) {
      std::array<int, 3> c;
      for (int a = 0; a < 3; ++a)
        c[a] = std::clamp(static_cast<int>(std::floor(at[a])) + (i >> a & 1), 0, count_[a] - 1);
      if (free_[index(c[0], c[1], c[2])]) return false;
    }
    return true;
  }

  /// E of a hull: cells outside the solid, with their centres inside of it.
  double excess(const TriangleMesh& hull) const {
    struct Plane {
      Vec3 n;
      double d;
    };
    std::vector<Plane> planes;
    Bounds box;
    for (const Vec3& v : hull.vertices) box.add(v);
    for (std::size_t i = 0; i < hull.triangles.size(); ++i) {
      const Triangle t = triangle(hull, i);
      const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
      if (n.norm() > 0.0) planes.push_back({n.normalized(), n.normalized().dot(t[0])});
    }
    const auto first = [&](int a) { return std::max(0, centre_above(box.low[a], a)); };
    const auto end = [&](int a) { return std::min(count_[a], centre_above(box.high[a], a)); };
    count(planes.size() * at(std::max(0, end(0) - first(0))) * at(std::max(0, end(1) - first(1))));
    std::size_t cells = 0;
    for (int x = first(0); x < end(0); ++x)
      for (int y = first(1); y < end(1); ++y) {
        // The line through the column's centres leaves the hull at the planes that it meets.
        double from = box.low[2], to = box.high[2];
        const double px = centre(x, 0), py = centre(y, 1);
        for (const Plane& p : planes) {
          const double left = p.d - 1e-6 * cell_ - p.n[0] * px - p.n[1] * py;
          if (std::abs(p.n[2]) < 1e-12) {
            if (left < 0.0) to = -kInfinity;
          } else if (p.n[2] > 0.0) {
            to = std::min(to, left / p.n[2]);
          } else {
            from = std::max(from, left / p.n[2]);
          }
        }
        if (!(from < to)) continue;
        const int a = std::clamp(centre_above(from, 2), 0, count_[2] - 1);
        const int b = std::clamp(centre_above(to, 2), 0, count_[2] - 1);
        if (a < b) cells += at(below_[index(x, y, b)] - below_[index(x, y, a)]);
      }
    return static_cast<double>(cells) * cell_ * cell_ * cell_;
  }

 private:
  std::size_t index(int x, int y, int z) const {
    return (at(x) * at(count_[1]) + at(y)) * at(count_[2]) + at(z);
  }
  double centre(int i, int axis) const { return low_[axis] + (i + 0.5) * cell_; }
  /// The first cell with its centre above a coordinate.
  int centre_above(double x, int axis) const {
    return static_cast<int>(std::ceil((x - low_[axis]) / cell_ - 0.5));
  }

  /// Marks where lines through the centres along `axis` cross a triangle: between cell k and k + 1.
  void add_walls(const Triangle& t, int axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    if (!(std::abs(n[axis]) > 0.0)) return;
    Bounds box = bounds_of(t);
    for (int i = centre_above(box.low[u], u); i < centre_above(box.high[u], u); ++i)
      for (int j = centre_above(box.low[v], v); j < centre_above(box.high[v], v); ++j) {
        const double pu = centre(i, u), pv = centre(j, v);
        bool within = true;
        for (int e = 0; e < 3 && within; ++e) {
          const Vec3 &a = t[at(e)], &b = t[at((e + 1) % 3)];
          const double side = (b[u] - a[u]) * (pv - a[v]) - (b[v] - a[v]) * (pu - a[u]);
          // On an edge counts for both of its triangles: no line slips between them.
          within = (n[axis] > 0.0 ? side : -side) >= -1e-9 * cell_ * cell_;
        }
        if (!within) continue;
        const double x = t[0][axis] - (n[u] * (pu - t[0][u]) + n[v] * (pv - t[0][v])) / n[axis];
        std::array<int, 3> c;
        c[at(axis)] = std::clamp(centre_above(x, axis) - 1, 0, count_[axis] - 1);
        c[at(u)] = i;
        c[at(v)] = j;
        wall_[at(axis)][index(c[0], c[1], c[2])] = true;
      }
  }

  void flood() {
    std::vector<std::array<int, 3>> open = {{0, 0, 0}};
    free_[0] = true;
    while (!open.empty()) {
      const std::array<int, 3> c = open.back();
      open.pop_back();
      for (int a = 0; a < 3; ++a)
        for (const int step : {-1, 1}) {
          std::array<int, 3> next = c;
          next[at(a)] += step;
          if (next[at(a)] < 0 || next[at(a)] >= count_[a]) continue;
          const std::array<int, 3>& lower = step > 0 ? c : next;
          const std::size_t i = index(next[0], next[1], next[2]);
          if (free_[i] || wall_[at(a)][index(lower[0], lower[1], lower[2])]) continue;
          free_[i] = true;
          open.push_back(next);
        }
    }
  }

  Vec3 low_;
  double cell_ = 0.0;
  std::array<int, 3> count_{};
  std::vector<bool> free_;
  std::array<std::vector<bool>, 3> wall_;
  std::vector<int> below_;  ///< outside cells of the column below each
  mutable std::size_t steps_ = 0;
};

/// The solid within a box, or several such.
struct Part {
  Soup surface;
  Bounds box;
  std::vector<Vec3> inner;  ///< corners of boxes inside the solid
  TriangleMesh hull;
  double hull_volume = 0.0, excess = 0.0;
};

/// The hull of a soup. Empty: it has no volume. `most`: keep the ends of columns only, so that there are
/// no more than 2 most^2 points.
TriangleMesh hull_of(const Part& part, int most) {
  TriangleMesh points;
  for (const Triangle& t : part.surface)
    points.vertices.insert(points.vertices.end(), t.begin(), t.end());
  points.vertices.insert(points.vertices.end(), part.inner.begin(), part.inner.end());
  if (most > 0 && points.vertices.size() > 2 * at(most) * at(most)) {
    std::map<std::pair<int, int>, std::pair<Vec3, Vec3>> ends;
    const Vec3 size = (part.box.high - part.box.low).cwiseMax(1e-300);
    for (const Vec3& p : points.vertices) {
      const Vec3 where = (p - part.box.low).cwiseQuotient(size) * most;
      const std::pair column(static_cast<int>(where[0]), static_cast<int>(where[1]));
      auto& [low, high] = ends.emplace(column, std::pair(p, p)).first->second;
      if (p[2] < low[2]) low = p;
      if (p[2] > high[2]) high = p;
    }
    points.vertices.clear();
    for (const auto& [column, pair] : ends) {
      points.vertices.push_back(pair.first);
      points.vertices.push_back(pair.second);
    }
  }
  const TriangleMesh found = convex_hull(points);
  TriangleMesh hull;  // the corners alone
  std::map<int, int> corner;
  for (Eigen::Vector3i t : found.triangles) {
    for (int& i : t) {
      const auto [known, is_new] = corner.emplace(i, static_cast<int>(hull.vertices.size()));
      if (is_new) hull.vertices.push_back(found.vertices[at(i)]);
      i = known->second;
    }
    hull.triangles.push_back(t);
  }
  const double size = (part.box.high - part.box.low).maxCoeff();
  if (hull.triangles.empty() || !(volume(hull) > 1e-9 * size * size * size)) return {};
  return hull;
}

void measure(Part& part, const Grid& grid, int most) {
  grid.count(100 * (3 * part.surface.size() + part.inner.size()));
  part.hull = hull_of(part, most);
  part.hull_volume = volume(part.hull);
  part.excess = grid.excess(part.hull);
}

/// The two sides of a plane through a part.
std::pair<Part, Part> cut(const Part& part, int axis, double c, const Grid& grid) {
  std::pair<Part, Part> out;
  grid.count(20 * part.surface.size());
  for (const Triangle& t : part.surface) {
    std::array<double, 3> d;
    for (int i = 0; i < 3; ++i) d[at(i)] = t[at(i)][axis] - c;
    const auto [least, most] = std::minmax_element(d.begin(), d.end());
    if (*least == 0.0 && *most == 0.0) {
      // In the plane: the solid is behind it.
      const bool upwards = (t[1] - t[0]).cross(t[2] - t[0])[axis] > 0.0;
      (upwards ? out.first : out.second).surface.push_back(t);
    } else if (*most <= 0.0) {
      out.first.surface.push_back(t);
    } else if (*least >= 0.0) {
      out.second.surface.push_back(t);
    } else {
      std::vector<Vec3> low, high;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        if (d[i] <= 0.0) low.push_back(t[i]);
        if (d[i] >= 0.0) high.push_back(t[i]);
        if (d[i] * d[j] >= 0.0) continue;
        Vec3 p = t[i] + d[i] / (d[i] - d[j]) * (t[j] - t[i]);
        p[axis] = c;
        low.push_back(p);
        high.push_back(p);
      }
      for (const auto& [polygon, side] :
           {std::pair(&low, &out.first), std::pair(&high, &out.second)})
        for (std::size_t i = 2; i < polygon->size(); ++i)
          side->surface.push_back({(*polygon)[0], (*polygon)[i - 1], (*polygon)[i]});
    }
  }
  for (Part* side : {&out.first, &out.second}) {
    side->box = part.box;
    (side == &out.first ? side->box.high : side->box.low)[axis] = c;
    for (int i = 0; i < 8; ++i)
      if (const Vec3 corner = side->box.corner(i); grid.inside(corner))
        side->inner.push_back(corner);
  }
  return out;
}

/// Where along an axis to cut: at the largest flat faces, and evenly.
std::vector<double> planes(const Part& part, int axis, const Grid& grid) {
  constexpr int kFlat = 6, kEven = 5;
  const double low = part.box.low[axis], high = part.box.high[axis];
  const double margin = 0.5 * grid.cell();
  std::map<double, double> area;  // of faces across the axis, by their place
  for (const Triangle& t : part.surface) {
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    const double x = t[0][axis];
    if (std::abs(n[axis]) > 0.999 * n.norm() && t[1][axis] == x && t[2][axis] == x &&
        x > low + margin && x < high - margin)
      area[x] += n.norm();
  }
  std::vector<std::pair<double, double>> flat;
  for (const auto& [x, a] : area) flat.emplace_back(-a, x);
  std::sort(flat.begin(), flat.end());
  std::vector<double> out;
  for (const auto& [a, x] : flat)
    if (out.size() < kFlat) out.push_back(x);
  for (int i = 1; i <= kEven; ++i) {
    const double x = low + (high - low) * i / (kEven + 1);
    if (x > low + margin && x < high - margin) out.push_back(x);
  }
  return out;
}

/// Points kept of a part while planes are compared.
constexpr int kColumns = 48;

std::optional<std::pair<Part, Part>> best_cut(const Part& part, const Grid& grid) {
  std::optional<std::pair<Part, Part>> best;
  double least = kInfinity;
  for (int axis = 0; axis < 3; ++axis)
    for (const double c : planes(part, axis, grid)) {
      auto sides = cut(part, axis, c, grid);
      auto& [a, b] = sides;
      if (a.surface.empty() || b.surface.empty()) continue;
      measure(a, grid, kColumns);
      measure(b, grid, kColumns);
      if (a.hull.triangles.empty() || b.hull.triangles.empty()) continue;
      const double score =
          a.excess + b.excess +
          0.05 * part.excess * std::abs(a.hull_volume - b.hull_volume) / part.hull_volume;
      if (score >= least) continue;
      least = score;
      best = std::move(sides);
    }
  return best;
}

Part united(const Part& a, const Part& b, const Grid& grid) {
  Part out;
  for (const Part* p : {&a, &b}) {
    out.inner.insert(out.inner.end(), p->hull.vertices.begin(), p->hull.vertices.end());
    out.box.add(p->box.low);
    out.box.add(p->box.high);
  }
  measure(out, grid, 0);
  return out;
}

double total(const std::vector<Part>& parts) {
  double sum = 0.0;
  for (const Part& p : parts) sum += p.excess;
  return sum;
}

void unite(std::vector<Part>& parts, const Grid& grid, std::size_t most, double allowed) {
  std::map<std::pair<std::size_t, std::size_t>, Part> pairs;
  const auto pair = [&](std::size_t i, std::size_t j) {
    pairs[{i, j}] = united(parts[i], parts[j], grid);
  };
  std::vector<bool> gone(parts.size(), false);
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = i + 1; j < parts.size(); ++j) pair(i, j);
  for (std::size_t left = parts.size(); left > 1; --left) {
    double least = kInfinity;
    std::pair<std::size_t, std::size_t> which;
    for (const auto& [key, both] : pairs) {
      const double more = both.excess - parts[key.first].excess - parts[key.second].excess;
      if (more >= least) continue;
      least = more;
      which = key;
    }
    if (left <= most && total(parts) + least > allowed) break;
    const auto [i, j] = which;
    parts[i] = std::move(pairs[which]);
    parts[j].excess = 0.0;
    gone[j] = true;
    for (auto it = pairs.begin(); it != pairs.end();)
      it = it->first.first == j || it->first.second == j ? pairs.erase(it) : std::next(it);
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (k != i && !gone[k]) pair(std::min(i, k), std::max(i, k));
  }
  std::vector<Part> kept;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (!gone[i]) kept.push_back(std::move(parts[i]));
  parts = std::move(kept);
}

}  // namespace

ConvexParts convex_parts(const TriangleMesh& mesh, const ConvexPartsOptions& options) {
  ConvexParts out;
  Part whole;
  for (const Vec3& v : mesh.vertices) whole.box.add(v);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    whole.surface.push_back(triangle(mesh, i));
  whole.hull = hull_of(whole, 0);
  if (whole.hull.triangles.empty()) return out;
  const Grid grid(mesh, whole.box, std::clamp(options.cells, 8, 128));
  whole.hull_volume = volume(whole.hull);
  whole.excess = grid.excess(whole.hull);
  out.excess_of_hull = whole.excess / whole.hull_volume;

  const auto most = at(std::clamp(options.most, 1, 64));
  const double of = whole.hull_volume, allowed = options.tolerance * of;
  std::vector<Part> parts;
  parts.push_back(std::move(whole));
  std::vector<bool> whole_again(1, false);  // no plane cuts it
  while (parts.size() < 2 * most && most > 1 && total(parts) > allowed) {
    // Uniting parts again takes longer than cutting them.
    out.cut_short = grid.steps() > options.steps / (parts.size() < most ? 1 : 4);
    if (out.cut_short) break;
    std::size_t worst = parts.size();
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (!whole_again[i] && (worst == parts.size() || parts[i].excess > parts[worst].excess))
        worst = i;
    if (worst == parts.size()) break;
    auto sides = best_cut(parts[worst], grid);
    if (!sides) {
      whole_again[worst] = true;
      continue;
    }
    parts[worst] = std::move(sides->first);
    parts.push_back(std::move(sides->second));
    whole_again.push_back(false);
  }
  if (parts.size() > 1) {
    for (Part& p : parts) measure(p, grid, 0);
    if (parts.size() > most || !out.cut_short) unite(parts, grid, most, allowed);
  }
  out.steps = grid.steps();
  out.excess = total(parts) / of;
  for (Part& p : parts) out.hulls.push_back(std::move(p.hull));
  return out;
}

}  // namespace cogrsim::geometry

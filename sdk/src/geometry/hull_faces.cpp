#include "cogrsim/geometry/hull_faces.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/geometry/convex_hull.h"

namespace cogrsim {
namespace {

// A point lies in a plane if its distance is below this fraction of the size of the hull. The value
// is above the rounding of single-precision files and below the curvature of any intended facet.
constexpr double kFlat = 1e-6;

struct Facet {
  Eigen::Vector3i corners;
  Vec3 normal;     // its length is twice the area
  double longest;  // length of the longest edge [m]
};

const Vec3& at(const HullFaces& hull, int v) { return hull.vertices[v]; }

/// Stores the corners of the hull in `out` and returns its triangles, the largest first.
std::vector<Facet> make_facets(const TriangleMesh& hull, HullFaces& out) {
  // The hull contains all points of its mesh; its corners are those that triangles use.
  std::vector<int> number(hull.vertices.size(), -1);
  for (const Eigen::Vector3i& t : hull.triangles)
    for (int k = 0; k < 3; ++k) number[t[k]] = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<int>(out.vertices.size());
    out.vertices.push_back(hull.vertices[i]);
  }
  std::vector<Facet> facets;
  for (const Eigen::Vector3i& t : hull.triangles) {
    Facet facet;
    for (int k = 0; k < 3; ++k) facet.corners[k] = number[t[k]];
    const Vec3 ab = at(out, facet.corners[1]) - at(out, facet.corners[0]);
    const Vec3 ac = at(out, facet.corners[2]) - at(out, facet.corners[0]);
    facet.normal = ab.cross(ac);
    facet.longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    facets.push_back(facet);
  }
  std::stable_sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) {
    return a.normal.squaredNorm() > b.normal.squaredNorm();
  });
  return facets;
}

void sort_around(const HullFaces& hull, const Vec3& normal, std::vector<int>& corners) {
  Vec3 middle = Vec3::Zero();
  for (const int v : corners) middle += at(hull, v) / static_cast<double>(corners.size());
  const Vec3 x = (at(hull, corners[0]) - middle).cross(normal).normalized();
  const Vec3 y = normal.cross(x);
  const auto angle = [&](int v) {
    const Vec3 r = at(hull, v) - middle;
    return std::atan2(r.dot(y), r.dot(x));
  };
  std::sort(corners.begin(), corners.end(), [&](int a, int b) { return angle(a) < angle(b); });
}

std::vector<int> thinned(const std::vector<int>& corners, std::size_t most) {
  if (corners.size() <= most) return corners;
  std::vector<int> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(corners[i * corners.size() / most]);
  return out;
}

}  // namespace

HullFaces hull_faces(const TriangleMesh& mesh, std::size_t most_corners) {
  HullFaces out;
  const std::vector<Facet> facets = make_facets(geometry::convex_hull(mesh), out);
  if (out.vertices.size() < 4) return out;
  Vec3 inside = Vec3::Zero(), low = out.vertices[0], high = low;
  for (const Vec3& v : out.vertices) {
    inside += v / static_cast<double>(out.vertices.size());
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double flat = kFlat * (high - low).norm();
  double thick = 0.0;  // extent of the hull perpendicular to its first face [m]
  std::vector<std::vector<int>> faces_of(out.vertices.size()), neighbours(out.vertices.size());
  for (const Facet& facet : facets)
    for (int k = 0; k < 3; ++k)
      for (const int other : {1, 2})
        neighbours[facet.corners[k]].push_back(facet.corners[(k + other) % 3]);
  std::vector<const Facet*> seen_from(out.vertices.size(), nullptr);
  for (const Facet& facet : facets) {
    const auto belongs = [&](int face, int k) {
      const auto& faces = faces_of[facet.corners[k]];
      return std::find(faces.begin(), faces.end(), face) != faces.end();
    };
    const auto& candidates = faces_of[facet.corners[0]];
    const bool known = std::any_of(candidates.begin(), candidates.end(),
                                   [&](int f) { return belongs(f, 1) && belongs(f, 2); });
    // The normal of a sliver is inaccurate; its corners belong to the neighbouring faces.
    if (known || facet.normal.norm() <= flat * facet.longest) continue;
    const Vec3& origin = at(out, facet.corners[0]);
    Vec3 normal = facet.normal.normalized();
    if (normal.dot(origin - inside) < 0.0) normal = -normal;
    const auto off = [&](int v) { return std::abs(normal.dot(at(out, v) - origin)); };
    if (out.normals.empty())
      for (int v = 0; v < static_cast<int>(out.vertices.size()); ++v)
        thick = std::max(thick, off(v));
    // The corners in the plane are neighbours of each other, as those highest along a direction are.
    std::vector<int> corners, next(facet.corners.begin(), facet.corners.end());
    while (!next.empty()) {
      const int v = next.back();
      next.pop_back();
      if (seen_from[v] == &facet) continue;
      seen_from[v] = &facet;
      if (off(v) > flat) continue;
      corners.push_back(v);
      next.insert(next.end(), neighbours[v].begin(), neighbours[v].end());
    }
    std::sort(corners.begin(), corners.end());
    for (const int v : corners) faces_of[v].push_back(static_cast<int>(out.normals.size()));
    sort_around(out, normal, corners);
    out.normals.push_back(normal);
    out.corners.push_back(thinned(corners, most_corners));
  }
  if (out.normals.size() < 4 || thick <= flat) {
    out.normals.clear();
    out.corners.clear();
  }
  return out;
}

}  // namespace cogrsim

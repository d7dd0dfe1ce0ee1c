#include "cogrsim/geometry/convex_hull.h"

// C, and written for another set of warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#include <libqhull_r/qhull_ra.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cstdio>

namespace cogrsim::geometry {
namespace {

/// The library prints what it thinks of degenerate points.
class Nowhere {
 public:
  Nowhere() : file_(std::fopen("/dev/null", "w")) {}
  ~Nowhere() {
    if (file_ != nullptr) std::fclose(file_);
  }
  Nowhere(const Nowhere&) = delete;
  Nowhere& operator=(const Nowhere&) = delete;
  std::FILE* get() const { return file_; }

 private:
  std::FILE* file_;
};

Eigen::Vector3i facet_corners(qhT* qh, const facetT* facet) {
  Eigen::Vector3i out(-1, -1, -1);
  int count = 0;
  vertexT *vertex, **vertexp;  // names the library's macro wants
  FOREACHvertex_(facet->vertices) {
    if (count < 3) out[count++] = qh_pointid(qh, vertex->point);
  }
  return out;
}

}  // namespace

TriangleMesh convex_hull(const TriangleMesh& mesh) {
  TriangleMesh out;
  out.name = mesh.name;
  std::vector<double> points;
  for (const Vec3& v : mesh.vertices) points.insert(points.end(), v.data(), v.data() + 3);
  const Nowhere nowhere;
  qhT library;
  qhT* const qh = &library;
  qh_zero(qh, nowhere.get());
  char options[] = "qhull Qt Pp";  // triangles only, no warnings
  const bool good = mesh.vertices.size() >= 4 &&
                    qh_new_qhull(qh, 3, static_cast<int>(mesh.vertices.size()), points.data(),
                                 False, options, nowhere.get(), nowhere.get()) == 0;
  if (good) {
    out.vertices = mesh.vertices;
    facetT* facet;  // a name the library's macro wants
    FORALLfacets {
      Eigen::Vector3i corners = facet_corners(qh, facet);
      if (corners.minCoeff() < 0) continue;
      const Vec3& a = out.vertices[corners[0]];
      const Vec3 normal = (out.vertices[corners[1]] - a).cross(out.vertices[corners[2]] - a);
      if (normal.dot(Eigen::Map<const Vec3>(facet->normal)) < 0.0)
        std::swap(corners[1], corners[2]);
      out.triangles.push_back(corners);
    }
  }
  qh_freeqhull(qh, !qh_ALL);
  int kept = 0, total = 0;
  qh_memfreeshort(qh, &kept, &total);
  return good && !out.triangles.empty() ? out : mesh;
}

std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  using Point = Eigen::Vector2d;
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Point> out(2 * points.size());
  std::size_t count = 0;
  // `least`: corners that are there for good, and one more.
  const auto turn_left_to = [&](const Point& p, std::size_t least) {
    const auto left = [&] {
      const Point a = out[count - 1] - out[count - 2], b = p - out[count - 2];
      return a.x() * b.y() - a.y() * b.x() > 0.0;
    };
    while (count >= least && !left()) --count;
    out[count++] = p;
  };
  for (const Point& p : points) turn_left_to(p, 2);
  const std::size_t lower = count + 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) turn_left_to(*p, lower);
  out.resize(count - 1);
  return out;
}

}  // namespace cogrsim::geometry

#include "geometry/penetration.h"

#include <cmath>

#include "geometry/gjk.h"

namespace cogrsim::geometry {
namespace {

using Support = std::function<Vec3(const Vec3&)>;

// Enough for 1e-4 wherever the depth is reached in one direction; where it is in a whole circle of
// them (two cylinders in one), each of them gives it exactly.
constexpr int kMostRounds = 400;
constexpr double kAccuracy = 1e-4;
constexpr double kRounding = 1e-10;  // of the set's size: what is nearer lies in a face's plane
constexpr double kSliver = 1e-9;     // of the set's size: a lower triangle has no normal of its own

struct Face {
  std::array<std::size_t, 3> corners;  // counter-clockwise seen from outside
  Vec3 normal;
  double distance;  // of the origin from its plane, positive where the origin is on the inner side
};

class Polytope {
 public:
  Polytope(const Support& support, double enough) : support_(support), enough_(enough) {}

  Penetration depth(std::size_t& rounds) {
    if (!start()) return best_;
    for (int round = 0; round < kMostRounds && best_.depth > enough_; ++round) {
      ++rounds;
      const Face nearest =
          *std::min_element(faces_.begin(), faces_.end(),
                            [](const Face& a, const Face& b) { return a.distance < b.distance; });
      if (nearest.distance == kInfinity) break;
      const Vec3 point = ask(nearest.normal);
      const double tolerance = kAccuracy * std::max(best_.depth, 0.0) + kRounding * size_;
      if (best_.depth - nearest.distance <= tolerance) break;
      if (!add(point)) break;
    }
    return best_;
  }

 private:
  // The set's point furthest along `normal` (unit); keeps the direction of least depth.
  Vec3 ask(const Vec3& normal) {
    const Vec3 point = support_(normal);
    const double depth = point.dot(normal);
    if (depth < best_.depth) best_ = {depth, normal};
    return point;
  }

  // A tetrahedron of points far from each other. False: the set is flat, or known to be shallow.
  bool start() {
    best_.depth = kInfinity;
    Eigen::Index axis = 0;
    std::array<Vec3, 3> up, down;
    Vec3 extent;
    for (int i = 0; i < 3; ++i) {
      up[i] = ask(Vec3::Unit(i));
      down[i] = ask(-Vec3::Unit(i));
      extent[i] = (up[i] - down[i])[i];
    }
    size_ = extent.maxCoeff(&axis);
    const double flat = kSliver * size_;
    points_ = {down[axis], up[axis]};
    if (size_ <= 0.0) return false;
    const Vec3 line = (points_[1] - points_[0]).normalized();
    const Vec3 x = line.unitOrthogonal(), y = line.cross(x);
    if (!add_furthest({x, -x, y, -y}, flat,
                      [&](const Vec3& p) { return (p - points_[0]).cross(line).norm(); }))
      return false;
    const Vec3 n = (points_[1] - points_[0]).cross(points_[2] - points_[0]).normalized();
    if (!add_furthest({n, -n}, flat,
                      [&](const Vec3& p) { return std::abs((p - points_[0]).dot(n)); }))
      return false;
    const bool below = (points_[3] - points_[0]).dot(n) < 0.0;
    const std::array<std::size_t, 3> base =
        below ? std::array<std::size_t, 3>{0, 1, 2} : std::array<std::size_t, 3>{0, 2, 1};
    faces_.push_back(face(base));
    for (std::size_t k = 0; k < 3; ++k) faces_.push_back(face({base[(k + 1) % 3], base[k], 3}));
    return best_.depth > enough_;
  }

  template <class Distance>
  bool add_furthest(const std::vector<Vec3>& directions, double flat, const Distance& distance) {
    Vec3 furthest = points_[0];
    for (const Vec3& d : directions) {
      const Vec3 point = ask(d);
      if (distance(point) > distance(furthest)) furthest = point;
    }
    if (distance(furthest) <= flat) return false;
    points_.push_back(furthest);
    return true;
  }

  Face face(const std::array<std::size_t, 3>& corners) const {
    const Vec3 &a = points_[corners[0]], &b = points_[corners[1]], &c = points_[corners[2]];
    Face out{corners, (b - a).cross(c - a), 0.0};
    const double area = out.normal.norm();
    const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
    if (area <= kSliver * size_ * longest) {
      out.normal.setZero();
      out.distance = kInfinity;
    } else {
      out.normal /= area;
      out.distance = out.normal.dot(a);
    }
    return out;
  }

  // Replaces the faces that `point` is above by those to it. False: it is above none.
  bool add(const Vec3& point) {
    using Edge = std::pair<std::size_t, std::size_t>;
    std::vector<Edge> edges;
    const auto seen = [&](const Face& f) {
      return f.normal.dot(point) - f.distance > kRounding * size_;
    };
    for (const Face& f : faces_) {
      if (!seen(f)) continue;
      for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(f.corners[k], f.corners[(k + 1) % 3]);
    }
    if (edges.empty()) return false;
    faces_.erase(std::remove_if(faces_.begin(), faces_.end(), seen), faces_.end());
    // An edge between two faces that went is there in both directions.
    std::sort(edges.begin(), edges.end());
    const std::size_t kept = faces_.size();
    points_.push_back(point);
    for (const Edge& edge : edges) {
      const Edge back(edge.second, edge.first);
      if (std::binary_search(edges.begin(), edges.end(), back)) continue;
      Face made = face({edge.first, edge.second, points_.size() - 1});
      if (made.normal.isZero()) {
        // A point in line with the edge: the triangle lies in the plane of the face beyond it.
        for (std::size_t i = 0; i < kept; ++i)
          for (std::size_t k = 0; k < 3; ++k)
            if (faces_[i].corners[k] == back.first && faces_[i].corners[(k + 1) % 3] == back.second)
              made.normal = faces_[i].normal, made.distance = faces_[i].distance;
      }
      faces_.push_back(made);
    }
    return faces_.size() > kept;
  }

  const Support& support_;
  double enough_;
  double size_ = 0.0;
  Penetration best_;
  std::vector<Vec3> points_;
  std::vector<Face> faces_;
};

}  // namespace

Penetration origin_depth(const Support& support, double enough, std::size_t& rounds) {
  return Polytope(support, enough).depth(rounds);
}

Penetration convex_penetration(const Placed& a, const Placed& b, double enough,
                               std::size_t& rounds) {
  const double margin = a.core.margin + b.core.margin;
  const Vec3 gap = core_gap(a, b);
  const double distance = gap.norm();
  // Nearer than this rounding may have ended the search for a gap early.
  if (distance > 1e-7) return {std::max(margin - distance, 0.0), -gap / distance};
  // About a point near both, so that coordinates are small.
  const Vec3 origin = 0.5 * (a.X_WS.p + b.X_WS.p);
  const Pose X_a{a.X_WS.p - origin, a.X_WS.q}, X_b{b.X_WS.p - origin, b.X_WS.q};
  const Placed A{a.core, X_a}, B{b.core, X_b};
  Penetration out = origin_depth(
      [&](const Vec3& d) -> Vec3 { return A.support(d) - B.support(-d); }, enough - margin, rounds);
  out.depth = std::max(std::max(out.depth, -distance) + margin, 0.0);
  return out;
}

double lift_over(const Placed& a, const Triangle& triangle, double enough) {
  // Conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body systems",
  // 1996, 2.3): from above it down, each time by what surely leaves a gap.
  constexpr int kMostSteps = 100;
  constexpr double kGap = 1e-9;  // [m]
  const Core core = core_of(triangle.data());
  double lift = core.support(Vec3::UnitZ()).z() - (a.support(-Vec3::UnitZ()).z() - a.core.margin);
  for (int step = 0; step < kMostSteps && lift > enough; ++step) {
    const Pose X(a.X_WS.p + lift * Vec3::UnitZ(), a.X_WS.q);
    const Vec3 gap = core_gap({a.core, X}, {core, {}});
    const double distance = gap.norm();
    if (distance - a.core.margin <= kGap) return lift;
    if (gap.z() <= 0.0) return 0.0;  // it comes down beside the triangle
    lift -= (distance - a.core.margin) * distance / gap.z();
  }
  return std::min(lift, enough);
}

}  // namespace cogrsim::geometry

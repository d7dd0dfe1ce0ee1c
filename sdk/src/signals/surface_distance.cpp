#include "signals/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "cogrsim/core/constants.h"
#include "signals/gjk.h"

namespace cogrsim {
namespace {

constexpr std::size_t kLeaf = 4;  // triangles in a leaf of a tree

/// What is convex, without the radius that is put around it.
struct Core {
  enum class Kind { point, segment, box, cylinder, points } kind = Kind::point;
  Vec3 half = Vec3::Zero();  // box: half extents; segment, cylinder: half length in z
  double radius = 0.0;       // cylinder
  const Vec3* points = nullptr;
  std::size_t count = 0;

  /// The point furthest along `d`, both in the shape's frame.
  Vec3 support(const Vec3& d) const {
    switch (kind) {
      case Kind::point:
        return Vec3::Zero();
      case Kind::segment:
        return {0, 0, std::copysign(half.z(), d.z())};
      case Kind::box:
        return {std::copysign(half.x(), d.x()), std::copysign(half.y(), d.y()),
                std::copysign(half.z(), d.z())};
      case Kind::cylinder: {
        const double r = std::hypot(d.x(), d.y());
        const double s = r > 0.0 ? radius / r : 0.0;
        return {s * d.x(), s * d.y(), std::copysign(half.z(), d.z())};
      }
      default: {
        std::size_t best = 0;
        double furthest = -kInfinity;
        for (std::size_t i = 0; i < count; ++i) {
          const double along = points[i].dot(d);
          if (along > furthest) furthest = along, best = i;
        }
        return points[best];
      }
    }
  }

  /// The point of it nearest to `p` in the shape's frame; nullopt: no closed form.
  std::optional<Vec3> nearest(const Vec3& p) const {
    switch (kind) {
      case Kind::point:
        return Vec3(Vec3::Zero());
      case Kind::segment:
      case Kind::box:
        return Vec3(p.cwiseMax(-half).cwiseMin(half));
      case Kind::cylinder: {
        const double r = std::hypot(p.x(), p.y());
        const double s = r > radius ? radius / r : 1.0;
        return Vec3(s * p.x(), s * p.y(), std::clamp(p.z(), -half.z(), half.z()));
      }
      default:
        return std::nullopt;
    }
  }
};

/// Nearest distance of two segments p ± a and q ± b (Ericson, Real-Time Collision Detection, 5.1.9).
double segment_distance(const Vec3& p, const Vec3& a, const Vec3& q, const Vec3& b) {
  const Vec3 d1 = 2 * a, d2 = 2 * b, r = (p - a) - (q - b);
  const double aa = d1.squaredNorm(), ee = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r);
  if (aa <= 0.0 || ee <= 0.0) {  // one is a point: project it
    const double s = aa > 0.0 ? std::clamp(-c / aa, 0.0, 1.0) : 0.0;
    const double t = ee > 0.0 ? std::clamp(f / ee, 0.0, 1.0) : 0.0;
    return (r + s * d1 - t * d2).norm();
  }
  const double bb = d1.dot(d2), denominator = aa * ee - bb * bb;
  double s =
      denominator > 1e-12 * aa * ee ? std::clamp((bb * f - c * ee) / denominator, 0.0, 1.0) : 0.0;
  double t = (bb * s + f) / ee;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((bb * t - c) / aa, 0.0, 1.0);
  }
  return (r + s * d1 - t * d2).norm();
}

/// A core somewhere.
struct Placed {
  const Core& core;
  const Pose& X_WS;
};

double core_distance(const Placed& a, const Placed& b) {
  using Kind = Core::Kind;
  if (a.core.kind == Kind::point || b.core.kind == Kind::point) {
    const Placed& point = a.core.kind == Kind::point ? a : b;
    const Placed& other = a.core.kind == Kind::point ? b : a;
    const Vec3 p = other.X_WS.inverse() * point.X_WS.p;
    if (const auto near = other.core.nearest(p)) return (p - *near).norm();
  }
  if (a.core.kind == Kind::segment && b.core.kind == Kind::segment)
    return segment_distance(a.X_WS.p, a.X_WS.q * a.core.half, b.X_WS.p, b.X_WS.q * b.core.half);
  // About a point near both, so that coordinates are small.
  const Vec3 origin = 0.5 * (a.X_WS.p + b.X_WS.p);
  const Pose A{a.X_WS.p - origin, a.X_WS.q}, B{b.X_WS.p - origin, b.X_WS.q};
  const auto difference = [&](const Vec3& d) -> Vec3 {
    return A * a.core.support(A.q.conjugate() * d) - B * b.core.support(B.q.conjugate() * -d);
  };
  return gjk::origin_distance(difference, difference(B.p - A.p));
}

/// Of boxes around triangles, halved at the median of the longest side.
struct Tree {
  struct Node {
    Vec3 low = Vec3::Constant(kInfinity), high = Vec3::Constant(-kInfinity);
    std::size_t first = 0, count = 0;  // of a leaf: triangles; else children `first`, `count`
    bool leaf = false;
  };
  std::vector<std::array<Vec3, 3>> triangles;
  std::vector<Node> nodes;

  void build() {
    if (!triangles.empty()) add(0, triangles.size());
  }
  std::size_t add(std::size_t begin, std::size_t end) {
    const std::size_t index = nodes.size();
    nodes.emplace_back();
    Node node;
    for (std::size_t i = begin; i < end; ++i)
      for (const Vec3& v : triangles[i])
        node.low = node.low.cwiseMin(v), node.high = node.high.cwiseMax(v);
    node.leaf = end - begin <= kLeaf;
    node.first = begin;
    node.count = end - begin;
    if (!node.leaf) {
      Eigen::Index axis = 0;
      (node.high - node.low).maxCoeff(&axis);
      const auto middle = triangles.begin() + static_cast<std::ptrdiff_t>((begin + end) / 2);
      std::nth_element(triangles.begin() + static_cast<std::ptrdiff_t>(begin), middle,
                       triangles.begin() + static_cast<std::ptrdiff_t>(end),
                       [axis](const auto& a, const auto& b) {
                         return a[0][axis] + a[1][axis] + a[2][axis] <
                                b[0][axis] + b[1][axis] + b[2][axis];
                       });
      node.first = add(begin, (begin + end) / 2);
      node.count = add((begin + end) / 2, end);
    }
    nodes[index] = node;
    return index;
  }
};

Core triangle_core(const std::array<Vec3, 3>& triangle) {
  Core core;
  core.kind = Core::Kind::points;
  core.points = triangle.data();
  core.count = 3;
  return core;
}

}  // namespace

struct SurfaceSet::Piece {
  int body = kWorld;
  Pose X_BS;
  enum class Kind { convex, plane, triangles } kind = Kind::convex;
  Core core;
  double margin = 0.0;         // radius around the core
  std::vector<Vec3> points;    // of a hull
  Tree tree;                   // of triangles
  Vec3 middle = Vec3::Zero();  // of the ball around it, in S
  double reach = 0.0;          // its radius
};

namespace {

using Piece = SurfaceSet::Piece;

void enclose(Piece& piece, const Vec3& low, const Vec3& high) {
  piece.middle = 0.5 * (low + high);
  piece.reach = 0.5 * (high - low).norm();
}

Vec3 height_sample(const HeightGrid& grid, int row, int column) {
  return {grid.size_x * (static_cast<double>(column) / (grid.columns - 1) - 0.5),
          grid.size_y * (static_cast<double>(row) / (grid.rows - 1) - 0.5),
          grid.heights[static_cast<std::size_t>(row * grid.columns + column)]};
}

void add_triangles(const SceneModel& model, const Shape& shape, Piece& piece) {
  auto& out = piece.tree.triangles;
  if (shape.type == ShapeType::mesh) {
    const TriangleMesh& mesh = model.meshes[static_cast<std::size_t>(shape.mesh)];
    const auto vertex = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
    for (const Eigen::Vector3i& t : mesh.triangles)
      out.push_back({vertex(t[0]), vertex(t[1]), vertex(t[2])});
  } else {
    const HeightGrid& grid = model.heightmaps[static_cast<std::size_t>(shape.heightmap)];
    for (int row = 0; row + 1 < grid.rows; ++row)
      for (int column = 0; column + 1 < grid.columns; ++column) {
        const Vec3 a = height_sample(grid, row, column), b = height_sample(grid, row, column + 1),
                   c = height_sample(grid, row + 1, column + 1),
                   d = height_sample(grid, row + 1, column);
        out.push_back({a, b, c});
        out.push_back({a, c, d});
      }
  }
  piece.tree.build();
  if (!piece.tree.nodes.empty()) enclose(piece, piece.tree.nodes[0].low, piece.tree.nodes[0].high);
}

std::shared_ptr<const Piece> piece_of(const SceneModel& model, int body, const Shape& shape) {
  auto piece = std::make_shared<Piece>();
  piece->body = body;
  piece->X_BS = shape.X_BS;
  const Vec3 z = 0.5 * shape.length * Vec3::UnitZ();
  switch (shape.type) {
    case ShapeType::box:
      piece->core.kind = Core::Kind::box;
      piece->core.half = 0.5 * shape.size;
      piece->reach = piece->core.half.norm();
      break;
    case ShapeType::sphere:
      piece->margin = piece->reach = shape.radius;
      break;
    case ShapeType::capsule:
      piece->core.kind = Core::Kind::segment;
      piece->core.half = z;
      piece->margin = shape.radius;
      piece->reach = shape.radius + z.z();
      break;
    case ShapeType::cylinder:
      piece->core.kind = Core::Kind::cylinder;
      piece->core.half = z;
      piece->core.radius = shape.radius;
      piece->reach = std::hypot(shape.radius, z.z());
      break;
    case ShapeType::plane:
      piece->kind = Piece::Kind::plane;
      break;
    case ShapeType::convex_mesh: {
      piece->points = model.meshes[static_cast<std::size_t>(shape.mesh)].vertices;
      piece->core.kind = Core::Kind::points;
      piece->core.points = piece->points.data();
      piece->core.count = piece->points.size();
      Vec3 low = Vec3::Constant(kInfinity), high = -low;
      for (const Vec3& v : piece->points) low = low.cwiseMin(v), high = high.cwiseMax(v);
      enclose(*piece, low, high);
      break;
    }
    default:
      piece->kind = Piece::Kind::triangles;
      add_triangles(model, shape, *piece);
  }
  return piece;
}

/// A piece in one frame.
struct Item {
  const Piece* piece;
  Pose X_WS;
  Vec3 middle;  // in the world
};

/// How far all of `item` is above the plane.
double above_plane(const Item& plane, const Item& item) {
  const Vec3 n = plane.X_WS.q * Vec3::UnitZ();
  const double height = n.dot(item.X_WS.p - plane.X_WS.p);
  const Vec3 n_S = item.X_WS.q.conjugate() * n;
  switch (item.piece->kind) {
    case Piece::Kind::plane:  // two half-spaces are apart only back to back
      return n_S.z() < -1.0 + 1e-12 ? height : 0.0;
    case Piece::Kind::convex:
      return height + n_S.dot(item.piece->core.support(-n_S)) - item.piece->margin;
    default: {
      double lowest = kInfinity;
      for (const auto& triangle : item.piece->tree.triangles)
        for (const Vec3& v : triangle) lowest = std::min(lowest, n_S.dot(v));
      return height + lowest;
    }
  }
}

/// Lowers `best` to the distance between a convex core and the triangles of `surface`.
void core_to_triangles(const Placed& core, double margin, const Vec3& middle, double reach,
                       const Item& surface, double& best) {
  const Tree& tree = surface.piece->tree;
  if (tree.nodes.empty()) return;
  const Vec3 centre = surface.X_WS.inverse() * middle;
  const auto bound = [&](const Tree::Node& node) {
    return (centre - centre.cwiseMax(node.low).cwiseMin(node.high)).norm() - reach;
  };
  std::vector<std::pair<double, std::size_t>> open = {{bound(tree.nodes[0]), 0}};
  while (!open.empty()) {
    const auto [least, index] = open.back();
    open.pop_back();
    if (least >= best) continue;
    const Tree::Node& node = tree.nodes[index];
    if (!node.leaf) {
      std::pair<double, std::size_t> near = {bound(tree.nodes[node.first]), node.first},
                                     far = {bound(tree.nodes[node.count]), node.count};
      if (far < near) std::swap(near, far);
      open.push_back(far);
      open.push_back(near);
      continue;
    }
    for (std::size_t i = node.first; i < node.first + node.count && best > 0.0; ++i) {
      const Core triangle = triangle_core(tree.triangles[i]);
      best = std::min(best, std::max(0.0, core_distance({triangle, surface.X_WS}, core) - margin));
    }
    if (best <= 0.0) return;
  }
}

void lower(const Item& a, const Item& b, double& best) {
  using Kind = Piece::Kind;
  if (a.piece->kind == Kind::plane || b.piece->kind == Kind::plane) {
    const bool first = a.piece->kind == Kind::plane;
    best = std::min(best, std::max(0.0, above_plane(first ? a : b, first ? b : a)));
  } else if (a.piece->kind == Kind::convex && b.piece->kind == Kind::convex) {
    const double cores = core_distance({a.piece->core, a.X_WS}, {b.piece->core, b.X_WS});
    best = std::min(best, std::max(0.0, cores - a.piece->margin - b.piece->margin));
  } else if (a.piece->kind == Kind::convex || b.piece->kind == Kind::convex) {
    const bool first = a.piece->kind == Kind::convex;
    const Item& convex = first ? a : b;
    core_to_triangles({convex.piece->core, convex.X_WS}, convex.piece->margin, convex.middle,
                      convex.piece->reach, first ? b : a, best);
  } else {
    const bool first = a.piece->tree.triangles.size() <= b.piece->tree.triangles.size();
    const Item& few = first ? a : b;
    for (const auto& triangle : few.piece->tree.triangles) {
      const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
      double reach = 0.0;
      for (const Vec3& v : triangle) reach = std::max(reach, (v - middle).norm());
      core_to_triangles({triangle_core(triangle), few.X_WS}, 0.0, few.X_WS * middle, reach,
                        first ? b : a, best);
      if (best <= 0.0) return;
    }
  }
}

std::vector<Item> items(const SurfaceSet& set, const std::vector<Pose>& poses,
                        const std::vector<bool>& gone) {
  std::vector<Item> out;
  for (const auto& piece : set.pieces()) {
    const auto body = static_cast<std::size_t>(piece->body);
    if (piece->body != kWorld && (body >= poses.size() || gone[body])) continue;
    const Pose X_WS = piece->body == kWorld ? piece->X_BS : poses[body] * piece->X_BS;
    out.push_back({piece.get(), X_WS, X_WS * piece->middle});
  }
  return out;
}

}  // namespace

SurfaceSet SurfaceSet::of_bodies(const SceneModel& model, const std::vector<int>& bodies) {
  SurfaceSet set;
  for (const int index : bodies) {
    const std::vector<Shape>& shapes = model.bodies[static_cast<std::size_t>(index)].shapes;
    const bool touches =
        std::any_of(shapes.begin(), shapes.end(), [](const Shape& s) { return s.collides; });
    for (const Shape& shape : shapes)
      if (shape.collides || !touches) set.pieces_.push_back(piece_of(model, index, shape));
    if (shapes.empty()) {
      auto point = std::make_shared<Piece>();
      point->body = index;
      set.pieces_.push_back(std::move(point));
    }
  }
  return set;
}

SurfaceSet SurfaceSet::of_point(const SignalPlace& place) {
  auto point = std::make_shared<Piece>();
  point->body = place.body;
  point->X_BS = place.X_BF;
  SurfaceSet set;
  set.pieces_.push_back(std::move(point));
  return set;
}

double surface_distance(const SurfaceSet& a, const SurfaceSet& b, const std::vector<Pose>& poses,
                        const std::vector<bool>& gone) {
  const std::vector<Item> first = items(a, poses, gone), second = items(b, poses, gone);
  if (first.empty() || second.empty()) return std::numeric_limits<double>::quiet_NaN();
  // Nearest balls first: what follows is then mostly out of question.
  struct Pair {
    double bound;
    std::size_t a, b;
  };
  std::vector<Pair> pairs;
  pairs.reserve(first.size() * second.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    for (std::size_t j = 0; j < second.size(); ++j) {
      const bool plane =
          first[i].piece->kind == Piece::Kind::plane || second[j].piece->kind == Piece::Kind::plane;
      const double bound = plane ? 0.0
                                 : (first[i].middle - second[j].middle).norm() -
                                       first[i].piece->reach - second[j].piece->reach;
      pairs.push_back({bound, i, j});
    }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& p, const Pair& q) {
    return std::tie(p.bound, p.a, p.b) < std::tie(q.bound, q.a, q.b);
  });
  double best = kInfinity;
  for (const Pair& pair : pairs) {
    if (pair.bound >= best || best <= 0.0) break;
    lower(first[pair.a], second[pair.b], best);
  }
  return best;
}

}  // namespace cogrsim

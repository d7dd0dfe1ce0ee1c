#include "geometry/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/triangles.h"

namespace cogrsim::geometry {
struct SurfaceSet::Piece {
  int body = kWorld;
  Pose X_BS;
  enum class Kind { convex, plane, triangles } kind = Kind::convex;
  Core core;
  std::vector<Vec3> points;  // of a hull
  std::vector<Triangle> triangles;
  BoundsTree tree;  // of them
  Ball ball;        // around it, in S
};

namespace {

using Piece = SurfaceSet::Piece;

std::shared_ptr<const Piece> piece_of(const SceneModel& model, int body, const Shape& shape) {
  auto piece = std::make_shared<Piece>();
  piece->body = body;
  piece->X_BS = shape.X_BS;
  piece->ball = bounding_ball(model, shape);
  switch (shape.type) {
    case ShapeType::plane:
      piece->kind = Piece::Kind::plane;
      break;
    case ShapeType::mesh:
    case ShapeType::heightmap: {
      piece->kind = Piece::Kind::triangles;
      std::vector<Bounds> boxes;
      for_triangles(model, shape, all_bounds(), [&](const Triangle& triangle) {
        piece->triangles.push_back(triangle);
        boxes.push_back(bounds_of(triangle));
      });
      piece->tree = BoundsTree(boxes);
      break;
    }
    case ShapeType::convex_mesh: {
      piece->core = core_of(model, shape);
      piece->points.assign(piece->core.points, piece->core.points + piece->core.count);
      piece->core.points = piece->points.data();
      break;
    }
    default:
      piece->core = core_of(model, shape);
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
      return height + n_S.dot(item.piece->core.support(-n_S)) - item.piece->core.margin;
    default: {
      double lowest = kInfinity;
      for (const auto& triangle : item.piece->triangles)
        for (const Vec3& v : triangle) lowest = std::min(lowest, n_S.dot(v));
      return height + lowest;
    }
  }
}

/// Lowers `best` to the distance between a convex core and the triangles of `surface`.
void core_to_triangles(const Placed& core, const Vec3& middle, double radius, const Item& surface,
                       double& best) {
  const BoundsTree& tree = surface.piece->tree;
  if (tree.nodes().empty()) return;
  const Vec3 centre = surface.X_WS.inverse() * middle;
  const auto bound = [&](const BoundsTree::Node& node) {
    const Vec3 nearest = centre.cwiseMax(node.bounds.low).cwiseMin(node.bounds.high);
    return (centre - nearest).norm() - radius;
  };
  std::vector<std::pair<double, std::size_t>> open = {{bound(tree.nodes()[0]), 0}};
  while (!open.empty()) {
    const auto [least, index] = open.back();
    open.pop_back();
    if (least >= best) continue;
    const BoundsTree::Node& node = tree.nodes()[index];
    if (!node.leaf) {
      std::pair<double, std::size_t> near = {bound(tree.nodes()[node.first]), node.first},
                                     far = {bound(tree.nodes()[node.count]), node.count};
      if (far < near) std::swap(near, far);
      open.push_back(far);
      open.push_back(near);
      continue;
    }
    for (std::size_t i = node.first; i < node.first + node.count && best > 0.0; ++i) {
      const Core triangle = core_of(surface.piece->triangles[tree.order()[i]].data());
      best = std::min(
          best, std::max(0.0, core_distance({triangle, surface.X_WS}, core) - core.core.margin));
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
    best = std::min(best, std::max(0.0, cores - a.piece->core.margin - b.piece->core.margin));
  } else if (a.piece->kind == Kind::convex || b.piece->kind == Kind::convex) {
    const bool first = a.piece->kind == Kind::convex;
    const Item& convex = first ? a : b;
    core_to_triangles({convex.piece->core, convex.X_WS}, convex.middle, convex.piece->ball.radius,
                      first ? b : a, best);
  } else {
    const bool first = a.piece->triangles.size() <= b.piece->triangles.size();
    const Item& few = first ? a : b;
    for (const auto& triangle : few.piece->triangles) {
      const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
      double radius = 0.0;
      for (const Vec3& v : triangle) radius = std::max(radius, (v - middle).norm());
      core_to_triangles({core_of(triangle.data()), few.X_WS}, few.X_WS * middle, radius,
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
    out.push_back({piece.get(), X_WS, X_WS * piece->ball.middle});
  }
  return out;
}

}  // namespace

SurfaceSet SurfaceSet::of_bodies(const SceneModel& model, const std::vector<int>& bodies) {
  SurfaceSet set;
  for (const int index : bodies) {
    const std::vector<Shape>& shapes = model.bodies[index].shapes;
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

SurfaceSet SurfaceSet::of_point(int body, const Pose& X_BP) {
  auto point = std::make_shared<Piece>();
  point->body = body;
  point->X_BS = X_BP;
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
                                       first[i].piece->ball.radius - second[j].piece->ball.radius;
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

}  // namespace cogrsim::geometry

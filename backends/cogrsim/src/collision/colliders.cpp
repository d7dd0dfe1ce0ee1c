#include "colliders.h"

#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cogrsim/core/constants.h"

namespace cogrsim::dynamics {
namespace {

constexpr double kMostMargin = 1e-3;      // rounding of edges in distance queries [m]
constexpr double kMarginFraction = 0.05;  // of the smallest half extent
constexpr int kCapCorners = 16;
constexpr int kManyCorners = 64;  // with fewer, looking at all is as fast as a walk
// Leaning less than this, a standing cylinder's corners stay with the cylinder [rad]: the direction
// of its lean is noise then, and what the polygon misses, (1 - cos(pi / 16)) R 3e-3, is nothing.
constexpr double kUpright = 3e-3;

btVector3 bt(const Vec3& v) { return {v[0], v[1], v[2]}; }

double margin_for(double smallest_half_extent) {
  return std::min(kMostMargin, kMarginFraction * smallest_half_extent);
}

// A hull of many corners, as scanned and drawn meshes have: the farthest is found by a walk along the
// edges, which passes about sqrt(n) of n corners. On a convex hull a corner that none of its neighbours
// exceeds is the farthest.
class WalkedHull final : public btConvexInternalAabbCachingShape {
 public:
  explicit WalkedHull(const btConvexHullComputer& hull) {
    m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
    const auto count = std::size_t(hull.vertices.size());
    std::vector<std::vector<int>> neighbours(count);
    for (int i = 0; i < hull.edges.size(); ++i)
      neighbours[std::size_t(hull.edges[i].getSourceVertex())].push_back(
          hull.edges[i].getTargetVertex());
    for (std::size_t i = 0; i < count; ++i) {
      points_.push_back(hull.vertices[int(i)]);
      first_.push_back(neighbours_.size());
      neighbours_.insert(neighbours_.end(), neighbours[i].begin(), neighbours[i].end());
    }
    first_.push_back(neighbours_.size());
    for (int k = 0; k < 8; ++k)
      starts_[k] = walk(0, btVector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    recalcLocalAabb();
  }

  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& d) const override {
    return points_[walk(starts_[(d.x() > 0) + 2 * (d.y() > 0) + 4 * (d.z() > 0)], d)];
  }
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions,
                                                         btVector3* out, int count) const override {
    for (int i = 0; i < count; ++i) out[i] = localGetSupportingVertexWithoutMargin(directions[i]);
  }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "WalkedHull"; }

 private:
  std::size_t walk(std::size_t at, const btVector3& d) const {
    double most = points_[at].dot(d);
    for (bool moved = true; moved;) {
      moved = false;
      std::size_t best = at;
      for (std::size_t e = first_[at]; e < first_[at + 1]; ++e) {
        const auto other = std::size_t(neighbours_[e]);
        const double along = points_[other].dot(d);
        if (along > most) {
          most = along;
          best = other;
          moved = true;
        }
      }
      at = best;
    }
    return at;
  }

  std::vector<btVector3> points_;
  std::vector<std::size_t> first_;  // of each corner in `neighbours_`, and the end
  std::vector<int> neighbours_;
  std::size_t starts_[8];  // the farthest corner of each octant's middle
};

// The hull for distance queries: shrunk by its margin, which moves the faces back to where they are.
std::shared_ptr<btConvexShape> make_rounded_hull(const std::vector<Vec3>& points) {
  geometry::Bounds bounds;
  for (const Vec3& p : points) bounds.add(p);
  std::vector<double> flat;
  for (const Vec3& p : points) flat.insert(flat.end(), {p[0], p[1], p[2]});
  btConvexHullComputer computer;
  const double wanted = margin_for(bounds.half().minCoeff());
  const double margin =
      computer.compute(flat.data(), int(3 * sizeof(double)), int(points.size()), wanted, 0.2);
  if (computer.vertices.size() > kManyCorners) {
    auto shape = std::make_shared<WalkedHull>(computer);
    shape->setMargin(std::max(margin, 0.0));
    return shape;
  }
  auto shape = std::make_shared<btConvexHullShape>();
  for (int i = 0; i < computer.vertices.size(); ++i) shape->addPoint(computer.vertices[i], false);
  shape->recalcLocalAabb();
  shape->setMargin(std::max(margin, 0.0));
  return shape;
}

void make_mesh(const TriangleMesh& mesh, Collider& c) {
  c.triangles = std::make_shared<btTriangleMesh>(true, false);
  for (const Eigen::Vector3i& t : mesh.triangles)
    c.triangles->addTriangle(bt(mesh.vertices[std::size_t(t[0])]),
                             bt(mesh.vertices[std::size_t(t[1])]),
                             bt(mesh.vertices[std::size_t(t[2])]));
  c.bvh = std::make_shared<btBvhTriangleMeshShape>(c.triangles.get(), true);
  c.bvh->setMargin(0.0);
}

Collider make_collider(const SceneModel& model, int body, int index) {
  const Shape& shape = model.bodies[std::size_t(body)].shapes[std::size_t(index)];
  Collider c;
  c.body = body;
  c.shape = index;
  c.type = shape.type;
  c.material = shape.material;
  c.surface_velocity = shape.surface_velocity;
  c.moves = model.bodies[std::size_t(body)].kind != BodyKind::static_body;
  c.X_BS = Placement(shape.X_BS);
  c.bounding_radius = geometry::bounding_radius(model, shape);
  if (c.is_convex()) c.core = geometry::core_of(model, shape);
  const double radius = shape.radius, half = 0.5 * shape.length;
  switch (shape.type) {
    case ShapeType::box:
      c.convex = std::make_shared<btBoxShape>(bt(c.core.half));
      c.convex->setMargin(margin_for(c.core.half.minCoeff()));
      break;
    case ShapeType::sphere:
      c.convex = std::make_shared<btSphereShape>(radius);
      break;
    case ShapeType::cylinder:
      c.convex = std::make_shared<btCylinderShapeZ>(btVector3(radius, radius, half));
      c.convex->setMargin(margin_for(std::min(radius, half)));
      break;
    case ShapeType::capsule:
      c.convex = std::make_shared<btCapsuleShapeZ>(radius, 2.0 * half);
      break;
    case ShapeType::convex_mesh: {
      const TriangleMesh& mesh = *model.meshes[std::size_t(shape.mesh)];
      c.hull = std::make_shared<HullFaces>(hull_faces(mesh, Feature::kMost));
      if (c.hull->normals.empty())
        throw std::runtime_error("shape '" + shape.name + "': its convex hull has no volume");
      c.convex = make_rounded_hull(mesh.vertices);
      c.core.points = c.hull->vertices.data();
      c.core.count = c.hull->vertices.size();
      break;
    }
    case ShapeType::plane:
      break;
    case ShapeType::mesh:
      make_mesh(*model.meshes[std::size_t(shape.mesh)], c);
      break;
    case ShapeType::heightmap:
      c.grid = model.heightmaps[std::size_t(shape.heightmap)];
      break;
  }
  return c;
}

bool is_like(const Collider& a, const Collider& b) {
  return a.type == b.type && a.core.half == b.core.half && a.core.radius == b.core.radius &&
         a.core.margin == b.core.margin;
}

std::size_t most_along(const HullFaces& hull, const Vec3& d) {
  std::size_t best = 0;
  double most = -2.0;
  for (std::size_t f = 0; f < hull.normals.size(); ++f) {
    const double along = hull.normals[f].dot(d);
    if (along > most) {
      most = along;
      best = f;
    }
  }
  return best;
}

void cylinder_feature(const Collider& c, const Vec3& d, Feature& out) {
  const Placement& X = c.X_WS;
  const double radius = c.core.radius, half = c.core.half.z();
  if (std::abs(d[2]) > 0.7) {
    // One corner where the rim reaches farthest, so that a coin rolls on it as on a circle.
    const double z = d[2] > 0 ? half : -half;
    const double first = std::hypot(d[0], d[1]) > kUpright ? std::atan2(d[1], d[0]) : 0.0;
    for (int k = 0; k < kCapCorners; ++k) {
      const double angle = first + 2.0 * kPi * k / kCapCorners;
      out.add(X * Vec3(radius * std::cos(angle), radius * std::sin(angle), z));
    }
    return;
  }
  const double length = std::hypot(d[0], d[1]);
  const double x = radius * d[0] / length, y = radius * d[1] / length;
  out.add(X * Vec3(x, y, -half));
  out.add(X * Vec3(x, y, half));
}

}  // namespace

std::vector<Collider> make_colliders(const SceneModel& model) {
  std::vector<Collider> out;
  std::size_t shapes = 0;
  for (const Body& body : model.bodies) shapes += body.shapes.size();
  out.reserve(shapes);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    for (std::size_t s = 0; s < body.shapes.size(); ++s) {
      const bool used = !body.removed && body.shapes[s].collides;
      out.push_back(used ? make_collider(model, int(b), int(s)) : Collider());
      // Of shapes one like the other in a row one serves distance queries.
      Collider& c = out.back();
      if (out.size() > 1 && c.convex && !c.hull && is_like(c, out[out.size() - 2]))
        c.convex = out[out.size() - 2].convex;
    }
  }
  return out;
}

void support_feature(const Collider& c, const Vec3& direction, Feature& out) {
  out.count = 0;
  const Placement& X = c.X_WS;
  const Vec3 d = X.R.transpose() * direction;
  const Vec3& half = c.core.half;
  switch (c.type) {
    case ShapeType::box: {
      int axis = 0;
      d.cwiseAbs().maxCoeff(&axis);
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      Vec3 p;
      p[axis] = d[axis] > 0 ? half[axis] : -half[axis];
      for (int k = 0; k < 4; ++k) {
        p[u] = (k == 1 || k == 2) ? half[u] : -half[u];
        p[v] = k >= 2 ? half[v] : -half[v];
        out.add(X * p);
      }
      return;
    }
    case ShapeType::sphere:
      out.add(X.p + c.core.margin * direction);
      return;
    case ShapeType::cylinder:
      cylinder_feature(c, d, out);
      return;
    case ShapeType::capsule:
      for (double end : {-half.z(), half.z()})
        out.add(X * Vec3(0, 0, end) + c.core.margin * direction);
      return;
    case ShapeType::convex_mesh: {
      for (int v : c.hull->corners[most_along(*c.hull, d)])
        out.add(X * c.hull->vertices[std::size_t(v)]);
      return;
    }
    case ShapeType::plane:
    case ShapeType::mesh:
    case ShapeType::heightmap:
      return;
  }
}

bool face_normal(const Collider& c, const Vec3& direction, Vec3& normal) {
  const Mat3& R = c.X_WS.R;
  const Vec3 d = R.transpose() * direction;
  int axis = 2;
  switch (c.type) {
    case ShapeType::convex_mesh:
      normal = R * c.hull->normals[most_along(*c.hull, d)];
      return true;
    case ShapeType::box:
      d.cwiseAbs().maxCoeff(&axis);
      [[fallthrough]];
    case ShapeType::cylinder:
      normal = d[axis] > 0.0 ? Vec3(R.col(axis)) : Vec3(-R.col(axis));
      return true;
    default:
      return false;
  }
}

double support_extent(const Collider& c, const Vec3& direction) {
  return c.core.extent(c.X_WS.R.transpose() * direction);
}

Vec3 support_point(const Collider& c, const Vec3& direction) {
  return c.X_WS * c.core.support(c.X_WS.R.transpose() * direction) + c.core.margin * direction;
}

}  // namespace cogrsim::dynamics

#include "collider.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "convert.h"
#include "engine.h"

#include "cogrsim/model/hull_faces.h"

namespace cogrsim::ode {

namespace {

constexpr int kMostPoints = 32;
constexpr std::size_t kMostCorners = 32;

// Thick enough that resting contact is found whatever the last digits say, thin against the shape.
double skin_of(double half_width) { return std::min(2e-5, 1e-3 * half_width); }

struct Convex {
  std::vector<double> planes, points;
  std::vector<unsigned> polygons;
  double half_width = 0.0;
};

/// ODE's convex from flat faces about the origin, every face moved outwards by `skin`.
Convex convex_from(const HullFaces& hull, const Vec3& origin, double skin) {
  Convex out;
  std::vector<std::vector<int>> at_corner(hull.vertices.size());
  out.half_width = 1e300;
  for (std::size_t f = 0; f < hull.normals.size(); ++f) {
    const Vec3& n = hull.normals[f];
    double d = -1e300;
    for (const int c : hull.corners[f]) {
      at_corner[static_cast<std::size_t>(c)].push_back(static_cast<int>(f));
      d = std::max(d, n.dot(hull.vertices[static_cast<std::size_t>(c)] - origin));
    }
    out.half_width = std::min(out.half_width, d);
    for (int i = 0; i < 3; ++i) out.planes.push_back(n[i]);
    out.planes.push_back(d + skin);
    out.polygons.push_back(static_cast<unsigned>(hull.corners[f].size()));
    for (const int c : hull.corners[f]) out.polygons.push_back(static_cast<unsigned>(c));
  }
  for (std::size_t v = 0; v < hull.vertices.size(); ++v) {
    Vec3 p = hull.vertices[v] - origin;
    const auto rows = static_cast<Eigen::Index>(at_corner[v].size());
    if (rows > 0 && skin > 0.0) {
      // The corner of the moved faces, in the sense of least squares where more than three meet.
      Eigen::MatrixX3d N(rows, 3);
      for (Eigen::Index k = 0; k < rows; ++k) {
        N.row(k) = hull.normals[static_cast<std::size_t>(at_corner[v][static_cast<std::size_t>(k)])]
                       .transpose();
      }
      p += N.completeOrthogonalDecomposition().solve(Eigen::VectorXd::Constant(rows, skin));
    }
    for (int i = 0; i < 3; ++i) out.points.push_back(p[i]);
  }
  return out;
}

void mesh_arrays(const SceneModel& model, const Shape& shape, std::vector<double>& vertices,
                 std::vector<dTriIndex>& triangles) {
  if (shape.type == ShapeType::mesh) {
    const TriangleMesh& mesh = model.meshes[static_cast<std::size_t>(shape.mesh)];
    for (const Vec3& v : mesh.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
    for (const auto& t : mesh.triangles) {
      for (int i = 0; i < 3; ++i) triangles.push_back(static_cast<dTriIndex>(t[i]));
    }
    return;
  }
  const HeightGrid& grid = model.heightmaps[static_cast<std::size_t>(shape.heightmap)];
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      vertices.push_back(grid.size_x * (static_cast<double>(c) / (grid.columns - 1) - 0.5));
      vertices.push_back(grid.size_y * (static_cast<double>(r) / (grid.rows - 1) - 0.5));
      vertices.push_back(grid.heights[static_cast<std::size_t>(r * grid.columns + c)]);
    }
  }
  const auto index = [&](int r, int c) { return static_cast<dTriIndex>(r * grid.columns + c); };
  for (int r = 0; r + 1 < grid.rows; ++r) {
    for (int c = 0; c + 1 < grid.columns; ++c) {
      for (const auto i : {index(r, c), index(r, c + 1), index(r + 1, c + 1), index(r, c),
                           index(r + 1, c + 1), index(r + 1, c)}) {
        triangles.push_back(i);
      }
    }
  }
}

// Whether a geom at `X` is where nothing comes that moves, or nowhere. ODE's space counts cells, of
// 1/8 m and more, in an int, and ends in an assertion where that is too small, at some 2e8 m.
bool is_out_of_reach(dGeomID geom, const Pose& X) {
  constexpr double kReach = 1e7;  // [m], ten times that of what moves
  if (!X.p.allFinite() || !X.q.coeffs().allFinite()) return true;
  if (X.p.squaredNorm() <= kReach * kReach) return false;
  dReal box[6];
  dGeomGetAABB(geom, box);
  for (int i = 0; i < 3; ++i) {
    if (!(box[2 * i] <= kReach && box[2 * i + 1] >= -kReach)) return true;
  }
  return false;
}

}  // namespace

Collider::~Collider() {
  if (locked_) return;  // ODE refuses to take anything out of a space in use: that memory is lost
  for (const auto& item : items_) {
    if (item->geom) dGeomDestroy(item->geom);
    if (item->mesh) dGeomTriMeshDataDestroy(item->mesh);
  }
  if (space_) dSpaceDestroy(space_);
}

Result<> Collider::make(const SceneModel& model, const Shape& shape, Item& item) {
  item.type = shape.type;
  item.X_BG = shape.X_BS;
  switch (shape.type) {
    case ShapeType::box: {
      item.skin = skin_of(0.5 * shape.size.minCoeff());
      const Vec3 size = shape.size + Vec3::Constant(2.0 * item.skin);
      item.geom = dCreateBox(space_, size.x(), size.y(), size.z());
      return {};
    }
    case ShapeType::sphere:
      item.skin = skin_of(shape.radius);
      item.geom = dCreateSphere(space_, shape.radius + item.skin);
      return {};
    case ShapeType::cylinder: {
      item.skin = skin_of(std::min(shape.radius, 0.5 * shape.length));
      item.geom = dCreateCylinder(space_, shape.radius + item.skin, shape.length + 2.0 * item.skin);
      return {};
    }
    case ShapeType::capsule:
      item.skin = skin_of(shape.radius);
      item.geom = dCreateCapsule(space_, shape.radius + item.skin, shape.length);
      return {};
    case ShapeType::plane:
      item.skin = skin_of(1.0);
      item.geom = dCreatePlane(space_, 0, 0, 1, item.skin);
      return {};
    case ShapeType::convex_mesh: {
      const HullFaces hull =
          hull_faces(model.meshes[static_cast<std::size_t>(shape.mesh)], kMostCorners);
      if (hull.normals.empty()) {
        return fail("shape '" + shape.name + "': its mesh has no volume",
                    place_of(model, shape.origin));
      }
      // ODE wants the origin inside.
      Vec3 middle = Vec3::Zero();
      for (const Vec3& v : hull.vertices) middle += v / static_cast<double>(hull.vertices.size());
      item.skin = skin_of(convex_from(hull, middle, 0.0).half_width);
      Convex convex = convex_from(hull, middle, item.skin);
      item.planes = std::move(convex.planes);
      item.points = std::move(convex.points);
      item.polygons = std::move(convex.polygons);
      item.X_BG = shape.X_BS * Pose(middle, Quat(1, 0, 0, 0));
      item.geom = dCreateConvex(
          space_, item.planes.data(), static_cast<unsigned>(item.planes.size() / 4),
          item.points.data(), static_cast<unsigned>(item.points.size() / 3), item.polygons.data());
      return {};
    }
    case ShapeType::mesh:
    case ShapeType::heightmap: {
      mesh_arrays(model, shape, item.vertices, item.triangles);
      item.mesh = dGeomTriMeshDataCreate();
      dGeomTriMeshDataBuildDouble(item.mesh, item.vertices.data(), 3 * sizeof(double),
                                  static_cast<int>(item.vertices.size() / 3), item.triangles.data(),
                                  static_cast<int>(item.triangles.size()), 3 * sizeof(dTriIndex));
      // Convex meshes are tested against triangles only with the angles between them.
      dGeomTriMeshDataPreprocess2(item.mesh, 1U << dTRIDATAPREPROCESS_BUILD_FACE_ANGLES, nullptr);
      item.geom = dCreateTriMesh(space_, item.mesh, nullptr, nullptr, nullptr);
      return {};
    }
  }
  return fail("shape '" + shape.name + "': of an unknown type", place_of(model, shape.origin));
}

Result<> Collider::add(const SceneModel& model) {
  prepare_thread();
  if (!space_) {
    space_ = dHashSpaceCreate(nullptr);
    dSpaceSetCleanup(space_, 0);
  }
  const std::size_t known = of_body_.size(), items = items_.size();
  for (std::size_t b = known; b < model.bodies.size(); ++b) {
    of_body_.emplace_back();
    if (model.bodies[b].removed) continue;
    for (std::size_t s = 0; s < model.bodies[b].shapes.size(); ++s) {
      const Shape& shape = model.bodies[b].shapes[s];
      if (!shape.collides) continue;
      auto item = std::make_unique<Item>();
      item->body = static_cast<int>(b);
      item->shape = static_cast<int>(s);
      auto made = make(model, shape, *item);
      if (!made) {
        while (items_.size() > items) {
          Item& last = *items_.back();
          dGeomDestroy(last.geom);
          if (last.mesh) dGeomTriMeshDataDestroy(last.mesh);
          items_.pop_back();
        }
        of_body_.resize(known);
        return made;
      }
      dGeomSetData(item->geom, reinterpret_cast<void*>(items_.size()));
      of_body_.back().push_back(static_cast<int>(items_.size()));
      items_.push_back(std::move(item));
    }
  }
  set_model(model);
  return {};
}

void Collider::remove(int body) {
  for (const int i : of_body_[static_cast<std::size_t>(body)]) {
    Item& item = *items_[static_cast<std::size_t>(i)];
    dGeomDestroy(item.geom);
    if (item.mesh) dGeomTriMeshDataDestroy(item.mesh);
    item.geom = nullptr;
    item.mesh = nullptr;
  }
  of_body_[static_cast<std::size_t>(body)].clear();
}

void Collider::place(int body, const Pose& X_WB) {
  for (const int i : of_body_[static_cast<std::size_t>(body)]) {
    Item& item = *items_[static_cast<std::size_t>(i)];
    const Pose X = X_WB * item.X_BG;
    if (item.type == ShapeType::plane) {
      const Vec3 n = X.q * Vec3::UnitZ();
      dGeomPlaneSetParams(item.geom, n.x(), n.y(), n.z(), n.dot(X.p) + item.skin);
      continue;
    }
    const dQuaternion q = {X.q.w(), X.q.x(), X.q.y(), X.q.z()};
    dGeomSetPosition(item.geom, X.p.x(), X.p.y(), X.p.z());
    dGeomSetQuaternion(item.geom, q);
    is_out_of_reach(item.geom, X) ? dGeomDisable(item.geom) : dGeomEnable(item.geom);
  }
}

void Collider::near(void* self, dGeomID a, dGeomID b) {
  auto& collider = *static_cast<Collider*>(self);
  const auto index = [](dGeomID geom) {
    return static_cast<int>(reinterpret_cast<std::size_t>(dGeomGetData(geom)));
  };
  int i = index(a), j = index(b);
  const auto item = [&](int k) -> const Item& {
    return *collider.items_[static_cast<std::size_t>(k)];
  };
  if (!collider.filter_.collide(item(i).body, item(j).body)) return;
  if (j < i) std::swap(i, j);  // items lie in the order of bodies and shapes
  collider.pairs_.emplace_back(i, j);
}

void Collider::find(const SceneModel&, std::vector<TouchPoint>& out) {
  out.clear();
  if (!space_) return;
  pairs_.clear();
  if (locked_) throw EngineError("an earlier search for contacts was broken off");
  locked_ = true;
  dSpaceCollide(space_, this, &Collider::near);
  locked_ = false;
  // The broadphase reports in an order that depends on the past.
  std::sort(pairs_.begin(), pairs_.end());
  for (const auto& [a, b] : pairs_) {
    collide(*items_[static_cast<std::size_t>(a)], *items_[static_cast<std::size_t>(b)], out);
  }
}

void Collider::collide(const Item& a, const Item& b, std::vector<TouchPoint>& out) {
  found_.resize(kMostPoints);
  const int count = dCollide(a.geom, b.geom, kMostPoints, found_.data(), sizeof(dContactGeom));
  const std::size_t first = out.size();
  for (int k = 0; k < count; ++k) {
    const dContactGeom& c = found_[static_cast<std::size_t>(k)];
    TouchPoint point;
    point.body_a = a.body;
    point.body_b = b.body;
    point.shape_a = a.shape;
    point.shape_b = b.shape;
    point.point = to_vec(c.pos);
    point.normal = -to_vec(c.normal);
    point.gap = a.skin + b.skin - c.depth;
    out.push_back(point);
  }
  if (count != 2) return;
  // A cylinder or capsule on its side. With friction at both ends of the line alone, a wheel that
  // drives an arc would roll on one of its rims; what is borne in the middle rolls on the mean.
  for (const Item* item : {&a, &b}) {
    if (item->type != ShapeType::cylinder && item->type != ShapeType::capsule) continue;
    const dReal* R = dGeomGetRotation(item->geom);
    const Vec3 axis(R[2], R[6], R[10]);
    TouchPoint &one = out[first], &two = out[first + 1];
    const Vec3 way = two.point - one.point;
    if (std::abs(axis.dot(one.normal)) > 0.1 || one.normal.dot(two.normal) < 0.9999 ||
        std::abs(way.dot(axis)) < 0.99 * way.norm()) {
      continue;
    }
    TouchPoint middle = one;
    middle.point = 0.5 * (one.point + two.point);
    middle.normal = (one.normal + two.normal).normalized();
    middle.gap = 0.5 * (one.gap + two.gap);
    one.line_end = two.line_end = true;
    out.push_back(middle);
    return;
  }
}

}  // namespace cogrsim::ode

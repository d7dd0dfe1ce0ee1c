#include "shape_factory.h"

#include <algorithm>
#include <cmath>

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <LinearMath/btConvexHullComputer.h>

#include "convert.h"
#include "support_feature.h"

namespace cogrsim::bullet {

namespace {

// Part of a shape's smallest half width that Bullet may round its edges by.
constexpr double kMarginShare = 0.02;

double margin_for(double smallest_half_width) { return kMarginShare * smallest_half_width; }

Result<std::unique_ptr<CollisionShape>> make_hull(const TriangleMesh& mesh, const Shape& shape) {
  auto out = std::make_unique<CollisionShape>();
  if (mesh.vertices.size() < 4) {
    return fail("shape '" + shape.name + "': a convex mesh needs at least four points");
  }
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
    out->reach = std::max(out->reach, v.norm());
  }
  // The hull is shrunk by the margin that Bullet adds again.
  btConvexHullComputer hull;
  const double margin = margin_for(0.5 * (high - low).minCoeff());
  const double shrunk = hull.compute(mesh.vertices.front().data(), 3 * sizeof(double),
                                     static_cast<int>(mesh.vertices.size()), margin, 0.25);
  if (hull.vertices.size() < 4 || shrunk < 0.0) {
    return fail("shape '" + shape.name + "': its points span no volume");
  }
  // The true faces, for contacts found without Bullet's help: its hulls are rounded to 1e-4 of
  // their size.
  out->faces = hull_faces(mesh, SupportFeature::kMost);
  if (out->faces.normals.empty()) {
    return fail("shape '" + shape.name + "': its points span no volume");
  }
  auto convex = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < hull.vertices.size(); ++i) convex->addPoint(hull.vertices[i], false);
  convex->recalcLocalAabb();
  convex->setMargin(shrunk);
  out->shape = std::move(convex);
  return out;
}

std::unique_ptr<CollisionShape> make_mesh(const TriangleMesh& mesh) {
  auto out = std::make_unique<CollisionShape>();
  out->numbers.reserve(3 * mesh.vertices.size());
  for (const Vec3& v : mesh.vertices)
    out->numbers.insert(out->numbers.end(), {v.x(), v.y(), v.z()});
  out->indices.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) out->indices.insert(out->indices.end(), {t[0], t[1], t[2]});
  auto triangles = std::make_unique<btTriangleIndexVertexArray>(
      static_cast<int>(mesh.triangles.size()), out->indices.data(), int{3 * sizeof(int)},
      static_cast<int>(mesh.vertices.size()), out->numbers.data(), int{3 * sizeof(double)});
  auto shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true);
  shape->setMargin(0.0);
  out->triangles = std::move(triangles);
  out->shape = std::move(shape);
  return out;
}

std::unique_ptr<CollisionShape> make_heightmap(const HeightGrid& grid) {
  auto out = std::make_unique<CollisionShape>();
  out->numbers = grid.heights;
  const auto [low, high] = std::minmax_element(out->numbers.begin(), out->numbers.end());
  auto shape = std::make_unique<btHeightfieldTerrainShape>(
      grid.columns, grid.rows, out->numbers.data(), *low, *high, 2, true);
  shape->setLocalScaling(
      btVector3(grid.size_x / (grid.columns - 1), grid.size_y / (grid.rows - 1), 1));
  shape->setMargin(0.0);
  // Bullet centres the field between its lowest and highest point.
  out->X_SC.setOrigin(btVector3(0, 0, 0.5 * (*low + *high)));
  out->shape = std::move(shape);
  return out;
}

}  // namespace

Result<std::unique_ptr<CollisionShape>> make_shape(const SceneModel& model, const Body& body,
                                                   const Shape& shape) {
  const bool surface = shape.type == ShapeType::plane || shape.type == ShapeType::mesh ||
                       shape.type == ShapeType::heightmap;
  if (surface && body.kind == BodyKind::dynamic) {
    return fail("body '" + body.name + "': a " + std::string(to_string(shape.type)) +
                    " cannot be moved by forces",
                place_of(model, shape.origin),
                "make the body static or kinematic, or use a convex-mesh");
  }
  auto out = std::make_unique<CollisionShape>();
  switch (shape.type) {
    case ShapeType::box: {
      auto box = std::make_unique<btBoxShape>(to_bt(0.5 * shape.size));
      box->setMargin(margin_for(0.5 * shape.size.minCoeff()));
      out->reach = 0.5 * shape.size.norm();
      out->shape = std::move(box);
      break;
    }
    case ShapeType::sphere:
      out->shape = std::make_unique<btSphereShape>(shape.radius);
      out->reach = shape.radius;
      break;
    case ShapeType::cylinder: {
      const Vec3 half(shape.radius, shape.radius, 0.5 * shape.length);
      auto cylinder = std::make_unique<btCylinderShapeZ>(to_bt(half));
      cylinder->setMargin(margin_for(half.minCoeff()));
      out->reach = std::hypot(shape.radius, 0.5 * shape.length);
      out->shape = std::move(cylinder);
      break;
    }
    case ShapeType::capsule:
      out->shape = std::make_unique<btCapsuleShapeZ>(shape.radius, shape.length);
      out->reach = shape.radius + 0.5 * shape.length;
      break;
    case ShapeType::plane:
      out->shape = std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0.0);
      break;
    case ShapeType::convex_mesh: {
      auto hull = make_hull(model.meshes[static_cast<std::size_t>(shape.mesh)], shape);
      if (!hull) {
        hull.error().where = place_of(model, shape.origin);
        return hull;
      }
      out = std::move(*hull);
      break;
    }
    case ShapeType::mesh: {
      const TriangleMesh& mesh = model.meshes[static_cast<std::size_t>(shape.mesh)];
      if (mesh.triangles.empty()) {
        return fail("shape '" + shape.name + "': its mesh has no triangles",
                    place_of(model, shape.origin));
      }
      out = make_mesh(mesh);
      break;
    }
    case ShapeType::heightmap:
      out = make_heightmap(model.heightmaps[static_cast<std::size_t>(shape.heightmap)]);
      break;
  }
  return out;
}

}  // namespace cogrsim::bullet

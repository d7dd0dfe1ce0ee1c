#include "shapes.h"

#include <algorithm>
#include <limits>

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btConvexHullComputer.h>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

/// The hull shrunk by the margin that Bullet adds again, so that it keeps its size. `margin` [m]; 0:
/// Bullet's own.
std::unique_ptr<btCollisionShape> hull(const TriangleMesh& mesh, double margin) {
  if (mesh.vertices.size() < 4) return nullptr;
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  if (!(margin > 0.0))
    margin = std::min<double>(CONVEX_DISTANCE_MARGIN, 0.05 * (high - low).minCoeff());
  btConvexHullComputer computer;
  const double shrunk = computer.compute(mesh.vertices.front().data(), 3 * sizeof(double),
                                         static_cast<int>(mesh.vertices.size()), margin, 0.25);
  if (computer.vertices.size() < 4 || shrunk < 0.0) return nullptr;
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < computer.vertices.size(); ++i) shape->addPoint(computer.vertices[i], false);
  shape->recalcLocalAabb();
  shape->setMargin(shrunk);
  return shape;
}

/// `out` keeps what the shape points into.
std::unique_ptr<btCollisionShape> surface(const MeshPtr& mesh, BodyShape& out) {
  if (mesh->triangles.empty()) return nullptr;
  out.data.push_back(mesh);
  auto triangles = std::make_unique<btTriangleIndexVertexArray>(
      static_cast<int>(mesh->triangles.size()), const_cast<int*>(mesh->triangles.front().data()),
      int{3 * sizeof(int)}, static_cast<int>(mesh->vertices.size()),
      const_cast<double*>(mesh->vertices.front().data()), int{3 * sizeof(double)});
  auto shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true);
  out.triangles.push_back(std::move(triangles));
  return shape;
}

/// Bullet centres the field between its lowest and highest point.
std::unique_ptr<btCollisionShape> terrain(const HeightGridPtr& grid, Pose& X_BS, BodyShape& out) {
  out.data.push_back(grid);
  const auto [low, high] = std::minmax_element(grid->heights.begin(), grid->heights.end());
  auto shape = std::make_unique<btHeightfieldTerrainShape>(
      grid->columns, grid->rows, grid->heights.data(), *low, *high, 2, true);
  shape->setLocalScaling(
      btVector3(grid->size_x / (grid->columns - 1), grid->size_y / (grid->rows - 1), 1));
  X_BS = X_BS * Pose(Vec3(0, 0, 0.5 * (*low + *high)), Quat(1, 0, 0, 0));
  return shape;
}

/// nullptr: a mesh without triangles or volume. X_BS moves where Bullet centres a shape elsewhere.
std::unique_ptr<btCollisionShape> make(const SceneModel& model, const Shape& shape, double margin,
                                       Pose& X_BS, BodyShape& out) {
  const double r = shape.radius;
  switch (shape.type) {
    case ShapeType::box:
      return std::make_unique<btBoxShape>(to_bt(0.5 * shape.size));
    case ShapeType::sphere:
      return std::make_unique<btSphereShape>(r);
    case ShapeType::cylinder:
      return std::make_unique<btCylinderShapeZ>(btVector3(r, r, 0.5 * shape.length));
    case ShapeType::capsule:
      return std::make_unique<btCapsuleShapeZ>(r, shape.length);
    case ShapeType::plane:
      return std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0.0);
    case ShapeType::convex_mesh:
      return hull(*model.meshes[shape.mesh], margin);
    case ShapeType::mesh:
      return surface(model.meshes[shape.mesh], out);
    case ShapeType::heightmap:
      return terrain(model.heightmaps[shape.heightmap], X_BS, out);
  }
  return nullptr;
}

/// The leaf of ours that a wrapper stands for: triangles of a mesh are made on the way.
const btCollisionShape* leaf_of(const btCollisionObjectWrapper* wrapper) {
  while (wrapper->getCollisionShape()->getUserIndex() < 0 && wrapper->m_parent)
    wrapper = wrapper->m_parent;
  return wrapper->getCollisionShape();
}

bool set_surface(btManifoldPoint& point, const btCollisionObjectWrapper* wrapper_0, int, int,
                 const btCollisionObjectWrapper* wrapper_1, int, int) {
  const void* const owner = wrapper_0->getCollisionObject()->getUserPointer();
  if (!owner || owner != wrapper_1->getCollisionObject()->getUserPointer()) return true;
  const btCollisionShape *const a = leaf_of(wrapper_0), *const b = leaf_of(wrapper_1);
  const SurfacePair pair =
      static_cast<const Surfaces*>(owner)->pairs(a->getUserIndex2(), b->getUserIndex2());
  point.m_combinedFriction = pair.friction;
  point.m_combinedRestitution = pair.restitution;
  // Without the one Bullet does not look at the other.
  const double least = pair.spinning_friction > 0.0 ? std::numeric_limits<double>::min() : 0.0;
  point.m_combinedRollingFriction = std::max(pair.rolling_friction, least);
  point.m_combinedSpinningFriction = pair.spinning_friction;
  if (pair.stiffness) {
    point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
    point.m_combinedContactStiffness1 = *pair.stiffness;
    point.m_combinedContactDamping1 = 0.0;
  }
  // Bullet does not read these; they are for read_contacts().
  point.m_partId0 = a->getUserIndex();
  point.m_partId1 = b->getUserIndex();
  return true;
}

// In each step, with the bodies where they are: directions of friction along and across the sliding of
// the surfaces, and the velocity of the first against the second at which they do not slide.
bool set_motion(btManifoldPoint& point, void* first, void* second) {
  const auto& a = *static_cast<const btCollisionObject*>(first);
  const auto& b = *static_cast<const btCollisionObject*>(second);
  const auto* const owner = static_cast<const Surfaces*>(a.getUserPointer());
  if (!owner || owner != b.getUserPointer() || owner->velocities.empty()) return true;
  const auto surface = [&](const btCollisionObject& of, int shape) {
    return of.getWorldTransform().getBasis() * owner->velocities[of.getUserIndex()][shape];
  };
  const auto speed = [](const btCollisionObject& of, const btVector3& at) {
    const btRigidBody* const body = btRigidBody::upcast(&of);
    return body->getVelocityInLocalPoint(at - of.getWorldTransform().getOrigin());
  };
  const btVector3 wanted = surface(b, point.m_partId1) - surface(a, point.m_partId0);
  const btVector3& n = point.m_normalWorldOnB;
  const auto tangential = [&n](const btVector3& v) { return v - n * v.dot(n); };
  btVector3 along = tangential(wanted);
  point.m_contactPointFlags &= ~BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
  if (along.length2() == 0.0) return true;
  const btVector3 slip =
      tangential(speed(a, point.m_positionWorldOnA) - speed(b, point.m_positionWorldOnB) - wanted);
  if (slip.length2() > SIMD_EPSILON) along = slip;
  point.m_contactPointFlags |= BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
  point.m_lateralFrictionDir1 = along.normalized();
  point.m_lateralFrictionDir2 = n.cross(point.m_lateralFrictionDir1);
  point.m_contactMotion1 = wanted.dot(point.m_lateralFrictionDir1);
  point.m_contactMotion2 = wanted.dot(point.m_lateralFrictionDir2);
  return true;
}

}  // namespace

Result<std::unique_ptr<BodyShape>> make_body_shape(const SceneModel& model, const Body& body,
                                                   double margin, Pose& X_BG) {
  auto out = std::make_unique<BodyShape>();
  const auto keep = [&](std::unique_ptr<btCollisionShape> shape) {
    return out->parts.emplace_back(std::move(shape)).get();
  };
  std::vector<std::pair<Pose, btCollisionShape*>> leaves;
  for (const Shape& shape : body.shapes) {
    if (!shape.collides) continue;
    Pose X_BS = shape.X_BS;
    auto made = make(model, shape, margin, X_BS, *out);
    if (!made)
      return fail("shape '" + shape.name + "': its mesh has no triangles, or spans no volume",
                  source_position(model, shape.origin));
    if (margin > 0.0 && (shape.type == ShapeType::box || shape.type == ShapeType::cylinder))
      made->setMargin(margin);
    made->setUserIndex(static_cast<int>(&shape - body.shapes.data()));
    made->setUserIndex2(shape.material);
    leaves.emplace_back(X_BS, keep(std::move(made)));
  }
  out->collides = !leaves.empty();
  if (leaves.empty()) {
    out->shape = keep(std::make_unique<btEmptyShape>());
    return out;
  }
  const auto same = [](const Pose& a, const Pose& b) {
    return a.p == b.p && a.q.coeffs() == b.q.coeffs();
  };
  if (leaves.size() == 1 && body.kind != BodyKind::dynamic) X_BG = leaves.front().first;
  if (leaves.size() == 1 && same(leaves.front().first, X_BG)) {
    out->shape = leaves.front().second;
    return out;
  }
  const bool centred = same(X_BG, Pose());
  auto compound = std::make_unique<btCompoundShape>();
  for (const auto& [X_BS, leaf] : leaves)
    compound->addChildShape(to_bt(centred ? X_BS : X_BG.inverse() * X_BS), leaf);
  out->shape = keep(std::move(compound));
  return out;
}

Surfaces::Surfaces(const SceneModelPtr& model) : pairs(model), model_(model) {
  for (const Body& body : model->bodies)
    for (const Shape& shape : body.shapes)
      if (shape.collides && !shape.surface_velocity.isZero(0.0))
        velocities.resize(model->bodies.size());
}

void Surfaces::set_frame(int body, const Pose& X_BG) {
  if (velocities.empty()) return;
  for (const Shape& shape : model_->bodies[body].shapes)
    velocities[body].push_back(
        to_bt(Vec3(X_BG.q.inverse() * (shape.X_BS.q * shape.surface_velocity))));
}

void Surfaces::install() {
  gContactAddedCallback = &set_surface;
  gContactProcessedCallback = &set_motion;
}

}  // namespace cogrsim::bullet

// Bullet collision shapes from the scene's.
#pragma once

#include <memory>
#include <vector>

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>

#include "cogrsim/core/result.h"
#include "cogrsim/model/hull_faces.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

/// A Bullet shape with the data it points into.
struct CollisionShape {
  // Order matters: the shape goes before what it refers to.
  std::vector<double> numbers;  ///< heights, vertices of a mesh
  std::vector<int> indices;
  HullFaces faces;  ///< of a hull, at most SupportFeature::kMost corners each
  std::unique_ptr<btStridingMeshInterface> triangles;
  std::unique_ptr<btCollisionShape> shape;
  btTransform X_SC = btTransform::getIdentity();  ///< Bullet's frame of the shape in the scene's
  double reach = 0.0;  ///< of a moving shape: radius of a ball around C's origin that holds it [m]
};

/// Shapes keep their true outer size: what Bullet adds as a collision margin is taken off inside.
/// Errors: a hull or mesh without volume or triangles, a plane, mesh or heightmap on a body that
/// moves.
Result<std::unique_ptr<CollisionShape>> make_shape(const SceneModel& model, const Body& body,
                                                   const Shape& shape);

}  // namespace cogrsim::bullet

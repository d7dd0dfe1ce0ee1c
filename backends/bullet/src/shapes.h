// A body's shapes as Bullet's, and the friction and restitution of what touches.
#pragma once

#include <memory>
#include <vector>

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/surface_table.h"

class btManifoldPoint;
struct btCollisionObjectWrapper;

namespace cogrsim::bullet {

/// All that a collision object points to. `shape` is the one shape, or a compound of several.
struct BodyShape {
  std::vector<std::shared_ptr<const void>> data;  // that shapes point into
  std::vector<std::unique_ptr<btStridingMeshInterface>> triangles;
  std::vector<std::unique_ptr<btCollisionShape>> parts;
  btCollisionShape* shape = nullptr;
  bool collides = false;
};

/// The colliding shapes of a body, seen from Bullet's frame of it, X_BG; of a body that does not
/// move and has one shape, X_BG becomes that shape's. Leaves carry their number in Body::shapes as
/// user index and their material as second user index. A body without any gets an empty shape.
/// Errors: a mesh without a volume.
Result<std::unique_ptr<BodyShape>> make_body_shape(const SceneModel& model, const Body& body,
                                                   double margin, Pose& X_BG);

/// What two materials do to each other, and where Bullet asks for it: gContactAddedCallback. One
/// per world; collision objects point to it (user pointer).
class Surfaces {
 public:
  explicit Surfaces(const SceneModelPtr& model);
  const SurfaceTable pairs;
  /// By body and shape, of its surface in Bullet's frame of the body [m/s]; empty: none moves.
  std::vector<std::vector<btVector3>> velocities;
  /// Bullet's frame of a body. Before it collides.
  void set_frame(int body, const Pose& X_BG);

  /// Puts our function into Bullet's global pointer. It changes only objects that carry
  /// CF_CUSTOM_MATERIAL_CALLBACK, and knows nothing but what these point to, so that worlds on
  /// several threads do not meet in it.
  static void install();

 private:
  SceneModelPtr model_;
};

}  // namespace cogrsim::bullet

// The ray benchmark's scene on bare Bullet, double precision.
#include <btBulletDynamicsCommon.h>

#include <limits>
#include <stdexcept>

#include "rays.h"

namespace cogrsim::bench {
namespace {

btVector3 convert(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

std::unique_ptr<btCollisionShape> make_shape(const Shape& shape) {
  switch (shape.type) {
    case ShapeType::box:
      return std::make_unique<btBoxShape>(convert(shape.size / 2));
    case ShapeType::sphere:
      return std::make_unique<btSphereShape>(shape.radius);
    case ShapeType::cylinder:
      return std::make_unique<btCylinderShapeZ>(
          btVector3(shape.radius, shape.radius, shape.length / 2));
    case ShapeType::capsule:
      return std::make_unique<btCapsuleShapeZ>(shape.radius, shape.length);
    default:
      throw std::logic_error("no such shape in this benchmark");
  }
}

class World final : public BulletRays {
 public:
  explicit World(const SceneModel& model) {
    for (const Body& body : model.bodies) {
      const Pose pose = body.X_WB * body.shapes.front().X_BS;
      auto object = std::make_unique<btCollisionObject>();
      shapes_.push_back(make_shape(body.shapes.front()));
      object->setCollisionShape(shapes_.back().get());
      object->setWorldTransform(btTransform(
          btQuaternion(pose.q.x(), pose.q.y(), pose.q.z(), pose.q.w()), convert(pose.p)));
      world_.addCollisionObject(object.get());
      objects_.push_back(std::move(object));
    }
    world_.updateAabbs();
  }
  ~World() override {
    for (auto& object : objects_) world_.removeCollisionObject(object.get());
  }

  void cast(const std::vector<Ray>& rays, double length, std::vector<double>& distances) override {
    distances.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const btVector3 from = convert(rays[i].origin);
      const btVector3 to = convert(rays[i].origin + length * rays[i].direction);
      btCollisionWorld::ClosestRayResultCallback nearest(from, to);
      world_.rayTest(from, to, nearest);
      distances[i] = nearest.hasHit() ? nearest.m_closestHitFraction * length
                                      : std::numeric_limits<double>::infinity();
    }
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> objects_;
};

}  // namespace

std::unique_ptr<BulletRays> make_bullet_rays(const SceneModel& model) {
  return std::make_unique<World>(model);
}

}  // namespace cogrsim::bench

#include "contacts.h"

#include <assimp/scene.h>

#include <algorithm>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <set>
#include <string>

#include "cogrsim/geometry/hull_faces.h"
#include "cogrsim/geometry/triangles.h"
#include "cogrsim/physics/scene_state.h"

namespace cogrsim::dart_engine {

namespace {

using namespace dart::dynamics;
using dart::collision::CollisionObject;

// ODE's space counts cells of 1/8 m and more in an int: what nothing gets to is left out [m].
constexpr double kOutOfReach = 1e7;
// Beyond any load that a boxed LCP of numbers can tell from no bound.
constexpr double kMostFriction = 1e6;

// ODE is given the normals of corners by DART, and reads them as those of triangles: so no two triangles
// share a corner, and the first of all corners bear the triangles' normals.
ShapePtr mesh_shape(const TriangleMesh& mesh) {
  auto* const out = new aiMesh;
  const auto count = static_cast<unsigned>(mesh.triangles.size());
  out->mNumVertices = 3 * count;
  out->mVertices = new aiVector3D[out->mNumVertices];
  out->mNormals = new aiVector3D[out->mNumVertices];
  out->mNumFaces = count;
  out->mFaces = new aiFace[count];
  const auto single = [](const Vec3& v) {
    return aiVector3D(static_cast<float>(v.x()), static_cast<float>(v.y()),
                      static_cast<float>(v.z()));
  };
  for (unsigned f = 0; f < count; ++f) {
    const geometry::Triangle corners = geometry::triangle(mesh, f);
    out->mFaces[f].mNumIndices = 3;
    out->mFaces[f].mIndices = new unsigned[3]{3 * f, 3 * f + 1, 3 * f + 2};
    for (unsigned k = 0; k < 3; ++k) out->mVertices[3 * f + k] = single(corners[k]);
    out->mNormals[f] =
        single((corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized());
  }
  auto* const scene = new aiScene;  // which the shape deletes
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { out };
  scene->mRootNode = new aiNode;
  return std::make_shared<MeshShape>(Eigen::Vector3d::Ones(), scene);
}

ShapePtr hull_shape(const TriangleMesh& mesh) {
  const HullFaces faces = hull_faces(mesh, mesh.vertices.size() + 3);
  if (faces.normals.empty()) return nullptr;
  TriangleMesh out;
  out.vertices = faces.vertices;
  for (const std::vector<int>& corners : faces.corners)
    for (std::size_t k = 2; k < corners.size(); ++k)
      out.triangles.emplace_back(corners[0], corners[k - 1], corners[k]);
  return mesh_shape(out);
}

ShapePtr shape_of(const SceneModel& model, const cogrsim::Shape& shape) {
  switch (shape.type) {
    case ShapeType::box:
      return std::make_shared<BoxShape>(shape.size);
    case ShapeType::sphere:
      return std::make_shared<SphereShape>(shape.radius);
    case ShapeType::cylinder:
      return std::make_shared<CylinderShape>(shape.radius, shape.length);
    case ShapeType::capsule:
      return std::make_shared<CapsuleShape>(shape.radius, shape.length);
    case ShapeType::plane:
      return std::make_shared<PlaneShape>(Eigen::Vector3d::UnitZ(), 0.0);
    case ShapeType::convex_mesh:
      return hull_shape(*model.meshes[shape.mesh]);
    case ShapeType::mesh:
      return mesh_shape(*model.meshes[shape.mesh]);
    case ShapeType::heightmap:
      return mesh_shape(geometry::triangles_of(*model.heightmaps[shape.heightmap]));
  }
  return nullptr;
}

}  // namespace

class Detector::Filter final : public dart::collision::CollisionFilter {
 public:
  Filter(const SceneModel& model, const Detector& detector) : pairs_(model), of_(detector) {}
  bool ignoresCollision(const CollisionObject* a, const CollisionObject* b) const override {
    const Geom &one = of_.geoms_.at(a->getShapeFrame()), &other = of_.geoms_.at(b->getShapeFrame());
    return !pairs_.collide(one.body, other.body);
  }

 private:
  cogrsim::CollisionFilter pairs_;
  const Detector& of_;
};

void prepare_thread() {
  // A detector takes ODE into use, for its thread too, and the last one to go ends it for the process.
  static const auto* const kept = new auto(dart::collision::OdeCollisionDetector::create());
  thread_local const auto of_thread = dart::collision::OdeCollisionDetector::create();
  (void)kept;
}

Result<std::shared_ptr<Detector>> Detector::make(const SceneModel& model, const Trees& trees) {
  const auto out = std::make_shared<Detector>();
  out->filter_ = std::make_shared<Filter>(model, *out);
  out->materials_ = model.materials.size();
  out->values_.resize(model.bodies.size());
  out->neutral_.resize(model.bodies.size());
  std::set<int> seen;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    for (std::size_t s = 0; s < model.bodies[b].shapes.size(); ++s) {
      const auto added = out->add(model, trees, static_cast<int>(b), static_cast<int>(s));
      if (!added) return tl::unexpected(added.error());
    }
  for (const auto& [frame, geom] : out->geoms_) seen.insert(geom.body);
  for (const int b : seen) {
    const auto body = static_cast<std::size_t>(b);
    out->neutral_[body] = out->add_stand(trees.node(b), kMostFriction, 1.0);
    for (std::size_t i = 0; i < out->materials_; ++i)
      for (std::size_t k = 0; k < out->materials_; ++k) {
        const SurfacePair pair = surface_pair(model, static_cast<int>(i), static_cast<int>(k));
        out->values_[body].push_back(out->add_stand(
            trees.node(b), std::min(pair.friction, kMostFriction), pair.restitution));
      }
  }
  return out;
}

Detector::Stand* Detector::add_stand(BodyNode* node, double friction, double restitution) {
  static const ShapePtr nothing = std::make_shared<SphereShape>(1e-9);
  auto* const made = node->createShapeNodeWith<DynamicsAspect>(nothing);
  made->getDynamicsAspect()->setFrictionCoeff(friction);
  made->getDynamicsAspect()->setRestitutionCoeff(restitution);
  return &stands_.emplace_back(this, made);
}

Result<> Detector::add(const SceneModel& model, const Trees& trees, int b, int s) {
  const Body& body = model.bodies[b];
  const cogrsim::Shape& shape = body.shapes[s];
  BodyNode* const node = trees.node(b);
  if (!shape.collides || body.removed || !node) return {};
  if (!node->getSkeleton()->isMobile() && shape.type != ShapeType::plane &&
      node->getTransform().translation().norm() > kOutOfReach)
    return {};
  const ShapePtr made = shape_of(model, shape);
  if (!made)
    return fail("shape '" + shape.name + "': its mesh has no volume",
                source_position(model, shape.origin));
  auto* const frame = node->createShapeNodeWith<CollisionAspect, DynamicsAspect>(made);
  frame->setRelativeTransform(to_dart(shape.X_BS));
  geoms_[frame] = {b, s, static_cast<std::size_t>(shape.material)};
  return {};
}

bool Detector::collide(dart::collision::CollisionGroup* group,
                       const dart::collision::CollisionOption& option,
                       dart::collision::CollisionResult* result) {
  const bool found = OdeCollisionDetector::collide(group, option, result);
  pairs_.clear();
  for (std::size_t i = 0; result && i < result->getNumContacts(); ++i) {
    dart::collision::Contact& contact = result->getContact(i);
    const Geom a = geoms_.at(contact.collisionObject1->getShapeFrame());
    const Geom b = geoms_.at(contact.collisionObject2->getShapeFrame());
    pairs_.emplace_back(a, b);
    contact.collisionObject1 = values_[a.body][a.material * materials_ + b.material];
    contact.collisionObject2 = neutral_[b.body];
  }
  return found;
}

void Detector::report(const dart::collision::CollisionResult& result,
                      std::vector<Contact>& out) const {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const dart::collision::Contact& found = result.getContact(i);
    if (dart::collision::Contact::isZeroNormal(found.normal)) continue;
    // DART's normal points into its first body, and its force acts on it.
    const Geom &first = pairs_[i].first, &second = pairs_[i].second;
    Contact& contact = out.emplace_back();
    contact.body_a = second.body;
    contact.body_b = first.body;
    contact.shape_a = second.shape;
    contact.shape_b = first.shape;
    contact.point = found.point;
    contact.depth = found.penetrationDepth;
    contact.normal = found.normal;
    contact.force = found.force;
  }
}

}  // namespace cogrsim::dart_engine

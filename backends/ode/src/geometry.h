// Shapes as geoms of ODE.
#pragma once

#include <ode/ode.h>

#include <map>
#include <memory>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::ode {

/// Triangles with the tree that ODE builds over them, which keeps pointers into the mesh.
struct Triangles {
  explicit Triangles(MeshPtr of);
  ~Triangles() { dGeomTriMeshDataDestroy(data); }
  Triangles(const Triangles&) = delete;
  Triangles& operator=(const Triangles&) = delete;
  MeshPtr mesh;
  dTriMeshDataID data;
};

/// Planes, points and polygons of dCreateConvex, about a point inside the hull. Likewise.
struct Hull {
  std::vector<double> planes, points;
  std::vector<unsigned> polygons;
  Vec3 middle = Vec3::Zero();  ///< in the shape's frame
};

/// What worlds that are rebuilt share: by mesh and heightmap of the model, which keep their index. A change
/// that fails leaves what the next one may have something else for.
class ShapeData {
 public:
  const std::shared_ptr<Triangles>& triangles(const SceneModel& model, const Shape& shape);
  /// Errors: a mesh without volume.
  Result<std::shared_ptr<Hull>> hull(const SceneModel& model, const Shape& shape);

 private:
  template <class Made>
  struct Entry {
    std::shared_ptr<const void> of;
    std::shared_ptr<Made> made;
  };
  std::map<int, Entry<Triangles>> meshes_, heightmaps_;
  std::map<int, Entry<Hull>> hulls_;
};

/// A colliding shape.
struct Geom {
  int index = 0;              ///< among all geoms of the world
  int body = -1, shape = -1;  ///< SceneModel
  int material = 0;
  Pose X_BG;                             ///< the geom's own frame
  Vec3 surface_velocity = Vec3::Zero();  ///< in the holder's axes, or the world's [m/s]
  dGeomID id = nullptr;
  dBodyID holder = nullptr;  ///< nullptr: static
  std::shared_ptr<Triangles> triangles;
  std::shared_ptr<Hull> hull;
};

/// Makes geom.id, in `space`, and sets what belongs to it. Errors: a shape that ODE cannot hold.
Result<> make_geom(dSpaceID space, const SceneModel& model, const Shape& shape, ShapeData& data,
                   Geom& geom);

/// Places a geom that no ODE body carries.
void place_geom(const Geom& geom, ShapeType type, const Pose& X_WB);

}  // namespace cogrsim::ode

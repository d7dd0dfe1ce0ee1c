#include "geometry.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/geometry/hull_faces.h"
#include "cogrsim/geometry/triangles.h"
#include "library.h"

namespace cogrsim::ode {

namespace {

constexpr std::size_t kMostCorners = 32;

std::shared_ptr<Hull> hull_of(const HullFaces& faces) {
  auto out = std::make_shared<Hull>();
  // ODE wants the origin inside.
  out->middle = faces.middle();
  for (const Vec3& v : faces.vertices) {
    const Vec3 p = v - out->middle;
    out->points.insert(out->points.end(), p.data(), p.data() + 3);
  }
  for (std::size_t f = 0; f < faces.normals.size(); ++f) {
    std::vector<int> corners = faces.corners[f];
    // ODE looks at the first three corners of each face and prints a warning where rounding turns
    // them round: begin with the three that span most.
    const auto spans = [&](const int& first) {
      const auto at = [&](std::size_t i) {
        i += static_cast<std::size_t>(&first - corners.data());
        const auto corner = static_cast<std::size_t>(corners[i % corners.size()]);
        return Vec3(faces.vertices[corner] - out->middle);
      };
      return at(0).cross(at(1)).dot(at(2));
    };
    std::rotate(corners.begin(),
                std::max_element(corners.begin(), corners.end(),
                                 [&](const int& a, const int& b) { return spans(a) < spans(b); }),
                corners.end());
    double d = 0.0;
    for (const int c : corners)
      d = std::max(d, faces.normals[f].dot(faces.vertices[c] - out->middle));
    out->planes.insert(out->planes.end(), faces.normals[f].data(), faces.normals[f].data() + 3);
    out->planes.push_back(d);
    out->polygons.push_back(static_cast<unsigned>(corners.size()));
    for (const int c : corners) out->polygons.push_back(static_cast<unsigned>(c));
  }
  return out;
}

}  // namespace

static_assert(sizeof(dTriIndex) == sizeof(int) && sizeof(Vec3) == 3 * sizeof(double));

Triangles::Triangles(MeshPtr of) : mesh(std::move(of)), data(dGeomTriMeshDataCreate()) {
  dGeomTriMeshDataBuildDouble(data, mesh->vertices.data(), sizeof(Vec3),
                              static_cast<int>(mesh->vertices.size()), mesh->triangles.data(),
                              static_cast<int>(3 * mesh->triangles.size()), 3 * sizeof(dTriIndex));
  // Convex meshes are tested against triangles only with the angles between them.
  dGeomTriMeshDataPreprocess2(data, 1U << dTRIDATAPREPROCESS_BUILD_FACE_ANGLES, nullptr);
}

const std::shared_ptr<Triangles>& ShapeData::triangles(const SceneModel& model,
                                                       const Shape& shape) {
  const bool is_mesh = shape.type == ShapeType::mesh;
  auto& [of, made] = is_mesh ? meshes_[shape.mesh] : heightmaps_[shape.heightmap];
  std::shared_ptr<const void> wanted;
  is_mesh ? wanted = model.meshes[shape.mesh] : wanted = model.heightmaps[shape.heightmap];
  if (of == wanted) return made;
  made = std::make_shared<Triangles>(
      is_mesh ? model.meshes[shape.mesh]
              : std::make_shared<const TriangleMesh>(
                    geometry::triangles_of(*model.heightmaps[shape.heightmap])));
  of = std::move(wanted);
  return made;
}

Result<std::shared_ptr<Hull>> ShapeData::hull(const SceneModel& model, const Shape& shape) {
  auto& [of, made] = hulls_[shape.mesh];
  const MeshPtr& mesh = model.meshes[shape.mesh];
  if (of == mesh) return made;
  const HullFaces faces = hull_faces(*mesh, kMostCorners);
  if (faces.normals.empty()) {
    return fail("shape '" + shape.name + "': its mesh has no volume",
                source_position(model, shape.origin));
  }
  made = hull_of(faces);
  of = mesh;
  return made;
}

Result<> make_geom(dSpaceID space, const SceneModel& model, const Shape& shape, ShapeData& data,
                   Geom& geom) {
  geom.material = shape.material;
  geom.X_BG = shape.X_BS;
  switch (shape.type) {
    case ShapeType::box:
      geom.id = dCreateBox(space, shape.size.x(), shape.size.y(), shape.size.z());
      return {};
    case ShapeType::sphere:
      geom.id = dCreateSphere(space, shape.radius);
      return {};
    case ShapeType::cylinder:
      geom.id = dCreateCylinder(space, shape.radius, shape.length);
      return {};
    case ShapeType::capsule:
      geom.id = dCreateCapsule(space, shape.radius, shape.length);
      return {};
    case ShapeType::plane:
      geom.id = dCreatePlane(space, 0, 0, 1, 0);
      return {};
    case ShapeType::convex_mesh: {
      const auto hull = data.hull(model, shape);
      if (!hull) return tl::unexpected(hull.error());
      geom.hull = *hull;
      geom.X_BG = shape.X_BS * Pose(geom.hull->middle, Quat(1, 0, 0, 0));
      geom.id = dCreateConvex(
          space, geom.hull->planes.data(), static_cast<unsigned>(geom.hull->planes.size() / 4),
          geom.hull->points.data(), static_cast<unsigned>(geom.hull->points.size() / 3),
          geom.hull->polygons.data());
      return {};
    }
    case ShapeType::mesh:
    case ShapeType::heightmap:
      geom.triangles = data.triangles(model, shape);
      geom.id = dCreateTriMesh(space, geom.triangles->data, nullptr, nullptr, nullptr);
      return {};
  }
  return fail("shape '" + shape.name + "': of an unknown type",
              source_position(model, shape.origin));
}

void place_geom(const Geom& geom, ShapeType type, const Pose& X_WB) {
  const Pose X = X_WB * geom.X_BG;
  if (type == ShapeType::plane) {
    const Vec3 n = X.q * Vec3::UnitZ();
    dGeomPlaneSetParams(geom.id, n.x(), n.y(), n.z(), n.dot(X.p));
    return;
  }
  const dQuaternion q = {X.q.w(), X.q.x(), X.q.y(), X.q.z()};
  dGeomSetPosition(geom.id, X.p.x(), X.p.y(), X.p.z());
  dGeomSetQuaternion(geom.id, q);
}

}  // namespace cogrsim::ode

// A slow reference for ray casts: every surface of every shape, one by one, in long double. Tests
// and benchmarks compare rays with it.
#pragma once

#include <cstdint>
#include <vector>

#include "cogrsim/core/random.h"
#include "cogrsim/rays/ray_caster.h"

namespace cogrsim::reference {

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  int body = -1;
};

/// Shapes are selected as in RayCaster; meshes by the triangles of their file.
Hit cast(const SceneModel& model, const std::vector<Pose>& poses, const Ray& ray,
         RayTargets targets = RayTargets::visible);

/// Whether `distance` is right: within 1e-9 m of what cast() says, or, where a ray grazes an edge
/// or a surface so closely that the rounding of its own numbers decides, of what it says for a ray
/// moved by a few such roundings.
bool agrees(const SceneModel& model, const std::vector<Pose>& poses, const Ray& ray,
            double distance, RayTargets targets = RayTargets::visible);

/// `count` bodies of 0.2 to 1.5 m in a cube of half width `extent` around `middle`: boxes, spheres,
/// cylinders and capsules in turn, and with `meshes` rings and octahedrons too. All are turned at
/// random.
SceneModelPtr mixed_bodies(int count, double extent, const Vec3& middle, std::uint64_t seed,
                           bool meshes);

std::vector<Pose> poses_of(const SceneModel& model);

Vec3 random_direction(RandomStream& random);
Vec3 random_point(RandomStream& random, double extent);
Pose random_pose(RandomStream& random, double extent);

/// A ring (torus) of 16 x 8 quadrilaterals, cut into triangles.
TriangleMesh ring(double radius, double thickness);
TriangleMesh octahedron(double radius);

}  // namespace cogrsim::reference

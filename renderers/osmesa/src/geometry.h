// Triangles of shapes, before they go to the graphics library.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::osmesa {

/// A point of the shape is position * scale + (0, 0, end * half_length): so one capsule serves all
/// capsules.
struct Vertex {
  std::array<float, 3> position{};
  float end = 0.0F;  ///< -1, 0 or 1
  std::array<float, 3> normal{};
  std::array<float, 2> uv{};  ///< (0, 0) at the picture's top left, as it lies in memory
};

struct Triangles {
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  ///< counter-clockwise seen from outside
};

/// Segments around the circle for a curved shape whose circle has `radius_pixels` on the screen,
/// such that it lies within `tolerance` pixels of the true one.
int segments_for(double radius_pixels, double tolerance);

/// Untextured box, sphere, cylinder or capsule of unit size (box: edge 1; others: radius 1,
/// cylinder from z = -1 to 1). `segments` as above. The polygon has the area of its circle, so
/// silhouettes are as large as they should be.
Triangles unit_shape(ShapeType type, int segments);

/// Factors that bring a unit shape to size: x, y, z, half length.
std::array<float, 4> unit_scale(const Shape& shape);

/// Triangles of mesh (a convex one too is seen as its file has it) and heightmap in the shape's
/// frame [m], with smooth normals where faces meet at less than 30 degrees.
Triangles faces_of(const SceneModel& model, const Shape& shape);

/// Pairs of vertices between which the surface has a visible edge: where shading jumps from one
/// triangle to the next, and where a surface ends.
std::vector<std::uint32_t> edges_of(const Triangles& triangles);

/// The same geometry with texture coordinates by the rule of cogrsim/model/surface.h, scaled to the
/// shape's size; vertices are no longer shared, so that seams are right.
Triangles textured(const SceneModel& model, const Shape& shape, const Triangles& plain);

}  // namespace cogrsim::osmesa

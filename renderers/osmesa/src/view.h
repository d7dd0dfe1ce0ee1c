// A pinhole camera, or a tile of one, as the drawing code needs it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "cogrsim/rendering/renderer.h"

namespace cogrsim::osmesa {

/// Everything drawn is first put relative to the camera, in double, so that a scene kilometres from
/// the origin is as exact as any.
struct View {
  int width = 0, height = 0;  ///< [pixel]
  double fx = 0, fy = 0, cx = 0, cy = 0;
  double near = 0, far = 0;
  Vec3 origin = Vec3::Zero();  ///< of the camera, world [m]
  Mat3 R_WC = Mat3::Identity();
  Eigen::Matrix4d clip;                   ///< from (world axes, relative to origin) to clip space
  std::array<Eigen::Vector4d, 6> planes;  ///< clip_planes(clip)

  /// Ray through a pixel, world axes, one long along the camera's x.
  Vec3 ray(double column, double row) const;
};

/// Inward planes of the clip space: left, right, top, bottom, and both ends of the depth, normals
/// one long.
std::array<Eigen::Vector4d, 6> clip_planes(const Eigen::Matrix4d& clip);

/// `X_WC` etc. of `camera`, distortion left out.
View make_view(const Camera& camera);

/// The part of `view` from (column, row), `width` x `height`, with `across` x `down` pixels for
/// each.
View tile_of(const View& view, int column, int row, int width, int height, int across, int down);

/// Convex polygon (relative to the view's origin) cut to what the view sees.
std::vector<Vec3> cut(std::vector<Vec3> polygon, const View& view);

}  // namespace cogrsim::osmesa

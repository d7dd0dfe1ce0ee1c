// Lens distortion: a wider picture without any is drawn and bent.
#pragma once

#include <optional>

#include "cogrsim/rendering/renderer.h"

namespace cogrsim::osmesa {

bool has_distortion(const Camera& camera);

/// Where the point (X, Y) of the plane x = 1 lands, see Camera.
Eigen::Vector2d distort(const Camera& camera, const Eigen::Vector2d& point);

/// The point that lands on `bent`: the branch of the formula that begins at the middle, as far as
/// it rises. Empty where nothing lands.
std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& bent);

/// For each pixel of a camera, where in the straight picture it looks; one look-up table serves as
/// long as lens and size stay.
struct Bending {
  Camera lens;                          ///< whose table this is; pose, near and far do not matter
  Camera straight;                      ///< what to draw instead, no distortion
  std::vector<Eigen::Vector2f> pixels;  ///< (height x width) columns and rows; NaN: sees nothing
  bool serves(const Camera& camera) const;
};

/// Errors: the straight picture would be too large.
Result<Bending> make_bending(const Camera& camera);

/// Colour by the four pixels around, mixed in linear light; black where the lens does not reach.
Image bend_color(const Bending& bending, const Image& straight);

/// Depth and labels by the nearest pixel of `straight`, which is Bending::straight or a whole
/// number of times as large; infinitely far and no body where the lens does not reach.
void bend_data(const Bending& bending, const Picture& straight, Picture& out);

}  // namespace cogrsim::osmesa

// Scenes and cameras for the tests of pictures.
#pragma once

#include <cstdlib>
#include <functional>
#include <string>

#include "cogrsim/model/builder.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim::test {

/// The renderer under test, made once. Ends the program with the reason if there is none.
Renderer& renderer();

/// A frame with every body where the model has it.
Frame frame_of(const SceneModelPtr& model);

/// Looks from `eye` to `at`, z up.
Pose look(const Vec3& eye, const Vec3& at);
inline Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat(1, 0, 0, 0)}; }

/// A material of that colour.
int colored(ModelBuilder& builder, double r, double g, double b);

/// Colour, depth and segmentation over a plain black background.
RenderRequest request_of(const Camera& camera);

/// Fails the test if there is an error.
Picture take(const SceneModelPtr& model, const RenderRequest& request);

int count_body(const Picture& picture, int body);
/// 0 to 255 each.
struct Rgb {
  int r = 0, g = 0, b = 0;
};
/// Sum over the three of how far they are apart.
inline int difference(const Rgb& a, const Rgb& b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
}
Rgb pixel(const Picture& picture, int column, int row);
float depth_at(const Picture& picture, int column, int row);
int body_at(const Picture& picture, int column, int row);
/// Column and row (with fractions) of a point in the world, by the formulas of Camera.
Eigen::Vector2d project(const Camera& camera, const Vec3& point);

}  // namespace cogrsim::test

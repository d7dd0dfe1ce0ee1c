#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cogrsim/rendering/renderer.h"

namespace cogrsim {

namespace {

bool is_finite(const Pose& pose) { return pose.p.allFinite() && pose.q.coeffs().allFinite(); }

}  // namespace

Camera make_camera(const Pose& X_WC, int width, int height, double fov) {
  Camera camera;
  camera.X_WC = X_WC;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.5 * width / std::tan(0.5 * fov);
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  return camera;
}

Result<> check_camera(const Camera& camera) {
  if (camera.width < 1 || camera.height < 1) {
    return fail(fmt::format("picture of {} x {} pixels: width and height must be at least 1",
                            camera.width, camera.height));
  }
  const std::int64_t pixels = std::int64_t{camera.width} * camera.height;
  if (pixels > kMaxImagePixels) {
    return fail(fmt::format("picture of {} x {} pixels: {} pixels exceed the limit of {}",
                            camera.width, camera.height, pixels, kMaxImagePixels));
  }
  if (!is_finite(camera.X_WC)) return fail("the camera's pose is not finite");
  // Small deviations of the norm are accepted; an orientation that was never set is an error.
  const double norm = camera.X_WC.q.norm();
  if (std::abs(norm - 1.0) > 1e-3) {
    return fail(fmt::format("the camera's orientation has length {:g}, expected 1", norm));
  }
  const std::pair<const char*, double> lengths[] = {{"fx", camera.fx}, {"fy", camera.fy}};
  for (const auto& [name, value] : lengths) {
    if (!std::isfinite(value) || value <= 0.0) {
      return fail(fmt::format("focal length {} = {:g} pixels, expected more than 0", name, value),
                  "", "a horizontal field of view lies between 0 and 180 degrees, ends excluded");
    }
  }
  const std::pair<const char*, double> points[] = {{"cx", camera.cx}, {"cy", camera.cy}};
  for (const auto& [name, value] : points) {
    if (!std::isfinite(value)) return fail(fmt::format("principal point {} is not finite", name));
  }
  const auto finite = [](double k) { return std::isfinite(k); };
  if (!std::all_of(camera.distortion.begin(), camera.distortion.end(), finite)) {
    return fail("a distortion coefficient is not finite");
  }
  if (!std::isfinite(camera.near) || !std::isfinite(camera.far) || camera.near <= 0.0 ||
      camera.near >= camera.far) {
    return fail(fmt::format("near {:g} m and far {:g} m: expected 0 < near < far, both finite",
                            camera.near, camera.far));
  }
  return {};
}

}  // namespace cogrsim

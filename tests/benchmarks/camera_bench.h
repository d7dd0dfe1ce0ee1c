// The same scene before two renderers.
#pragma once

#include <memory>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::bench {

/// `shapes` mixed boxes, spheres, cylinders and capsules over a floor, under one sun.
struct CameraScene {
  int width = 0, height = 0;  ///< [pixel]
  int shapes = 0;
  bool shadows = false;
  int samples = 1;  ///< per pixel; 1: no anti-aliasing
};

inline constexpr int kShadowMapSize = 1024;    ///< of both
inline constexpr double kVerticalField = 0.8;  ///< [rad]
Pose viewpoint();                              ///< of the camera, looking along x, z up
Vec3 place_of(int shape, int shapes);          ///< middle, at time 0 [m]
double height_at(int shape, int frame);        ///< by how much it is lifted in a frame [m]

/// Takes pictures one after the other; everything moves from one to the next.
class CameraRunner {
 public:
  virtual ~CameraRunner() = default;
  virtual void take(int frame) = 0;
  /// RGB of the last picture.
  virtual std::vector<std::uint8_t> picture() const = 0;
};

std::unique_ptr<CameraRunner> make_mujoco_camera(const CameraScene& scene);

}  // namespace cogrsim::bench

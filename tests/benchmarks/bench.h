// The same scenes, twice: as a scene model for a backend, and as a program on the bare engine.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::bench {

inline constexpr double kStep = 1e-3;  // [s]

enum class Scene { free_boxes, pyramid, robots, chain };
inline constexpr Scene kScenes[] = {Scene::free_boxes, Scene::pyramid, Scene::robots, Scene::chain};

/// "200 free boxes", ….
const char* title(Scene scene);

/// Numbers both sides share. SI units.
namespace boxes {
inline constexpr int kCount = 200, kPerRow = 15;
inline constexpr double kSize = 0.2, kMass = 1.0, kPitch = 1.0, kSpin = 3.0;
}  // namespace boxes

namespace pyramid {
inline constexpr int kBase = 20;
inline constexpr double kSize = 0.5, kMass = 1.0, kFriction = 0.6, kPitch = 0.55;
/// Centres of all 210 boxes, from the ground up.
std::vector<Vec3> centres();
}  // namespace pyramid

namespace robots {
inline constexpr int kPerSide = 10;
inline constexpr double kSpacing = 1.0, kFriction = 0.8;
inline constexpr double kChassisX = 0.24, kChassisY = 0.14, kChassisZ = 0.04, kChassisMass = 1.2;
inline constexpr double kHeight = 0.05;  // of the chassis' centre
inline constexpr double kWheelRadius = 0.04, kWheelWidth = 0.02, kWheelMass = 0.15;
inline constexpr double kAxleX = 0.05, kHalfTrack = 0.082;
inline constexpr double kCasterX = -0.09, kCasterRadius = 0.02;
inline constexpr double kLeftSpeed = 5.0, kRightSpeed = 4.0, kMaxTorque = 0.6;
}  // namespace robots

namespace chain {
inline constexpr int kLinks = 30;
inline constexpr double kLength = 0.2, kWidth = 0.04, kMass = 1.0, kTilt = 1.0;  // tilt [rad]
}  // namespace chain

/// The scene for a backend.
SceneModelPtr model(Scene scene);

/// One side of a comparison.
class Runner {
 public:
  virtual ~Runner() = default;
  virtual void step() = 0;
  /// Height of the last body's origin [m]: shows that both sides simulate the same thing.
  virtual double last_height() = 0;
};

/// Programs on the bare engines, each the way its manual would do it.
std::unique_ptr<Runner> make_raw_bullet(Scene scene);
std::unique_ptr<Runner> make_raw_simbody(Scene scene);

}  // namespace cogrsim::bench

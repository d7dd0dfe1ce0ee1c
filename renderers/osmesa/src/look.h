// How pictures for people are lit, here and in the studio's page, which has the same numbers in
// apps/studio/web/src/view3d/look.ts, where each is explained; its unit tests compare the two.
// Colours and shares are of linear light.
#pragma once

#include "cogrsim/core/types.h"

namespace cogrsim::osmesa {

inline constexpr double kLightShare = 0.8;
inline const Vec3 kKey(-0.7, 0.3, -1.0);
inline const Vec3 kFill(0.05, -0.9, -0.5);
inline constexpr double kFillShare = 0.16;
inline const Vec3 kSkyLight(0.265, 0.29, 0.325);
inline const Vec3 kGroundLight(0.115, 0.1, 0.085);
inline const Vec3 kAmbientToward(0.01, -0.05, 0.09);
inline constexpr double kLampRange = 6.0;
inline constexpr double kSpotEdge = 0.85;
inline constexpr double kKnee = 0.7;
inline constexpr double kContact = 0.55;
inline constexpr double kContactReach = 0.7;
inline constexpr double kContactBlur = 0.16;
// The sky as it is encoded in sRGB.
inline const Vec3 kZenith(0.36, 0.56, 0.8);
inline const Vec3 kHorizon(0.86, 0.91, 0.96);
inline const Vec3 kNadir(0.62, 0.63, 0.64);

}  // namespace cogrsim::osmesa

// Viewpoints that show the whole scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cogrsim/rendering/renderer.h"

namespace cogrsim {

/// front: from +x, looking along -x; back: from -x; left: from +y; right: from -y; top, bottom:
/// from +z and -z, y up in the picture; iso: from the front left, above.
enum class StandardView { front, back, left, right, top, bottom, iso };

/// "front", "back", …
COGRSIM_API const char* to_string(StandardView view);
/// All of them, as text.
COGRSIM_API std::vector<std::string> standard_view_names();
COGRSIM_API std::optional<StandardView> standard_view(const std::string& name);

/// A box that encloses bodies, world [m].
struct Bounds {
  Vec3 low = Vec3::Constant(-1.0), high = Vec3::Constant(1.0);
};

/// What encloses all visible shapes of the frame but planes. Without any: 2 m around the origin.
COGRSIM_API Bounds visible_bounds(const Frame& frame);
/// Encloses both.
COGRSIM_API Bounds joined(const Bounds& a, const Bounds& b);

/// A camera that looks in the view's direction at the middle of `bounds`, from as near as shows all
/// of it with a margin of 5 %. `fov` horizontal [rad].
COGRSIM_API Camera standard_camera(StandardView view, const Bounds& bounds, int width, int height,
                                   double fov = 0.8);

/// Where a `<view>` is: one on a body goes where the body goes, as the named frame on that body which
/// has the view's name; once the body is gone it is where it was at the start.
COGRSIM_API Pose view_pose(const Frame& frame, const ViewModel& view);

}  // namespace cogrsim

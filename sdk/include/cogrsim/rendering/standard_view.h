// Viewpoints that show the whole scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cogrsim/geometry/bounds.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim {

/// Standard viewing directions. front: from +x along -x; back: from -x; left: from +y; right: from
/// -y; top and bottom: from +z and -z, with y up in the image; iso: obliquely from above on the
/// front left.
enum class StandardView { front, back, left, right, top, bottom, iso };

/// "front", "back", …
COGRSIM_API const char* to_string(StandardView view);
/// The names of all standard views.
COGRSIM_API std::vector<std::string> standard_view_names();
/// The standard view with this name; nullopt: unknown.
COGRSIM_API std::optional<StandardView> standard_view(const std::string& name);

/// Bounding box of all visible shapes of the frame except planes, in the world [m]. Without shapes:
/// from -1 m to 1 m.
COGRSIM_API geometry::Bounds visible_bounds(const Frame& frame);
/// The same of one body; empty if it is removed or has no such shape.
COGRSIM_API geometry::Bounds visible_bounds(const Frame& frame, std::size_t body);

/// A camera in the direction of the view that shows the whole of `bounds` with a margin of 5 %.
/// `fov` is the horizontal field of view [rad].
COGRSIM_API Camera standard_camera(StandardView view, const geometry::Bounds& bounds, int width,
                                   int height, double fov = 0.8);

/// Pose of a `<view>` in the world. A view on a body moves with it (the body has a named frame with
/// the name of the view); if the body has been removed, the view has its initial pose.
COGRSIM_API Pose view_pose(const Frame& frame, const ViewModel& view);

}  // namespace cogrsim

// Depth and segmentation as pictures people and programs can read.
#pragma once

#include <initializer_list>
#include <string>

#include "cogrsim/core/output_file.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim::cli {

/// Default size of a view [pixel].
inline constexpr int kViewWidth = 960, kViewHeight = 720;

/// Sixteen-bit grey PNG of depth in millimetres, 1 to 65535 (65.535 m and beyond); 0: background.
Result<std::string> depth_png(const Picture& picture);

/// A colour for every body, the same in every picture of the scene; background black.
Result<std::string> segmentation_png(const Picture& picture);
/// "#1f77b4  123 pixels  robot.chassis", one line for every body in the picture.
std::string segmentation_legend(const SceneModel& model, const Picture& picture);

/// Whether a name ends so, in upper or lower case.
bool has_ending(const std::string& name, std::initializer_list<const char*> endings);
/// The kind of picture or film by its file name.
OutputKind kind_of_picture(const std::string& name);

}  // namespace cogrsim::cli

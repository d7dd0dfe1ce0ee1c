// Lines and labels over the scene.
#pragma once

#include <vector>

#include "view.h"

namespace cogrsim::osmesa {

/// Corner of a line's two triangles.
struct OverlayVertex {
  float clip[4];
  float color[4];  ///< linear light, and opacity
};

/// Triangles of all lines that are (not) on top; `pixels` is how many of the view's pixels make one
/// of the picture's, across and down.
std::vector<OverlayVertex> line_triangles(const std::vector<OverlayLine>& lines, bool on_top,
                                          const View& view, int across, int down);

/// Writes the labels whose positions are before the scene's `depth` (height x width) [m].
void write_labels(const std::vector<OverlayLabel>& labels, const Camera& camera,
                  const std::vector<float>& depth, Image& picture);

/// Text that is no UTF-8 has its wrong bytes replaced by U+FFFD.
std::string valid_utf8(const std::string& text);

}  // namespace cogrsim::osmesa

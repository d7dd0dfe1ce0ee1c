// Maps: drawings of a frame seen from above.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/core/result.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/sensing/sensor_rays.h"

namespace cogrsim {

/// The path of an object.
struct MapTrail {
  std::string label;         ///< in the legend; empty: none
  std::vector<Vec3> points;  ///< world [m], in the order of time; a non-finite point is a gap
  Color color{0.85, 0.15, 0.1, 1};
};

/// A frame of another run of the scene, whose moving bodies are drawn as outlines over the map.
struct MapGhost {
  FramePtr frame;
  Color color{0.8, 0.3, 0.05, 1};
};

/// The area of a map in world coordinates [m].
struct MapArea {
  double x_min = -1, y_min = -1, x_max = 1, y_max = 1;
};

/// Options of a map.
struct MapOptions {
  int width = 900;              ///< of the drawing [pixel], 64 to 8000
  std::optional<MapArea> area;  ///< empty: all shapes except planes, see map_area()
  std::string title;
  bool names = true;  ///< draw names of assemblies and single bodies where they fit
  bool grid = true;
  std::vector<MapTrail> trails;  ///< dashed
  std::vector<MapGhost> ghosts;
  /// Lines; those of a lidar are one pale fan at its height, under the shapes that are higher.
  std::vector<SensorRay> rays;
};

/// The area that contains all bodies of the frame (except planes) and the trails, with a margin of
/// 5 %. For a scene with only planes it is 2 m by 2 m around the origin.
COGRSIM_API MapArea map_area(const Frame& frame, const std::vector<MapTrail>& trails = {});
/// The smallest area that contains two areas.
COGRSIM_API MapArea joined(const MapArea& a, const MapArea& b);

/// Outline of a shape seen from above: closed polygons in world coordinates x, y [m] whose union is
/// the vertical projection of the shape. A plane has none. Round outlines are exact to 0.05 % of
/// their size.
COGRSIM_API std::vector<std::vector<Eigen::Vector2d>> plan_outline(const SceneModel& model,
                                                                   const Shape& shape,
                                                                   const Pose& X_WB);

/// Draws a frame in the format with the extension `ending` (".svg", ".png" or ".pdf") and returns
/// the bytes of the file. Higher shapes hide lower ones; shapes have the colours of their
/// materials. The drawing has a scale bar. Errors: another extension, a width out of range, or an
/// empty area.
COGRSIM_API Result<std::string> map_picture(const Frame& frame, const MapOptions& options,
                                            const std::string& ending);
/// Draws a frame to a file in the format of its extension. Errors: as map_picture(), or those of
/// write_output_file().
COGRSIM_API Result<> draw_map(const Frame& frame, const MapOptions& options,
                              const std::string& path, const OutputRules& rules = {});

}  // namespace cogrsim

// The plan view: the scene from above, as a drawing. It shows the same frames as the 3D pictures.
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

/// Where something has been.
struct MapTrail {
  std::string label;         ///< for the legend; empty: none
  std::vector<Vec3> points;  ///< world [m], in order of time; a point that is not finite is a gap
  Color color{0.85, 0.15, 0.1, 1};
};

/// Another frame, whose moving bodies are drawn as outlines over the map: another run of the scene.
struct MapGhost {
  FramePtr frame;
  Color color{0.8, 0.3, 0.05, 1};
};

/// Corners of what the map shows, world [m].
struct MapArea {
  double x_min = -1, y_min = -1, x_max = 1, y_max = 1;
};

struct MapOptions {
  int width = 900;              ///< of the drawing [pixel], 64 to 8000
  std::optional<MapArea> area;  ///< empty: everything but planes, see map_area()
  std::string title;
  bool names = true;  ///< of bodies that stand alone and of assemblies; where there is room
  bool grid = true;
  std::vector<MapTrail> trails;  ///< dashed
  std::vector<MapGhost> ghosts;
  std::vector<SensorRay> rays;  ///< red
};

/// What encloses all bodies of the frame (planes aside) and the trails, with a margin of 5 %.
/// A scene of nothing but planes gives 2 m by 2 m around the origin.
COGRSIM_API MapArea map_area(const Frame& frame, const std::vector<MapTrail>& trails = {});
/// Encloses both.
COGRSIM_API MapArea joined(const MapArea& a, const MapArea& b);

/// Outline of a shape from above in world coordinates [m] (2 x n each): closed polygons whose union
/// is its shadow on the ground at noon. A plane has none. Round outlines lie within 0.05 % of the
/// true ones.
COGRSIM_API std::vector<std::vector<Eigen::Vector2d>> plan_outline(const SceneModel& model,
                                                                   const Shape& shape,
                                                                   const Pose& X_WB);

/// Draws the frame; `ending` says how: ".svg", ".png" or ".pdf". Returns the file's bytes. Shapes
/// lie over each other as seen from above, in their materials' colours. With a scale bar.
/// Errors: another ending, a width out of range, an area that is empty.
COGRSIM_API Result<std::string> map_picture(const Frame& frame, const MapOptions& options,
                                            const std::string& ending);
/// The same to a file, by its ending. Errors also: write_output_file()'s.
COGRSIM_API Result<> draw_map(const Frame& frame, const MapOptions& options,
                              const std::string& path, const OutputRules& rules = {});

}  // namespace cogrsim

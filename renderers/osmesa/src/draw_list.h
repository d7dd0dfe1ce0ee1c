// What a view sees of the items, put in order for few draw calls.
#pragma once

#include <functional>
#include <vector>

#include "gl_objects.h"
#include "scene_items.h"
#include "view.h"

namespace cogrsim::osmesa {

/// As the shaders' instance attributes have it.
struct Instance {
  float rows[3][4];  ///< from the shape to (world axes, relative to the view's origin)
  float scale[4];
  float color[4];
  float body;
};

struct Batch {
  const Geometry* geometry = nullptr;
  const Texture* texture = nullptr;  ///< nullptr: none
  bool cull = false;                 ///< its back cannot be seen
  bool transparent = false;
  bool floor = false;
  std::size_t first = 0, count = 0;  ///< instances
};

struct DrawList {
  std::vector<Instance> instances;
  std::vector<Batch> batches;  ///< opaque first, then transparent ones from far to near
};

/// Finds an item's geometry for the number of segments.
using GeometryFinder = std::function<const Geometry&(std::size_t item, int segments)>;
using TextureFinder = std::function<const Texture*(std::size_t item)>;

struct DrawOptions {
  double pixel_tolerance = 0.1;     ///< of silhouettes [pixel]
  double relative_tolerance = 1.0;  ///< of depth, per distance
  int segments = 0;                 ///< of everything round; 0: by the two above
  bool opaque_only = false;
  const std::vector<int>* hidden_bodies = nullptr;  ///< sorted
};

/// All but planes.
DrawList list_items(const std::vector<Item>& items, const std::vector<Placement>& placements,
                    const View& view, const DrawOptions& options, const GeometryFinder& geometry,
                    const TextureFinder& texture);

/// One instance; `origin` is subtracted from its position.
Instance make_instance(const Item& item, const Placement& placement, const Vec3& origin);

}  // namespace cogrsim::osmesa

#include "draw_list.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cogrsim::osmesa {

namespace {

struct Seen {
  const Geometry* geometry;
  const Texture* texture;
  bool cull, transparent;
  double distance;  // squared, of its middle
  std::size_t item;

  auto key() const { return std::make_tuple(transparent, geometry, texture, cull); }
  bool operator<(const Seen& other) const {
    // What is near hides what is far, so it comes first; glass must be drawn over what is behind.
    if (transparent && other.transparent) return distance > other.distance;
    return std::make_tuple(key(), distance) < std::make_tuple(other.key(), other.distance);
  }
};

bool is_visible(const Vec3& middle, double radius, const View& view) {
  return std::all_of(view.planes.begin(), view.planes.end(), [&](const Eigen::Vector4d& plane) {
    return plane.head<3>().dot(middle) + plane.w() >= -radius;
  });
}

}  // namespace

Instance make_instance(const Item& item, const Placement& placement, const Vec3& origin) {
  Instance out;
  const Vec3 p = placement.p_WS - origin;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.rows[i][j] = static_cast<float>(placement.R_WS(i, j));
    out.rows[i][3] = static_cast<float>(p[i]);
  }
  std::copy(item.scale.begin(), item.scale.end(), out.scale);
  std::copy(item.color.begin(), item.color.end(), out.color);
  out.body = static_cast<float>(item.body);
  return out;
}

DrawList list_items(const std::vector<Item>& items, const std::vector<Placement>& placements,
                    const View& view, const DrawOptions& options, const GeometryFinder& geometry,
                    const TextureFinder& texture) {
  std::vector<Seen> seen;
  seen.reserve(items.size());
  // Nothing of the near plane's rectangle is farther off than this.
  double near_radius = 0.0;
  for (const double column : {0.0, double(view.width)}) {
    for (const double row : {0.0, double(view.height)}) {
      near_radius = std::max(near_radius, view.near * view.ray(column, row).norm());
    }
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Item& item = items[i];
    if (item.type == ShapeType::plane || (options.opaque_only && item.color[3] < 1.0F)) continue;
    if (options.hidden_bodies != nullptr &&
        std::binary_search(options.hidden_bodies->begin(), options.hidden_bodies->end(),
                           item.body)) {
      continue;
    }
    const Vec3 middle = placements[i].middle - view.origin;
    if (!is_visible(middle, item.bounding_radius, view)) continue;
    Seen entry;
    entry.item = i;
    entry.distance = middle.squaredNorm();
    const double distance = std::sqrt(entry.distance);
    int segments = 0;
    if (item.curve > 0.0 && options.segments > 0) {
      segments = options.segments;
    } else if (item.curve > 0.0) {
      const double nearest = std::max(distance - item.bounding_radius, view.near);
      segments =
          segments_for(item.curve / nearest * std::max(view.fx, view.fy), options.pixel_tolerance);
      if (options.relative_tolerance < 1.0) {
        segments =
            std::max(segments, segments_for(item.curve / nearest, options.relative_tolerance));
      }
    }
    entry.geometry = &geometry(i, segments);
    entry.texture = texture ? texture(i) : nullptr;
    entry.transparent = item.color[3] < 1.0F;
    // From inside, or where the near plane cuts it open, the back is what one sees.
    entry.cull = item.closed() && distance > item.bounding_radius + near_radius;
    seen.push_back(entry);
  }
  std::sort(seen.begin(), seen.end());
  DrawList out;
  out.instances.reserve(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (i == 0 || seen[i].key() != seen[i - 1].key()) {
      out.batches.push_back(
          {seen[i].geometry, seen[i].texture, seen[i].cull, seen[i].transparent, false, i, 0});
    }
    ++out.batches.back().count;
    const std::size_t item = seen[i].item;
    out.instances.push_back(make_instance(items[item], placements[item], view.origin));
  }
  return out;
}

}  // namespace cogrsim::osmesa

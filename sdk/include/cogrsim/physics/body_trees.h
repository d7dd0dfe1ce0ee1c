// The trees in which joints hold bodies, for engines whose coordinates are those of joints. For
// backends; header only.
#pragma once

#include <cstddef>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// By body.
struct BodyTrees {
  std::vector<int> joint;   ///< that holds it; -1: it flies, stands, or is removed
  std::vector<int> parent;  ///< the body to which that joint joins it; kWorld
  std::vector<std::vector<int>> children;
};

/// Grows trees from the world, then from static and kinematic bodies, then from the first body of
/// what hangs on neither. `left_out(j)` says of which joints besides loops no tree is made.
template <class LeftOut>
BodyTrees grow_body_trees(const SceneModel& scene, const LeftOut& left_out) {
  const std::size_t count = scene.bodies.size();
  const auto at = [&](int b) { return b == kWorld ? count : static_cast<std::size_t>(b); };
  std::vector<std::vector<int>> joints(count + 1);  // by body; the world is the last
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& it = scene.joints[j];
    if (it.removed || it.closes_loop || it.type == JointType::free || left_out(j)) continue;
    joints[at(it.parent)].push_back(static_cast<int>(j));
    joints[at(it.child)].push_back(static_cast<int>(j));
  }
  BodyTrees out;
  out.joint.assign(count, -1);
  out.parent.assign(count, kWorld);
  out.children.resize(count);
  std::vector<char> reached(count + 1);
  const auto spread = [&](int root) {
    reached[at(root)] = 1;
    std::vector<int> rim = {root};
    while (!rim.empty()) {
      const int from = rim.back();
      rim.pop_back();
      for (const int j : joints[at(from)]) {
        const Joint& it = scene.joints[static_cast<std::size_t>(j)];
        const int to = it.parent == from ? it.child : it.parent;
        if (reached[at(to)]) continue;
        reached[at(to)] = 1;
        out.joint[at(to)] = j;
        out.parent[at(to)] = from;
        rim.push_back(to);
      }
    }
  };
  const auto is_ground = [](const Body& b) { return b.kind != BodyKind::dynamic; };
  reached[count] = 1;
  for (std::size_t b = 0; b < count; ++b)
    reached[b] = scene.bodies[b].removed || is_ground(scene.bodies[b]);
  spread(kWorld);
  for (std::size_t b = 0; b < count; ++b)
    if (!scene.bodies[b].removed && is_ground(scene.bodies[b])) spread(static_cast<int>(b));
  for (std::size_t b = 0; b < count; ++b)
    if (!reached[b]) spread(static_cast<int>(b));
  for (std::size_t b = 0; b < count; ++b)
    if (out.joint[b] >= 0 && out.parent[b] != kWorld)
      out.children[at(out.parent[b])].push_back(static_cast<int>(b));
  return out;
}

}  // namespace cogrsim

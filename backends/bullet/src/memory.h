// What Bullet keeps from step to step, as plain numbers that any world of the scene can take up.
#pragma once

#include <vector>

#include <BulletCollision/NarrowPhaseCollision/btManifoldPoint.h>

#include "engine.h"

namespace cogrsim::bullet {

struct Memory {
  /// Of one collision object in the broadphase.
  struct Proxy {
    int stage = 0;
    btVector3 low, high, volume_low, volume_high;
    btTransform detected;  ///< where it was when contacts were last looked for
  };
  /// Two bodies whose boxes overlap; `manifolds` are those of their collision algorithm.
  struct Pair {
    int a = -1, b = -1;
    bool looked_at = false;
    std::vector<std::vector<btManifoldPoint>> manifolds;
  };
  SceneModelPtr model;
  std::vector<Motion> now, before;
  std::vector<Pose> places;  ///< by body
  std::vector<std::vector<double>> trees, trees_before;
  std::vector<double> positions;
  std::vector<Proxy> proxies;                       ///< by body
  std::vector<Pair> pairs;                          ///< in Bullet's order
  std::vector<std::pair<int, int>> manifold_order;  ///< pair, number in it
  int broadphase[9] = {};
};

}  // namespace cogrsim::bullet

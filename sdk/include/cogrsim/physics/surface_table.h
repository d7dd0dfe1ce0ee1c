// Friction, restitution and stiffness of all pairs of materials. For backends; header only.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// surface_pair() of the materials of a scene, found once for each pair unless there are too many.
class SurfaceTable {
 public:
  explicit SurfaceTable(const SceneModelPtr& model)
      : model_(model), count_(model->materials.size()) {
    for (std::size_t a = 0; a < count_ && count_ <= kMost; ++a)
      for (std::size_t b = 0; b < count_; ++b)
        pairs_.push_back(surface_pair(*model, static_cast<int>(a), static_cast<int>(b)));
  }
  SurfacePair operator()(int a, int b) const {
    if (pairs_.empty()) return surface_pair(*model_, a, b);
    return pairs_[static_cast<std::size_t>(a) * count_ + static_cast<std::size_t>(b)];
  }

 private:
  static constexpr std::size_t kMost = 256;  // materials
  SceneModelPtr model_;
  std::size_t count_ = 0;
  std::vector<SurfacePair> pairs_;  // (count x count)
};

}  // namespace cogrsim

// Between the SDK and DART.
#pragma once

#include <dart/dynamics/BodyNode.hpp>

#include "cogrsim/core/types.h"

namespace cogrsim::dart_engine {

inline Eigen::Isometry3d to_dart(const Pose& X) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = X.q.toRotationMatrix();
  out.translation() = X.p;
  return out;
}

inline Pose from_dart(const Eigen::Isometry3d& X) {
  return {X.translation(), Quat(X.linear()).normalized()};
}

}  // namespace cogrsim::dart_engine

// Where the robots of a run have been.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/map/map.h"

namespace cogrsim::cli {

/// Collects the paths of bodies from frames, for maps.
class Trails {
 public:
  /// Bodies and assemblies by name; empty: every top-level assembly that has a controller or a
  /// motor. Errors: a name that is not there, with the nearest one.
  static Result<Trails> of(const SceneModel& model, const std::vector<std::string>& names);

  void add(const Frame& frame);
  const std::vector<MapTrail>& trails() const { return trails_; }

 private:
  std::vector<std::string> bodies_;  // by name: indices stay, but bodies may come back
  std::vector<MapTrail> trails_;
};

}  // namespace cogrsim::cli

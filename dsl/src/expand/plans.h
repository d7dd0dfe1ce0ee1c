// Elements that expansion turns into several others: stored until the model exists.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl {

struct Element;

/// A `<door>`, or the doors of one letter in a maze: an assembly of a leaf, a slider and a motor.
struct DoorPlan {
  const Element* element = nullptr;
  const Element* leaf = nullptr;
  const Element* motor = nullptr;
  double travel = 0.0;  ///< [m] > 0
  bool starts_open = false;
  bool force_given = false;            ///< else its motor is as strong as its leaf needs
  std::vector<const Element*> passes;  ///< bodies that it slides into
  bool passes_ground = false;          ///< and everything static
};

struct MazePlan {
  const Element* element = nullptr;
  MazeModel plan;          ///< its doors count within `doors`
  std::vector<int> doors;  ///< CompileContext::doors
};

/// Objects of one iteration of a `<scatter>`: they keep their relative poses.
struct ScatterGroup {
  std::vector<const Element*> members;
};
struct ScatterPlan {
  const Element* element = nullptr;
  std::vector<ScatterGroup> groups;
};

}  // namespace cogrsim::dsl

// Where bodies will be when forces on them are evaluated.
#pragma once

#include <string_view>
#include <vector>

#include "cogrsim/core/types.h"

namespace cogrsim {

/// Extension "cogrsim.state_ahead/1" of worlds with ExternalForces, see World::extension(). Without it bodies are taken to
/// go on as they move now.
class StateAhead {
 public:
  static constexpr std::string_view kId = "cogrsim.state_ahead/1";
  virtual ~StateAhead() = default;
  /// Where the bodies will be `ahead` [s] from now, at ExternalForces::evaluation_time() of the next step, and how they will
  /// move, to second order, as far as can be told without the forces of that step. One entry per body, as in WorldState;
  /// those of bodies that stand stay as they are. Between steps, on their thread.
  virtual void get_state_ahead(double ahead, std::vector<Pose>& poses,
                               std::vector<Twist>& twists) = 0;
};

}  // namespace cogrsim

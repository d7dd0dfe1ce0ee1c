// A model in MJCF or URDF that MuJoCo runs from its file, beside its import on the mujoco backend.
#pragma once

#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::test {

struct OriginalRun {
  double apart = 0.0;    ///< largest difference of a joint's coordinate in any step [rad] or [m]
  std::string furthest;  ///< the joint that has it
  double base_apart =
      0.0;  ///< of the floating bases' positions [m] and entries of rotation matrices
  int steps = 0, joints = 0;
  int missing = 0;   ///< joints of the file with one axis that the import does not have
  int touching = 0;  ///< most contacts in a step
};

/// Runs the file at `path` for `seconds` in steps of its own, from its keyframe `keyframe` (empty:
/// its reference pose) with the controls of that, in MuJoCo and as an import, with the same options
/// of the solver; a URDF with its root held, within its limits, and without drives. Errors: MuJoCo cannot read the file; what the import, the compiler or the backend
/// say.
Result<OriginalRun> run_beside_original(const std::string& path, const std::string& keyframe,
                                        double seconds);

}  // namespace cogrsim::test

// contact="simbody": contact as Simbody has it, between the shapes that its trackers know.
#pragma once

#include <vector>

#include "mechanism.h"

#include "cogrsim/physics/state.h"

namespace cogrsim::simbody {

class TrackerContact {
 public:
  /// To be made before Mechanism::realize_topology(). Throws std::runtime_error for a pair of shapes
  /// that could meet and that no tracker knows: Simbody would let them through in silence.
  TrackerContact(Mechanism& mechanism, const Options& options);

  /// What touches, with the forces now.
  void read(const SimTK::State& state, std::vector<Contact>& out) const;

 private:
  struct Surface {
    int body = -1, shape = -1;  ///< SceneModel::bodies, Body::shapes
    SimTK::MobilizedBodyIndex mobod;
    int ordinal = 0;  ///< of the body's surfaces
    SimTK::ContactGeometryTypeId type;
  };
  void add(Mechanism& mechanism, const Options& options, int body, int shape);

  const Mechanism& mechanism_;
  SimTK::ContactTrackerSubsystem tracker_;
  SimTK::CompliantContactSubsystem contact_;
  std::vector<Surface> surfaces_;
};

}  // namespace cogrsim::simbody

// The features of scenes that a backend supports, checked before a run.
#pragma once

#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

enum class Support { unsupported, approximate, exact };

/// "exact", "approximate", "unsupported".
COGRSIM_API const char* to_string(Support support);

/// Support of one feature.
struct Capability {
  Support support = Support::unsupported;
  std::string note;  ///< the reason or the approximation; required unless exact
};

/// Table of the supported features by id. The ids are:
///   shape.TYPE                 box sphere cylinder capsule plane convex-mesh mesh heightmap
///   pair.TYPE-TYPE             two colliding shapes; the types in the order above
///   joint.TYPE                 hinge slider …
///   joint.limit.TYPE  joint.damping.TYPE  joint.friction.TYPE  joint.stiffness.TYPE
///   joint.rotor-inertia.TYPE
///   joint.coupling             joints with coupled coordinates
///   joint.coupling-effort      a limit of the effort of a coupling
///   loop.TYPE                  a joint that closes a loop
///   motor.MODE                 velocity torque position servo dc
///   body.force                 forces and torques given for each step, see ExternalForces
///   body.static  body.kinematic  body.gravity-scale
///   contact.stiffness  contact.rolling-friction  contact.spinning-friction
///   contact.surface-velocity   a surface that moves along itself, as of a conveyor belt
///   runtime.add  runtime.remove  runtime.save  runtime.set_state
///   runtime.attach  runtime.body_kind  runtime.joint_axes
///   report.contact_force  report.joint_reaction  report.joint_effort
class COGRSIM_API Capabilities {
 public:
  void set(const std::string& feature, Support support, std::string note = {});
  void set_all(std::initializer_list<const char*> features, Support support,
               const std::string& note = {}) {
    for (const char* feature : features) set(feature, support, note);
  }
  /// The entry of a feature; if it was never set, unsupported with the note "not known to this
  /// backend".
  Capability get(const std::string& feature) const;
  const std::map<std::string, Capability>& all() const { return features_; }

 private:
  std::map<std::string, Capability> features_;
};

/// Id of a shape pair such as "pair.box-mesh", for the types in either order.
COGRSIM_API std::string pair_feature(ShapeType a, ShapeType b);

/// Compares the features that a scene needs with those of a backend. An unsupported feature is an
/// error (CG0801) and an approximate one a warning (CG2008), with the source location of the first
/// element that needs it; each feature is reported once. The pairs of shapes are those that can
/// collide: a mobile one with any other that the collision filter admits.
COGRSIM_API std::vector<Diagnostic> check_capabilities(const SceneModel& model,
                                                       const std::string& backend,
                                                       const Capabilities& capabilities);

}  // namespace cogrsim

// What an engine can do, asked before anything runs.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

enum class Support { unsupported, approximate, exact };

/// "exact", "approximate", "unsupported".
COGRSIM_API const char* to_string(Support support);

struct Capability {
  Support support = Support::unsupported;
  std::string note;  ///< why or how; required unless exact
};

/// Features by id. Ids:
///   shape.TYPE                 box sphere cylinder capsule plane convex-mesh mesh heightmap
///   pair.TYPE-TYPE             two collision shapes; the types in the order above
///   joint.TYPE                 hinge slider …
///   joint.limit.TYPE  joint.damping.TYPE  joint.friction.TYPE  joint.stiffness.TYPE
///   loop.TYPE                  a joint that closes a loop
///   motor.MODE                 velocity torque position servo dc
///   body.static  body.kinematic  contact.stiffness
///   runtime.add  runtime.remove  runtime.save  runtime.set_state
///   runtime.attach  runtime.body_kind  runtime.joint_axes
///   report.contact_force  report.joint_reaction  report.joint_effort
class COGRSIM_API Capabilities {
 public:
  void set(const std::string& feature, Support support, std::string note = {});
  /// unsupported with the note "not known to this backend" when it was never set.
  Capability get(const std::string& feature) const;
  const std::map<std::string, Capability>& all() const { return features_; }

 private:
  std::map<std::string, Capability> features_;
};

/// "pair.box-mesh", whichever comes first.
COGRSIM_API std::string pair_feature(ShapeType a, ShapeType b);

/// What the scene needs and the backend lacks, as errors (CG0801) with the element's place, and
/// what is approximate as advice (CG2008), each feature once. Shape pairs are those that could
/// ever meet: mobile with anything that collides with it.
COGRSIM_API std::vector<Diagnostic> check_capabilities(const SceneModel& model,
                                                       const std::string& backend,
                                                       const Capabilities& capabilities);

}  // namespace cogrsim

// What a run leaves out of a scene on request, because an engine lacks it.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/capabilities.h"

namespace cogrsim {

/// A feature that was left out of a scene.
struct LeftOut {
  std::string feature;  ///< its id, see Capabilities: "joint.rotor-inertia.hinge"
  std::string of;       ///< of what: "joint", "coupling", "body", "shape", "material", "force"
  int count = 0;        ///< of how many of these
};

/// What can be left out, and what the scene has instead:
///
/// | feature                                             | instead                               |
/// |-----------------------------------------------------|---------------------------------------|
/// | joint.limit.TYPE .damping .friction .stiffness .rotor-inertia | these joints have none      |
/// | joint.coupling, joint.coupling-effort               | no coupling; one that never slips     |
/// | loop.TYPE                                           | the loop is open: no joint, no motors and sensors on it |
/// | body.force, body.gravity-scale                      | no force; gravity as for others       |
/// | contact.…                                           | materials and shapes have none        |
/// | shape.TYPE                                          | these shapes do not collide           |
/// | pair.TYPE-mesh                                      | the meshes collide as convex hulls    |
/// | pair.TYPE-TYPE                                      | bodies with these shapes pass through each other |
///
/// Joint types, motor modes and kinds of bodies cannot: without them it is another scene.
COGRSIM_API bool can_leave_out(const std::string& feature);

/// Checks what is asked for with `--without`: "lacking", which is whatever the engine lacks; the id of
/// a feature that can be left out, or its beginning up to a dot ("joint.limit"); or "couplings",
/// "limits", "loops", "rotor-inertia", which are short for such. Errors: an unknown name, with the
/// nearest one, or what cannot be left out.
COGRSIM_API Result<> check_without(const std::vector<std::string>& names);

/// The scene without what `names` says, which check_without() accepts, on an engine with these
/// capabilities; the model itself if it has nothing of that. `found`: receives what was left out, by
/// feature.
COGRSIM_API SceneModelPtr leave_out(SceneModelPtr model, const Capabilities& capabilities,
                                    const std::vector<std::string>& names,
                                    std::vector<LeftOut>* found = nullptr);

/// "joint.coupling (2 couplings), joint.rotor-inertia.hinge (12 joints)".
COGRSIM_API std::string to_text(const std::vector<LeftOut>& left_out);

}  // namespace cogrsim

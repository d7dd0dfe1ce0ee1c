#include "capabilities.h"

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::bullet {

Capabilities make_capabilities() {
  Capabilities out;
  set_shape_features(out);
  set_joint_features(out);
  out.set("contact.stiffness", Support::approximate,
          "a spring per contact point; restitution becomes its damping");
  for (const char* feature :
       {"body.static", "body.kinematic", "runtime.add", "runtime.remove", "runtime.save",
        "runtime.set_state", "runtime.attach", "runtime.body_kind", "runtime.joint_axes",
        "report.contact_force", "report.joint_reaction", "report.joint_effort"}) {
    out.set(feature, Support::exact);
  }
  return out;
}

}  // namespace cogrsim::bullet

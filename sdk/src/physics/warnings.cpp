#include "cogrsim/physics/warnings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/index.h"
#include "model/diagnose.h"

namespace cogrsim {
namespace {

// Inverse mass of a body's point along a unit vector, free of joints [1/kg].
double inverse_mass(const SceneModel& model, int index, const Vec3& point, const Vec3& direction) {
  if (index == kWorld || model.bodies[at(index)].kind != BodyKind::dynamic) return 0.0;
  const Body& body = model.bodies[at(index)];
  const Vec3 turn = (body.X_WB.q.conjugate() * (point - body.X_WB * body.com).cross(direction));
  return 1.0 / body.mass + turn.dot(body.inertia.inverse() * turn);
}

Diagnostic warning(const SceneModel& model, const SourceSpan& origin, const std::string& message,
                   const std::string& help) {
  Diagnostic d = diagnose(model, origin, message, "CG2008", help);
  d.severity = Severity::warning;
  return d;
}

}  // namespace

std::vector<Diagnostic> rotor_warnings(const SceneModel& scene, const std::string& backend,
                                       const std::vector<std::vector<double>>& ratios,
                                       double most) {
  std::vector<Diagnostic> out;
  for (std::size_t j = 0; j < ratios.size(); ++j) {
    const auto ratio =
        std::find_if(ratios[j].begin(), ratios[j].end(), [&](double one) { return one > most; });
    if (ratio == ratios[j].end()) continue;
    const Joint& joint = scene.joints[j];
    out.push_back(warning(
        scene, joint.origin,
        fmt::format("backend '{}' may not hold the rotor inertia of joint '{}': it is {:.3g} "
                    "times the inertia of the bodies it turns, and the solver's sweeps hold {:.3g}",
                    backend, joint.name, *ratio, most),
        "take more iterations or a direct solver, a lighter rotor or a heavier link, or run the "
        "scene on another backend"));
    // The lighter side of the axis.
    const auto side = [&](int body) {
      const bool moves = body != kWorld && scene.bodies[at(body)].kind == BodyKind::dynamic;
      return moves ? &scene.bodies[at(body)] : nullptr;
    };
    const Body *link = side(joint.child), *const parent = side(joint.parent);
    if (!link || (parent && parent->inertia.trace() < link->inertia.trace())) link = parent;
    if (link)
      out.back().notes.emplace_back("it turns '" + link->name + "'",
                                    source_position(scene, link->origin));
  }
  return out;
}

// A force k x + d v on an inverse mass w, held over steps of h, lets the motion grow from h^2 w k + 2 h w d = 4 on,
// the bound of the leapfrog; from 1 on the period of an oscillation is off by 4 %.
std::vector<Diagnostic> stiff_forces(const SceneModel& model) {
  const double dt = model.physics.step;
  constexpr double kUnstable = 4.0, kInaccurate = 1.0;
  std::vector<Diagnostic> out;
  const auto warn = [&](const ForceModel& force, const char* what, double stiffness) {
    if (!(stiffness > kInaccurate)) return;
    out.push_back(warning(
        model, force.origin,
        fmt::format("{} '{}' is too stiff for steps of {:.3g} ms and the masses it acts on: {:.3g} "
                    "of the {} at which the motion grows without bounds, unless joints hold the "
                    "bodies",
                    what, force.name, 1e3 * dt, stiffness, kUnstable),
        fmt::format("take steps of {:.2g} ms, or less stiffness and damping",
                    1e3 * dt / std::sqrt(stiffness / kInaccurate))));
  };
  for (const ForceModel& force : model.forces) {
    if (force.removed) continue;
    const auto pose_of = [&](int body) {
      return body == kWorld ? Pose() : model.bodies[at(body)].X_WB;
    };
    if (force.kind == ForceModel::Kind::spring) {
      const Vec3 from = (pose_of(force.body) * force.X_BE).p,
                 to = pose_of(force.other) * force.other_point;
      const double length = (to - from).norm();
      if (!(length > 0.0)) continue;
      const Vec3 line = (to - from) / length;
      const double w =
          inverse_mass(model, force.body, from, line) + inverse_mass(model, force.other, to, line);
      warn(force, "spring", dt * w * (dt * force.stiffness + 2.0 * force.damping));
    } else if (force.kind == ForceModel::Kind::drag && force.body != kWorld) {
      const Body& body = model.bodies[at(force.body)];
      if (body.kind != BodyKind::dynamic) continue;
      const double turning = force.angular * body.inertia.inverse().norm();
      warn(force, "drag", 2.0 * dt * std::max(force.linear / body.mass, turning));
    }
  }
  return out;
}

}  // namespace cogrsim

#include "cogrsim/physics/capabilities.h"

#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "cogrsim/physics/leave_out.h"

namespace cogrsim {
namespace {

constexpr int kShapeTypeCount = static_cast<int>(ShapeType::heightmap) + 1;

/// Two shapes that can collide.
struct ShapePair {
  const Shape* first;
  const Shape* second;
};

/// A shape of a body, in the list of its shape type.
struct ModelShape {
  int body;
  const Shape* shape;
};

/// Traverses a model and reports the features that the backend lacks.
class Check {
 public:
  Check(const SceneModel& model, const std::string& backend, const Capabilities& capabilities)
      : model_(model), backend_(backend), capabilities_(capabilities) {}

  std::vector<Diagnostic> run() {
    check_bodies();
    for (const MaterialPair& pair : model_.material_pairs) {
      need_turning_friction(pair.rolling_friction.value_or(0.0),
                            pair.spinning_friction.value_or(0.0), "pair of materials", pair.origin);
    }
    check_pairs();
    check_joints();
    check_couplings();
    check_motors();
    for (const ForceModel& force : model_.forces) {
      if (force.removed || force.kind == ForceModel::Kind::wind) continue;
      need("body.force", "forces on bodies", "force '" + force.name + "'", force.origin,
           "leave it out, or run the scene on another backend");
    }
    return std::move(out_);
  }

 private:
  void check_bodies();
  void check_pairs();
  void check_joints();
  void check_couplings();
  void check_motors();

  /// Checks a feature on its first use. `what` describes the feature ("joint type 'screw'"), and
  /// `element` the first element that needs it ("joint 'lift'").
  Diagnostic* need(const std::string& feature, const std::string& what, const std::string& element,
                   const SourceSpan& origin, const std::string& help);

  void need_turning_friction(double rolling, double spinning, const std::string& element,
                             const SourceSpan& origin);

  const SceneModel& model_;
  const std::string& backend_;
  const Capabilities& capabilities_;
  std::set<std::string> asked_;
  std::vector<Diagnostic> out_;
};

Diagnostic* Check::need(const std::string& feature, const std::string& what,
                        const std::string& element, const SourceSpan& origin,
                        const std::string& help) {
  if (!asked_.insert(feature).second) return nullptr;
  const Capability found = capabilities_.get(feature);
  if (found.support == Support::exact) return nullptr;
  Diagnostic d;
  const bool lacking = found.support == Support::unsupported;
  d.severity = lacking ? Severity::error : Severity::warning;
  d.code = lacking ? "CG0801" : "CG2008";
  d.message = fmt::format("backend '{}' {} {} ({})", backend_,
                          lacking ? "does not support" : "only approximates", what, element);
  if (!found.note.empty()) d.notes.emplace_back(found.note);
  d.locate(source_position(model_, origin));
  if (lacking) d.help = help;
  if (lacking && can_leave_out(feature))
    d.help += fmt::format("; --without {} leaves it out of a run", feature);
  out_.push_back(std::move(d));
  return &out_.back();
}

void Check::need_turning_friction(double rolling, double spinning, const std::string& element,
                                  const SourceSpan& origin) {
  const char* const help = "leave it out, or run the scene on another backend";
  if (rolling > 0.0) need("contact.rolling-friction", "rolling friction", element, origin, help);
  if (spinning > 0.0) need("contact.spinning-friction", "spinning friction", element, origin, help);
}

void Check::check_bodies() {
  for (const Body& body : model_.bodies) {
    if (body.removed) continue;
    if (body.kind != BodyKind::dynamic) {
      const bool fixed = body.kind == BodyKind::static_body;
      need(fixed ? "body.static" : "body.kinematic", fixed ? "static bodies" : "kinematic bodies",
           "body '" + body.name + "'", body.origin, "run the scene on another backend");
    }
    if (body.kind == BodyKind::dynamic && body.gravity_scale != 1.0) {
      need("body.gravity-scale", "a body's gravity-scale", "body '" + body.name + "'", body.origin,
           "leave the gravity-scale out, or run the scene on another backend");
    }
    for (const Shape& shape : body.shapes) {
      if (!shape.collides) continue;
      const std::string type = to_string(shape.type);
      const std::string element = "shape '" + shape.name + "'";
      need("shape." + type, fmt::format("shape type '{}'", type), element, shape.origin,
           "use another shape, or run the scene on another backend");
      const Material& material = model_.materials[shape.material];
      if (material.stiffness) {
        need("contact.stiffness", "a material's contact stiffness", element, shape.origin,
             "leave the stiffness out, or run the scene on another backend");
      }
      need_turning_friction(material.rolling_friction, material.spinning_friction, element,
                            shape.origin);
      if (!shape.surface_velocity.isZero(0.0)) {
        need("contact.surface-velocity", "a surface velocity", element, shape.origin,
             "leave it out, or run the scene on another backend");
      }
    }
  }
}

void Check::check_pairs() {
  const CollisionFilter filter(model_);
  std::array<std::vector<ModelShape>, kShapeTypeCount> all, mobile;
  for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
    const Body& body = model_.bodies[i];
    if (body.removed) continue;
    for (const Shape& shape : body.shapes) {
      if (!shape.collides) continue;
      const ModelShape candidate{static_cast<int>(i), &shape};
      all[static_cast<std::size_t>(shape.type)].push_back(candidate);
      if (body.kind == BodyKind::dynamic) {
        mobile[static_cast<std::size_t>(shape.type)].push_back(candidate);
      }
    }
  }
  // Only pairs that the filter excludes are skipped before the first hit, so the cost grows with
  // the number of exclusions and not with the square of the number of bodies.
  const auto first_meeting = [&filter](const std::vector<ModelShape>& movers,
                                       const std::vector<ModelShape>& others) -> ShapePair {
    for (const ModelShape& a : movers) {
      for (const ModelShape& b : others) {
        if (filter.collide(a.body, b.body)) return {a.shape, b.shape};
      }
    }
    return {nullptr, nullptr};
  };
  for (std::size_t a = 0; a < kShapeTypeCount; ++a) {
    for (std::size_t b = a; b < kShapeTypeCount; ++b) {
      const std::string feature =
          pair_feature(static_cast<ShapeType>(a), static_cast<ShapeType>(b));
      if (capabilities_.get(feature).support == Support::exact) continue;
      ShapePair pair = first_meeting(mobile[a], all[b]);
      if (pair.first == nullptr) pair = first_meeting(mobile[b], all[a]);
      if (pair.first == nullptr) continue;
      Diagnostic* d =
          need(feature,
               fmt::format("contact of {} and {}", to_string(pair.first->type),
                           to_string(pair.second->type)),
               fmt::format("shapes '{}' and '{}'", pair.first->name, pair.second->name),
               pair.first->origin,
               "use another shape for one of them, keep them from colliding, or run the scene on "
               "another backend");
      if (d == nullptr) continue;
      SourcePosition other = source_position(model_, pair.second->origin);
      if (!other.file.empty()) {
        d->notes.emplace_back(fmt::format("the other shape, '{}'", pair.second->name),
                              std::move(other));
      }
    }
  }
}

void Check::check_joints() {
  for (const Joint& joint : model_.joints) {
    if (joint.removed) continue;
    const std::string type = to_string(joint.type);
    const std::string element = "joint '" + joint.name + "'";
    const std::string help = "use another joint, or run the scene on another backend";
    if (joint.closes_loop) {
      need("loop." + type, fmt::format("loops closed by joint type '{}'", type), element,
           joint.origin, help);
    } else {
      need("joint." + type, fmt::format("joint type '{}'", type), element, joint.origin, help);
    }
    const auto need_of_axis = [&](bool wanted, const char* property, const char* text) {
      if (!wanted) return;
      need(fmt::format("joint.{}.{}", property, type),
           fmt::format("{} of joint type '{}'", text, type), element, joint.origin,
           fmt::format("leave the {} out, or run the scene on another backend", text));
    };
    for (const JointAxis& axis : joint.axes) {
      need_of_axis(axis.has_limit(), "limit", "limits");
      need_of_axis(axis.damping > 0.0, "damping", "damping");
      need_of_axis(axis.friction > 0.0, "friction", "friction");
      need_of_axis(axis.stiffness > 0.0, "stiffness", "stiffness");
      need_of_axis(axis.rotor_inertia > 0.0, "rotor-inertia", "rotor inertia");
    }
  }
}

void Check::check_couplings() {
  for (const Coupling& coupling : model_.couplings) {
    if (coupling.removed) continue;
    need("joint.coupling", "coupled joints", "coupling '" + coupling.name + "'", coupling.origin,
         "leave the coupling out, or run the scene on another backend");
    if (std::isfinite(coupling.max_effort)) {
      need("joint.coupling-effort", "the largest effort of a coupling",
           "coupling '" + coupling.name + "'", coupling.origin,
           "leave it out, or run the scene on another backend");
    }
  }
}

void Check::check_motors() {
  for (const Motor& motor : model_.motors) {
    if (motor.removed) continue;
    const std::string mode = to_string(motor.mode);
    need("motor." + mode, fmt::format("motor mode '{}'", mode), "motor '" + motor.name + "'",
         motor.origin, "use another mode, or run the scene on another backend");
  }
}

}  // namespace

const char* to_string(Support support) {
  switch (support) {
    case Support::unsupported:
      return "unsupported";
    case Support::approximate:
      return "approximate";
    case Support::exact:
      return "exact";
  }
  return "?";
}

void Capabilities::set(const std::string& feature, Support support, std::string note) {
  features_[feature] = {support, std::move(note)};
}

Capability Capabilities::get(const std::string& feature) const {
  const auto found = features_.find(feature);
  if (found != features_.end()) return found->second;
  return {Support::unsupported, "not known to this backend"};
}

std::string pair_feature(ShapeType a, ShapeType b) {
  if (a > b) std::swap(a, b);
  return fmt::format("pair.{}-{}", to_string(a), to_string(b));
}

std::vector<Diagnostic> check_capabilities(const SceneModel& model, const std::string& backend,
                                           const Capabilities& capabilities) {
  return Check(model, backend, capabilities).run();
}

}  // namespace cogrsim

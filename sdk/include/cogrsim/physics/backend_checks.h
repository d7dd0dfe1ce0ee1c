// Checks and capability tables that all backends share: states and twists to be set, snapshots of
// other scenes, motors without an axis, and features by shape, joint and motor. For backends;
// header only.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/mass_properties.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/capabilities.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// All values of the enumerations, in their order.
inline constexpr std::array kShapeTypes = {
    ShapeType::box,   ShapeType::sphere,      ShapeType::cylinder, ShapeType::capsule,
    ShapeType::plane, ShapeType::convex_mesh, ShapeType::mesh,     ShapeType::heightmap};
inline constexpr std::array kJointTypes = {
    JointType::fixed,       JointType::hinge,     JointType::slider, JointType::screw,
    JointType::cylindrical, JointType::universal, JointType::planar, JointType::ball,
    JointType::free,        JointType::gimbal};
inline constexpr std::array kMotorModes = {MotorMode::velocity, MotorMode::torque,
                                           MotorMode::position, MotorMode::servo, MotorMode::dc};

/// Whether a shape is a surface (plane, mesh, heightmap). A body with a colliding surface shape
/// cannot be moved by forces.
constexpr bool is_surface(ShapeType type) {
  return type == ShapeType::plane || type == ShapeType::mesh || type == ShapeType::heightmap;
}

/// Sets shape.* and pair.* to exact, except for pairs of two surfaces, which never collide. A
/// backend then sets the features that differ.
inline void set_shape_features(Capabilities& out) {
  for (const ShapeType a : kShapeTypes) {
    out.set(std::string("shape.") + to_string(a), Support::exact);
    for (const ShapeType b : kShapeTypes) {
      if (is_surface(a) && is_surface(b)) {
        out.set(pair_feature(a, b), Support::unsupported,
                "two surfaces: neither can be moved by forces");
      } else {
        out.set(pair_feature(a, b), Support::exact);
      }
    }
  }
}

/// Sets pair.* to approximate where `note(a, b)` is not null: how the contact of these shapes differs.
template <class Note>
void set_pair_notes(Capabilities& out, const Note& note) {
  for (const ShapeType a : kShapeTypes)
    for (const ShapeType b : kShapeTypes)
      if (const char* text = is_surface(a) && is_surface(b) ? nullptr : note(a, b))
        out.set(pair_feature(a, b), Support::approximate, text);
}

/// Sets joint.*, loop.* and motor.* to exact, except for limits, damping, friction and stiffness of
/// joints without axes.
inline void set_joint_features(Capabilities& out) {
  for (const JointType type : kJointTypes) {
    const std::string name = to_string(type);
    out.set("joint." + name, Support::exact);
    out.set("loop." + name, Support::exact);
    for (const char* part : {"limit", "damping", "friction", "stiffness"}) {
      const std::string feature = "joint." + std::string(part) + "." + name;
      if (type == JointType::fixed || type == JointType::free) {
        out.set(feature, Support::unsupported, "this joint has no axes");
      } else {
        out.set(feature, Support::exact);
      }
    }
  }
  for (const MotorMode mode : kMotorModes)
    out.set(std::string("motor.") + to_string(mode), Support::exact);
}

/// Sets a feature of one type of joint: with parts {"joint.", "joint.limit."} joint.TYPE and
/// joint.limit.TYPE.
inline void set_joint_parts(Capabilities& out, JointType type,
                            std::initializer_list<const char*> parts, Support support,
                            const std::string& note) {
  for (const char* part : parts) out.set(std::string(part) + to_string(type), support, note);
}

/// Sets all of a type of joint that an engine does not have to unsupported.
inline void lack_joint(Capabilities& out, JointType type, const std::string& note) {
  set_joint_parts(
      out, type,
      {"joint.", "loop.", "joint.limit.", "joint.damping.", "joint.friction.", "joint.stiffness."},
      Support::unsupported, note);
}

/// Sets what most engines do as the scene says to exact: kinds of bodies and forces on them, changes
/// and snapshots of a world, reports. A backend then sets the features that differ.
inline void set_world_features(Capabilities& out) {
  out.set_all({"body.static", "body.kinematic", "body.gravity-scale", "body.force", "runtime.add",
               "runtime.remove", "runtime.save", "runtime.set_state", "runtime.attach",
               "runtime.body_kind", "runtime.joint_axes", "report.contact_force",
               "report.joint_reaction", "report.joint_effort"},
              Support::exact);
}

/// Check for Backend::create_world() and World::add(). Errors: a motor acts on a joint without an
/// axis to drive, with the source location. No capability covers this case.
inline Result<> check_motors(const SceneModel& model) {
  for (const Motor& motor : model.motors) {
    if (motor.removed) continue;
    const JointType type = model.joints[motor.joint].type;
    if (type != JointType::ball && type != JointType::free && type != JointType::fixed) continue;
    return fail("motor '" + motor.name + "': a " + std::string(to_string(type)) +
                    " joint has no axis to drive",
                source_position(model, motor.origin),
                "use a hinge, slider, universal or another joint with axes");
  }
  return {};
}

/// Check for Backend::create_world() and World::add(). Errors: the mass or the inertia of a body that
/// forces move is not physical (see check_mass_properties()), with the source location.
inline Result<> check_masses(const SceneModel& model) {
  for (const Body& body : model.bodies) {
    if (body.removed || body.kind != BodyKind::dynamic) continue;
    if (auto massive = check_mass_properties(body.mass, body.inertia); !massive) {
      return fail("body '" + body.name + "': " + massive.error().message,
                  source_position(model, body.origin), massive.error().hint);
    }
  }
  return {};
}

/// Check for Backend::create_world() and World::add(). Errors: a surface on a body that forces move, with
/// the source location. No capability covers this case.
inline Result<> check_surfaces(const SceneModel& model) {
  for (const Body& body : model.bodies)
    for (const Shape& shape : body.shapes) {
      if (body.removed || body.kind != BodyKind::dynamic) continue;
      if (!shape.collides || !is_surface(shape.type)) continue;
      return fail("body '" + body.name + "': a " + std::string(to_string(shape.type)) +
                      " cannot be moved by forces",
                  source_position(model, shape.origin),
                  "make the body static or kinematic, or use a convex-mesh");
    }
  return {};
}

/// check_motors(), check_masses(), check_surfaces().
inline Result<> check_parts(const SceneModel& model) {
  if (auto fine = check_motors(model); !fine) return fine;
  if (auto fine = check_masses(model); !fine) return fine;
  return check_surfaces(model);
}

/// Options that the scene sets for an engine, completed by the defaults of `table`. Errors: those of
/// complete_parameters(), with the source location.
inline Result<Parameters> physics_options(const SceneModel& model, const std::string& engine,
                                          const ParameterTable& table) {
  const auto given = model.physics.engine_options.find(engine);
  const Parameters none;
  Result<Parameters> out = complete_parameters(
      table, given == model.physics.engine_options.end() ? none : given->second);
  if (!out) out.error().locate(source_position(model, model.physics.origin));
  return out;
}

/// Check for World::set_state(), before anything is changed. Errors: the numbers of bodies or joint
/// coordinates differ from those of the model; a value is not finite (the error names the body);
/// the norm of an orientation differs from 1 by more than 1e-6.
inline Result<> check_state(const SceneModel& model, const WorldState& state) {
  const std::size_t bodies = model.bodies.size();
  const auto positions = static_cast<std::size_t>(model.joint_positions);
  if (state.poses.size() != bodies || state.twists.size() != bodies ||
      state.joint_positions.size() != positions ||
      state.joint_velocities.size() != static_cast<std::size_t>(model.joint_speeds)) {
    return fail("the state belongs to another scene: it has " + std::to_string(state.poses.size()) +
                " bodies and " + std::to_string(state.joint_positions.size()) +
                " joint coordinates, this scene " + std::to_string(bodies) + " and " +
                std::to_string(positions));
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    const Pose& X = state.poses[b];
    const Twist& V = state.twists[b];
    if (!X.p.allFinite() || !X.q.coeffs().allFinite() || std::abs(X.q.norm() - 1.0) > 1e-6 ||
        !V.linear.allFinite() || !V.angular.allFinite()) {
      return fail("body '" + model.bodies[b].name + "': its pose or twist is not finite, or its " +
                  "orientation not of unit length");
    }
  }
  const auto finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  };
  if (!finite(state.joint_positions) || !finite(state.joint_velocities))
    return fail("a joint's position or velocity is not finite");
  return {};
}

/// Check for KinematicDrive::set_kinematic_twist(). Errors: the body does not exist or is not
/// kinematic, or the twist is not finite.
inline Result<> check_kinematic_twist(const SceneModel& model, int body, const Twist& twist) {
  if (body < 0 || body >= static_cast<int>(model.bodies.size()))
    return fail("there is no body " + std::to_string(body));
  const Body& moved = model.bodies[body];
  if (moved.kind != BodyKind::kinematic || moved.removed)
    return fail("body '" + moved.name + "' is not kinematic", source_position(model, moved.origin));
  if (!twist.linear.allFinite() || !twist.angular.allFinite())
    return fail("body '" + moved.name + "': its twist is not finite");
  return {};
}

/// Check for World::restore(): whether two worlds were created from the same scene, by the names of
/// bodies and joints. Worlds of one scene may have been created from copies of its model.
inline bool same_names(const SceneModel& a, const SceneModel& b) {
  if (&a == &b) return true;
  const auto same = [](const auto& one, const auto& other) { return one.name == other.name; };
  return std::equal(a.bodies.begin(), a.bodies.end(), b.bodies.begin(), b.bodies.end(), same) &&
         std::equal(a.joints.begin(), a.joints.end(), b.joints.begin(), b.joints.end(), same);
}

}  // namespace cogrsim

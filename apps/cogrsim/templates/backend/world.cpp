#include "world.h"

#include <cmath>
#include <string>
#include <utility>

#include <cogrsim/model/mass_properties.h>
#include <cogrsim/physics/backend_checks.h>

namespace adapter {
namespace {

using cogrsim::fail;
using cogrsim::Pose;
using cogrsim::Result;
using cogrsim::SceneModel;
using cogrsim::SceneModelPtr;
using cogrsim::Twist;
using cogrsim::Vec3;

// Beyond these limits a body has diverged: 1000 km, 100 km/s, 1e6 rad/s.
constexpr double kFarthest = 1e6, kFastest = 1e5, kFastestSpin = 1e6;

// CogRSim uses the origin of the body, the engine its centre of mass.
void place(const cogrsim::Body& model, const Pose& X_WB, const Twist& V_WB, flight::Body& body) {
  body.orientation = flight::Quat(X_WB.q).normalized();
  const Vec3 arm = body.orientation * model.com;  // from the origin to the centre of mass
  body.position = X_WB.p + arm;
  if (body.motion == flight::Motion::still) return;
  body.velocity = V_WB.at(arm);
  flight::set_spin(body, V_WB.angular);
}

flight::Motion motion_of(cogrsim::BodyKind kind) {
  if (kind == cogrsim::BodyKind::static_body) return flight::Motion::still;
  return kind == cogrsim::BodyKind::kinematic ? flight::Motion::carried : flight::Motion::free;
}

flight::Body make_body(const cogrsim::Body& model) {
  flight::Body body;
  body.motion = motion_of(model.kind);
  body.mass = model.mass;
  body.inertia = model.inertia;
  place(model, model.X_WB, model.V_WB, body);
  // A carried body rotates about its origin, so the engine moves the origin.
  if (body.motion == flight::Motion::carried) {
    body.position = model.X_WB.p;
    body.velocity = model.V_WB.linear;
  }
  return body;
}

// The point that the engine moves, in body axes: the centre of mass, but see make_body().
Vec3 moved_point(const cogrsim::Body& model) {
  return model.kind == cogrsim::BodyKind::kinematic ? Vec3(Vec3::Zero()) : model.com;
}

}  // namespace

Result<> check_scene(const SceneModel& model) {
  // The caller has normally checked capabilities() before.
  for (const cogrsim::Joint& joint : model.joints) {
    if (!joint.removed) {
      return fail("joint '" + joint.name + "': bodies fly freely here, there are no joints",
                  source_position(model, joint.origin));
    }
  }
  for (const cogrsim::Body& body : model.bodies) {
    if (body.removed || body.kind != cogrsim::BodyKind::dynamic) continue;
    if (const auto right = cogrsim::check_mass_properties(body.mass, body.inertia); !right) {
      return fail("body '" + body.name + "': " + right.error().message,
                  source_position(model, body.origin), right.error().hint);
    }
  }
  return {};
}

FlightWorld::FlightWorld(SceneModelPtr model, int substeps)
    : first_(std::move(model)), substeps_(substeps) {
  static_cast<void>(reset());  // cannot fail for this world
}

Result<> FlightWorld::reset() {
  now_ = Everything();
  now_.model = first_;
  for (const cogrsim::Body& body : first_->bodies) now_.bodies.push_back(make_body(body));
  return {};
}

cogrsim::StepResult FlightWorld::step(double dt, const std::vector<cogrsim::Drive>&) {
  // On a copy, so that a failed step leaves the world unchanged.
  trial_ = now_.bodies;
  const Vec3& gravity = now_.model->physics.gravity;
  for (std::size_t i = 0; i < trial_.size(); ++i) {
    if (now_.model->bodies[i].removed) continue;
    flight::Body& body = trial_[i];
    for (int part = 0; part < substeps_; ++part) flight::advance(body, gravity, dt / substeps_);
    // This form of the comparison also rejects NaN.
    const bool fine = body.position.norm() < kFarthest && body.velocity.norm() < kFastest &&
                      body.angular_velocity.norm() < kFastestSpin;
    if (!fine) {
      return {cogrsim::StepStatus::diverged, static_cast<int>(i),
              "body '" + now_.model->bodies[i].name + "' left all bounds (1000 km, 100 km/s)"};
    }
  }
  now_.bodies.swap(trial_);
  now_.time += dt;
  return {};
}

void FlightWorld::get_state(cogrsim::WorldState& out) const {
  const SceneModel& model = *now_.model;
  out.poses.resize(model.bodies.size());
  out.twists.resize(model.bodies.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const flight::Body& body = now_.bodies[i];
    const Vec3 arm = body.orientation * moved_point(model.bodies[i]);
    out.poses[i] = {body.position - arm, cogrsim::Quat(body.orientation)};
    if (body.motion == flight::Motion::still) {
      out.twists[i] = Twist();
      continue;
    }
    const Twist V{body.velocity, body.angular_velocity};
    out.twists[i] = {V.at(-arm), body.angular_velocity};
  }
  // There are no joints.
  out.joint_positions.assign(static_cast<std::size_t>(model.joint_positions), 0.0);
  out.joint_velocities.assign(static_cast<std::size_t>(model.joint_speeds), 0.0);
  out.joint_efforts.assign(static_cast<std::size_t>(model.joint_speeds), 0.0);
  out.motor_efforts.assign(model.motors.size(), 0.0);
}

Result<> FlightWorld::set_state(const cogrsim::WorldState& state) {
  const SceneModel& model = *now_.model;
  // Everything is checked before anything is changed.
  if (auto fine = check_state(model, state); !fine) return fine;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    cogrsim::Body moved = model.bodies[i];
    moved.X_WB = state.poses[i];
    moved.V_WB = state.twists[i];
    now_.bodies[i] = make_body(moved);
  }
  return {};
}

void FlightWorld::get_contacts(std::vector<cogrsim::Contact>& out) const {
  out.clear();  // there are no contacts
}

Result<> FlightWorld::add(const SceneModelPtr& next) {
  if (auto possible = check_scene(*next); !possible) return possible;
  for (std::size_t i = now_.bodies.size(); i < next->bodies.size(); ++i) {
    now_.bodies.push_back(make_body(next->bodies[i]));
  }
  now_.model = next;
  return {};
}

Result<> FlightWorld::remove(const SceneModelPtr& next) {
  now_.model = next;  // step() skips removed bodies; their last values remain
  return {};
}

Result<> FlightWorld::change(const SceneModelPtr& next) {
  if (next->bodies.size() != now_.bodies.size()) {
    return fail("a change keeps all bodies; add() and remove() are for the others");
  }
  cogrsim::WorldState state;
  get_state(state);
  for (std::size_t i = 0; i < now_.bodies.size(); ++i) {
    const cogrsim::Body& before = now_.model->bodies[i];
    cogrsim::Body after = next->bodies[i];
    if (before.kind == after.kind || after.removed) continue;
    // The body keeps its pose and has zero velocity.
    after.X_WB = state.poses[i];
    after.V_WB = Twist();
    now_.bodies[i] = make_body(after);
  }
  now_.model = next;
  return {};
}

struct FlightWorld::Snapshot final : cogrsim::WorldSnapshot {
  SceneModelPtr first;
  Everything saved;
};

cogrsim::SnapshotPtr FlightWorld::save() const {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->first = first_;
  snapshot->saved = now_;
  return snapshot;
}

Result<> FlightWorld::restore(const cogrsim::SnapshotPtr& snapshot) {
  const auto* mine = dynamic_cast<const Snapshot*>(snapshot.get());
  if (mine == nullptr) return fail("the snapshot is of another backend");
  if (!same_names(*mine->first, *first_)) {
    return fail("the snapshot is of another scene than '" + first_->name + "'");
  }
  now_ = mine->saved;
  return {};
}

void* FlightWorld::extension(std::string_view id) {
  if (id == KinematicDrive::kId) return static_cast<KinematicDrive*>(this);
  return nullptr;
}

Result<> FlightWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*now_.model, body, twist); !fine) return fine;
  now_.bodies[static_cast<std::size_t>(body)].velocity = twist.linear;
  now_.bodies[static_cast<std::size_t>(body)].angular_velocity = twist.angular;
  return {};
}

}  // namespace adapter

#include "world.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <cogrsim/model/mass_properties.h>

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

// Body `i` of the scene, with its motion in `at`.
flight::Body make_body(const SceneModel& scene, const cogrsim::WorldState& at, std::size_t i) {
  const cogrsim::Body& model = scene.bodies[i];
  flight::Body body;
  body.motion = motion_of(model.kind);
  body.mass = model.mass;
  body.inertia = model.inertia;
  place(model, at.poses[i], at.twists[i], body);
  // A carried body rotates about its origin, so the engine moves the origin.
  if (body.motion == flight::Motion::carried) {
    body.position = at.poses[i].p;
    body.velocity = at.twists[i].linear;
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

struct FlightWorld::Memory final : cogrsim::HostedMemory {
  std::vector<flight::Body> bodies;
};

FlightWorld::FlightWorld(const SceneModelPtr& model, int substeps) : substeps_(substeps) {
  static_cast<void>(start(model));  // cannot fail for this world
}

Result<> FlightWorld::build(const SceneModelPtr& model, const cogrsim::WorldState& begin) {
  bodies_.clear();
  for (std::size_t i = 0; i < model->bodies.size(); ++i)
    bodies_.push_back(make_body(*model, begin, i));
  return {};
}

// Bodies that stay what they were keep their last digits.
Result<> FlightWorld::rebuild(const SceneModelPtr& next, const cogrsim::WorldState& begin,
                              const cogrsim::SceneChange&) {
  for (std::size_t i = 0; i < next->bodies.size(); ++i) {
    const bool stays = i < bodies_.size() && (next->bodies[i].removed ||
                                              bodies_[i].motion == motion_of(next->bodies[i].kind));
    if (stays) continue;
    bodies_.resize(std::max(bodies_.size(), i + 1));
    bodies_[i] = make_body(*next, begin, i);
  }
  return {};
}

cogrsim::StepResult FlightWorld::advance(double dt, const std::vector<cogrsim::Drive>&,
                                         const std::vector<double>&) {
  // On a copy, so that a failed step leaves the world unchanged.
  trial_ = bodies_;
  for (std::size_t i = 0; i < trial_.size(); ++i) {
    if (model()->bodies[i].removed) continue;
    flight::Body& body = trial_[i];
    for (int part = 0; part < substeps_; ++part)
      flight::advance(body, model()->physics.gravity, dt / substeps_);
    // This form of the comparison also rejects NaN.
    const bool fine = body.position.norm() < kFarthest && body.velocity.norm() < kFastest &&
                      body.angular_velocity.norm() < kFastestSpin;
    if (!fine) return diverged(static_cast<int>(i), "1000 km, 100 km/s");
  }
  bodies_.swap(trial_);
  return {};
}

Pose FlightWorld::pose(int body) const {
  const flight::Body& it = bodies_[static_cast<std::size_t>(body)];
  return {it.position - arm(body), cogrsim::Quat(it.orientation)};
}

Twist FlightWorld::twist(int body) const {
  const flight::Body& it = bodies_[static_cast<std::size_t>(body)];
  const Twist V{it.velocity, it.angular_velocity};
  return {V.at(-arm(body)), V.angular};
}

Vec3 FlightWorld::arm(int body) const {
  const auto i = static_cast<std::size_t>(body);
  return bodies_[i].orientation * moved_point(model()->bodies[i]);
}

Result<> FlightWorld::write(const cogrsim::WorldState& state) {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (!model()->bodies[i].removed) bodies_[i] = make_body(*model(), state, i);
  return {};
}

cogrsim::HostedWorld::MemoryPtr FlightWorld::save_memory() const {
  auto out = std::make_shared<Memory>();
  out->bodies = bodies_;
  return out;
}

Result<> FlightWorld::restore_memory(const SceneModelPtr&, const MemoryPtr& memory,
                                     const cogrsim::WorldState&) {
  bodies_ = static_cast<const Memory&>(*memory).bodies;
  return {};
}

void FlightWorld::move_kinematic(int body) {
  const auto i = static_cast<std::size_t>(body);
  bodies_[i].velocity = twists()[i].linear;
  bodies_[i].angular_velocity = twists()[i].angular;
}

}  // namespace adapter

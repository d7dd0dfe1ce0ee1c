// Forces on bodies, with x and v the position and velocity of the element's frame E:
//   force   factor F at x
//   drag    -(c1 + c2 |u|) u  at x,  u = v - wind,  and the torque -c3 w;  wind: its own, and each of
//           the scene times its factor
//   spring  along e = (x2 - x) / l, l = |x2 - x|:  T = k (l - l0) + d e (v2 - v),  T e at x, -T e at x2;
//           e and l a time after the start of the step that suits the engine
//           (ExternalForces::evaluation_time)
//   buoyancy  -density V g at the centroid of the volume V below the level, at the same time
// Each is moved to the centre of mass c of its body: force F, torque (x - c) x F.
#include "simulation/force_system.h"

#include <algorithm>
#include <cmath>

#include "core/index.h"
#include "simulation/find_named.h"

namespace cogrsim {

namespace {

struct PointMotion {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
};

PointMotion motion_of(const WorldState& state, int body, const Vec3& point) {
  if (body == kWorld) return {point, Vec3::Zero()};
  const Pose& X_WB = state.poses[at(body)];
  const Vec3 arm = X_WB.q * point;
  const Vec3 v = state.twists[at(body)].at(arm);
  return {X_WB.p + arm, v};
}

}  // namespace

void ForceSystem::add(const SceneModel& model, int body, const WorldState& state, const Vec3& force,
                      const Vec3& point, const Vec3& torque) {
  if (body == kWorld || model.bodies[at(body)].kind != BodyKind::dynamic) return;
  const Pose& X_WB = state.poses[at(body)];
  Wrench& sum = sums_[at(body)];
  sum.force += force;
  sum.torque += torque + (point - X_WB * model.bodies[at(body)].com).cross(force);
}

void ForceSystem::buoyancy(const SceneModelPtr& model, std::size_t force, const WorldState& state,
                           double ahead) {
  const ForceModel& it = model->forces[force];
  const Vec3& gravity = model->physics.gravity;
  if (it.body == kWorld || !(gravity.norm() > 0.0)) return;
  if (displaced_of_ != model) {
    displaced_of_ = model;
    displaced_.assign(model->forces.size(), {});
  }
  const Body& body = model->bodies[at(it.body)];
  std::vector<geometry::DisplacedShape>& shapes = displaced_[force];
  if (shapes.empty()) {
    for (const Shape& shape : body.shapes) shapes.emplace_back(shape, model->meshes);
  }
  const Twist& V = state.twists[at(it.body)];
  Pose X_WB = state.poses[at(it.body)];
  X_WB.p += ahead * V.linear;
  if (const double turn = ahead * V.angular.norm(); turn > 0.0)
    X_WB.q = Quat(Eigen::AngleAxisd(turn, V.angular.normalized())) * X_WB.q;
  const Vec3 moved = X_WB * body.com - state.poses[at(it.body)] * body.com;
  for (const geometry::DisplacedShape& shape : shapes) {
    const geometry::Displaced part = shape.below(X_WB, -gravity.normalized(), it.level);
    if (part.volume > 0.0)
      add(*model, it.body, state, -it.density * part.volume * gravity, part.centre - moved,
          Vec3::Zero());
  }
}

Result<> ForceSystem::apply(const ApplyForce& command, WorldHost& host, const Clock& clock) {
  const SceneModel& model = *host.model();
  const auto found = find_named(model.bodies, "body", command.body);
  if (!found) return tl::unexpected(found.error());
  if (model.bodies[at(*found)].kind != BodyKind::dynamic)
    return fail("body '" + command.body + "' is static or kinematic: forces do not move it");
  if (!command.force.allFinite() || !command.torque.allFinite() || !command.point.allFinite())
    return fail("the force on body '" + command.body + "' is not finite");
  if (!(command.duration >= 0.0)) return fail("the duration of a force must be 0 s or more");
  if (!host.world().extension<ExternalForces>())
    return fail("backend '" + std::string(host.backend().name()) + "' has no forces on bodies");
  constexpr std::size_t kMost = 100000;  // at the same time
  if (applied_.size() >= kMost) return fail("too many forces of commands act at the same time");
  // With half a step of slack: multiples of the step are whole numbers of steps.
  const double length = std::max(command.duration, clock.dt());
  applied_.push_back({*found, command, clock.time() + length - 0.5 * clock.dt()});
  return {};
}

void ForceSystem::apply(WorldHost& host, const Clock& clock, const ChannelLookup& channels,
                        FrameSource& frames) {
  const SceneModelPtr& model = host.model();
  if (model->forces.empty() && applied_.empty() && !given_) return;
  auto* const engine = host.world().extension<ExternalForces>();
  if (!engine) return;  // refused before the run
  factors_.resolve(model, model->forces, &ForceModel::factor, channels);
  constexpr double kEarly = 1e-6;  // of a step: times that are multiples of it count as reached
  const double now = clock.time() + kEarly * clock.dt();
  const double ahead = engine->evaluation_time() * clock.dt();
  const WorldState& state = host.state();
  // Controllers have published since the frame of this step was made.
  const std::shared_ptr<Frame> frame = factors_.any() ? frames.latest(factors_.needs()) : nullptr;
  sums_.assign(model->bodies.size(), Wrench());
  // Of a force or wind at this time.
  const auto factor = [&](std::size_t i) {
    const ForceModel& it = model->forces[i];
    if (now < it.from || now >= it.until) return 0.0;
    if (it.factor.empty()) return 1.0;
    const double value = factors_.evaluate(i, *frame);
    return std::isfinite(value) ? value : 0.0;
  };
  Vec3 wind = Vec3::Zero();
  for (std::size_t i = 0; i < model->forces.size(); ++i) {
    const ForceModel& it = model->forces[i];
    if (it.kind == ForceModel::Kind::wind && !it.removed) wind += factor(i) * it.wind;
  }
  for (std::size_t i = 0; i < model->forces.size(); ++i) {
    const ForceModel& it = model->forces[i];
    if (it.removed) continue;
    const PointMotion m = motion_of(state, it.body, it.X_BE.p);
    switch (it.kind) {
      case ForceModel::Kind::force: {
        const double f = factor(i);
        Quat q(1, 0, 0, 0);
        if (it.in_body && it.body != kWorld) q = state.poses[at(it.body)].q * it.X_BE.q;
        add(*model, it.body, state, f * (q * it.force), m.x, f * (q * it.torque));
        break;
      }
      case ForceModel::Kind::drag: {
        if (it.body == kWorld) break;
        const Vec3 u = m.v - it.wind - wind;
        add(*model, it.body, state, -(it.linear + it.quadratic * u.norm()) * u, m.x,
            -it.angular * state.twists[at(it.body)].angular);
        break;
      }
      case ForceModel::Kind::buoyancy:
        buoyancy(model, i, state, ahead);
        break;
      case ForceModel::Kind::wind:
        break;
      case ForceModel::Kind::spring: {
        const PointMotion n = motion_of(state, it.other, it.other_point);
        const Vec3 between = (n.x + ahead * n.v) - (m.x + ahead * m.v);
        const double l = between.norm();
        if (!(l > 1e-9)) break;  // without a direction
        const Vec3 e = between / l;
        double tension = it.stiffness * (l - it.length) + it.damping * e.dot(n.v - m.v);
        if (it.cable) tension = l > it.length ? std::max(tension, 0.0) : 0.0;
        add(*model, it.body, state, tension * e, m.x, Vec3::Zero());
        add(*model, it.other, state, -tension * e, n.x, Vec3::Zero());
        break;
      }
    }
  }
  applied_.erase(std::remove_if(applied_.begin(), applied_.end(),
                                [&](const Applied& it) {
                                  return clock.time() >= it.until ||
                                         model->bodies[at(it.body)].removed;
                                }),
                 applied_.end());
  for (const Applied& it : applied_) {
    const Quat q = it.command.in_body ? state.poses[at(it.body)].q : Quat(1, 0, 0, 0);
    add(*model, it.body, state, q * it.command.force, state.poses[at(it.body)] * it.command.point,
        q * it.command.torque);
  }
  given_ = !model->forces.empty() || !applied_.empty();
  engine->set_external_forces(given_ ? sums_ : std::vector<Wrench>());
}

}  // namespace cogrsim

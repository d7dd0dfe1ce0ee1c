// Forces on bodies, at the time after the start of the step that suits the engine
// (ExternalForces::evaluation_time), with x and v the position and velocity of the element's frame E there:
//   force   factor F at x
//   drag    -(c1 + c2 |u|) u  at x,  u = v - wind,  and the torque -c3 w;  wind: its own, and each of
//           the scene times its factor
//   spring  along e = (x2 - x) / l, l = |x2 - x|:  T = k (l - l0) + d e (v2 - v),  T e at x, -T e at x2
//   buoyancy  -density V g at the centroid of the volume V below the level
// Until then a body moves as the engine expects, or its centre of mass c goes on straight and the body turns about it as it does.
// Each is moved to the centre of mass c of its body: force F, torque (x - c) x F.
#include "simulation/force_system.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/physics/state_ahead.h"
#include "core/index.h"
#include "simulation/find_named.h"

namespace cogrsim {

namespace {

// Of a point of the body, in its frame.
struct PointMotion {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
};

PointMotion point_of(const Pose& X_WB, const Twist& V_WB, const Vec3& point) {
  const Vec3 arm = X_WB.q * point;
  return {X_WB.p + arm, V_WB.at(arm)};
}

}  // namespace

// Where the body will be after the time `ahead` [s].
ForceSystem::Motion ForceSystem::motion_of(const SceneModel& model, int body, double ahead) const {
  if (body == kWorld) return {};
  Motion m{poses_[at(body)], twists_[at(body)]};
  const Body& it = model.bodies[at(body)];
  if (is_ahead_ || !(ahead > 0.0) || it.kind == BodyKind::static_body) return m;
  const Vec3 com =
      it.kind == BodyKind::dynamic ? it.com : Vec3::Zero();  // kinematic: of its origin
  const Vec3 arm = m.X_WB.q * com, v = m.V_WB.at(arm);
  const Vec3 middle = m.X_WB.p + arm + ahead * v;
  if (const double turn = ahead * m.V_WB.angular.norm(); turn > 0.0)
    m.X_WB.q = Quat(Eigen::AngleAxisd(turn, m.V_WB.angular.normalized())) * m.X_WB.q;
  const Vec3 new_arm = m.X_WB.q * com;
  m.X_WB.p = middle - new_arm;
  m.V_WB.linear = v - m.V_WB.angular.cross(new_arm);
  return m;
}

void ForceSystem::add(const SceneModel& model, int body, const Pose& X_WB, const Vec3& force,
                      const Vec3& point, const Vec3& torque) {
  if (body == kWorld || model.bodies[at(body)].kind != BodyKind::dynamic) return;
  Wrench& sum = sums_[at(body)];
  sum.force += force;
  sum.torque += torque + (point - X_WB * model.bodies[at(body)].com).cross(force);
}

void ForceSystem::buoyancy(const SceneModelPtr& model, std::size_t force, double ahead) {
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
  const Pose X_WB = motion_of(*model, it.body, ahead).X_WB;
  for (const geometry::DisplacedShape& shape : shapes) {
    const geometry::Displaced part = shape.below(X_WB, -gravity.normalized(), it.level);
    if (part.volume > 0.0)
      add(*model, it.body, X_WB, -it.density * part.volume * gravity, part.centre, Vec3::Zero());
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
  poses_ = host.state().poses;
  twists_ = host.state().twists;
  auto* const expected = host.world().extension<StateAhead>();
  is_ahead_ = expected != nullptr;
  if (expected) expected->get_state_ahead(ahead, poses_, twists_);
  // Controllers have published since the frame of this step was made.
  const std::shared_ptr<Frame> frame = factors_.any() ? frames.latest(factors_.needs()) : nullptr;
  if (frame) frame->time += ahead;
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
    const Motion body = motion_of(*model, it.body, ahead);
    const PointMotion m = point_of(body.X_WB, body.V_WB, it.X_BE.p);
    switch (it.kind) {
      case ForceModel::Kind::force: {
        const double f = factor(i);
        Quat q(1, 0, 0, 0);
        if (it.in_body && it.body != kWorld) q = body.X_WB.q * it.X_BE.q;
        add(*model, it.body, body.X_WB, f * (q * it.force), m.x, f * (q * it.torque));
        break;
      }
      case ForceModel::Kind::drag: {
        if (it.body == kWorld) break;
        const Vec3 u = m.v - it.wind - wind;
        add(*model, it.body, body.X_WB, -(it.linear + it.quadratic * u.norm()) * u, m.x,
            -it.angular * body.V_WB.angular);
        break;
      }
      case ForceModel::Kind::buoyancy:
        buoyancy(model, i, ahead);
        break;
      case ForceModel::Kind::wind:
        break;
      case ForceModel::Kind::spring: {
        const Motion other = motion_of(*model, it.other, ahead);
        const PointMotion n = point_of(other.X_WB, other.V_WB, it.other_point);
        const Vec3 between = n.x - m.x;
        const double l = between.norm();
        if (!(l > 1e-9)) break;  // without a direction
        const Vec3 e = between / l;
        double tension = it.stiffness * (l - it.length) + it.damping * e.dot(n.v - m.v);
        if (it.cable) tension = l > it.length ? std::max(tension, 0.0) : 0.0;
        add(*model, it.body, body.X_WB, tension * e, m.x, Vec3::Zero());
        add(*model, it.other, other.X_WB, -tension * e, n.x, Vec3::Zero());
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
    const Pose X_WB = motion_of(*model, it.body, ahead).X_WB;
    const Quat q = it.command.in_body ? X_WB.q : Quat(1, 0, 0, 0);
    add(*model, it.body, X_WB, q * it.command.force, X_WB * it.command.point,
        q * it.command.torque);
  }
  given_ = !model->forces.empty() || !applied_.empty();
  engine->set_external_forces(given_ ? sums_ : std::vector<Wrench>());
}

}  // namespace cogrsim

// Forces on bodies, with x and v the position and velocity of the element's frame E:
//   force   factor F at x
//   drag    -(c1 + c2 |u|) u  at x,  u = v - wind,  and the torque -c3 w
//   spring  along e = (x2 - x) / l, l = |x2 - x|:  T = k (l - l0) + d e (v2 - v),  T e at x, -T e at x2;
//           e and l a time after the start of the step that suits the engine
//           (ExternalForces::evaluation_time)
// Each is moved to the centre of mass c of its body: force F, torque (x - c) x F.
#include "simulation/force_system.h"

#include <cmath>

#include "core/index.h"

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

void ForceSystem::apply(WorldHost& host, const Clock& clock, const ChannelLookup& channels,
                        FrameSource& frames) {
  const SceneModelPtr& model = host.model();
  if (model->forces.empty() && !given_) return;
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
  for (std::size_t i = 0; i < model->forces.size(); ++i) {
    const ForceModel& it = model->forces[i];
    if (it.removed) continue;
    const PointMotion m = motion_of(state, it.body, it.X_BE.p);
    switch (it.kind) {
      case ForceModel::Kind::force: {
        if (now < it.from || now >= it.until) break;
        double factor = 1.0;
        if (!it.factor.empty()) factor = factors_.evaluate(i, *frame);
        if (!std::isfinite(factor)) break;
        Quat q(1, 0, 0, 0);
        if (it.in_body && it.body != kWorld) q = state.poses[at(it.body)].q * it.X_BE.q;
        add(*model, it.body, state, factor * (q * it.force), m.x, factor * (q * it.torque));
        break;
      }
      case ForceModel::Kind::drag: {
        if (it.body == kWorld) break;
        const Vec3 u = m.v - it.wind;
        add(*model, it.body, state, -(it.linear + it.quadratic * u.norm()) * u, m.x,
            -it.angular * state.twists[at(it.body)].angular);
        break;
      }
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
  given_ = !model->forces.empty();
  engine->set_external_forces(given_ ? sums_ : std::vector<Wrench>());
}

}  // namespace cogrsim

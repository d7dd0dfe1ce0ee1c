// Conserves the momentum of free mechanisms to rounding.
#include "stepper.h"

namespace cogrsim::dynamics {

void Stepper::measure_momenta(bool inertia) {
  const Mechanism& m = mechanism_;
  if (momenta_.empty()) return;
  const std::vector<LinkMotion>& motions = m.motions();
  for (FreeMomentum& f : momenta_) {
    const Component& c = mechanism_.components()[std::size_t(f.component)];
    f.mass = 0.0;
    f.com = f.linear = f.angular = f.load = f.load_moment = Vec3::Zero();
    Mat3 about_origin = Mat3::Zero();
    for (int index : c.links) {
      const Link& link = m.links()[std::size_t(index)];
      const LinkMotion& motion = motions[std::size_t(index)];
      const Placement& X = motion.X;
      const Vec3 p = X * link.com, omega = motion.angular;
      const Vec3 momentum = link.mass * motion.velocity_at(p);
      const Mat3& R = X.R;
      f.mass += link.mass;
      f.com += link.mass * p;
      f.linear += momentum;
      const Wrench& load = m.loads()[std::size_t(index)];
      f.load += load.force;
      f.load_moment += p.cross(load.force) + load.torque;
      f.angular += R * (link.inertia * (R.transpose() * omega)) + p.cross(momentum);
      if (inertia)
        about_origin += R * link.inertia * R.transpose() +
                        link.mass * (p.squaredNorm() * Mat3::Identity() - p * p.transpose());
    }
    f.com /= f.mass;
    if (!inertia) continue;
    f.inertia = about_origin -
                f.mass * (f.com.squaredNorm() * Mat3::Identity() - f.com * f.com.transpose());
  }
}

void Stepper::conserve_momentum(double h) {
  Mechanism& m = mechanism_;
  if (momenta_.empty()) return;
  start_momenta_ = momenta_;
  measure_momenta(true);
  // Impulses of contact.
  gained_.assign(m.components().size(), Gain());
  for (const Manifold& manifold : contacts_.manifolds()) {
    for (const ContactPoint* point = manifold.first; point != manifold.end; ++point) {
      const ContactOutcome& outcome = contacts_.outcome_of(*point);
      if (!outcome.has_rows) continue;
      const Vec3 moment = point->point.cross(outcome.impulse.force) + outcome.impulse.torque;
      for (int side = 0; side < 2; ++side) {
        if (manifold.component[side] < 0) continue;
        Gain& gained = gained_[std::size_t(manifold.component[side])];
        const double sign = side == 0 ? -1.0 : 1.0;
        gained.linear += sign * outcome.impulse.force;
        gained.angular += sign * moment;
      }
    }
  }
  const std::vector<LinkMotion>& motions = m.motions();
  for (std::size_t i = 0; i < momenta_.size(); ++i) {
    const FreeMomentum& end = momenta_[i];
    if (untouched_[std::size_t(end.component)] ||
        m.components()[std::size_t(end.component)].asleep)
      continue;
    const FreeMomentum& start = start_momenta_[i];
    Vec3 linear = start.linear + h * end.load - end.linear;
    Vec3 angular = start.angular + 0.5 * h * (start.load_moment + end.load_moment) - end.angular;
    linear += gained_[std::size_t(end.component)].linear;
    angular += gained_[std::size_t(end.component)].angular;
    const Vec3 omega = end.inertia.inverse() * (angular - end.com.cross(linear));
    const int first = m.components()[std::size_t(end.component)].links[0];
    const Link& base = m.links()[std::size_t(first)];
    const Vec3 at = motions[std::size_t(first)].X * base.com;
    const Vec3 v = linear / end.mass + omega.cross(at - end.com);
    double* const u = &m.state.change_u()[base.first_u];
    for (int k = 0; k < 3; ++k) {
      u[k] += omega[k];
      u[3 + k] += v[k];
    }
  }
}

}  // namespace cogrsim::dynamics

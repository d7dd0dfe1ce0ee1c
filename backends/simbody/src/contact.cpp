#include "contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cogrsim/physics/scene_state.h"

namespace cogrsim::simbody {

GeneralContact::GeneralContact(const Mechanism& mechanism, const Options& options)
    : mechanism_(mechanism),
      options_(options),
      detector_(mechanism.model()),
      surfaces_(mechanism.model().materials.size() * mechanism.model().materials.size()) {
  const SceneModel& model = mechanism.model();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    motions_.emplace_back().index = mechanism.mobod(int(b)).getMobilizedBodyIndex();
    if (mechanism.body_link(int(b)) < 0 && !model.bodies[b].removed)
      detector_.set_pose(int(b), dynamics::Placement(mechanism.static_poses()[b]), 0.0);
  }
}

const GeneralContact::Surface& GeneralContact::surface(int a, int b) const {
  const SceneModel& model = mechanism_.model();
  Surface& out = surfaces_[std::size_t(a) * model.materials.size() + std::size_t(b)];
  if (out.known) return out;
  const SurfacePair pair = surface_pair(model, a, b);
  out.known = true;
  out.mu = pair.friction;
  out.rolling = pair.rolling_friction;
  out.spinning = pair.spinning_friction;
  out.k = pair.stiffness.value_or(options_.stiffness);
  out.c = options_.dissipation > 0.0 ? options_.dissipation
                                     : dissipation_of(pair.restitution, options_.impact_speed);
  return out;
}

double GeneralContact::stiffness(const dynamics::Collider& a, const dynamics::Collider& b) const {
  const double given = surface(a.material, b.material).k;
  if (given > 0.0) return given;
  const auto inverse_mass = [&](int index) {
    const Body& body = mechanism_.model().bodies[index];
    return body.kind == BodyKind::dynamic ? 1.0 / body.mass : 0.0;
  };
  return options_.frequency * options_.frequency / (inverse_mass(a.body) + inverse_mass(b.body));
}

SimTK::SpatialVec GeneralContact::push(const dynamics::ContactPoint& point) const {
  const dynamics::Collider& a = detector_.colliders()[point.collider_a];
  const dynamics::Collider& b = detector_.colliders()[point.collider_b];
  const Surface& between = surface(a.material, b.material);
  const Motion &A = motions_[a.body], &B = motions_[b.body];
  const SimTK::Vec3 n = to_simtk(point.normal), at = to_simtk(point.point);
  const SimTK::Vec3 v = B.V[1] + B.V[0] % (at - B.p) - A.V[1] - A.V[0] % (at - A.p);
  const double separation_speed = SimTK::dot(v, n);
  const double f = stiffness(a, b) * -point.gap * (1.0 - between.c * separation_speed);
  if (point.gap >= 0.0 || f <= 0.0) return SimTK::SpatialVec(SimTK::Vec3(0));
  const SimTK::Vec3 slip = v - separation_speed * n + to_simtk(detector_.surface_velocity(point));
  // Against a speed or spin s: bound f min(s / v_t, 1) along s / |s|; nothing is divided by zero.
  const auto resist = [&](double bound, const SimTK::Vec3& rate) {
    return -bound * f / std::max(rate.norm(), options_.transition_velocity) * rate;
  };
  const SimTK::Vec3 turning = B.V[0] - A.V[0], spin = SimTK::dot(turning, n) * n;
  return {resist(between.rolling, turning - spin) + resist(between.spinning, spin),
          f * n + resist(between.mu, slip)};
}

void GeneralContact::calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& forces,
                               SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector&) const {
  const std::vector<Contact>& contacts = read(state);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const SimTK::Vec3 force = to_simtk(contact.force), at = to_simtk(contact.point);
    const Motion &A = motions_[contact.body_a], &B = motions_[contact.body_b];
    forces[A.index] -= SimTK::SpatialVec((at - A.p) % force + torques_[i], force);
    forces[B.index] += SimTK::SpatialVec((at - B.p) % force + torques_[i], force);
  }
}

const std::vector<Contact>& GeneralContact::read(const SimTK::State& state) const {
  // Where a step of the integrator ends the next one begins.
  const auto same = [](const SimTK::Vector& a, const SimTK::Vector& b) {
    return a.size() > 0 && a.size() == b.size() && std::equal(&a[0], &a[0] + a.size(), &b[0]);
  };
  if (same(q_, state.getQ()) && same(u_, state.getU())) return contacts_;
  for (const Link& link : mechanism_.links()) {
    if (link.slave || detector_.bounding_radius(link.body) <= 0.0) continue;
    const SimTK::Transform& X = link.mobod.getBodyTransform(state);
    Motion& motion = motions_[link.body];
    motion = {X.p(), link.mobod.getBodyVelocity(state), motion.index};
    detector_.set_pose(
        link.body,
        dynamics::Placement(Eigen::Map<const Mat3>(&X.R().asMat33()(0, 0)), from_simtk(X.p())),
        0.0);
  }
  detector_.detect(points_);
  contacts_.clear();
  torques_.clear();
  for (const dynamics::ContactPoint& point : points_) {
    const dynamics::Collider& a = detector_.colliders()[point.collider_a];
    const dynamics::Collider& b = detector_.colliders()[point.collider_b];
    const SimTK::SpatialVec wrench = push(point);
    torques_.push_back(wrench[0]);
    contacts_.push_back({a.body, b.body, a.shape, b.shape, point.point, point.normal, -point.gap,
                         from_simtk(SimTK::Vec3(wrench[1]))});
  }
  q_ = state.getQ();
  u_ = state.getU();
  return contacts_;
}

void ContactReport::add(const std::vector<Contact>& now, double h) {
  for (const std::vector<Contact>* part : {&std::as_const(last_), &now})
    for (const Contact& contact : *part) {
      const auto [first, end] = std::equal_range(sums_.begin(), sums_.end(), contact, comes_before);
      auto sum = std::find_if(first, end, [&](const Contact& old) {
        return (old.point - contact.point).norm() < 0.02;
      });
      if (sum == end) {
        sum = sums_.insert(sum, contact);
        sum->force = Vec3::Zero();
      }
      sum->force += 0.5 * h * contact.force;
      sum->point = contact.point;
      sum->normal = contact.normal;
      sum->depth = contact.depth;
    }
  last_ = now;
}

std::vector<Contact> ContactReport::get(double dt) const {
  std::vector<Contact> out = sums_;
  for (Contact& contact : out) contact.force /= dt;
  return out;
}

}  // namespace cogrsim::simbody

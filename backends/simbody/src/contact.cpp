#include "contact.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cogrsim::simbody {

GeneralContact::GeneralContact(const Mechanism& mechanism, const Options& options)
    : mechanism_(mechanism),
      options_(options),
      detector_(mechanism.model()),
      surfaces_(mechanism.model().materials.size() * mechanism.model().materials.size()) {
  const SceneModel& model = mechanism.model();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (mechanism.body_link(int(b)) < 0 && !model.bodies[b].removed)
      detector_.place(int(b), dynamics::Placement(mechanism.places()[b]), 0.0);
  }
}

const GeneralContact::Surface& GeneralContact::surface(int a, int b) const {
  const SceneModel& model = mechanism_.model();
  Surface& out = surfaces_[std::size_t(a) * model.materials.size() + std::size_t(b)];
  if (out.known) return out;
  const SurfacePair pair = surface_pair(model, a, b);
  out.known = true;
  out.mu = pair.friction;
  out.k = pair.stiffness.value_or(options_.stiffness);
  out.c = options_.dissipation > 0.0 ? options_.dissipation
                                     : dissipation_of(pair.restitution, options_.impact_speed);
  return out;
}

double GeneralContact::stiffness(const dynamics::Collider& a, const dynamics::Collider& b) const {
  const double given = surface(a.material, b.material).k;
  if (given > 0.0) return given;
  const auto inverse_mass = [&](int index) {
    const Body& body = mechanism_.model().bodies[std::size_t(index)];
    return body.kind == BodyKind::dynamic ? 1.0 / body.mass : 0.0;
  };
  return options_.frequency * options_.frequency / (inverse_mass(a.body) + inverse_mass(b.body));
}

SimTK::Vec3 GeneralContact::push(const SimTK::State& state,
                                 const dynamics::ContactPoint& point) const {
  const dynamics::Collider& a = detector_.colliders()[std::size_t(point.collider_a)];
  const dynamics::Collider& b = detector_.colliders()[std::size_t(point.collider_b)];
  const Surface& between = surface(a.material, b.material);
  const SimTK::MobilizedBody &A = mechanism_.mobod(a.body), &B = mechanism_.mobod(b.body);
  const SimTK::SpatialVec &V_a = A.getBodyVelocity(state), &V_b = B.getBodyVelocity(state);
  const SimTK::Vec3 n = to_simtk(point.normal), at = to_simtk(point.point);
  const SimTK::Vec3 v = V_b[1] + V_b[0] % (at - B.getBodyOriginLocation(state)) - V_a[1] -
                        V_a[0] % (at - A.getBodyOriginLocation(state));
  const double apart = SimTK::dot(v, n);
  const double f = stiffness(a, b) * -point.gap * (1.0 - between.c * apart);
  if (point.gap >= 0.0 || f <= 0.0) return SimTK::Vec3(0);
  const SimTK::Vec3 slip = v - apart * n;
  // mu f min(s / v_t, 1) along slip / s, s its size; nothing is divided by zero.
  return f * n - (between.mu * f / std::max(slip.norm(), options_.transition_velocity)) * slip;
}

void GeneralContact::calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& forces,
                               SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector&) const {
  read(state, contacts_);
  for (const Contact& contact : contacts_) {
    const SimTK::Vec3 force = to_simtk(contact.force), at = to_simtk(contact.point);
    const SimTK::MobilizedBody &A = mechanism_.mobod(contact.body_a),
                               &B = mechanism_.mobod(contact.body_b);
    forces[A.getMobilizedBodyIndex()] -=
        SimTK::SpatialVec((at - A.getBodyOriginLocation(state)) % force, force);
    forces[B.getMobilizedBodyIndex()] +=
        SimTK::SpatialVec((at - B.getBodyOriginLocation(state)) % force, force);
  }
}

void GeneralContact::read(const SimTK::State& state, std::vector<Contact>& out) const {
  for (const Link& link : mechanism_.links()) {
    if (link.slave || detector_.reach(link.body) <= 0.0) continue;
    const SimTK::Transform& X = link.mobod.getBodyTransform(state);
    detector_.place(
        link.body,
        dynamics::Placement(Eigen::Map<const Mat3>(&X.R().asMat33()(0, 0)), from_simtk(X.p())),
        0.0);
  }
  detector_.detect(points_);
  out.clear();
  for (const dynamics::ContactPoint& point : points_) {
    const dynamics::Collider& a = detector_.colliders()[std::size_t(point.collider_a)];
    const dynamics::Collider& b = detector_.colliders()[std::size_t(point.collider_b)];
    Contact contact;
    contact.body_a = a.body;
    contact.shape_a = a.shape;
    contact.body_b = b.body;
    contact.shape_b = b.shape;
    contact.point = point.point;
    contact.normal = point.normal;
    contact.depth = -point.gap;
    contact.force = from_simtk(push(state, point));
    out.push_back(contact);
  }
}

void ContactReport::start(const std::vector<Contact>& now) {
  last_ = now;
  sums_.clear();
}

void ContactReport::add(const std::vector<Contact>& now, double h) {
  const auto shapes = [](const Contact& c) {
    return std::tie(c.body_a, c.body_b, c.shape_a, c.shape_b);
  };
  const auto add_part = [&](const std::vector<Contact>& part) {
    for (const Contact& contact : part) {
      auto sum = std::find_if(sums_.begin(), sums_.end(), [&](const Contact& old) {
        return shapes(old) == shapes(contact) && (old.point - contact.point).norm() < 0.02;
      });
      if (sum == sums_.end()) {
        sum = sums_.insert(sum, contact);
        sum->force = Vec3::Zero();
      }
      sum->force += 0.5 * h * contact.force;
      sum->point = contact.point;
      sum->normal = contact.normal;
      sum->depth = contact.depth;
    }
  };
  add_part(last_);
  add_part(now);
  last_ = now;
}

void ContactReport::get(double dt, std::vector<Contact>& out) const {
  out = sums_;
  for (Contact& contact : out) contact.force /= dt;
  std::stable_sort(out.begin(), out.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.body_a, a.body_b, a.shape_a, a.shape_b) <
           std::tie(b.body_a, b.body_b, b.shape_a, b.shape_b);
  });
}

}  // namespace cogrsim::simbody

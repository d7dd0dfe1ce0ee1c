#include "collision/compliant_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cogrsim/physics/scene_state.h"

namespace cogrsim::dynamics {

namespace {

// One component after the other, as a program without Eigen would: its results are the same bits.
double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

double dissipation_of(double restitution, double speed) {
  constexpr double kLeast = 0.04;
  const double e = std::max(restitution, kLeast);
  if (e >= 1.0) return 0.0;
  // y = c v solves y - ln(1 + y) = -e y - ln(1 - e y), 0 < y < 1/e; the left side wins for small y.
  double low = 0.0, high = 1.0 / e;
  for (int i = 0; i < 200; ++i) {
    const double y = 0.5 * (low + high);
    const bool below = y - std::log1p(y) > -e * y - std::log1p(-e * y);
    (below ? low : high) = y;
  }
  return 0.5 * (low + high) / speed;
}

CompliantContact::CompliantContact(const SceneModel& model, const CompliantLaw& law,
                                   const std::vector<Pose>& still)
    : model_(model),
      law_(law),
      detector_(model),
      motions_(model.bodies.size()),
      surfaces_(model.materials.size() * model.materials.size()) {
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].kind == BodyKind::static_body && !model.bodies[b].removed)
      detector_.set_pose(int(b), Placement(still[b]), 0.0);
}

const CompliantContact::Surface& CompliantContact::surface(int a, int b) {
  Surface& out = surfaces_[std::size_t(a) * model_.materials.size() + std::size_t(b)];
  if (out.known) return out;
  const SurfacePair pair = surface_pair(model_, a, b);
  out.known = true;
  out.mu = pair.friction;
  out.rolling = pair.rolling_friction;
  out.spinning = pair.spinning_friction;
  out.k = pair.stiffness.value_or(law_.stiffness);
  out.c = law_.dissipation > 0.0 ? law_.dissipation
                                 : dissipation_of(pair.restitution, law_.impact_speed);
  return out;
}

double CompliantContact::stiffness(const Surface& surface, int body_a, int body_b) const {
  if (surface.k > 0.0) return surface.k;
  const auto inverse_mass = [&](int index) {
    const Body& body = model_.bodies[std::size_t(index)];
    return body.kind == BodyKind::dynamic ? 1.0 / body.mass : 0.0;
  };
  return law_.frequency * law_.frequency / (inverse_mass(body_a) + inverse_mass(body_b));
}

void CompliantContact::set_body(int body, const Placement& X, const Twist& V) {
  motions_[std::size_t(body)] = {X.p, V};
  detector_.set_pose(body, X, 0.0);
}

void CompliantContact::push(const ContactPoint& point) {
  const Collider& a = detector_.colliders()[std::size_t(point.collider_a)];
  const Collider& b = detector_.colliders()[std::size_t(point.collider_b)];
  const Surface& between = surface(a.material, b.material);
  const Motion &A = motions_[std::size_t(a.body)], &B = motions_[std::size_t(b.body)];
  contacts_.push_back({a.body, b.body, a.shape, b.shape, point.point, point.normal, -point.gap});
  torques_.emplace_back(Vec3::Zero());
  const Vec3& n = point.normal;
  const Vec3 v = B.V.linear + B.V.angular.cross(point.point - B.p) - A.V.linear -
                 A.V.angular.cross(point.point - A.p);
  const double separation_speed = dot(v, n);
  const double f =
      stiffness(between, a.body, b.body) * -point.gap * (1.0 - between.c * separation_speed);
  if (point.gap >= 0.0 || f <= 0.0) return;
  const Vec3 slip = v - separation_speed * n + detector_.surface_velocity(point);
  // Against a speed or spin s: bound f min(s / v_t, 1) along s / |s|; nothing is divided by zero.
  const auto resist = [&](double bound, const Vec3& rate) -> Vec3 {
    return -bound * f / std::max(std::sqrt(dot(rate, rate)), law_.transition_velocity) * rate;
  };
  const Vec3 turning = B.V.angular - A.V.angular, spin = dot(turning, n) * n;
  torques_.back() = resist(between.rolling, turning - spin) + resist(between.spinning, spin);
  contacts_.back().force = f * n + resist(between.mu, slip);
}

void CompliantContact::find() {
  detector_.detect(points_);
  contacts_.clear();
  torques_.clear();
  for (const ContactPoint& point : points_) push(point);
}

void ContactMeans::add(const std::vector<Contact>& now, double h) {
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

std::vector<Contact> ContactMeans::get(double dt) const {
  std::vector<Contact> out = sums_;
  for (Contact& contact : out) contact.force /= dt;
  return out;
}

}  // namespace cogrsim::dynamics

#include "contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cogrsim/physics/friction_share.h"
#include "collision/contact_rates.h"

namespace cogrsim::dynamics {
namespace {

// Contact points of successive steps that are nearer than this are the same point [m].
constexpr double kSamePoint = 0.02;

// Speculative margin of a body at rest [m], but not more than half its thickness: what is thinner would touch
// with its far side, too.
constexpr double kRestMargin = 1e-4;

// A cylinder whose ends are less than this, and this much of its length, apart in height touches
// along its whole line: contact leaves gaps of up to 1e-5 m (kTouching in rows.cpp) [m], [rad].
constexpr double kFlush = 1e-5;
constexpr double kTilt = 1e-3;

// At once, and more than is needed now: the numbers of contacts change from step to step.
template <class T>
void make_room(std::vector<T>& items, std::size_t count) {
  if (count > items.capacity()) items.reserve(count + count / 4);
}

bool same_pair(const ContactPoint& a, const ContactPoint& b) {
  return a.collider_a == b.collider_a && a.collider_b == b.collider_b;
}

// What the sweeps leave of forces that only press the points of a face against each other would
// stay for ever: the start, `warm`, is made without it.
void share_warm_friction(const std::vector<ContactRows>& contacts, std::size_t first,
                         std::vector<Vec3>& warm) {
  constexpr double kSameNormal = 1.0 - 1e-6;  // cosine
  constexpr std::size_t kMost = 16;
  const std::size_t count = warm.size();
  if (count < 2 || count > kMost || contacts[first].friction <= 0.0) return;
  const Vec3& normal = contacts[first].point->normal;
  for (std::size_t k = 0; k < count; ++k) {
    const ContactRows& contact = contacts[first + k];
    if (contact.kind != FrictionKind::point || contact.point->normal.dot(normal) <= kSameNormal)
      return;
  }
  std::array<double, kMost> loads;
  std::array<Vec3, kMost> points, friction;
  for (std::size_t k = 0; k < count; ++k) {
    loads[k] = std::max(warm[k].dot(normal), 0.0);
    points[k] = contacts[first + k].point->point;
    friction[k] = warm[k] - loads[k] * normal;
  }
  share_friction(count, normal, loads.data(), points.data(), friction.data());
  for (std::size_t k = 0; k < count; ++k) warm[k] = loads[k] * normal + friction[k];
}

Vec3 friction_impulse_of(const RowSet& set, const ContactRows& contact) {
  const Row* const rows = &set.rows[std::size_t(contact.first)];
  if (contact.kind == FrictionKind::point)
    return rows[1].lambda * contact.tangent1 + rows[2].lambda * contact.tangent2;
  // Friction of a line as forces at its two ends: half of what slides each, and the twist as a
  // couple.
  const ContactRows& partner = set.contacts[std::size_t(contact.partner)];
  const bool second = contact.kind == FrictionKind::twist;
  const ContactRows& patch = second ? partner : contact;
  const ContactRows& twist = second ? contact : partner;
  const Row* const slide = &set.rows[std::size_t(patch.first)];
  const Vec3 half = 0.5 * (slide[1].lambda * patch.tangent1 + slide[2].lambda * patch.tangent2);
  const Vec3 r = contact.point->point - partner.point->point;
  const double couple = set.rows[std::size_t(twist.first + 1)].lambda;
  return half + couple / std::max(r.squaredNorm(), 1e-18) * contact.point->normal.cross(r);
}

// On b, at the point.
Wrench impulse_of(const RowSet& set, const ContactRows& contact) {
  Wrench impulse;
  impulse.force = set.rows[std::size_t(contact.first)].lambda * contact.point->normal;
  if (contact.friction > 0.0) impulse.force += friction_impulse_of(set, contact);
  for (int i = 0; i < contact.turning_rows(); ++i)
    impulse.torque +=
        set.rows[std::size_t(contact.first_turning() + i)].lambda * contact.turning_axis(i);
  return impulse;
}

// What the position stage found for a contact, its friction's only where that is of the point.
Vec3 position_impulse_of(const RowSet& set, const ContactRows& contact) {
  const Row* const rows = &set.rows[std::size_t(contact.first)];
  const Vec3 impulse = rows[0].position_impulse * contact.point->normal;
  if (contact.friction <= 0.0 || contact.kind != FrictionKind::point) return impulse;
  return impulse + rows[1].position_impulse * contact.tangent1 +
         rows[2].position_impulse * contact.tangent2;
}

}  // namespace

Contacts::Contacts(Mechanism& mechanism, Detector& detector, double tolerance, WorkerPool* pool)
    : mechanism_(mechanism),
      detector_(detector),
      tolerance_(tolerance),
      pool_(pool),
      margins_(mechanism.links().size(), 0.0) {
  for (const Link& link : mechanism.links())
    has_shapes_ = has_shapes_ || detector.bounding_radius(link.plan.body) > 0.0;
  const SceneModel& model = mechanism.model();
  const int n = int(model.materials.size());
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) surfaces_.push_back(surface_pair(model, a, b));
}

void Contacts::clear() {
  points_.clear();
  manifolds_.clear();
  outcomes_.clear();
}

void Contacts::measure_speeds(double h) {
  const double fall = 0.5 * h * h * mechanism_.model().physics.gravity.norm();
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  for (std::size_t i = 0; i < margins_.size(); ++i) {
    const Link& link = mechanism_.links()[i];
    const double radius = detector_.bounding_radius(link.plan.body);
    if (link.plan.shadow || radius == 0.0) continue;
    const LinkMotion& motion = motions[i];
    const double spin = std::isfinite(radius) ? radius * motion.angular.norm() : 0.0;
    const double rest = std::min(kRestMargin, detector_.thinness(link.plan.body));
    margins_[i] = rest + fall + h * (motion.linear.norm() + spin);
  }
}

void Contacts::detect(double h, const std::vector<WarmContact>& last) {
  clear();
  if (!has_shapes_) return;
  const std::vector<Link>& links = mechanism_.links();
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  offsets_.clear();
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int body = links[i].plan.body;
    if (links[i].plan.shadow || detector_.bounding_radius(body) == 0.0) continue;
    Placement X = motions[i].X;
    const Vec3 offset = 0.5 * h * motions[i].velocity_at(X * links[i].com);
    double rest = 0.5 * h;
    if (offset.norm() > detector_.thinness(body)) {
      offsets_.resize(mechanism_.model().bodies.size(), Vec3::Zero());
      offsets_[std::size_t(body)] = offset;
      X.p -= offset;
      rest = h;
    }
    detector_.set_pose(body, X, margins_[i], rest * motions[i].linear, rest * motions[i].angular);
  }
  detector_.detect(points_, pool_);
  if (!offsets_.empty()) {
    const std::vector<Collider>& colliders = detector_.colliders();
    for (ContactPoint& point : points_) {
      const Vec3& a = offsets_[std::size_t(colliders[std::size_t(point.collider_a)].body)];
      const Vec3& b = offsets_[std::size_t(colliders[std::size_t(point.collider_b)].body)];
      point.gap += point.normal.dot(b - a);
      point.point += 0.5 * (a + b);
    }
  }
  find_manifolds(last);
}

void Contacts::find_manifolds(const std::vector<WarmContact>& last) {
  last_of_.clear();
  taken_.assign(last.size(), 0);
  outcomes_.assign(points_.size(), {});
  const std::vector<Collider>& colliders = detector_.colliders();
  const auto pair_of = [](const auto& c) { return std::pair(c.collider_a, c.collider_b); };
  std::size_t old = 0;
  for (std::size_t first = 0, end = 0; first < points_.size(); first = end) {
    const ContactPoint& point = points_[first];
    for (end = first + 1; end < points_.size() && same_pair(points_[end], point); ++end) continue;
    Manifold m;
    m.first = &point;
    m.end = points_.data() + end;
    const Collider* const sides[2] = {&colliders[std::size_t(point.collider_a)],
                                      &colliders[std::size_t(point.collider_b)]};
    for (int i = 0; i < 2; ++i) {
      m.link[i] = mechanism_.body_link(sides[i]->body);
      const int component =
          m.link[i] < 0 ? -1 : mechanism_.links()[std::size_t(m.link[i])].component;
      if (component >= 0 && mechanism_.components()[std::size_t(component)].size() > 0)
        m.component[i] = component;
    }
    if (m.component[0] < 0 && m.component[1] < 0) continue;
    m.surface = &surfaces_[std::size_t(sides[0]->material) * mechanism_.model().materials.size() +
                           std::size_t(sides[1]->material)];
    m.is_line = is_line(m);
    manifolds_.push_back(m);
    Range range;
    while (old < last.size() && pair_of(last[old]) < pair_of(point)) ++old;
    for (range.first = old; old < last.size() && pair_of(last[old]) == pair_of(point);) ++old;
    range.end = old;
    last_of_.push_back(range);
  }
}

// Of a cylinder or capsule on its side.
bool Contacts::is_line(const Manifold& m) const {
  if (m.end - m.first != 2) return false;
  const ContactPoint &one = m.first[0], &two = m.first[1];
  const auto round = [&](int collider) {
    const ShapeType type = detector_.colliders()[std::size_t(collider)].type;
    return type == ShapeType::cylinder || type == ShapeType::capsule;
  };
  if (!round(one.collider_a) && !round(one.collider_b)) return false;
  // A line lies across the normal; two ends of a pair with different normals are no line, nor are
  // ends of which one is off the ground, as of a coin that leans.
  if (two.normal.dot(one.normal) < 0.9999) return false;
  return std::abs(two.gap - one.gap) <= kFlush + kTilt * (two.point - one.point).norm();
}

Vec3 Contacts::convective_acceleration(int index, const Vec3& point) const {
  if (index < 0) return Vec3::Zero();
  const Link& link = mechanism_.links()[std::size_t(index)];
  const LinkMotion& motion = mechanism_.motions()[std::size_t(index)];
  const auto about = [&](const Vec3& centre) {
    return motion.angular.cross(motion.angular.cross(point - centre));
  };
  if (link.component < 0) return about(motion.X.p);
  const Component& c = mechanism_.components()[std::size_t(link.component)];
  if (c.is_free_body) return about(motion.X * link.com);
  return bias_at(c, c.find(index), motion, point);
}

// Of velocity, and of what the speeds make of it.
ContactMotion Contacts::motion_at(const Manifold& manifold, const ContactPoint& point,
                                  double h) const {
  static const LinkMotion rest;
  const std::vector<LinkMotion>& motions = mechanism_.motions();
  const auto [link_a, link_b] = manifold.link;
  const LinkMotion& motion_a = link_a < 0 ? rest : motions[std::size_t(link_a)];
  const LinkMotion& motion_b = link_b < 0 ? rest : motions[std::size_t(link_b)];
  ContactMotion out;
  out.surface = detector_.surface_velocity(point);
  const Vec3& n = point.normal;
  const Vec3 v = motion_b.velocity_at(point.point) - motion_a.velocity_at(point.point);
  out.velocity = v;
  const Vec3 slip = v - n.dot(v) * n;
  const double turn2 = std::max(motion_a.angular.squaredNorm(), motion_b.angular.squaredNorm());
  // No surface is straighter than kStraight or sharper than kSharp. What changes velocities by less than a tenth of
  // what the sweeps leave is none.
  if (kStraight * turn2 + slip.squaredNorm() / kSharp < 0.1 * tolerance_ / h) return out;
  const ContactRates rates = find_contact_rates(
      detector_.colliders()[std::size_t(point.collider_a)],
      detector_.colliders()[std::size_t(point.collider_b)], point,
      manifold.end - manifold.first == 1, motion_a.angular, motion_b.angular, slip);
  const Vec3 turning = convective_acceleration(link_b, point.point) -
                       convective_acceleration(link_a, point.point) +
                       motion_b.angular.cross(rates.on_b) - motion_a.angular.cross(rates.on_a) +
                       rates.normal.dot(slip) * n;
  // A turn of more than a radian in a step is none that a derivative continues.
  const double turn = h * h * turn2;
  const double share = 1.0 / (1.0 + turn * turn);
  if (turning.allFinite() && std::isfinite(share)) out.turning = share * turning;
  return out;
}

void Contacts::build_rows(const StepContext& context, const Manifold& manifold, RowSet& set) const {
  static thread_local std::vector<ContactMotion> motions;
  motions.clear();
  for (const ContactPoint* point = manifold.first; point != manifold.end; ++point)
    motions.push_back(motion_at(manifold, *point, context.h));
  RowBuilder(mechanism_, set).add_contacts(context, manifold, motions.data());
}

bool Contacts::can_yield(const StepContext& context, const Manifold& manifold) const {
  static thread_local RowSet rows;
  rows.clear();
  build_rows(context, manifold, rows);
  return !rows.contacts.empty();
}

void Contacts::add_rows(const StepContext& context, std::size_t index,
                        const std::vector<WarmContact>& last, RowSet& set) {
  const std::size_t first = set.contacts.size();
  build_rows(context, manifolds_[index], set);
  if (set.contacts.size() == first) return;
  warm_start(context.h, index, last, set, first);
  balance_pair(context.h, set, first);
}

void Contacts::warm_start(double h, std::size_t manifold, const std::vector<WarmContact>& last,
                          RowSet& set, std::size_t first) {
  const Range range = last_of_[manifold];
  if (range.first == range.end) return;
  static thread_local std::vector<Vec3> warm;  // impulses
  warm.assign(set.contacts.size() - first, Vec3::Zero());
  const int collider = manifolds_[manifold].first->collider_b;
  const Placement& X_b = detector_.colliders()[std::size_t(collider)].X_WS;
  for (std::size_t k = 0; k < warm.size(); ++k) {
    const ContactRows& contact = set.contacts[first + k];
    const Vec3 point_B = X_b.to_local(contact.point->point);
    double nearest = kSamePoint * kSamePoint;
    std::size_t best = range.end;
    for (std::size_t i = range.first; i < range.end; ++i) {
      const double d = (last[i].point_B - point_B).squaredNorm();
      if (taken_[i] || d >= nearest) continue;
      nearest = d;
      best = i;
    }
    if (best == range.end) continue;
    taken_[best] = 1;
    const WarmContact& found = last[best];
    warm[k] = h * found.wrench.force;
    Row* const rows = &set.rows[std::size_t(contact.first)];
    for (int i = 0; i < contact.turning_rows(); ++i)
      set.rows[std::size_t(contact.first_turning() + i)].lambda =
          h * found.wrench.torque.dot(contact.turning_axis(i));
    rows[0].position_impulse = found.position_impulse.dot(contact.point->normal);
    if (contact.friction <= 0.0 || contact.kind != FrictionKind::point) continue;
    rows[1].position_impulse = found.position_impulse.dot(contact.tangent1);
    rows[2].position_impulse = found.position_impulse.dot(contact.tangent2);
  }
  share_warm_friction(set.contacts, first, warm);
  for (std::size_t k = 0; k < warm.size(); ++k) {
    const ContactRows& contact = set.contacts[first + k];
    const Vec3& normal = contact.point->normal;
    Row* const rows = &set.rows[std::size_t(contact.first)];
    rows[0].lambda = std::max(warm[k].dot(normal), 0.0);
    if (contact.friction <= 0.0) continue;
    Vec3 impulse = warm[k];
    if (contact.kind != FrictionKind::point) {
      const Vec3& other = warm[1 - k];
      if (contact.kind == FrictionKind::twist) {
        const Vec3 arm = 0.5 * (contact.point->point - set.contacts[first + 1 - k].point->point);
        rows[1].lambda = normal.dot(arm.cross(impulse - other));
        continue;
      }
      impulse += other;
    }
    rows[1].lambda = impulse.dot(contact.tangent1);
    rows[2].lambda = impulse.dot(contact.tangent2);
  }
}

void Contacts::balance_pair(double h, RowSet& set, std::size_t first) const {
  constexpr double kYield = 5e-3;  // of the effective inverse mass of the points
  // A light body under a heavy one has little effective mass and much load: beyond a load of so many
  // times its weight it yields less, or the heavy one would tilt on it slowly.
  constexpr double kLoad = 100.0;
  const double most = kLoad * h * mechanism_.model().physics.gravity.norm();
  double sum = 0.0, inverse_mass = 0.0;
  int resting = 0;
  const auto rests = [](const Row& row) { return row.has_gap && row.stays && !row.bilateral; };
  for (std::size_t i = first; i < set.contacts.size(); ++i) {
    const Row& row = set.rows[std::size_t(set.contacts[i].first)];
    if (!rests(row)) continue;
    sum += row.lambda;
    inverse_mass += row.diagonal;
    ++resting;
  }
  if (resting < 2) return;
  // The same yield for all: then the loads are their mean, projected onto those that balance, which
  // never adds to them. Else points that press against each other would. Of up to kMost points, as
  // NormalBlock, the mean is that of this step, found by the sweeps; else it is the last step's, and what
  // lands on a light body falls until it has grown.
  const bool together =
      resting == int(set.contacts.size() - first) && resting <= NormalBlock::kMost;
  double yield = kYield * inverse_mass / resting;
  const double speed = inverse_mass * sum / (resting * resting);
  if (most > 0.0 && speed > most)
    yield *= std::max(most / speed * (most / speed), 0.1 * most / speed);
  for (std::size_t i = first; i < set.contacts.size(); ++i) {
    Row& row = set.rows[std::size_t(set.contacts[i].first)];
    if (!rests(row)) continue;
    row.gamma = yield;
    if (!together) row.target += row.gamma * sum / resting;
    row.inverse = 1.0 / (row.diagonal + row.gamma);
  }
}

void Contacts::take_outcomes(const RowSet& set) {
  for (const ContactRows& contact : set.contacts) {
    ContactOutcome& out = outcomes_[std::size_t(contact.point - points_.data())];
    const Row& normal = set.rows[std::size_t(contact.first)];
    out.has_rows = true;
    out.loaded = normal.lambda > 0.0;
    out.is_kept = out.loaded || contact.kind != FrictionKind::point;
    out.gap = normal.has_gap ? normal.gap + normal.gap_change : contact.point->gap;
    out.impulse = impulse_of(set, contact);
    out.position_impulse = position_impulse_of(set, contact);
  }
}

void Contacts::remember(double h, std::vector<WarmContact>& out) const {
  out.clear();
  make_room(out, points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactOutcome& outcome = outcomes_[i];
    if (!outcome.is_kept) continue;
    WarmContact& w = out.emplace_back();
    w.collider_a = points_[i].collider_a;
    w.collider_b = points_[i].collider_b;
    const Placement& X_b = detector_.colliders()[std::size_t(w.collider_b)].X_WS;
    w.point_B = X_b.to_local(points_[i].point);
    w.wrench.force = outcome.impulse.force / h;
    w.wrench.torque = outcome.impulse.torque / h;
    w.position_impulse = outcome.position_impulse;
  }
}

void Contacts::report(std::vector<ContactRecord>& records) const {
  const std::size_t earlier = records.size();
  make_room(records, earlier + points_.size());
  for (std::size_t index = 0; index < points_.size(); ++index) {
    const ContactPoint& point = points_[index];
    const ContactOutcome& outcome = outcomes_[index];
    if (!outcome.has_rows || (!outcome.loaded && point.gap > 0.0)) continue;
    // A step in parts touches the same point several times.
    ContactRecord* same = nullptr;
    for (std::size_t i = 0; i < earlier && !same; ++i) {
      ContactRecord& r = records[i];
      if (r.collider_a == point.collider_a && r.collider_b == point.collider_b &&
          (r.point - point.point).norm() < kSamePoint)
        same = &r;
    }
    if (!same) same = &records.emplace_back();
    same->collider_a = point.collider_a;
    same->collider_b = point.collider_b;
    same->point = point.point;
    same->normal = point.normal;
    same->gap = outcome.gap;
    same->impulse.force += outcome.impulse.force;
    same->impulse.torque += outcome.impulse.torque;
  }
}

}  // namespace cogrsim::dynamics

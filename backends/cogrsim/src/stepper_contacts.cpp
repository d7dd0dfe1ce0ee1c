// What contacts and joints' rows take from the step before and leave to the next, and what is
// reported of them.
#include <algorithm>
#include <array>
#include <cmath>

#include "cogrsim/physics/friction_share.h"
#include "stepper.h"

namespace cogrsim::dynamics {
namespace {

// Contact points of successive steps that are nearer than this are the same point [m].
constexpr double kSamePoint = 0.02;

}  // namespace

Wrench Stepper::impulse_of(const ContactRows& contact) const {
  Wrench impulse;
  impulse.force = set_.rows[std::size_t(contact.first)].lambda * contact.point.normal;
  if (contact.friction > 0.0) impulse.force += friction_impulse_of(contact);
  for (int i = 0; i < contact.turning_rows(); ++i)
    impulse.torque +=
        set_.rows[std::size_t(contact.first_turning() + i)].lambda * contact.turning_axis(i);
  return impulse;
}

Vec3 Stepper::friction_impulse_of(const ContactRows& contact) const {
  const Row* const rows = &set_.rows[std::size_t(contact.first)];
  if (contact.kind == FrictionKind::point)
    return rows[1].lambda * contact.tangent1 + rows[2].lambda * contact.tangent2;
  // Friction of a line as forces at its two ends: half of what slides each, and the twist as a
  // couple.
  const ContactRows& partner = set_.contacts[std::size_t(contact.partner)];
  const bool second = contact.kind == FrictionKind::twist;
  const ContactRows& patch = second ? partner : contact;
  const ContactRows& twist = second ? contact : partner;
  const Row* const slide = &set_.rows[std::size_t(patch.first)];
  const Vec3 half = 0.5 * (slide[1].lambda * patch.tangent1 + slide[2].lambda * patch.tangent2);
  const Vec3 r = contact.point.point - partner.point.point;
  const double couple = set_.rows[std::size_t(twist.first + 1)].lambda;
  return half + couple / std::max(r.squaredNorm(), 1e-18) * contact.point.normal.cross(r);
}

Vec3 Stepper::position_impulse_of(const ContactRows& contact) const {
  const Row* const rows = &set_.rows[std::size_t(contact.first)];
  const Vec3 impulse = rows[0].position_impulse * contact.point.normal;
  if (contact.friction <= 0.0 || contact.kind != FrictionKind::point) return impulse;
  return impulse + rows[1].position_impulse * contact.tangent1 +
         rows[2].position_impulse * contact.tangent2;
}

void Stepper::warm_start(double h) {
  if (!memory.had_rows) return;
  if (!memory.efforts.empty()) {
    for (std::size_t i = 0; i < set_.joint_rows(); ++i)
      if (Row& row = set_.rows[i]; row.slot >= 0)
        row.lambda = std::clamp(h * memory.efforts[std::size_t(row.slot)], row.low, row.high);
  }
  warm_.assign(set_.contacts.size(), Vec3::Zero());
  taken_.assign(memory.contacts.size(), 0);
  for_contact_chunks(
      [&](std::size_t, std::size_t first, std::size_t end) { warm_start_contacts(h, first, end); });
}

void Stepper::warm_start_contacts(double h, std::size_t first, std::size_t end) {
  const auto before = [](const StepMemory::WarmContact& w, const ContactPoint& point) {
    return w.collider_a != point.collider_a ? w.collider_a < point.collider_a
                                            : w.collider_b < point.collider_b;
  };
  if (first == end) return;
  std::size_t at = std::size_t(std::lower_bound(memory.contacts.begin(), memory.contacts.end(),
                                                set_.contacts[first].point, before) -
                               memory.contacts.begin());
  for (std::size_t index = first; index < end; ++index) {
    const ContactRows& contact = set_.contacts[index];
    const ContactPoint& point = contact.point;
    while (at < memory.contacts.size() && before(memory.contacts[at], point)) ++at;
    const Placement& X_b = detector_.colliders()[std::size_t(point.collider_b)].X_WS;
    const Vec3 point_B = X_b.to_local(point.point);
    double nearest = kSamePoint * kSamePoint;
    std::size_t best = memory.contacts.size();
    for (std::size_t i = at; i < memory.contacts.size(); ++i) {
      const StepMemory::WarmContact& w = memory.contacts[i];
      if (w.collider_a != point.collider_a || w.collider_b != point.collider_b) break;
      const double d = (w.point_B - point_B).squaredNorm();
      if (!taken_[i] && d < nearest) {
        nearest = d;
        best = i;
      }
    }
    if (best == memory.contacts.size()) continue;
    taken_[best] = 1;
    const Wrench& wrench = memory.contacts[best].wrench;
    warm_[index] = h * wrench.force;
    for (int i = 0; i < contact.turning_rows(); ++i)
      set_.rows[std::size_t(contact.first_turning() + i)].lambda =
          h * wrench.torque.dot(contact.turning_axis(i));
    const Vec3& position_impulse = memory.contacts[best].position_impulse;
    Row* const rows = &set_.rows[std::size_t(contact.first)];
    rows[0].position_impulse = position_impulse.dot(point.normal);
    if (contact.friction <= 0.0 || contact.kind != FrictionKind::point) continue;
    rows[1].position_impulse = position_impulse.dot(contact.tangent1);
    rows[2].position_impulse = position_impulse.dot(contact.tangent2);
  }
  share_warm_friction(first, end);
  for (std::size_t i = first; i < end; ++i) {
    const ContactRows& contact = set_.contacts[i];
    Row* const rows = &set_.rows[std::size_t(contact.first)];
    rows[0].lambda = std::max(warm_[i].dot(contact.point.normal), 0.0);
    if (contact.friction <= 0.0) continue;
    Vec3 impulse = warm_[i];
    if (contact.kind != FrictionKind::point) {
      const std::size_t partner = std::size_t(contact.partner);
      if (contact.kind == FrictionKind::twist) {
        const Vec3 arm = 0.5 * (contact.point.point - set_.contacts[partner].point.point);
        rows[1].lambda = contact.point.normal.dot(arm.cross(warm_[i] - warm_[partner]));
        continue;
      }
      impulse += warm_[partner];
    }
    rows[1].lambda = impulse.dot(contact.tangent1);
    rows[2].lambda = impulse.dot(contact.tangent2);
  }
}

// What the sweeps leave of forces that only press the points of a face against each other would
// stay for ever: the start is made without it.
void Stepper::share_warm_friction(std::size_t begin, std::size_t last) {
  constexpr double kSameNormal = 1.0 - 1e-6;  // cosine
  constexpr std::size_t kMost = 16;
  const std::vector<ContactRows>& contacts = set_.contacts;
  std::size_t end = begin;
  for (std::size_t first = begin; first < last; first = end) {
    const ContactPoint& leader = contacts[first].point;
    bool flat = true;
    for (end = first; end < last; ++end) {
      const ContactPoint& point = contacts[end].point;
      if (point.collider_a != leader.collider_a || point.collider_b != leader.collider_b) break;
      flat = flat && contacts[end].kind == FrictionKind::point &&
             point.normal.dot(leader.normal) > kSameNormal;
    }
    const std::size_t count = end - first;
    if (!flat || count < 2 || count > kMost || contacts[first].friction <= 0.0) continue;
    std::array<double, kMost> loads;
    std::array<Vec3, kMost> points, friction;
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3& impulse = warm_[first + k];
      loads[k] = std::max(impulse.dot(leader.normal), 0.0);
      points[k] = contacts[first + k].point.point;
      friction[k] = impulse - loads[k] * leader.normal;
    }
    share_friction(count, leader.normal, loads.data(), points.data(), friction.data());
    for (std::size_t k = 0; k < count; ++k)
      warm_[first + k] = loads[k] * leader.normal + friction[k];
  }
}

void Stepper::balance_pairs(double h, std::size_t begin, std::size_t last) {
  constexpr double kYield = 5e-3;  // of the effective inverse mass of the points
  // A light body under a heavy one has little effective mass and much load: beyond a load of so many
  // times its weight it yields less, or the heavy one would tilt on it slowly.
  constexpr double kLoad = 100.0;
  const double most = kLoad * h * model_.physics.gravity.norm();
  std::vector<ContactRows>& contacts = set_.contacts;
  for (std::size_t first = begin, end = begin; first < last; first = end) {
    double sum = 0.0, inverse_mass = 0.0;
    int resting = 0;
    const auto row_of = [&](std::size_t i) -> Row& {
      return set_.rows[std::size_t(contacts[i].first)];
    };
    const auto rests = [&](std::size_t i) {
      const Row& row = row_of(i);
      return row.has_gap && row.stays && !row.bilateral;
    };
    for (end = first;
         end < last && contacts[end].point.collider_a == contacts[first].point.collider_a &&
         contacts[end].point.collider_b == contacts[first].point.collider_b;
         ++end) {
      if (!rests(end)) continue;
      sum += row_of(end).lambda;
      inverse_mass += row_of(end).diagonal;
      ++resting;
    }
    if (resting < 2) continue;
    // The same yield for all: then the loads are their mean, projected onto those that balance, which
    // never adds to them. Else points that press against each other would. Of up to kMost points, as
    // NormalBlock, the mean is that of this step, found by the sweeps; else it is the last step's, and what
    // lands on a light body falls until it has grown.
    const bool together = resting == int(end - first) && resting <= NormalBlock::kMost;
    double yield = kYield * inverse_mass / resting;
    const double speed = inverse_mass * sum / (resting * resting);
    if (most > 0.0 && speed > most)
      yield *= std::max(most / speed * (most / speed), 0.1 * most / speed);
    for (std::size_t i = first; i < end; ++i) {
      if (!rests(i)) continue;
      Row& row = row_of(i);
      row.gamma = yield;
      if (!together) row.target += row.gamma * sum / resting;
      row.inverse_diagonal = 1.0 / (row.diagonal + row.gamma);
    }
  }
}

void Stepper::remember_contact(double h, std::size_t index, ContactChunk& out) const {
  const ContactRows& contact = set_.contacts[index];
  const Row& normal = set_.rows[std::size_t(contact.first)];
  if (normal.hits) out.hits.push_back(contact.first);
  if (normal.lambda <= 0.0 && contact.kind == FrictionKind::point) return;
  StepMemory::WarmContact w;
  w.collider_a = contact.point.collider_a;
  w.collider_b = contact.point.collider_b;
  const Placement& X_b = detector_.colliders()[std::size_t(w.collider_b)].X_WS;
  w.point_B = X_b.to_local(contact.point.point);
  w.wrench.force = contact_impulses_[index].force / h;
  w.wrench.torque = contact_impulses_[index].torque / h;
  w.position_impulse = position_impulse_of(contact);
  out.contacts.push_back(w);
}

void Stepper::remember(double h) {
  memory.contacts.clear();
  memory.efforts.assign(std::size_t(RowBuilder::slot_count(model_)), 0.0);
  for (std::size_t i = 0; i < set_.joint_rows(); ++i)
    if (const Row& row = set_.rows[i]; row.slot >= 0)
      memory.efforts[std::size_t(row.slot)] = row.lambda / h;
  chunks_.resize(std::max(chunks_.size(), set_.contacts.size() / kChunk + 1));
  const std::size_t count =
      for_contact_chunks([&](std::size_t number, std::size_t first, std::size_t end) {
        ContactChunk& out = chunks_[number];
        out.contacts.clear();
        out.hits.clear();
        for (std::size_t i = first; i < end; ++i) remember_contact(h, i, out);
      });
  predict_udot(h);
  // An impact's acceleration lasts no further step: what it met is carried to the next middle by the smooth
  // one, which has its gyroscopic terms.
  const auto forget_impact = [&](int index) {
    const Row& row = set_.rows[std::size_t(index)];
    if (!row.hits || row.lambda <= 0.0) return;
    for (int s = 0; s < row.sides; ++s)
      for (int u : mechanism_.components()[std::size_t(row.side[s].component)].speeds)
        memory.udot[u] = udot_[u];
  };
  for (const int row : set_.scalars) forget_impact(row);
  for (std::size_t i = 0; i < count; ++i) {
    const ContactChunk& chunk = chunks_[i];
    memory.contacts.insert(memory.contacts.end(), chunk.contacts.begin(), chunk.contacts.end());
    for (const int row : chunk.hits) forget_impact(row);
  }
  memory.had_rows = true;
}

// The first half of the next step takes the mean acceleration of the last, a, and, where the one before was near
// it, b, their line on to the middle of that half: a + 3/4 (a - b).
void Stepper::predict_udot(double h) {
  constexpr double kNear = 0.2;  // of a: as far as what turns by a fifth of a radian in a step
  const bool known = memory.mean_udot.size() == u0_.size();
  memory.udot = (1.0 / h) * (end_u_ - u0_);
  mean_.swap(memory.mean_udot);
  memory.mean_udot = memory.udot;
  for (const Component& c : mechanism_.components()) {
    double change = 0.0, size = 0.0;
    for (std::size_t k = 0; known && k < c.speeds.size(); ++k) {
      const double a = memory.udot[c.speeds[k]], d = a - mean_[c.speeds[k]];
      change += d * d;
      size += a * a;
    }
    if (change == 0.0 || change > kNear * kNear * size) continue;
    for (const int u : c.speeds) memory.udot[u] += 0.75 * (memory.udot[u] - mean_[u]);
  }
}

void Stepper::report() {
  for (std::size_t i = 0; i < set_.joint_rows(); ++i) {
    const Row& row = set_.rows[i];
    if (row.coupling >= 0) {
      const Coupling& coupling = model_.couplings[std::size_t(row.coupling)];
      const auto add = [&](int joint, double factor) {
        impulses.joints[std::size_t(model_.joints[std::size_t(joint)].speed_offset)] +=
            factor * row.lambda;
      };
      add(coupling.joint, 1.0);
      for (const CouplingTerm& term : coupling.terms) add(term.joint, -term.ratio);
    }
    if (row.effort < 0) continue;
    impulses.joints[std::size_t(row.effort)] += row.effort_sign * row.lambda;
    if (row.motor >= 0) impulses.motors[std::size_t(row.motor)] += row.lambda;
  }
  for (const BallLimit& limit : set_.ball_limits)
    for (int k = 0; k < 3; ++k)
      impulses.joints[std::size_t(limit.effort + k)] +=
          limit.direction[k] * set_.rows[std::size_t(limit.row)].lambda;
  const std::size_t earlier = records.size();
  for (const ContactRows& contact : set_.contacts) {
    const Row* const rows = &set_.rows[std::size_t(contact.first)];
    const Wrench& impulse = contact_impulses_[std::size_t(&contact - set_.contacts.data())];
    if (rows[0].lambda <= 0.0 && contact.point.gap > 0.0) continue;
    // A step in parts touches the same point several times.
    ContactRecord* same = nullptr;
    for (std::size_t i = 0; i < earlier && !same; ++i) {
      ContactRecord& r = records[i];
      if (r.collider_a == contact.point.collider_a && r.collider_b == contact.point.collider_b &&
          (r.point - contact.point.point).norm() < kSamePoint)
        same = &r;
    }
    if (!same) {
      records.emplace_back();
      same = &records.back();
    }
    same->collider_a = contact.point.collider_a;
    same->collider_b = contact.point.collider_b;
    same->point = contact.point.point;
    same->normal = contact.point.normal;
    same->gap = rows[0].has_gap ? rows[0].gap + rows[0].gap_change : contact.point.gap;
    same->impulse.force += impulse.force;
    same->impulse.torque += impulse.torque;
  }
}

}  // namespace cogrsim::dynamics

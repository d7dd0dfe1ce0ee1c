#include "contact_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cogrsim::bullet {

namespace {

// Sliding slower than this has no direction yet, (m/s)^2; Bullet's own figure.
constexpr double kNoSliding = SIMD_EPSILON;

/// One body as a point sees it.
struct Side {
  int index = -1;
  const StepBodies::Entry* entry = nullptr;  ///< nullptr: does not move
  btVector3 arm{0, 0, 0};
};

Side side_of(const btCollisionObject& object, const btVector3& at, const StepBodies& bodies) {
  Side side;
  side.index = StepBodies::index_of(object);
  if (side.index < 0) return side;
  side.entry = &bodies.entry(side.index);
  side.arm = at - object.getWorldTransform().getOrigin();
  return side;
}

btVector3 velocity_at(const Side& side) {
  if (side.entry == nullptr) return {0, 0, 0};
  return side.entry->lin + side.entry->ang.cross(side.arm);
}

/// Fills the rows on one body; adds to their inverse masses. `sign`: -1 on the body that the
/// directions point away from.
void fill_side(const Side& side, const btVector3 (&directions)[3], double sign, Six (&J)[3],
               Six (&K)[3], double (&felt)[3]) {
  const btMatrix3x3& I = side.entry->body->getInvInertiaTensorWorld();
  for (int k = 0; k < 3; ++k) {
    const btVector3 lin = directions[k] * sign;
    const btVector3 ang = side.arm.cross(lin);
    const btVector3 turn = I * ang;
    J[k] = Six(lin, ang);
    K[k] = Six(lin * side.entry->inverse_mass, turn);
    felt[k] += side.entry->inverse_mass + ang.dot(turn);
  }
}

/// Adds what the three rows' impulses do. (Written out: at -O2 a loop stays a loop.)
inline void apply(const Six (&K)[3], double d0, double d1, double d2, Six& v) {
  v.p[0] += K[0].p[0] * d0 + (K[1].p[0] * d1 + K[2].p[0] * d2);
  v.p[1] += K[0].p[1] * d0 + (K[1].p[1] * d1 + K[2].p[1] * d2);
  v.p[2] += K[0].p[2] * d0 + (K[1].p[2] * d1 + K[2].p[2] * d2);
}

}  // namespace

ContactCourse make_contact_rows(btManifoldPoint& point, const btCollisionObject& object_a,
                                const btCollisionObject& object_b, StepBodies& bodies, double dt,
                                ContactRows& out) {
  Side a = side_of(object_a, point.getPositionWorldOnA(), bodies);
  Side b = side_of(object_b, point.getPositionWorldOnB(), bodies);
  const btVector3& normal = point.m_normalWorldOnB;
  const btVector3 sliding_old = point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                                point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
  const btVector3 v = velocity_at(a) - velocity_at(b);
  const double approach = normal.dot(v);
  btVector3 sliding = v - normal * approach;
  const double speed2 = sliding.length2();
  if (speed2 > kNoSliding) {
    sliding /= std::sqrt(speed2);
    point.m_lateralFrictionDir1 = sliding;
    point.m_lateralFrictionDir2 = sliding.cross(normal).normalized();
  } else {
    btPlaneSpace1(normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
  }

  ContactCourse course;
  if (a.entry != nullptr) {
    course.speed += normal.dot(a.entry->start_lin + a.entry->ang.cross(a.arm));
    course.gained += normal.dot(a.entry->gained_lin);
  }
  if (b.entry != nullptr) {
    course.speed -= normal.dot(b.entry->start_lin + b.entry->ang.cross(b.arm));
    course.gained -= normal.dot(b.entry->gained_lin);
  }

  // What does not move is always b: with both directions turned round the rows are the same.
  btVector3 directions[3] = {normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2};
  const double impulses[3] = {point.m_appliedImpulse, sliding_old.dot(directions[1]),
                              sliding_old.dot(directions[2])};
  const double rates[3] = {approach, v.dot(directions[1]), v.dot(directions[2])};
  if (a.entry == nullptr || a.entry->inverse_mass == 0.0) {
    std::swap(a, b);
    for (btVector3& d : directions) d = -d;
  }
  const bool both = b.entry != nullptr && b.entry->inverse_mass > 0.0;
  out.a = a.index;
  out.b = both ? b.index : -1;
  double felt[3] = {};
  fill_side(a, directions, 1.0, out.Ja, out.Ka, felt);
  if (both) fill_side(b, directions, -1.0, out.Jb, out.Kb, felt);
  course.inverse_mass = felt[0];
  for (int k = 0; k < 3; ++k) {
    out.inverse[k] = 1.0 / felt[k];
    out.impulse[k] = impulses[k];
    out.rhs[k] = -(k == 0 ? rates[0] + point.getDistance() / dt : rates[k]) * out.inverse[k];
  }
  out.keep = 1.0;
  for (int k = 0; k < 2; ++k) {
    Pair change = product(out.Ja[k + 1], out.Ka[0]);
    if (both) change += product(out.Jb[k + 1], out.Kb[0]);
    out.coupling[k] = sum(change) * out.inverse[k + 1];
  }
  out.friction = point.m_combinedFriction;
  out.start = impulses[0];

  apply(out.Ka, impulses[0], impulses[1], impulses[2], bodies.delta(out.a));
  if (both) apply(out.Kb, impulses[0], impulses[1], impulses[2], bodies.delta(out.b));
  return course;
}

void sweep_contacts(ContactRows* first, ContactRows* last, DeltaVelocity* deltas) {
  for (; first != last; ++first) {
    ContactRows& p = *first;
    DeltaVelocity& a = deltas[p.a];
    // The speeds that impulses have changed, along all three rows at once; what the push then
    // changes of the other two comes in through their coupling.
    Pair along0 = product(p.Ja[0], a), along1 = product(p.Ja[1], a), along2 = product(p.Ja[2], a);
    if (p.b >= 0) {
      const DeltaVelocity& b = deltas[p.b];
      along0 += product(p.Jb[0], b);
      along1 += product(p.Jb[1], b);
      along2 += product(p.Jb[2], b);
    }
    const double push =
        std::max((p.impulse[0] * p.keep + p.rhs[0]) - sum(along0) * p.inverse[0], 0.0);
    const double d0 = push - p.impulse[0];
    // Friction in both directions at once, cut back to the circle of Coulomb's law: the bound
    // holds for its length, not for each direction, and is nil where the contact carries nothing.
    double x = (p.impulse[1] + p.rhs[1]) - sum(along1) * p.inverse[1] - p.coupling[0] * d0;
    double y = (p.impulse[2] + p.rhs[2]) - sum(along2) * p.inverse[2] - p.coupling[1] * d0;
    const double bound = p.friction * push, size2 = x * x + y * y;
    if (size2 > bound * bound) {
      const double scale = bound / std::sqrt(size2);
      x *= scale;
      y *= scale;
    }
    const double d1 = x - p.impulse[1], d2 = y - p.impulse[2];
    p.impulse[0] = push;
    p.impulse[1] = x;
    p.impulse[2] = y;
    apply(p.Ka, d0, d1, d2, a);
    if (p.b >= 0) apply(p.Kb, d0, d1, d2, deltas[p.b]);
  }
}

}  // namespace cogrsim::bullet

// The conditions of one step of an OdeWorld, and their solution.
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "convert.h"
#include "world.h"

namespace cogrsim::ode {

namespace {

// A contact yields by this part of the speed that its load gives in one step: enough to decide how
// points share what rigid bodies leave open, 1e-4 g h^2 in depth.
constexpr double kYield = 1e-4;
constexpr double kSlip = 1e-7;
// The ends of a line of contact yield that much more than its middle.
constexpr double kLineEnds = 1e3;
// Joints of a loop may forbid the same thing twice; so much softness (see Rows::point) decides how
// they share it, and changes speeds by that part of what a step changes them.
constexpr double kLoopSoftness = 1e-9;
// How far friction may be from Coulomb's law before the step is solved again, and how often it is.
constexpr double kFrictionError = 2e-3;
constexpr double kSameWay = 0.9998;  // cosine of 0.02 rad
// What friction may do across the way of the sliding, or of the force that was too much, as part of
// its bound: with all of it, it would hold the way as a rail does; with none, small motions chatter.
constexpr double kSlidingAside = 0.05, kStickingAside = 0.3;
constexpr double kSliding = 1e-6;    // [m/s]
constexpr double kSlightest = 1e-5;  // [N]
constexpr int kMostPasses = 5, kFewestPasses = 2;
constexpr int kFewRows = 100;  // up to which passes cost little
// Islands with more rows than this go to the quick solver: the exact one costs their cube.
constexpr int kMostExactRows = 200;
// Bodies that overlap are driven apart by this part of the way per step, at this speed at most.
constexpr double kRecovery = 0.2;
constexpr double kRecoverySpeed = 1.0;

}  // namespace

void OdeWorld::find_touches(double h) {
  const SceneModel& model = *model_;
  collider_->find(model, touches_);
  points_.clear();
  for (const TouchPoint& touch : touches_) {
    RowBody &a = row_body(touch.body_a), &b = row_body(touch.body_b);
    const auto ia = static_cast<std::size_t>(touch.body_a);
    const auto ib = static_cast<std::size_t>(touch.body_b);
    const BodyState &body_a = bodies_[ia], &body_b = bodies_[ib];
    const SurfacePair surface = surface_pair(
        model, model.bodies[ia].shapes[static_cast<std::size_t>(touch.shape_a)].material,
        model.bodies[ib].shapes[static_cast<std::size_t>(touch.shape_b)].material);
    Point point;
    point.touch = touch;
    point.friction = surface.friction;
    Rows::Touch& row = point.row;
    row.n = touch.normal;
    row.friction = surface.friction;
    // Found where the bodies would be at the end of the step; rows act at the start. The arms about
    // the centres of mass are kept; of two moving bodies, on the mean.
    Vec3 shift = Vec3::Zero();
    if (a.id && b.id) shift = 0.5 * h * (a.v + b.v);
    if (a.id && !b.id) shift = h * a.v;
    if (b.id && !a.id) shift = h * b.v;
    row.at = touch.point - shift;
    const auto speed = [&](const RowBody& body, const Vec3& v, const Vec3& w) {
      const Vec3 arm = body.id ? Vec3(row.at - body.c) : Vec3(touch.point - body.c);
      return Vec3(v + w.cross(arm));
    };
    const Vec3 free = speed(b, b.v, b.w) - speed(a, a.v, a.w);
    const Vec3 start = speed(b, b.id ? body_b.now.v : b.v, b.id ? body_b.now.w : b.w) -
                       speed(a, a.id ? body_a.now.v : a.v, a.id ? body_a.now.w : a.w);
    const double vn = free.dot(row.n);
    const double gap = touch.gap - h * vn;  // at the start
    point.vn = vn;
    // Directions of friction: along the sliding, so that the pyramid is touched at its right place.
    const Vec3 slide = free - vn * row.n;
    Vec3 unused;
    if (slide.norm() > 1e-9) {
      row.s = slide.normalized();
    } else {
      perpendiculars(row.n, row.s, unused);
    }
    const auto felt = [&](const Vec3& d) {
      double sum = 0.0;
      for (const RowBody* body : {&a, &b}) {
        const Vec3 arm = (row.at - body->c).cross(d);
        sum += body->inverse_mass + arm.dot(body->inverse_inertia * arm);
      }
      return sum;
    };
    row.cfm = kYield * h * felt(row.n) * (touch.line_end ? kLineEnds : 1.0);
    row.slip = kSlip * h * felt(row.s);
    row.target = vn - touch.gap / h;
    if (gap < 0.0) row.target += gap / h + std::min(-kRecovery * gap / h, kRecoverySpeed);
    if (surface.stiffness && touch.gap < 0.0) {
      const double k = *surface.stiffness;
      // A spring with the damping that gives the pair's restitution (critical for none), both at
      // the end of the step: force = -k (gap + h v) - c v.
      const double e = std::clamp(surface.restitution, 1e-3, 1.0), log_e = std::log(e);
      const double ratio = -log_e / std::sqrt(M_PI * M_PI + log_e * log_e);
      const double c = 2.0 * ratio * std::sqrt(k / felt(row.n));
      row.cfm = 1.0 / (c + h * k);
      row.target = -gap * k / (c + h * k);
      points_.push_back(point);
      mark_solved(touch);
      continue;
    }
    // Restitution: the speed after which the flight reaches e^2 times the height that was fallen,
    // wherever in the step the impact is. Energies per mass over the touching point, with the
    // acceleration g towards each other:
    //   v^2 / 2 + g (gap + h v) = e^2 w^2 / 2,  w^2 = v0^2 + 2 g gap.
    const double e = surface.restitution, g = -(vn - start.dot(row.n)) / h;
    const double v0 = -start.dot(row.n);
    const double w2 = v0 * v0 + 2.0 * g * std::max(gap, 0.0);
    if (e > 0.0 && touch.gap < 0.0 && v0 > 0.0 && w2 > 0.0 &&
        std::sqrt(w2) > model.physics.bounce_threshold) {
      const double root = g * g * h * h + e * e * w2 - 2.0 * g * gap;
      if (root > 0.0) row.target = std::max(row.target, -g * h + std::sqrt(root));
    }
    points_.push_back(point);
    mark_solved(touch);
  }
}

void OdeWorld::mark_solved(const TouchPoint& touch) {
  for (const int body : {touch.body_a, touch.body_b}) {
    if (ids_[static_cast<std::size_t>(body)]) solved_[static_cast<std::size_t>(body)] = 1;
  }
}

double OdeWorld::softness_of(const Joint& joint) const {
  const auto in_loop = [&](int b) {
    return b != kWorld && in_loop_[static_cast<std::size_t>(b)] != 0;
  };
  return in_loop(joint.parent) || in_loop(joint.child) ? kLoopSoftness : 0.0;
}

void OdeWorld::find_loops() {
  // Every movable body that hangs together by joints with a loop.
  const SceneModel& model = *model_;
  in_loop_.assign(bodies_.size(), 0);
  const auto mark = [&](const Joint& joint) {
    bool changed = false;
    for (const int b : {joint.parent, joint.child}) {
      if (b == kWorld || !ids_[static_cast<std::size_t>(b)]) continue;
      changed = changed || !in_loop_[static_cast<std::size_t>(b)];
      in_loop_[static_cast<std::size_t>(b)] = 1;
    }
    return changed;
  };
  bool changed = false;
  for (const Joint& joint : model.joints) {
    if (!joint.removed && joint.closes_loop) changed = mark(joint) || changed;
  }
  while (changed) {
    changed = false;
    for (const Joint& joint : model.joints) {
      if (joint.removed || softness_of(joint) == 0.0) continue;
      changed = mark(joint) || changed;
    }
  }
}

void OdeWorld::put_bodies(double h) {
  rows_->clear();
  rows_->set_step(h);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const dBodyID id = ids_[b];
    if (!id) continue;
    if (!solved_[b]) continue;
    const RowBody& row = row_bodies_[b];
    const Quat& q = bodies_[b].now.q;
    const dQuaternion dq = {q.w(), q.x(), q.y(), q.z()};
    dBodySetPosition(id, row.c.x(), row.c.y(), row.c.z());
    dBodySetQuaternion(id, dq);
    dBodySetLinearVel(id, row.v.x(), row.v.y(), row.v.z());
    dBodySetAngularVel(id, row.w.x(), row.w.y(), row.w.z());
  }
}

void OdeWorld::ask_rows(double h) {
  put_bodies(h);
  const SceneModel& model = *model_;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || !joints_[j].has_rows()) continue;
    const RowBody &parent = row_body(joint.parent), &child = row_body(joint.child);
    if (!parent.id && !child.id) continue;
    joints_[j].ask(*rows_, parent, child, Closing::position, end_of(joint.parent),
                   end_of(joint.child), h, softness_of(joint));
  }
  for (Point& point : points_) {
    const RowBody &a = row_body(point.touch.body_a), &b = row_body(point.touch.body_b);
    point.handle = rows_->touch(a, b, point.row);
  }
}

void OdeWorld::find_islands() {
  // 1: solved exactly, 2: by sweeps.
  const std::size_t n = bodies_.size();
  std::vector<int>&root = island_, &size = island_rows_;
  root.resize(n);
  std::iota(root.begin(), root.end(), 0);
  size.assign(n, 0);
  const auto find = [&](int b) {
    while (root[static_cast<std::size_t>(b)] != b) {
      int& up = root[static_cast<std::size_t>(b)];
      b = up = root[static_cast<std::size_t>(up)];
    }
    return b;
  };
  const auto movable = [&](int b) { return b != kWorld && ids_[static_cast<std::size_t>(b)]; };
  const auto tie = [&](int a, int b, bool count, int rows) {
    if (!movable(a)) std::swap(a, b);
    if (!movable(a)) return;
    if (!count && movable(b)) root[static_cast<std::size_t>(find(b))] = find(a);
    if (count) size[static_cast<std::size_t>(find(a))] += rows;
  };
  for (const bool count : {false, true}) {
    for (const Joint& joint : model_->joints) {
      if (joint.removed || joint.type == JointType::free) continue;
      tie(joint.parent, joint.child, count, 6 - position_count(joint.type) / 2);
    }
    for (const Point& point : points_) tie(point.touch.body_a, point.touch.body_b, count, 3);
  }
  largest_ = 0;
  for (std::size_t b = 0; b < n; ++b) {
    if (!solved_[b]) continue;
    const int rows = size[static_cast<std::size_t>(find(static_cast<int>(b)))];
    const bool quick = solver_ == "quick" || (solver_ == "auto" && rows > kMostExactRows);
    solved_[b] = static_cast<char>(quick ? 2 : 1);
    if (!quick) largest_ = std::max(largest_, rows);
  }
}

bool OdeWorld::enable(int kind) {
  bool any = false;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!ids_[b]) continue;
    if (solved_[b] == kind) {
      dBodyEnable(ids_[b]);
      any = true;
    } else {
      dBodyDisable(ids_[b]);
    }
  }
  return any;
}

void OdeWorld::solve(double h) {
  if (std::find(solved_.begin(), solved_.end(), 1) == solved_.end()) return;
  find_islands();
  ask_rows(h);
  if (enable(1)) {
    engine_->step(h);
    const int most = largest_ > kFewRows ? kFewestPasses : kMostPasses;
    for (int pass = 1; pass < most && bound_friction(); ++pass) {
      ask_rows(h);
      enable(1);
      engine_->step(h);
    }
  }
  if (enable(2)) {
    // Its sweeps go through the rows in an order of chance, from a source that the whole process
    // shares.
    static std::mutex chance;
    const std::lock_guard<std::mutex> lock(chance);
    dRandSetSeed(1);
    dWorldSetQuickStepNumIterations(engine_->world(), iterations_);
    engine_->quick_step(h);
  }
}

bool OdeWorld::bound_friction() {
  // ODE bounds friction by the loads that the contacts would have without any, in a square. Where
  // that differs from Coulomb's law for the loads found, the step is solved again with bounds from
  // those, the square turned so that one of its directions is that of the sliding found, or of the force
  // where it sticks.
  const auto movable = [&](int b) { return ids_[static_cast<std::size_t>(b)] != nullptr; };
  const auto exact = [&](int b) { return movable(b) && solved_[static_cast<std::size_t>(b)] == 1; };
  const auto speed = [&](int b, const Vec3& at) {
    const RowBody& row = row_body(b);
    if (!row.id) return row.at(at);
    const Vec3 v = to_vec(dBodyGetLinearVel(row.id)), w = to_vec(dBodyGetAngularVel(row.id));
    return Vec3(v + w.cross(at - row.c));
  };
  bool again = false;
  for (Point& point : points_) {
    const TouchPoint& touch = point.touch;
    if (point.friction <= 0.0 || !(exact(touch.body_a) || exact(touch.body_b))) continue;
    Rows::Touch& row = point.row;
    const Vec3 f =
        rows_->wrench(point.handle, row_body(touch.body_a), row_body(touch.body_b), row.at).force;
    const double load = std::max(f.dot(row.n), 0.0), bound = point.friction * load;
    const Vec3 across = f - f.dot(row.n) * row.n;
    const double force = across.norm();
    const Vec3 v = speed(touch.body_b, row.at) - speed(touch.body_a, row.at);
    const Vec3 slide = v - v.dot(row.n) * row.n;
    const double sliding = slide.norm();
    const double tolerance = kFrictionError * (bound + kSlightest);
    const bool slides = sliding > kSliding, beyond = force > bound + tolerance;
    const bool astray = slides && row.fixed_cap && slide.dot(row.s) < kSameWay * sliding;
    point.cap = bound;
    point.along = Vec3::Zero();
    point.aside = 1.0;
    if (beyond) {
      point.along = across / force;
      point.aside = kStickingAside;
    }
    if (slides) {
      point.along = slide / sliding;
      point.aside = kSlidingAside;
    }
    // The ends of a line bear next to nothing, and slide whenever it turns.
    if (touch.line_end) continue;
    again = again || beyond || astray || (slides && force < bound - tolerance);
  }
  if (!again) return false;
  for (Point& point : points_) {
    if (point.cap < 0.0) continue;
    point.row.fixed_cap = true;
    point.row.cap = point.cap;
    point.row.cap_t = point.aside * point.cap;
    if (point.along != Vec3::Zero()) point.row.s = point.along;
  }
  return true;
}

}  // namespace cogrsim::ode

#include "world.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "convert.h"

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::ode {

namespace {

// Beyond these a world has exploded, whatever the numbers say.
constexpr double kFarthest = 1e6;     // [m]
constexpr double kFastest = 1e5;      // [m/s]
constexpr double kFastestSpin = 1e9;  // [rad/s]
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

Parameters options_of(const SceneModel& model) {
  const auto it = model.physics.engine_options.find("ode");
  return it == model.physics.engine_options.end() ? Parameters{} : it->second;
}

}  // namespace

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter(
          "solver", "auto",
          "step: exact (Dantzig's method), costs the cube of what touches; quick: sweeps; auto: "
          "exact for islands of bodies up to some 200 conditions")
          .one_of({"auto", "step", "quick"}),
      parameter("iterations", 100, "sweeps of the quick solver per step").range(1, 10000),
  };
  return table;
}

Result<> check_motors(const SceneModel& model) {
  for (const Motor& motor : model.motors) {
    const JointType type = model.joints[static_cast<std::size_t>(motor.joint)].type;
    if (motor.removed ||
        (type != JointType::ball && type != JointType::free && type != JointType::fixed)) {
      continue;
    }
    return fail("motor '" + motor.name + "': a " + std::string(to_string(type)) +
                    " joint has no axis to drive",
                place_of(model, motor.origin),
                "use a hinge, slider, universal or another joint with axes");
  }
  return {};
}

Result<std::unique_ptr<World>> OdeWorld::create(const SceneModelPtr& model) {
  std::unique_ptr<OdeWorld> world(new OdeWorld);
  try {
    if (auto built = world->build(model); !built) return tl::unexpected(built.error());
  } catch (const EngineError& error) {
    return fail(std::string(error.what()));
  }
  world->initial_ = model;
  return world;
}

Result<> OdeWorld::build(const SceneModelPtr& model, const std::vector<BodyState>* bodies) {
  const auto options = complete_parameters(world_option_table(), options_of(*model));
  if (!options) return tl::unexpected(options.error());
  if (auto fine = check_motors(*model); !fine) return fine;
  auto collider = std::make_unique<Collider>();
  if (auto added = collider->add(*model); !added) return added;

  solver_ = std::get<std::string>(options->at("solver"));
  iterations_ = static_cast<int>(std::get<std::int64_t>(options->at("iterations")));
  model_ = model;
  time_ = 0.0;
  collider_ = std::move(collider);
  if (bodies) {
    bodies_ = *bodies;
  } else {
    bodies_.clear();
    for (const Body& body : model->bodies) bodies_.emplace_back(body);
  }
  q_.clear();
  last_u_.clear();
  joint_efforts_.clear();
  motor_efforts_.clear();
  reactions_.clear();
  contacts_.clear();
  adopt(model);
  return {};
}

void OdeWorld::adopt(const SceneModelPtr& next) {
  model_ = next;
  const auto known = q_.size();
  q_.resize(static_cast<std::size_t>(next->joint_positions));
  for (const Joint& joint : next->joints) {
    if (static_cast<std::size_t>(joint.position_offset) < known) continue;
    std::copy(joint.position.begin(), joint.position.end(), q_.begin() + joint.position_offset);
  }
  joint_efforts_.resize(static_cast<std::size_t>(next->joint_speeds), 0.0);
  motor_efforts_.resize(next->motors.size(), 0.0);
  reactions_.resize(next->joints.size());
  joints_.resize(next->joints.size());
  motors_of_.assign(next->joints.size(), {});
  for (std::size_t m = 0; m < next->motors.size(); ++m) {
    if (next->motors[m].removed) continue;
    motors_of_[static_cast<std::size_t>(next->motors[m].joint)].push_back(static_cast<int>(m));
  }
  const std::size_t n = bodies_.size();
  row_bodies_.assign(n, {});
  momentum_.assign(n, Vec3::Zero());
  ends_.assign(n, Pose());
  solved_.assign(n, 0);
  loads_.assign(n, {});
  make_bodies();
}

void OdeWorld::make_bodies() {
  // A new world each time: it costs little, and nothing of the past can stay.
  rows_.reset();
  engine_ = std::make_unique<Engine>();
  rows_.emplace(*engine_);
  ids_.assign(bodies_.size(), nullptr);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyState& body = bodies_[b];
    if (body.removed) continue;
    collider_->place(static_cast<int>(b), body.pose());
    if (!body.dynamic()) continue;
    const dBodyID id = dBodyCreate(engine_->world());
    dMass mass;
    const Mat3& I = body.inertia();
    dMassSetParameters(&mass, body.mass(), 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2),
                       I(1, 2));
    dBodySetMass(id, &mass);
    dBodySetGyroscopicMode(id, 0);  // see BodyState::mean_spin
    dBodySetFiniteRotationMode(id, 0);
    dBodySetMaxAngularSpeed(id, dInfinity);
    ids_[b] = id;
  }
  find_loops();
}

StepResult OdeWorld::step(double dt, const std::vector<Drive>& drives) {
  int lost = -1;
  std::string what;
  const std::vector<BodyState> before = bodies_;
  try {
    prepare_thread();
    begin_joints(dt, drives);
    predict(dt);
    // What is not a number or nearly so is not for ODE, which would end in an assertion.
    lost = find_wild();
    if (lost < 0) {
      find_touches(dt);
      solve(dt);
      move(dt);
      lost = find_diverged();
    }
  } catch (const EngineError& error) {
    what = error.what();
    engine_->abandon();
    for (std::size_t b = 0; b < bodies_.size() && lost < 0; ++b) {
      if (bodies_[b].dynamic()) lost = static_cast<int>(b);
    }
  }
  if (lost >= 0 || !what.empty()) {
    bodies_ = before;
    make_bodies();  // what ODE was in the middle of is dropped
    if (what.empty()) {
      what = "body '" + model_->bodies[static_cast<std::size_t>(lost)].name +
             "' has left all bounds (a million metres, 100 km/s) or is not a number";
    }
    return {StepStatus::diverged, lost, what};
  }
  report(dt);
  time_ += dt;
  return {};
}

void OdeWorld::begin_joints(double h, const std::vector<Drive>& drives) {
  const SceneModel& model = *model_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyState& body = bodies_[b];
    RowBody& row = row_bodies_[b];
    row.id = ids_[b];
    row.c = body.now.c;
    row.v = body.removed ? Vec3::Zero() : body.now.v;
    row.w = body.removed ? Vec3::Zero() : body.now.w;
    row.inverse_mass = body.inverse_mass();
    row.inverse_inertia = body.inverse_inertia_at(body.now.q);
    loads_[b] = {};
    solved_[b] = 0;
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed) continue;
    const Pose X_WP = pose_of(joint.parent), X_WC = pose_of(joint.child);
    JointStep& step = joints_[j];
    step.begin(model, static_cast<int>(j), X_WP, X_WC, twist_of(joint.parent),
               twist_of(joint.child), q_.data() + joint.position_offset);
    if (!step.has_rows()) continue;
    step.form_laws(model, motors_of_[j], drives, h, row_body(joint.parent), row_body(joint.child));
    const Wrench known = step.known();
    for (const int side : {1, -1}) {
      const int b = side > 0 ? joint.child : joint.parent;
      if (b == kWorld || !ids_[static_cast<std::size_t>(b)]) continue;
      const auto i = static_cast<std::size_t>(b);
      solved_[i] = 1;
      loads_[i].force += side * known.force;
      loads_[i].torque +=
          side * (known.torque + (step.place() - bodies_[i].now.c).cross(known.force));
    }
  }
}

void OdeWorld::predict(double h) {
  const Vec3 g = model_->physics.gravity;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyState& body = bodies_[b];
    if (body.removed || body.kind == BodyKind::fixed) {
      ends_[b] = body.pose();
      continue;
    }
    if (body.kind == BodyKind::kinematic) {
      BodyState moved = body;
      moved.carry(h);
      ends_[b] = moved.pose();
      // Rows see the mean speed of its centre over the step.
      row_bodies_[b].v = (moved.now.c - body.now.c) / h;
      collider_->place(static_cast<int>(b), ends_[b]);
      continue;
    }
    RowBody& row = row_bodies_[b];
    row.v = body.now.v + h * (g + loads_[b].force / body.mass());
    momentum_[b] = body.inertia_at(body.now.q) * body.now.w + h * loads_[b].torque;
    row.w = body.mean_spin(momentum_[b], h);
    Motion end;
    end.c = body.now.c + h * row.v;
    end.q = (rotation_by(h * row.w) * body.now.q).normalized();
    ends_[b] = body.pose(end);
    if (end.c.allFinite() && end.q.coeffs().allFinite() && end.c.norm() < kFarthest) {
      collider_->place(static_cast<int>(b), ends_[b]);
    }
  }
}

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
  std::vector<int> root(n), size(n, 0);
  std::iota(root.begin(), root.end(), 0);
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
    dWorldStep(engine_->world(), h);
    const int most = largest_ > kFewRows ? kFewestPasses : kMostPasses;
    for (int pass = 1; pass < most && bound_friction(); ++pass) {
      ask_rows(h);
      enable(1);
      dWorldStep(engine_->world(), h);
    }
  }
  if (enable(2)) {
    // Its sweeps go through the rows in an order of chance, from a source that the whole process
    // shares.
    static std::mutex chance;
    const std::lock_guard<std::mutex> lock(chance);
    dRandSetSeed(1);
    dWorldSetQuickStepNumIterations(engine_->world(), iterations_);
    dWorldQuickStep(engine_->world(), h);
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

void OdeWorld::move(double h) {
  const Vec3 g = model_->physics.gravity;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    BodyState& body = bodies_[b];
    if (body.removed || body.kind == BodyKind::fixed) continue;
    if (body.kind == BodyKind::kinematic) {
      body.carry(h);
      continue;
    }
    if (!solved_[b]) {
      body.fly(h, g);
      continue;
    }
    const Vec3 v = to_vec(dBodyGetLinearVel(ids_[b])), w = to_vec(dBodyGetAngularVel(ids_[b]));
    const Vec3 L = momentum_[b] + body.inertia_at(body.now.q) * (w - row_bodies_[b].w);
    body.now.c += h * v;
    body.now.q = (rotation_by(h * w) * body.now.q).normalized();
    body.now.v = v;
    body.now.w = body.inverse_inertia_at(body.now.q) * L;
  }
}

int OdeWorld::find_wild() const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!ids_[b]) continue;
    const double fast = row_bodies_[b].v.norm(), spin = row_bodies_[b].w.norm();
    if (!(fast <= kFastest) || !(spin <= kFastestSpin)) return static_cast<int>(b);
  }
  return -1;
}

int OdeWorld::find_diverged() const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyState& body = bodies_[b];
    if (body.removed || body.kind == BodyKind::fixed) continue;
    // Written so that a NaN fails.
    const bool sane = body.now.c.squaredNorm() <= kFarthest * kFarthest &&
                      body.now.v.squaredNorm() <= kFastest * kFastest &&
                      std::isfinite(body.now.w.squaredNorm()) && body.now.q.coeffs().allFinite();
    if (!sane) return static_cast<int>(b);
  }
  return -1;
}

void OdeWorld::report(double h) {
  const SceneModel& model = *model_;
  std::fill(motor_efforts_.begin(), motor_efforts_.end(), 0.0);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed) continue;
    double previous[7];
    double* q = q_.data() + joint.position_offset;
    std::copy(q, q + position_count(joint.type), previous);
    joint_position(joint, relative_pose(joint, pose_of(joint.parent), pose_of(joint.child)),
                   previous, q);
    const RowBody &parent = row_body(joint.parent), &child = row_body(joint.child);
    if (!joints_[j].has_rows() || (!parent.id && !child.id)) continue;
    joints_[j].report(*rows_, parent, child, joint_efforts_, motor_efforts_, reactions_[j]);
  }
  contacts_.clear();
  for (const Point& point : points_) {
    const RowBody &a = row_body(point.touch.body_a), &b = row_body(point.touch.body_b);
    Contact contact;
    contact.body_a = point.touch.body_a;
    contact.body_b = point.touch.body_b;
    contact.shape_a = point.touch.shape_a;
    contact.shape_b = point.touch.shape_b;
    contact.point = point.touch.point;
    contact.normal = point.touch.normal;
    // At the end of the step as it was, not as it was predicted.
    const auto speed = [&](int body, const RowBody& row) {
      if (!row.id) return row.at(point.touch.point);
      const auto i = static_cast<std::size_t>(body);
      return Vec3(bodies_[i].now.v +
                  bodies_[i].now.w.cross(point.touch.point - ends_[i] * Vec3(bodies_[i].com())));
    };
    const double vn = (speed(contact.body_b, b) - speed(contact.body_a, a)).dot(point.touch.normal);
    contact.depth = -(point.touch.gap + h * (vn - point.vn));
    contact.force = rows_->wrench(point.handle, a, b, point.row.at).force;
    contacts_.push_back(contact);
  }
}

void* OdeWorld::extension(std::string_view id) {
  if (id == JointReactions::kId) return static_cast<JointReactions*>(this);
  if (id == KinematicDrive::kId) return static_cast<KinematicDrive*>(this);
  return nullptr;
}

Result<> OdeWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (body < 0 || body >= static_cast<int>(bodies_.size())) {
    return fail("there is no body " + std::to_string(body));
  }
  const Body& model = model_->bodies[static_cast<std::size_t>(body)];
  if (model.kind != BodyKind::kinematic || model.removed) {
    return fail("body '" + model.name + "' is not kinematic", place_of(*model_, model.origin));
  }
  if (!twist.linear.allFinite() || !twist.angular.allFinite()) {
    return fail("body '" + model.name + "': its twist is not finite");
  }
  BodyState& moved = bodies_[static_cast<std::size_t>(body)];
  moved.set(moved.pose(), twist);
  return {};
}

}  // namespace cogrsim::ode

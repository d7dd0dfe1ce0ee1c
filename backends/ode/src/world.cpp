#include "world.h"

#include <algorithm>
#include <cmath>

#include "convert.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::ode {

namespace {

// Beyond these a world has exploded, whatever the numbers say.
constexpr double kFarthest = 1e6;     // [m]
constexpr double kFastest = 1e5;      // [m/s]
constexpr double kFastestSpin = 1e9;  // [rad/s]

// Written so that a NaN fails.
bool is_near(const Motion& m) {
  return m.c.squaredNorm() <= kFarthest * kFarthest && m.q.coeffs().allFinite();
}

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
  before_ = bodies_;
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
    for (std::size_t b = 0; b < bodies_.size() && lost < 0; ++b) {
      if (bodies_[b].dynamic()) lost = static_cast<int>(b);
    }
  }
  if (lost >= 0 || !what.empty()) {
    bodies_ = before_;
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

void OdeWorld::begin_rows() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyState& body = bodies_[b];
    RowBody& row = row_bodies_[b];
    row.id = ids_[b];
    row.c = body.now.c;
    row.v = body.removed ? Vec3::Zero() : body.now.v;
    row.w = body.removed ? Vec3::Zero() : body.now.w;
    row.inverse_mass = body.inverse_mass();
    row.inverse_inertia = body.inverse_inertia_at(body.now.q);
    solved_[b] = 0;
  }
}

void OdeWorld::begin_joints(double h, const std::vector<Drive>& drives) {
  const SceneModel& model = *model_;
  begin_rows();
  std::fill(loads_.begin(), loads_.end(), Wrench{});
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
      if (is_near(moved.now)) collider_->place(static_cast<int>(b), ends_[b]);
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
    if (is_near(end)) collider_->place(static_cast<int>(b), ends_[b]);
  }
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
    const BodyState& body = bodies_[b];
    if (body.removed || body.kind == BodyKind::fixed) continue;
    if (!is_near(body.now)) return static_cast<int>(b);
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
    const bool sane = is_near(body.now) && body.now.v.squaredNorm() <= kFastest * kFastest &&
                      std::isfinite(body.now.w.squaredNorm());
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
  if (auto fine = check_kinematic_twist(*model_, body, twist); !fine) return fine;
  BodyState& moved = bodies_[static_cast<std::size_t>(body)];
  moved.set(moved.pose(), twist);
  return {};
}

}  // namespace cogrsim::ode

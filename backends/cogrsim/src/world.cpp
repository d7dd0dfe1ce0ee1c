#include "world.h"

#include <cmath>
#include <exception>

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::dynamics {
namespace {

constexpr double kFarthest = 1e6;  // [m]
constexpr double kFastest = 1e5;   // [m/s]

struct DynamicsSnapshot final : WorldSnapshot {
  SceneModelPtr scene;
  Progress progress;
};

}  // namespace

DynamicsWorld::DynamicsWorld(SceneModelPtr model, const StepperOptions& options)
    : options_(options), initial_(model) {
  start(std::move(model));
}

void DynamicsWorld::start(SceneModelPtr model) {
  auto engine = std::make_unique<Engine>(model, options_);
  Progress progress;
  progress.placed = progress.model = std::move(model);
  progress.twists.reserve(progress.model->bodies.size());
  for (const Body& body : progress.model->bodies)
    progress.twists.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  engine_ = std::move(engine);
  progress_ = std::move(progress);
}

StepResult DynamicsWorld::step(double dt, const std::vector<Drive>& drives) {
  Mechanism& m = engine_->mechanism;
  progress_.start_q = m.state.q();
  progress_.start_u = m.state.u();
  StepResult result;
  try {
    if (!external_.empty() || has_external_forces_) engine_->mechanism.set_external(external_);
    has_external_forces_ = !external_.empty();
    engine_->stepper.advance(dt, drives, progress_.twists);
    result.body = find_diverged();
    if (result.body >= 0)
      result.message = "body '" + progress_.model->bodies[std::size_t(result.body)].name +
                       "' left all bounds (1000 km, 100 km/s)";
  } catch (const std::bad_alloc&) {
    throw;  // no fault of the world's
  } catch (const std::exception& e) {
    result.message = e.what();
    result.status = StepStatus::diverged;
    result.body = find_suspect();
  }
  if (result.body >= 0) result.status = StepStatus::diverged;
  if (result.status == StepStatus::diverged) {
    m.state.change_q() = progress_.start_q;
    m.state.change_u() = progress_.start_u;
    engine_->stepper.forget();
    return result;
  }
  progress_.reactions_kept = false;
  progress_.time += dt;
  progress_.last_dt = dt;
  return result;
}

// q + a qdot and u + a (u - u-) / h-, at the time a from now, with the speeds u- before the last step, of h-.
void DynamicsWorld::get_state_ahead(double ahead, std::vector<Pose>& poses,
                                    std::vector<Twist>& twists) {
  constexpr double kNear = 0.2;  // a change by more, as of an impact, does not go on
  Mechanism& m = engine_->mechanism;
  const Values q = m.state.q(), u = m.state.u();
  Values next = u, rates;
  if (progress_.last_dt > 0.0 && progress_.start_u.size() == u.size()) {
    const Values change = u - progress_.start_u;
    for (const Component& c : m.components()) {
      double changed = 0.0, size = 0.0;
      for (const int k : c.speeds) {
        changed += change[k] * change[k];
        size += u[k] * u[k];
      }
      if (changed > kNear * kNear * size) continue;
      for (const int k : c.speeds) next[k] += ahead / progress_.last_dt * change[k];
    }
  }
  m.multiply_by_n(next, rates);
  m.state.change_q() = q + ahead * rates;
  m.normalize_quaternions();
  m.state.change_u() = next;
  const std::vector<LinkMotion>& motions = m.motions();
  for (std::size_t b = 0; b < progress_.model->bodies.size(); ++b) {
    const int link = m.body_link(int(b));
    if (link < 0) continue;
    const LinkMotion& motion = motions[std::size_t(link)];
    poses[b] = pose_of(motion.X);
    twists[b] = {motion.linear, motion.angular};
  }
  m.state.change_q() = q;
  m.state.change_u() = u;
}

int DynamicsWorld::find_diverged() const {
  const Mechanism& m = engine_->mechanism;
  const std::vector<LinkMotion>& motions = m.motions();
  for (std::size_t i = 0; i < m.links().size(); ++i) {
    const LinkMotion& motion = motions[i];
    // Written so that a NaN fails.
    const bool fine = motion.X.p.norm() < kFarthest && motion.linear.norm() < kFastest &&
                      motion.angular.norm() < kFastest * 10;
    if (!fine) return m.links()[i].plan.body;
  }
  return -1;
}

int DynamicsWorld::find_suspect() const {
  const Mechanism& m = engine_->mechanism;
  const Values& q = m.state.q();
  const Values& u = m.state.u();
  int body = -1;
  double most = -1.0;
  for (const Link& link : m.links()) {
    double size = 0.0;
    for (int k = 0; k < link.nq; ++k) size += 0.0 * q[link.first_q + k];
    for (int k = 0; k < link.nu; ++k) size += std::abs(u[link.first_u + k]);
    if (!std::isfinite(size)) return link.plan.body;
    if (size <= most) continue;
    most = size;
    body = link.plan.body;
  }
  return body;
}

void DynamicsWorld::get_contacts(std::vector<Contact>& out) const {
  const std::vector<ContactRecord>& records = engine_->stepper.records;
  const std::vector<Collider>& colliders = engine_->detector.colliders();
  out.clear();
  for (const ContactRecord& r : records) {
    const Collider& a = colliders[std::size_t(r.collider_a)];
    const Collider& b = colliders[std::size_t(r.collider_b)];
    if (a.body < 0 || b.body < 0) continue;  // removed since
    Contact c;
    c.body_a = a.body;
    c.shape_a = a.shape;
    c.body_b = b.body;
    c.shape_b = b.shape;
    c.point = r.point;
    c.normal = r.normal;
    c.depth = -r.gap;
    c.force = r.impulse.force / progress_.last_dt;
    out.push_back(c);
  }
}

void DynamicsWorld::capture(Progress& progress) const {
  const Engine& e = *engine_;
  progress = progress_;
  progress.q = e.mechanism.state.q();
  progress.u = e.mechanism.state.u();
  progress.memory = e.stepper.memory;
  progress.sleep = e.stepper.sleep.state();
  progress.impulses = e.stepper.impulses;
  progress.records = e.stepper.records;
}

void DynamicsWorld::apply(const Progress& progress) {
  Engine& e = *engine_;
  progress_ = progress;
  e.mechanism.state.change_q() = progress.q;
  e.mechanism.state.change_u() = progress.u;
  e.stepper.memory = progress.memory;
  e.stepper.sleep.set_state(progress.sleep);
  e.stepper.impulses = progress.impulses;
  e.stepper.records = progress.records;
}

SnapshotPtr DynamicsWorld::save() const {
  auto snapshot = std::make_shared<DynamicsSnapshot>();
  snapshot->scene = initial_;
  capture(snapshot->progress);
  return snapshot;
}

Result<> DynamicsWorld::restore(const SnapshotPtr& snapshot) {
  const auto* mine = dynamic_cast<const DynamicsSnapshot*>(snapshot.get());
  if (!mine) return fail("the snapshot is not of a world of the cogrsim backend");
  if (!same_names(*mine->scene, *initial_))
    return fail("the snapshot is of another scene than '" + initial_->name + "'");
  try {
    if (mine->progress.placed != progress_.placed)
      engine_ = std::make_unique<Engine>(mine->progress.placed, options_);
    apply(mine->progress);
  } catch (const std::exception& e) {
    return fail(message_of(e));
  }
  return {};
}

Result<> DynamicsWorld::reset() {
  try {
    start(initial_);
  } catch (const std::exception& e) {
    return fail(message_of(e));
  }
  return {};
}

void DynamicsWorld::get_joint_reactions(std::vector<Wrench>& out) const {
  if (progress_.reactions_kept) {
    out = progress_.reactions;
    return;
  }
  Engine& e = *engine_;
  StepRecord record;
  record.dt = progress_.last_dt;
  record.start_q = &progress_.start_q;
  record.start_u = &progress_.start_u;
  record.contacts = &e.stepper.records;
  record.colliders = &e.detector.colliders();
  std::vector<double> efforts = e.stepper.impulses.joints;
  for (double& effort : efforts) effort /= record.dt > 0.0 ? record.dt : 1.0;
  record.joint_efforts = &efforts;
  // Before the first step.
  if (progress_.start_q.size() != e.mechanism.state.nq()) record.dt = 0.0;
  calc_joint_reactions(e.mechanism, record, out);
}

Result<> DynamicsWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto r = check_kinematic_twist(*progress_.model, body, twist); !r) return r;
  progress_.twists[std::size_t(body)] = twist;
  return {};
}

}  // namespace cogrsim::dynamics

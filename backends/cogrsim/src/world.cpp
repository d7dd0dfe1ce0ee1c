#include "world.h"

#include <cmath>
#include <exception>

#include "cogrsim/core/random.h"

namespace cogrsim::dynamics {
namespace {

constexpr double kFarthest = 1e6;  // [m]
constexpr double kFastest = 1e5;   // [m/s]

struct DynamicsSnapshot final : WorldSnapshot {
  std::uint64_t scene = 0;
  Progress progress;
};

// What makes two models the same scene: names, in order, of what was there at the start.
std::uint64_t signature(const SceneModel& model) {
  std::uint64_t hash = hash_bytes(model.name.data(), model.name.size());
  for (const Body& b : model.bodies) hash = hash_bytes(b.name.c_str(), b.name.size() + 1, hash);
  for (const Joint& j : model.joints) hash = hash_bytes(j.name.c_str(), j.name.size() + 1, hash);
  return hash;
}

}  // namespace

DynamicsWorld::DynamicsWorld(SceneModelPtr model, const StepperOptions& options)
    : options_(options), initial_(model) {
  start(std::move(model));
}

void DynamicsWorld::start(SceneModelPtr model) {
  auto engine = std::make_unique<Engine>(model, options_);
  Progress progress;
  progress.placed = progress.model = std::move(model);
  for (const Body& body : progress.model->bodies)
    progress.twists.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  engine_ = std::move(engine);
  progress_ = std::move(progress);
}

StepResult DynamicsWorld::step(double dt, const std::vector<Drive>& drives) {
  Mechanism& m = engine_->mechanism;
  copy(m.state.getQ(), progress_.start_q);
  copy(m.state.getU(), progress_.start_u);
  StepResult result;
  try {
    engine_->stepper.advance(dt, drives, progress_.twists);
    result.body = find_diverged();
    if (result.body >= 0)
      result.message = "body '" + progress_.model->bodies[std::size_t(result.body)].name +
                       "' left all bounds (1000 km, 100 km/s)";
  } catch (const std::bad_alloc&) {
    throw;  // no fault of the world's
  } catch (const std::exception& e) {
    result.message = std::string("Simbody: ") + e.what();
    result.status = StepStatus::diverged;
    result.body = find_suspect();
  }
  if (result.body >= 0) result.status = StepStatus::diverged;
  if (result.status == StepStatus::diverged) {
    m.state.updQ() = progress_.start_q;
    m.state.updU() = progress_.start_u;
    engine_->stepper.memory.clear();
    return result;
  }
  progress_.reactions_kept = false;
  progress_.time += dt;
  progress_.last_dt = dt;
  return result;
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
  const SimTK::Vector& q = m.state.getQ();
  const SimTK::Vector& u = m.state.getU();
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
    c.force = r.impulse / progress_.last_dt;
    out.push_back(c);
  }
}

void DynamicsWorld::capture(Progress& progress) const {
  const Engine& e = *engine_;
  progress = progress_;
  progress.q = e.mechanism.state.getQ();
  progress.u = e.mechanism.state.getU();
  progress.memory = e.stepper.memory;
  progress.impulses = e.stepper.impulses;
  progress.records = e.stepper.records;
}

void DynamicsWorld::apply(const Progress& progress) {
  Engine& e = *engine_;
  progress_ = progress;
  e.mechanism.state.updQ() = progress.q;
  e.mechanism.state.updU() = progress.u;
  e.stepper.memory = progress.memory;
  e.stepper.impulses = progress.impulses;
  e.stepper.records = progress.records;
}

SnapshotPtr DynamicsWorld::save() const {
  auto snapshot = std::make_shared<DynamicsSnapshot>();
  snapshot->scene = signature(*initial_);
  capture(snapshot->progress);
  return snapshot;
}

Result<> DynamicsWorld::restore(const SnapshotPtr& snapshot) {
  const auto* mine = dynamic_cast<const DynamicsSnapshot*>(snapshot.get());
  if (!mine) return fail("the snapshot is not of a world of the cogrsim backend");
  if (mine->scene != signature(*initial_))
    return fail("the snapshot is of another scene than '" + initial_->name + "'");
  try {
    if (mine->progress.placed != progress_.placed)
      engine_ = std::make_unique<Engine>(mine->progress.placed, options_);
    apply(mine->progress);
  } catch (const std::exception& e) {
    return fail("Simbody: " + message_of(e));
  }
  return {};
}

Result<> DynamicsWorld::reset() {
  try {
    start(initial_);
  } catch (const std::exception& e) {
    return fail("Simbody: " + message_of(e));
  }
  return {};
}

void* DynamicsWorld::extension(std::string_view id) {
  if (id == JointReactions::kId) return static_cast<JointReactions*>(this);
  if (id == KinematicDrive::kId) return static_cast<KinematicDrive*>(this);
  return nullptr;
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
  if (progress_.start_q.size() != e.mechanism.state.getNQ()) record.dt = 0.0;
  calc_joint_reactions(e.mechanism, record, out);
}

Result<> DynamicsWorld::set_kinematic_twist(int body, const Twist& twist) {
  const SceneModel& model = *progress_.model;
  if (body < 0 || std::size_t(body) >= model.bodies.size())
    return fail("there is no body " + std::to_string(body));
  const Body& b = model.bodies[std::size_t(body)];
  if (b.kind != BodyKind::kinematic || b.removed)
    return fail("body '" + b.name + "' is not kinematic", place_of(model, b.origin),
                "say kinematic=\"true\" on it");
  if (!twist.linear.allFinite() || !twist.angular.allFinite())
    return fail("body '" + b.name + "': a twist must be finite");
  progress_.twists[std::size_t(body)] = twist;
  return {};
}

}  // namespace cogrsim::dynamics

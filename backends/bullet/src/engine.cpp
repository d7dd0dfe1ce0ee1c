// Building Bullet's world and changing it; a step, and what can be read after it.
#include "engine.h"

#include <Eigen/Eigenvalues>

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyMLCPConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btLemkeSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>

#include "cogrsim/model/joint_kinematics.h"
#include "convert.h"

namespace cogrsim::bullet {

namespace {

// Bounds of what may still be called a state.
constexpr double kFarthest = 1e6;  // [m]
constexpr double kFastest = 1e5;   // [m/s]
constexpr double kMostSpin = 1e6;  // [rad/s]

std::unique_ptr<btConstraintSolver> make_solver(const std::string& name, bool reduced,
                                                std::unique_ptr<btMLCPSolverInterface>& mlcp) {
  mlcp.reset();
  if (name == "dantzig") mlcp = std::make_unique<btDantzigSolver>();
  if (name == "lemke") mlcp = std::make_unique<btLemkeSolver>();
  if (name == "projected-gauss-seidel") mlcp = std::make_unique<btSolveProjectedGaussSeidel>();
  if (mlcp && reduced) return std::make_unique<btMultiBodyMLCPConstraintSolver>(mlcp.get());
  if (mlcp) return std::make_unique<btMLCPSolver>(mlcp.get());
  if (reduced) return std::make_unique<btMultiBodyConstraintSolver>();
  if (name == "nncg") return std::make_unique<btNNCGConstraintSolver>();
  return std::make_unique<btSequentialImpulseConstraintSolver>();
}

int gyroscopic_flag(const std::string& name) {
  if (name == "implicit-body") return BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY;
  if (name == "implicit-world") return BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD;
  return name == "explicit" ? BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT : 0;
}

bool moves(const Body& body) { return body.kind == BodyKind::dynamic && !body.removed; }

/// Centre of mass and principal axes; the body's own axes where they are principal.
Pose principal_frame(const Body& body, btVector3& moments) {
  const Mat3& inertia = body.inertia;
  const double off = std::abs(inertia(0, 1)) + std::abs(inertia(0, 2)) + std::abs(inertia(1, 2));
  if (off <= 1e-14 * inertia.trace()) {
    moments = to_bt(Vec3(inertia.diagonal()));
    return {body.com, Quat(1, 0, 0, 0)};
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  Mat3 axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  moments = to_bt(Vec3(solver.eigenvalues()));
  return {body.com, Quat(axes).normalized()};
}

}  // namespace

WorldState initial_state(const SceneModel& model) {
  WorldState start;
  for (const Body& body : model.bodies) {
    start.poses.push_back(body.X_WB);
    start.twists.push_back(body.V_WB);
  }
  for (const Joint& joint : model.joints) {
    start.joint_positions.insert(start.joint_positions.end(), joint.position.begin(),
                                 joint.position.end());
    start.joint_velocities.insert(start.joint_velocities.end(), joint.velocity.begin(),
                                  joint.velocity.end());
  }
  return start;
}

Result<std::unique_ptr<Engine>> Engine::create(const SceneModelPtr& model, const Options& options,
                                               const WorldState& state) {
  auto out = std::unique_ptr<Engine>(new Engine(model, options));
  if (auto done = out->build(state); !done) return tl::unexpected<Error>(done.error());
  return out;
}

Engine::~Engine() {
  for (const auto& joint : joints_) joint->remove_from(*world_);
  for (const auto& tree : trees_) tree->remove_from(*reduced_world_);
  for (const Part& part : parts_) {
    if (part.rigid) world_->removeRigidBody(part.rigid.get());
  }
}

void Engine::make_world(bool reduced) {
  btDefaultCollisionConstructionInfo info;
  configuration_ = std::make_unique<btDefaultCollisionConfiguration>(info);
  if (const int n = options_.plane_convex_points; n > 0) {
    configuration_->setPlaneConvexMultipointIterations(n, n);
  }
  if (const int n = options_.convex_convex_points; n > 0) {
    configuration_->setConvexConvexMultipointIterations(n, n);
  }
  dispatcher_ = std::make_unique<btCollisionDispatcher>(configuration_.get());
  broadphase_ = std::make_unique<btDbvtBroadphase>();
  solver_ = make_solver(options_.solver, reduced, mlcp_);
  if (reduced) {
    auto made = std::make_unique<btMultiBodyDynamicsWorld>(
        dispatcher_.get(), broadphase_.get(),
        static_cast<btMultiBodyConstraintSolver*>(solver_.get()), configuration_.get());
    reduced_world_ = made.get();
    world_ = std::move(made);
  } else {
    world_ = std::make_unique<btDiscreteDynamicsWorld>(dispatcher_.get(), broadphase_.get(),
                                                       solver_.get(), configuration_.get());
  }
  world_->getDispatchInfo().m_deterministicOverlappingPairs = options_.deterministic_pairs;
  btContactSolverInfo& solver = world_->getSolverInfo();
  solver.m_numIterations = options_.iterations;
  solver.m_erp = options_.erp;
  solver.m_erp2 = options_.erp2;
  solver.m_globalCfm = options_.cfm;
  solver.m_splitImpulse = options_.split_impulse;
  solver.m_splitImpulsePenetrationThreshold = options_.split_impulse_penetration_threshold;
  // Without warm starting the solver would not write its impulses back: a factor of 0 is the same.
  solver.m_warmstartingFactor = options_.warm_starting ? options_.warm_starting_factor : 0.0;
  if (options_.friction_directions == 1) solver.m_solverMode &= ~SOLVER_USE_2_FRICTION_DIRECTIONS;
  if (options_.friction_directions == 2) solver.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  if (mlcp_) solver.m_minimumSolverBatchSize = 1;  // its cost grows with the cube of a batch
  world_->setGravity(to_bt(model_->physics.gravity));
  solver.m_restitutionVelocityThreshold = model_->physics.bounce_threshold;
  ground_ = std::make_unique<btRigidBody>(
      btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, nullptr));
}

Result<> Engine::build(const WorldState& state) {
  const auto plans = plan_trees(*model_, options_);
  if (!plans) return tl::unexpected<Error>(plans.error());
  make_world(!plans->empty());
  const std::size_t count = model_->bodies.size();
  std::vector<char> in_tree(count, 0);
  for (const TreePlan& plan : *plans) {
    for (const int b : plan.bodies) in_tree[at(b)] = 1;
  }
  parts_.resize(count);
  for (std::size_t b = 0; b < count; ++b) {
    const Body& body = model_->bodies[b];
    if (body.removed) continue;
    Part& part = parts_[b];
    part.place = state.poses[b];
    if (body.kind == BodyKind::dynamic) part.X_BG = principal_frame(body, part.inertia);
    auto shape = make_body_shape(*model_, body, options_, part.X_BG);
    if (!shape) return tl::unexpected<Error>(shape.error());
    part.shape = std::move(*shape);
    part.centred = part.X_BG.p == Vec3::Zero() && part.X_BG.q.coeffs() == Quat(1, 0, 0, 0).coeffs();
    if (!in_tree[b]) add_body(static_cast<int>(b), state);
  }
  positions_ = state.joint_positions;
  for (const TreePlan& plan : *plans) add_tree(plan, state);
  trees_before_.resize(trees_.size());
  for (std::size_t t = 0; t < trees_.size(); ++t) trees_[t]->save(trees_before_[t]);
  for (std::size_t j = 0; j < model_->joints.size(); ++j) add_joint(static_cast<int>(j));
  set_ignored_pairs();
  list_movers();
  return {};
}

Motion Engine::motion_of(const Part& part, const Pose& X, const Twist& V) const {
  const Vec3 arm = X.q * part.X_BG.p;
  return {to_bt(part.centred ? X : X * part.X_BG), to_bt(part.centred ? V.linear : V.at(arm)),
          to_bt(V.angular)};
}

void Engine::add_body(int body, const WorldState& state) {
  const Body& of = model_->bodies[at(body)];
  Part& part = parts_[at(body)];
  const Motion start = motion_of(part, state.poses[at(body)], state.twists[at(body)]);
  btRigidBody::btRigidBodyConstructionInfo info(of.kind == BodyKind::dynamic ? of.mass : 0.0,
                                                nullptr, part.shape->shape, part.inertia);
  info.m_startWorldTransform = start.X;
  part.rigid = std::make_unique<btRigidBody>(info);
  btRigidBody& rigid = *part.rigid;
  rigid.setFlags(gyroscopic_flag(options_.gyroscopic));
  rigid.setUserIndex(body);
  rigid.setUserPointer(surfaces_.get());
  int flags = rigid.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK;
  if (of.kind == BodyKind::kinematic) {
    flags = (flags & ~btCollisionObject::CF_STATIC_OBJECT) | btCollisionObject::CF_KINEMATIC_OBJECT;
  }
  rigid.setCollisionFlags(flags);
  rigid.setActivationState(DISABLE_DEACTIVATION);
  if (of.kind == BodyKind::dynamic) set_motion(rigid, start);
  if (part.shape->collides) {
    world_->addRigidBody(&rigid);
  } else {
    world_->addRigidBody(&rigid, 0, 0);
  }
}

void Engine::set_motion(btRigidBody& body, const Motion& motion) {
  body.setLinearVelocity(motion.velocity);
  body.setAngularVelocity(motion.spin);
  body.setCenterOfMassTransform(motion.X);
  body.setInterpolationWorldTransform(motion.X);
}

void Engine::add_tree(const TreePlan& plan, const WorldState& state) {
  std::vector<LinkBody> bodies(parts_.size());
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const Part& part = parts_[b];
    if (!part.shape) continue;
    bodies[b] = {part.X_BG, part.place, part.inertia, part.shape->shape, part.shape->collides};
  }
  trees_.push_back(std::make_unique<Tree>(model_, plan, bodies, surfaces_.get()));
  Tree& tree = *trees_.back();
  Motion root;
  if (plan.root != kWorld) {
    root =
        motion_of(parts_[at(plan.root)], state.poses[at(plan.root)], state.twists[at(plan.root)]);
  }
  tree.set_state(state, root.X, root.velocity, root.spin);
  tree.add_to(*reduced_world_, bodies);
  for (const int b : plan.bodies) parts_[at(b)].tree = &tree;
}

void Engine::add_joint(int joint) {
  const Joint& made = model_->joints[at(joint)];
  if (made.removed || made.type == JointType::free) return;
  const auto is_free = [&](int body) { return body != kWorld && moves(model_->bodies[at(body)]); };
  if (!is_free(made.parent) && !is_free(made.child)) return;
  for (const int end : {made.parent, made.child}) {
    if (end != kWorld && parts_[at(end)].tree) return;  // a link's
  }
  const auto rigid = [&](int body) -> btRigidBody& {
    return body == kWorld ? *ground_ : *parts_[at(body)].rigid;
  };
  auto constraint = std::make_unique<ConstraintJoint>(
      *model_, joint, rigid(made.parent), rigid(made.child), frame_of(made.parent, made.X_PF),
      frame_of(made.child, made.X_CM));
  constraint->add_to(*world_);
  joints_.push_back(std::move(constraint));
}

/// Pairs that the scene keeps apart, and the ends of a link's joint. A constraint's ends are kept
/// apart by itself.
void Engine::set_ignored_pairs() {
  std::vector<std::pair<int, int>> wanted = model_->no_collide;
  for (const auto& tree : trees_) {
    for (const int j : tree->plan().joints) {
      const Joint& joint = model_->joints[at(j)];
      if (joint.parent != kWorld && !joint.bodies_collide) {
        wanted.emplace_back(joint.parent, joint.child);
      }
    }
  }
  for (const auto& [first, second] : wanted) {
    btCollisionObject *const a = object(first), *const b = object(second);
    if (!a || !b) continue;
    a->setIgnoreCollisionCheck(b, true);
    b->setIgnoreCollisionCheck(a, true);
  }
}

void Engine::list_movers() {
  movers_.clear();
  now_.clear();
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const btRigidBody* const rigid = parts_[b].rigid.get();
    if (!rigid || model_->bodies[b].kind != BodyKind::dynamic) continue;
    movers_.push_back(static_cast<int>(b));
    now_.push_back(
        {rigid->getWorldTransform(), rigid->getLinearVelocity(), rigid->getAngularVelocity()});
  }
  before_ = now_;
}

void Engine::forget_contacts() {
  btOverlappingPairCache& cache = *broadphase_->getOverlappingPairCache();
  for (int i = 0; i < cache.getNumOverlappingPairs(); ++i) {
    cache.cleanOverlappingPair(cache.getOverlappingPairArray()[i], dispatcher_.get());
  }
}

btCollisionObject* Engine::object(int body) const {
  const Part& part = parts_[at(body)];
  if (part.rigid) return part.rigid.get();
  return part.tree ? part.tree->collider(body) : nullptr;
}

/// A frame of a body's, in Bullet's frame of it.
btTransform Engine::frame_of(int body, const Pose& X_BF) const {
  if (body == kWorld || parts_[at(body)].centred) return to_bt(X_BF);
  return to_bt(parts_[at(body)].X_BG.inverse() * X_BF);
}

// --- A step -----------------------------------------------------------------------------------

void Engine::count_turns(int joint) const {
  const Joint& of = model_->joints[at(joint)];
  const auto place = [&](int body) { return body == kWorld ? Pose() : pose(body); };
  double* const q = positions_.data() + of.position_offset;
  joint_position(of, relative_pose(of, place(of.parent), place(of.child)), q, q);
}

void Engine::apply_joints(double dt, const std::vector<Drive>& drives) {
  for (const auto& joint : joints_) {
    if (!joint->has_laws()) continue;
    const double* q = nullptr;
    if (joint->needs_position(drives)) {
      count_turns(joint->joint());
      q = positions_.data() + model_->joints[at(joint->joint())].position_offset;
    }
    joint->apply(dt, drives, q);
  }
  for (const auto& tree : trees_) tree->apply(dt, drives);
}

int Engine::step(double dt, const std::vector<Drive>& drives, const std::vector<Twist>& twists) {
  double spin = 0.0;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (model_->bodies[b].kind != BodyKind::kinematic || !parts_[b].rigid) continue;
    // Bullet takes its velocity from where it is put.
    Pose& X = parts_[b].place;
    const double angle = twists[b].angular.norm() * dt;
    X.p += twists[b].linear * dt;
    if (angle > 0) {
      X.q = (Quat(Eigen::AngleAxisd(angle, twists[b].angular.normalized())) * X.q).normalized();
    }
    spin = std::max(spin, angle / dt);
    parts_[b].rigid->setWorldTransform(to_bt(X * parts_[b].X_BG));
  }
  for (std::size_t t = 0; t < trees_.size(); ++t) trees_[t]->save(trees_before_[t]);
  apply_joints(dt, drives);
  world_->stepSimulation(dt, 0);

  before_.swap(now_);
  int diverged = -1;
  double most = spin * spin;
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const btRigidBody& body = *parts_[at(movers_[i])].rigid;
    Motion& motion = now_[i];
    motion.X = body.getWorldTransform();
    motion.velocity = body.getLinearVelocity();
    motion.spin = body.getAngularVelocity();
    const double turning = motion.spin.length2();
    most = std::max(most, turning);
    // Written so that a NaN fails.
    const bool fine = motion.X.getOrigin().length2() < kFarthest * kFarthest &&
                      motion.velocity.length2() < kFastest * kFastest &&
                      turning < kMostSpin * kMostSpin;
    if (!fine && diverged < 0) diverged = movers_[i];
  }
  double fastest = std::sqrt(most);
  for (const auto& tree : trees_) {
    if (!tree->is_sound() && diverged < 0) diverged = tree->plan().bodies.front();
    fastest = std::max(fastest, tree->fastest());
  }
  if (diverged >= 0) {
    now_ = before_;
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      set_motion(*parts_[at(movers_[i])].rigid, now_[i]);
    }
    for (std::size_t t = 0; t < trees_.size(); ++t) trees_[t]->restore(trees_before_[t]);
    forget_contacts();
    return diverged;
  }
  // Two bodies turn against each other by at most twice that; half a turn may not be missed.
  turned_ += 2.0 * dt * fastest;
  if (turned_ > 2.0) {
    for (std::size_t j = 0; j < model_->joints.size(); ++j) {
      if (!model_->joints[j].removed) count_turns(static_cast<int>(j));
    }
    turned_ = 0.0;
  }
  return -1;
}

Pose Engine::pose(int body) const {
  const Part& part = parts_[at(body)];
  if (!moves(model_->bodies[at(body)])) return part.place;
  const btTransform X = part.tree ? part.tree->place(body) : part.rigid->getWorldTransform();
  return part.centred ? from_bt(X) : from_bt(X) * part.X_BG.inverse();
}

Twist Engine::twist(int body) const {
  const Part& part = parts_[at(body)];
  if (!moves(model_->bodies[at(body)])) return {};
  btVector3 velocity, spin;
  if (part.tree) {
    part.tree->get_velocity(body, velocity, spin);
  } else {
    velocity = part.rigid->getLinearVelocity();
    spin = part.rigid->getAngularVelocity();
  }
  Twist out{from_bt(velocity), from_bt(spin)};
  if (!part.centred) out.linear = out.at(pose(body).q * -part.X_BG.p);
  return out;
}

void Engine::get_joints(WorldState& out) const {
  turned_ = 0.0;
  const auto place = [&](int body) { return body == kWorld ? Pose() : out.poses[at(body)]; };
  const auto motion = [&](int body) { return body == kWorld ? Twist() : out.twists[at(body)]; };
  for (const Joint& joint : model_->joints) {
    if (joint.removed) continue;
    double* const q = positions_.data() + joint.position_offset;
    const Pose X_WP = place(joint.parent), X_WC = place(joint.child);
    const Pose X_FM = relative_pose(joint, X_WP, X_WC);
    joint_position(joint, X_FM, q, q);
    joint_velocity(joint, X_FM,
                   relative_twist(joint, X_WP, motion(joint.parent), X_WC, motion(joint.child)), q,
                   out.joint_velocities.data() + joint.speed_offset);
    std::copy(q, q + position_count(joint.type),
              out.joint_positions.begin() + joint.position_offset);
  }
}

void Engine::set_state(const WorldState& state) {
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    Part& part = parts_[b];
    const Body& body = model_->bodies[b];
    if (!part.rigid || body.kind == BodyKind::fixed) continue;
    const Motion motion = motion_of(part, state.poses[b], state.twists[b]);
    part.place = state.poses[b];
    set_motion(*part.rigid, body.kind == BodyKind::dynamic ? motion : Motion{motion.X, {}, {}});
  }
  for (const auto& tree : trees_) {
    Motion root;
    if (const int b = tree->plan().root; b != kWorld) {
      root = motion_of(parts_[at(b)], state.poses[at(b)], state.twists[at(b)]);
    }
    tree->set_state(state, root.X, root.velocity, root.spin);
  }
  positions_ = state.joint_positions;
  turned_ = 0.0;
  list_movers();
  forget_contacts();
}

// --- Reports ----------------------------------------------------------------------------------

/// Where a rigid body was when the last step began; kinematic ones, where it put them.
btTransform Engine::start_of(int body) const {
  if (body == kWorld) return btTransform::getIdentity();
  const auto found = std::lower_bound(movers_.begin(), movers_.end(), body);
  if (found == movers_.end() || *found != body) return parts_[at(body)].rigid->getWorldTransform();
  return before_[static_cast<std::size_t>(found - movers_.begin())].X;
}

void Engine::get_efforts(double dt, std::vector<double>& joints,
                         std::vector<double>& motors) const {
  std::fill(joints.begin(), joints.end(), 0.0);
  std::fill(motors.begin(), motors.end(), 0.0);
  for (const auto& constraint : joints_) {
    const Joint& joint = model_->joints[at(constraint->joint())];
    constraint->get_efforts(start_of(joint.parent), start_of(joint.child),
                            joints.data() + joint.speed_offset, motors);
  }
  for (const auto& tree : trees_) tree->get_efforts(dt, joints, motors);
}

void Engine::get_reactions(std::vector<Wrench>& out) const {
  out.assign(model_->joints.size(), Wrench());
  for (const auto& joint : joints_) {
    btVector3 force, torque;
    joint->get_reaction(start_of(model_->joints[at(joint->joint())].child), force, torque);
    out[at(joint->joint())] = {from_bt(force), from_bt(torque)};
  }
}

void Engine::get_contacts(double dt, std::vector<Contact>& out) const {
  out.clear();
  for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher_->getManifoldByIndexInternal(i);
    const int first = manifold.getBody0()->getUserIndex();
    const int second = manifold.getBody1()->getUserIndex();
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      // On the first body, along what leads to it from the second.
      const btVector3 impulse = point.m_normalWorldOnB * point.m_appliedImpulse +
                                point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                                point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
      const bool swapped = first > second;
      const double sign = swapped ? 1.0 : -1.0;
      Contact contact;
      contact.body_a = swapped ? second : first;
      contact.body_b = swapped ? first : second;
      contact.shape_a = swapped ? point.m_partId1 : point.m_partId0;
      contact.shape_b = swapped ? point.m_partId0 : point.m_partId1;
      contact.point = from_bt((point.m_positionWorldOnA + point.m_positionWorldOnB) / 2);
      contact.normal = from_bt(point.m_normalWorldOnB * sign);
      contact.depth = -point.getDistance();
      contact.force = from_bt(impulse * (sign / dt));
      out.push_back(contact);
    }
  }
  const auto key = [](const Contact& c) {
    return std::make_tuple(c.body_a, c.body_b, c.shape_a, c.shape_b);
  };
  std::stable_sort(out.begin(), out.end(),
                   [&](const Contact& a, const Contact& b) { return key(a) < key(b); });
}

}  // namespace cogrsim::bullet

// Building Bullet's world and changing it; a step, and what can be read after it.
#include "engine.h"

#include <Eigen/Eigenvalues>

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btLemkeSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/warnings.h"
#include "convert.h"

namespace cogrsim::bullet {

namespace {

// Sweeps over the rows of joints where there are rotors or couplings, at most, and the square of the
// change of speeds in one [rad^2/s^2] that ends them. A double pendulum with rotors of 5, 50, 250 times
// its links' inertia is within 0.5 mrad of a direct solver's after 3 s with 200 sweeps; with 1000 times
// it is 8 mrad off, with 1000 sweeps 0.
constexpr int kSweeps = 500;
constexpr double kSettled = 1e-24;

// A rotor's inertia over that of the bodies it turns, up to which they hold it.
constexpr double kMostRotor = 1000.0;

// A softness of rows from which Bullet's sweeps are slow to converge or diverge (1).
constexpr double kSoftRow = 0.7;

/// Keeps the rows of joints. btJointFeedback would sum them up in every step, asked for or not.
template <class Solver>
class RowKeeper : public Solver {
 public:
  template <class... Inner>
  explicit RowKeeper(JointRows& rows, Inner... inner) : Solver(inner...), rows_(rows) {}

 private:
  // A sweep of Bullet's over a row adds rhs - cfm impulse - speed / mobility to its impulse, as if
  // the softness were no part of the mobility. Its three numbers scaled, a soft row has the same
  // solution and converges.
  void convertJoints(btTypedConstraint** constraints, int count,
                     const btContactSolverInfo& info) override {
    Solver::convertJoints(constraints, count, info);
    btConstraintArray& made = this->m_tmpSolverNonContactConstraintPool;
    for (int i = 0; i < made.size(); ++i) {
      if (made[i].m_cfm < kSoftRow) continue;
      const double scale = 1.0 / (1.0 + made[i].m_cfm);
      made[i].m_jacDiagABInv *= scale;
      made[i].m_rhs *= scale;
      made[i].m_cfm *= scale;
    }
  }
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int count,
                                         const btContactSolverInfo& info) override {
    const btConstraintArray& solved = this->m_tmpSolverNonContactConstraintPool;
    const int first = rows_.size();
    rows_.resizeNoInitialize(first + solved.size());
    for (int i = 0; i < solved.size(); ++i) {
      JointRow& row = rows_[first + i];
      row.constraint = static_cast<btTypedConstraint*>(solved[i].m_originalContactPoint);
      row.linear = solved[i].m_contactNormal2 * solved[i].m_appliedImpulse;
      row.angular = solved[i].m_relpos2CrossNormal * solved[i].m_appliedImpulse;
    }
    return Solver::solveGroupCacheFriendlyFinish(bodies, count, info);
  }
  JointRows& rows_;
};

/// Bullet's matrix knows one softness for all rows; each row has its own here as in the sweeps.
class MatrixKeeper final : public RowKeeper<btMLCPSolver> {
  using RowKeeper::RowKeeper;
  void createMLCPFast(const btContactSolverInfo& info) override {
    RowKeeper::createMLCPFast(info);
    for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
      const btSolverConstraint& row = *m_allConstraintPtrArray[i];
      if (row.m_cfm > info.m_globalCfm)
        m_A.setElem(i, i, m_A(i, i) + row.m_cfm / row.m_jacDiagABInv);
    }
  }
};

std::unique_ptr<btConstraintSolver> make_solver(const std::string& name,
                                                std::unique_ptr<btMLCPSolverInterface>& mlcp,
                                                JointRows& rows) {
  mlcp.reset();
  if (name == "dantzig") mlcp = std::make_unique<btDantzigSolver>();
  if (name == "lemke") mlcp = std::make_unique<btLemkeSolver>();
  if (name == "projected-gauss-seidel") mlcp = std::make_unique<btSolveProjectedGaussSeidel>();
  if (mlcp) return std::make_unique<MatrixKeeper>(rows, mlcp.get());
  if (name == "nncg") return std::make_unique<RowKeeper<btNNCGConstraintSolver>>(rows);
  return std::make_unique<RowKeeper<btSequentialImpulseConstraintSolver>>(rows);
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

const ParameterTable& Engine::options() {
  static const ParameterTable table = {
      parameter(
          "solver", "sequential-impulse",
          "btSequentialImpulseConstraintSolver, btNNCGConstraintSolver (diverges with bounded "
          "motors), or btMLCPSolver with btDantzigSolver, btLemkeSolver (none for friction) or "
          "btSolveProjectedGaussSeidel")
          .one_of({"sequential-impulse", "nncg", "dantzig", "lemke", "projected-gauss-seidel"}),
      parameter("iterations", 10, "sweeps of the solver (m_numIterations)").range(1, 10000),
      parameter("erp", 0.2, "part of a joint's error that a step takes back (m_erp)").range(0, 1),
      parameter("erp2", 0.2, "part of an overlap that a step takes back (m_erp2)").range(0, 1),
      parameter("cfm", 0.0, "softness of contacts and joints (m_globalCfm)").range(0, 1e3),
      parameter("split-impulse", true,
                "overlap beyond the threshold is taken back without momentum (m_splitImpulse)"),
      parameter("split-impulse-penetration-threshold", -0.04, "m",
                "contact distance below which impulses are split")
          .range(-1e3, 1e3),
      parameter("warm-starting", true, "begin with the impulses of the step before"),
      parameter("warm-starting-factor", 0.85, "part of them (m_warmstartingFactor)").range(0, 1),
      parameter("friction-directions", 1,
                "1: along the slip, 2: also across it (SOLVER_USE_2_FRICTION_DIRECTIONS)")
          .range(1, 2),
      parameter("margin", 0.0, "m",
                "collision margin of boxes, cylinders and hulls; 0: a tenth of the smallest half "
                "extent, 4 cm at most (setSafeMargin)")
          .range(0, 10),
      parameter("plane-convex-multipoint-iterations", 4,
                "contact points between a plane and another shape that are looked for at once "
                "(setPlaneConvexMultipointIterations)")
          .range(0, 16),
  };
  return table;
}

Result<std::unique_ptr<Engine>> Engine::make(const SceneModelPtr& model, const Parameters& options,
                                             const WorldState& begin, const Engine*) {
  std::unique_ptr<Engine> out(new Engine(model));
  if (auto done = out->build(options, begin); !done) return tl::unexpected<Error>(done.error());
  return out;
}

Engine::~Engine() {
  // The world takes its bodies out of the broadphase, which cannot be done once memory ran out while
  // its pairs grew: it is leaked then, and the broadphase frees itself.
  sound_ ? world_.reset() : void(world_.release());
}

void Engine::make_world(const Parameters& options) {
  btDefaultCollisionConstructionInfo info;
  configuration_ = std::make_unique<btDefaultCollisionConfiguration>(info);
  const auto count = [&](const char* name) {
    return static_cast<int>(value_of<std::int64_t>(options, name));
  };
  const int points = count("plane-convex-multipoint-iterations");
  if (points > 0) configuration_->setPlaneConvexMultipointIterations(points, points);
  dispatcher_ = std::make_unique<btCollisionDispatcher>(configuration_.get());
  broadphase_ = std::make_unique<btDbvtBroadphase>();
  solver_ = make_solver(value_of<std::string>(options, "solver"), mlcp_, rows_);
  world_ = std::make_unique<btDiscreteDynamicsWorld>(dispatcher_.get(), broadphase_.get(),
                                                     solver_.get(), configuration_.get());
  // Pairs in order of their bodies, not of memory addresses: otherwise runs need not repeat.
  world_->getDispatchInfo().m_deterministicOverlappingPairs = true;
  const auto number = [&](const char* name) { return value_of<double>(options, name); };
  btContactSolverInfo& solver = world_->getSolverInfo();
  solver.m_numIterations = count("iterations");
  solver.m_erp = number("erp");
  solver.m_erp2 = number("erp2");
  solver.m_globalCfm = number("cfm");
  solver.m_splitImpulse = value_of<bool>(options, "split-impulse");
  solver.m_splitImpulsePenetrationThreshold = number("split-impulse-penetration-threshold");
  // Without warm starting the solver would not write its impulses back: a factor of 0 is the same.
  solver.m_warmstartingFactor =
      value_of<bool>(options, "warm-starting") ? number("warm-starting-factor") : 0.0;
  if (count("friction-directions") == 2) solver.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  if (!surfaces_->velocities.empty()) {
    solver.m_solverMode |=
        SOLVER_USE_2_FRICTION_DIRECTIONS | SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;
  }
  if (mlcp_) solver.m_minimumSolverBatchSize = 1;  // its cost grows with the cube of a batch
  world_->setGravity(to_bt(model_->physics.gravity));
  solver.m_restitutionVelocityThreshold = model_->physics.bounce_threshold;
  ground_ = std::make_unique<btRigidBody>(
      btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, nullptr));
}

Result<> Engine::build(const Parameters& options, const WorldState& state) {
  make_world(options);
  const std::size_t count = model_->bodies.size();
  parts_.resize(count);
  before_.resize(count);
  for (std::size_t b = 0; b < count; ++b) {
    const Body& body = model_->bodies[b];
    if (body.removed) continue;
    Part& part = parts_[b];
    part.pose = state.poses[b];
    if (body.kind == BodyKind::dynamic) part.X_BG = principal_frame(body, part.inertia);
    auto shape = make_body_shape(*model_, body, value_of<double>(options, "margin"), part.X_BG);
    if (!shape) return tl::unexpected<Error>(shape.error());
    part.shape = std::move(*shape);
    surfaces_->set_frame(static_cast<int>(b), part.X_BG);
    part.centred = part.X_BG.p == Vec3::Zero() && part.X_BG.q.coeffs() == Quat(1, 0, 0, 0).coeffs();
  }
  // Bodies side by side in memory, and so constraints.
  for (std::size_t b = 0; b < count; ++b) make_body(static_cast<int>(b), state);
  for (std::size_t b = 0; b < count; ++b) add_body(static_cast<int>(b));
  if (!model_->couplings.empty() || has_rotors(*model_)) {
    sweeps_ = kSweeps;
    world_->getSolverInfo().m_leastSquaresResidualThreshold = kSettled;
  }
  const auto cfm = value_of<double>(options, "cfm");
  for (std::size_t j = 0; j < model_->joints.size(); ++j) make_joint(static_cast<int>(j), cfm);
  for (const auto& joint : joints_) joint->make_constraint();
  for (const auto& joint : joints_) {
    joint->make_laws(*model_);
    joint->add_to(*world_, sweeps_);
  }
  // Pairs that the scene excludes from collision. A constraint excludes its own two bodies.
  for (const auto& [first, second] : model_->no_collide) {
    btRigidBody *const a = parts_[first].rigid.get(), *const b = parts_[second].rigid.get();
    if (!a || !b) continue;
    a->setIgnoreCollisionCheck(b, true);
    b->setIgnoreCollisionCheck(a, true);
  }
  sound_ = true;
  return {};
}

Motion Engine::motion_of(const Part& part, const Pose& X, const Twist& V) const {
  const Vec3 arm = X.q * part.X_BG.p;
  return {to_bt(part.centred ? X : X * part.X_BG), to_bt(part.centred ? V.linear : V.at(arm)),
          to_bt(V.angular)};
}

void Engine::make_body(int body, const WorldState& state) {
  const Body& of = model_->bodies[body];
  Part& part = parts_[body];
  if (of.removed) return;
  const Motion start = motion_of(part, state.poses[body], state.twists[body]);
  btRigidBody::btRigidBodyConstructionInfo info(of.kind == BodyKind::dynamic ? of.mass : 0.0,
                                                nullptr, part.shape->shape, part.inertia);
  info.m_startWorldTransform = start.X;
  part.rigid = std::make_unique<btRigidBody>(info);
  btRigidBody& rigid = *part.rigid;
  rigid.setUserIndex(body);
  rigid.setUserPointer(surfaces_.get());
  int flags = rigid.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK;
  if (of.kind == BodyKind::kinematic) {
    kinematic_.push_back(body);
    flags = (flags & ~btCollisionObject::CF_STATIC_OBJECT) | btCollisionObject::CF_KINEMATIC_OBJECT;
  }
  rigid.setCollisionFlags(flags);
  rigid.setActivationState(DISABLE_DEACTIVATION);
  if (of.kind == BodyKind::dynamic) {
    set_motion(rigid, start);
    movers_.push_back(body);
  }
  before_[body] = start;
}

void Engine::add_body(int body) {
  Part& part = parts_[body];
  if (!part.rigid) return;
  btRigidBody& rigid = *part.rigid;
  part.shape->collides ? world_->addRigidBody(&rigid) : world_->addRigidBody(&rigid, 0, 0);
  rigid.setGravity(model_->bodies[body].gravity_scale *
                   world_->getGravity());  // addRigidBody sets the world's
}

void Engine::set_motion(btRigidBody& body, const Motion& motion) {
  body.setLinearVelocity(motion.velocity);
  body.setAngularVelocity(motion.spin);
  body.setCenterOfMassTransform(motion.X);
  body.setInterpolationWorldTransform(motion.X);
}

void Engine::make_joint(int joint, double cfm) {
  const Joint& made = model_->joints[joint];
  if (made.removed || made.type == JointType::free) return;
  const auto is_free = [&](int body) { return body != kWorld && moves(model_->bodies[body]); };
  if (!is_free(made.parent) && !is_free(made.child)) return;
  const auto exists = [&](int body) { return body == kWorld || parts_[body].rigid; };
  if (!exists(made.parent) || !exists(made.child)) return;  // of a forged snapshot
  const auto rigid = [&](int body) -> btRigidBody& {
    return body == kWorld ? *ground_ : *parts_[body].rigid;
  };
  joints_.push_back(std::make_unique<ConstraintJoint>(
      *model_, joint, rigid(made.parent), rigid(made.child), frame_of(made.parent, made.X_PF),
      frame_of(made.child, made.X_CM), cfm));
}

Motion Engine::motion(const btRigidBody& body) {
  return {body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity()};
}

void Engine::forget_contacts() {
  btOverlappingPairCache& cache = *broadphase_->getOverlappingPairCache();
  for (int i = 0; i < cache.getNumOverlappingPairs(); ++i)
    cache.cleanOverlappingPair(cache.getOverlappingPairArray()[i], dispatcher_.get());
}

/// A frame of a body's, in Bullet's frame of it.
btTransform Engine::frame_of(int body, const Pose& X_BF) const {
  if (body == kWorld || parts_[body].centred) return to_bt(X_BF);
  return to_bt(parts_[body].X_BG.inverse() * X_BF);
}

void Engine::step(const StepInput& input) {
  dt_ = input.dt;
  driven_spin_ = 0.0;
  for (const int b : kinematic_) {
    // Bullet takes its velocity from where it is put.
    Part& part = parts_[b];
    part.before = part.pose;
    part.pose = moved(part.pose, input.twists[b], dt_);
    driven_spin_ = std::max(driven_spin_, input.twists[b].angular.norm());
    before_[b].X = to_bt(part.pose * part.X_BG);
    part.rigid->setWorldTransform(before_[b].X);
  }
  for (const auto& joint : joints_) joint->apply(input);
  for (const int b : movers_) before_[b] = motion(*parts_[b].rigid);
  for (std::size_t b = 0; b < input.external.size(); ++b) {  // Bullet clears them after the step
    if (!parts_[b].rigid) continue;
    parts_[b].rigid->applyCentralForce(to_bt(input.external[b].force));
    parts_[b].rigid->applyTorque(to_bt(input.external[b].torque));
  }
  rows_.resizeNoInitialize(0);
  sound_ = false;
  world_->stepSimulation(dt_, 0);
  sound_ = true;
}

int Engine::find_lost() const {
  for (const int b : movers_) {
    const btRigidBody& body = *parts_[b].rigid;
    if (!kBounds.hold(body.getCenterOfMassPosition().length2(), body.getLinearVelocity().length2(),
                      body.getAngularVelocity().length2()))
      return b;
  }
  return -1;
}

bool Engine::undo() {
  for (const int b : movers_) set_motion(*parts_[b].rigid, before_[b]);
  for (const int b : kinematic_) {
    Part& part = parts_[b];
    part.pose = part.before;
    before_[b].X = to_bt(part.pose * part.X_BG);
    part.rigid->setWorldTransform(before_[b].X);
    part.rigid->setInterpolationWorldTransform(before_[b].X);
  }
  forget_contacts();
  return true;
}

double Engine::fastest_spin() const {
  double most = driven_spin_ * driven_spin_;
  for (const int b : movers_)
    most = std::max(most, parts_[b].rigid->getAngularVelocity().length2());
  return std::sqrt(most);
}

std::vector<Diagnostic> Engine::warnings() const {
  if (mlcp_) return {};
  std::vector<std::vector<double>> ratios(model_->joints.size());
  for (const auto& joint : joints_) {
    for (std::size_t i = 0; i < model_->joints[joint->joint()].axes.size(); ++i)
      ratios[joint->joint()].push_back(joint->rotor_ratio(i));
  }
  return rotor_warnings(*model_, "bullet", ratios, kMostRotor);
}

Pose Engine::pose(int body) const {
  const Part& part = parts_[body];
  if (!moves(model_->bodies[body])) return part.pose;
  const btTransform& X = part.rigid->getWorldTransform();
  return part.centred ? from_bt(X) : from_bt(X) * part.X_BG.inverse();
}

Twist Engine::twist(int body) const {
  const Part& part = parts_[body];
  if (!moves(model_->bodies[body])) return {};
  Twist out{from_bt(part.rigid->getLinearVelocity()), from_bt(part.rigid->getAngularVelocity())};
  if (!part.centred) out.linear = out.at(pose(body).q * -part.X_BG.p);
  return out;
}

void Engine::write(const WorldState& state) {
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    Part& part = parts_[b];
    const Body& body = model_->bodies[b];
    if (!part.rigid || body.kind == BodyKind::static_body) continue;
    const Motion motion = motion_of(part, state.poses[b], state.twists[b]);
    part.pose = state.poses[b];
    set_motion(*part.rigid, body.kind == BodyKind::dynamic ? motion : Motion{motion.X, {}, {}});
    before_[b] = motion;
  }
  forget_contacts();
}

btTransform Engine::start_of(int body) const {
  return body == kWorld ? btTransform::getIdentity() : before_[body].X;
}

void Engine::sum_rows() const {
  if (rows_.size() == 0) return;
  for (const auto& joint : joints_) joint->clear_loads();
  for (int i = 0; i < rows_.size(); ++i) {
    Load& load = *static_cast<Load*>(rows_[i].constraint->getUserConstraintPtr());
    load.force += rows_[i].linear / dt_;
    load.torque += rows_[i].angular / dt_;
  }
  rows_.resizeNoInitialize(0);
}

void Engine::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  sum_rows();
  for (const auto& constraint : joints_) {
    const Joint& joint = model_->joints[constraint->joint()];
    constraint->get_efforts(start_of(joint.parent), start_of(joint.child),
                            joints.data() + joint.speed_offset, motors);
  }
}

void Engine::read_reactions(std::vector<Wrench>& out) const {
  sum_rows();
  for (const auto& joint : joints_) {
    const std::size_t j = at(joint->joint());
    const Load load = joint->get_reaction(start_of(model_->joints[j].child));
    out[j] = {from_bt(load.force), from_bt(load.torque)};
  }
}

void Engine::read_contacts(std::vector<Contact>& out) const {
  for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher_->getManifoldByIndexInternal(i);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      // On Bullet's first body, along what leads to it from the second.
      const btVector3 impulse = point.m_normalWorldOnB * point.m_appliedImpulse +
                                point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                                point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
      out.push_back({manifold.getBody1()->getUserIndex(), manifold.getBody0()->getUserIndex(),
                     point.m_partId1, point.m_partId0,
                     from_bt((point.m_positionWorldOnA + point.m_positionWorldOnB) / 2),
                     from_bt(point.m_normalWorldOnB), -point.getDistance(),
                     from_bt(impulse * (1.0 / dt_))});
    }
  }
}

}  // namespace cogrsim::bullet

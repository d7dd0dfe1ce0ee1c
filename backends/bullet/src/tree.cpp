#include "tree.h"

#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

bool is_link(JointType type) {
  return type == JointType::hinge || type == JointType::slider || type == JointType::ball ||
         type == JointType::fixed;
}

btEmptyShape& no_shape() {
  static btEmptyShape shape;
  return shape;
}

class Planner {
 public:
  Planner(const SceneModel& model, const Options& options) : model_(model), options_(options) {}

  Result<std::vector<TreePlan>> plan() {
    std::vector<TreePlan> out;
    std::vector<int> group(model_.bodies.size());
    for (std::size_t b = 0; b < group.size(); ++b) group[b] = static_cast<int>(b);
    const auto find = [&](int b) {
      while (group[at(b)] != b) b = group[at(b)] = group[at(group[at(b)])];
      return b;
    };
    for (const Joint& joint : model_.joints) {
      if (counts(joint) && moves(joint.parent) && moves(joint.child)) {
        group[at(find(joint.child))] = find(joint.parent);
      }
    }
    std::vector<std::vector<int>> joints(model_.bodies.size());
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (!counts(joint)) continue;
      const int body = moves(joint.parent) ? joint.parent : joint.child;
      if (moves(body)) joints[at(find(body))].push_back(static_cast<int>(j));
    }
    for (const std::vector<int>& of_group : joints) {
      if (of_group.empty()) continue;
      TreePlan tree;
      const auto wanted = is_wanted(of_group);
      if (!wanted) return tl::unexpected<Error>(wanted.error());
      if (*wanted == Formulation::constraints) continue;
      const std::string problem = arrange(of_group, tree);
      if (problem.empty()) {
        out.push_back(std::move(tree));
      } else if (*wanted == Formulation::reduced) {
        return fail("bullet: formulation 'reduced': " + problem, place_of(model_, origin_),
                    "use formulation=\"constraints\" for this assembly");
      }
    }
    return out;
  }

 private:
  bool moves(int body) const {
    return body != kWorld && model_.bodies[at(body)].kind == BodyKind::dynamic &&
           !model_.bodies[at(body)].removed;
  }
  static bool counts(const Joint& joint) { return !joint.removed && joint.type != JointType::free; }

  /// `reduced`: an assembly asks for it; `unsaid`: where it can be.
  Result<Formulation> is_wanted(const std::vector<int>& joints) {
    Formulation said = Formulation::unsaid;
    for (const int j : joints) {
      const Joint& joint = model_.joints[at(j)];
      const Formulation own = formulation_of(model_, joint.assembly);
      if (own == Formulation::unsaid || own == said) continue;
      if (said != Formulation::unsaid) {
        return fail(
            "bullet: joint '" + joint.name +
                "': assemblies that are joined to each other ask for different formulations",
            place_of(model_, joint.origin), "give both the same");
      }
      said = own;
    }
    if (said != Formulation::unsaid) return said;
    return options_.reduced ? Formulation::unsaid : Formulation::constraints;
  }

  /// Empty, or what is in the way.
  std::string arrange(const std::vector<int>& joints, TreePlan& tree) {
    std::vector<int> held(model_.bodies.size());
    for (const int j : joints) {
      const Joint& joint = model_.joints[at(j)];
      origin_ = joint.origin;
      const std::string what = "joint '" + joint.name + "'";
      if (joint.closes_loop) return what + " closes a loop";
      if (!is_link(joint.type)) {
        return what + ": a btMultiBody has no " + std::string(to_string(joint.type)) + " joint";
      }
      for (const int end : {joint.parent, joint.child}) {
        if (end != kWorld && model_.bodies[at(end)].kind == BodyKind::kinematic) {
          return what + " is on a kinematic body";
        }
      }
      if (!moves(joint.child)) return what + " has its fixed end as child";
      if (held[at(joint.child)]++ > 0) return what + " holds a body that another one holds, too";
      tree.bodies.push_back(joint.child);
    }
    for (const int j : joints) {
      const int parent = model_.joints[at(j)].parent;
      if (!moves(parent) || held[at(parent)] > 0 || parent == tree.root) continue;
      tree.root = parent;
      tree.bodies.push_back(parent);
    }
    std::sort(tree.bodies.begin(), tree.bodies.end());
    std::vector<char> placed(model_.bodies.size());
    if (tree.root != kWorld) placed[at(tree.root)] = 1;
    while (tree.joints.size() < joints.size()) {
      for (const int j : joints) {
        const Joint& joint = model_.joints[at(j)];
        if (placed[at(joint.child)] || (moves(joint.parent) && !placed[at(joint.parent)])) continue;
        placed[at(joint.child)] = 1;
        tree.joints.push_back(j);
      }
    }
    return "";
  }

  const SceneModel& model_;
  const Options& options_;
  SourceSpan origin_;
};

}  // namespace

Result<std::vector<TreePlan>> plan_trees(const SceneModel& model, const Options& options) {
  return Planner(model, options).plan();
}

Tree::Tree(const SceneModelPtr& model, TreePlan plan, const std::vector<LinkBody>& bodies,
           void* user_pointer)
    : model_(model), plan_(std::move(plan)), link_of_(model->bodies.size(), -2) {
  links_ = static_cast<int>(plan_.joints.size());
  const bool floats = plan_.root != kWorld;
  const LinkBody* const root = floats ? &bodies[at(plan_.root)] : nullptr;
  multibody_ =
      std::make_unique<btMultiBody>(links_, floats ? model_->bodies[at(plan_.root)].mass : 0,
                                    floats ? root->inertia : btVector3(0, 0, 0), !floats, false);
  multibody_->setBaseWorldTransform(btTransform::getIdentity());
  multibody_->setLinearDamping(0);
  multibody_->setAngularDamping(0);
  multibody_->setMaxCoordinateVelocity(kUnbounded);
  multibody_->setMaxAppliedImpulse(kUnbounded);
  if (floats) link_of_[at(plan_.root)] = -1;
  bool collides = floats && root->collides;
  for (int link = 0; link < links_; ++link) {
    const Joint& joint = model_->joints[at(plan_.joints[at(link)])];
    const LinkBody& child = bodies[at(joint.child)];
    const int parent = joint.parent == kWorld ? -2 : link_of_[at(joint.parent)];
    Pose X_PF = joint.X_PF;  // in the parent's G, or the world
    if (joint.parent != kWorld) {
      const LinkBody& held = bodies[at(joint.parent)];
      X_PF = (parent < -1 ? held.X_WB : held.X_BG.inverse()) * X_PF;
    }
    const Pose X_CM = child.X_BG.inverse() * joint.X_CM;
    add_link(link, std::max(parent, -1), X_PF, X_CM, child.inertia);
    link_of_[at(joint.child)] = link;
    collides |= child.collides;
  }
  multibody_->finalizeMultiDof();
  add_laws();
  if (!collides && laws_.empty()) return;
  for (int link = -1; link < links_; ++link) {
    if (link < 0 && !floats) {
      colliders_.push_back(nullptr);
      continue;
    }
    auto made = std::make_unique<LinkCollider>(multibody_.get(), link);
    made->setCollisionShape(&no_shape());
    made->setActivationState(DISABLE_DEACTIVATION);
    made->setUserPointer(user_pointer);
    made->setCollisionFlags(made->getCollisionFlags() |
                            btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    if (link < 0) {
      multibody_->setBaseCollider(made.get());
    } else {
      multibody_->getLink(link).m_collider = made.get();
    }
    colliders_.push_back(std::move(made));
  }
}

Tree::~Tree() = default;

void Tree::add_link(int link, int parent, const Pose& X_PF, const Pose& X_CM,
                    const btVector3& inertia) {
  const Joint& joint = model_->joints[at(plan_.joints[at(link)])];
  const double mass = model_->bodies[at(joint.child)].mass;
  const btTransform F = to_bt(X_PF), M = to_bt(X_CM);
  // Turns the parent's axes to the link's.
  const btQuaternion turn = (F.getRotation() * M.getRotation().inverse()).inverse();
  const btVector3 to_pivot = F.getOrigin(), to_com = -M.getOrigin();
  const btVector3 along = M.getBasis().getColumn(2);
  const bool apart = !joint.bodies_collide;
  switch (joint.type) {
    case JointType::hinge:
      multibody_->setupRevolute(link, mass, inertia, parent, turn, along, to_pivot, to_com, apart);
      break;
    case JointType::slider:
      multibody_->setupPrismatic(link, mass, inertia, parent, turn, along, to_pivot, to_com, apart);
      break;
    case JointType::ball:
      multibody_->setupSpherical(link, mass, inertia, parent, turn, to_pivot, to_com, apart);
      break;
    default:
      multibody_->setupFixed(link, mass, inertia, parent, turn, to_pivot, to_com);
  }
}

void Tree::add_laws() {
  for (int link = 0; link < links_; ++link) {
    const int j = plan_.joints[at(link)];
    const Joint& joint = model_->joints[at(j)];
    if (joint.type != JointType::hinge && joint.type != JointType::slider) continue;
    const auto add = [&](int motor, bool has_row) {
      Law law{link, joint.axes.empty() ? JointAxis() : joint.axes.front(), motor, {}, {}, 0.0};
      if (has_row) {
        law.row = std::make_unique<btMultiBodyJointMotor>(multibody_.get(), link, 0.0, 0.0);
        law.row->finalizeMultiDof();
      }
      laws_.push_back(std::move(law));
    };
    for (const JointAxis& axis : joint.axes) {
      const bool acts = axis.stiffness > 0.0 || axis.damping > 0.0 || axis.friction > 0.0;
      if (!acts && !axis.has_limit()) continue;
      add(-1, axis.friction > 0.0);
      if (!axis.has_limit()) continue;
      auto& limit = laws_.back().limit;
      limit = std::make_unique<btMultiBodyJointLimitConstraint>(multibody_.get(), link,
                                                                std::max(axis.lower, -kUnbounded),
                                                                std::min(axis.upper, kUnbounded));
      limit->setMaxAppliedImpulse(kUnbounded);
      limit->finalizeMultiDof();
    }
    for (std::size_t m = 0; m < model_->motors.size(); ++m) {
      const Motor& motor = model_->motors[m];
      if (!motor.removed && motor.joint == j) add(static_cast<int>(m), true);
    }
  }
}

void Tree::add_to(btMultiBodyDynamicsWorld& world, const std::vector<LinkBody>& bodies) {
  world.addMultiBody(multibody_.get());
  for (const auto& made : colliders_) {
    if (!made) continue;
    const LinkBody* of = nullptr;
    for (const int b : plan_.bodies) {
      if (link_of_[at(b)] == made->m_link) {
        of = &bodies[at(b)];
        made->setUserIndex(b);
      }
    }
    if (of && of->collides) made->setCollisionShape(of->shape);
    // Places first: the broadphase takes their boxes as they are added.
    refresh();
    const btTransform X = made->m_link < 0
                              ? multibody_->getBaseWorldTransform()
                              : multibody_->getLink(made->m_link).m_cachedWorldTransform;
    made->setWorldTransform(X);
    made->setInterpolationWorldTransform(X);
    const bool collides = of && of->collides;
    world.addCollisionObject(made.get(), collides ? int{btBroadphaseProxy::DefaultFilter} : 0,
                             collides ? int{btBroadphaseProxy::AllFilter} : 0);
  }
  for (btMultiBodyConstraint* constraint : constraints()) world.addMultiBodyConstraint(constraint);
  note_places();
}

std::vector<btMultiBodyConstraint*> Tree::constraints() const {
  std::vector<btMultiBodyConstraint*> out;
  for (const Law& law : laws_) {
    if (law.row) out.push_back(law.row.get());
    if (law.limit) out.push_back(law.limit.get());
  }
  return out;
}

void Tree::note_places() {
  detected_.resize(colliders_.size());
  for (std::size_t i = 0; i < colliders_.size(); ++i) {
    if (colliders_[i]) detected_[i] = colliders_[i]->getWorldTransform();
  }
}

void Tree::remove_from(btMultiBodyDynamicsWorld& world) {
  for (btMultiBodyConstraint* constraint : constraints()) {
    world.removeMultiBodyConstraint(constraint);
  }
  for (const auto& made : colliders_) {
    if (made) world.btCollisionWorld::removeCollisionObject(made.get());
  }
  world.removeMultiBody(multibody_.get());
}

LinkCollider* Tree::collider(int body) const {
  const int link = link_of_[at(body)];
  return colliders_.empty() || link < -1 ? nullptr : colliders_[at(link + 1)].get();
}

void Tree::set_state(const WorldState& state, const btTransform& X_WR, const btVector3& velocity,
                     const btVector3& spin) {
  if (plan_.root != kWorld) {
    multibody_->setBaseWorldTransform(X_WR);
    multibody_->setBaseVel(velocity);
    multibody_->setBaseOmega(spin);
  }
  for (int link = 0; link < links_; ++link) {
    const Joint& joint = model_->joints[at(plan_.joints[at(link)])];
    const double* const q = state.joint_positions.data() + joint.position_offset;
    const double* const u = state.joint_velocities.data() + joint.speed_offset;
    if (joint.type == JointType::ball) {
      // Bullet keeps the inverse of the turn from where the joint began, in the child's axes; so
      // is its velocity.
      const btQuaternion M = multibody_->getLink(link).m_zeroRotParentToThis *
                             to_bt(joint.X_PF.q);  // F to the child's G
      const btQuaternion turn = M * to_bt(Quat(q[0], q[1], q[2], q[3])).inverse() * M.inverse();
      const double position[] = {turn.x(), turn.y(), turn.z(), -turn.w()};
      const btVector3 rate = quatRotate(turn * M, btVector3(u[0], u[1], u[2]));
      const double rates[] = {rate.x(), rate.y(), rate.z()};
      multibody_->setJointPosMultiDof(link, position);
      multibody_->setJointVelMultiDof(link, rates);
      continue;
    }
    if (joint.type == JointType::fixed) continue;
    multibody_->setJointPos(link, *q);
    multibody_->setJointVel(link, *u);
  }
  fresh_ = false;
  multibody_->updateCollisionObjectWorldTransforms(turns_, origins_);
}

void Tree::refresh() const {
  if (fresh_) return;
  multibody_->forwardKinematics(turns_, origins_);
  spins_.resize(links_ + 1);
  velocities_.resize(links_ + 1);
  multibody_->compTreeLinkVelocities(&spins_[0], &velocities_[0]);
  fresh_ = true;
}

btTransform Tree::place(int body) const {
  refresh();
  const int link = link_of_[at(body)];
  return link < 0 ? multibody_->getBaseWorldTransform()
                  : multibody_->getLink(link).m_cachedWorldTransform;
}

void Tree::get_velocity(int body, btVector3& velocity, btVector3& spin) const {
  const btMatrix3x3 R = place(body).getBasis();
  const int link = link_of_[at(body)];
  velocity = R * velocities_[link + 1];
  spin = R * spins_[link + 1];
}

void Tree::apply(double dt, const std::vector<Drive>& drives) {
  note_places();
  for (Law& law : laws_) {
    double velocity = 0.0, bound = law.law.friction;
    law.effort = 0.0;
    if (law.limit) {
      law.limit->internalSetAppliedImpulse(0, 0.0);
      law.limit->internalSetAppliedImpulse(1, 0.0);
    }
    if (law.motor >= 0 && drives[at(law.motor)].is_speed_source()) {
      velocity = drives[at(law.motor)].velocity;
      bound = drives[at(law.motor)].max_effort;
    } else {
      if (law.motor >= 0) bound = 0.0;
      const AxisLaw axis =
          law.motor >= 0 ? AxisLaw::of(drives[at(law.motor)]) : AxisLaw::of(law.law);
      law.effort =
          axis.effort(multibody_->getJointPos(law.link), multibody_->getJointVel(law.link));
      multibody_->addJointTorque(law.link, law.effort);
    }
    if (!law.row) continue;
    law.row->internalSetAppliedImpulse(0, 0.0);
    law.row->setVelocityTarget(velocity);
    law.row->setMaxAppliedImpulse(std::min(bound, kUnbounded) * dt);
  }
  fresh_ = false;
}

void Tree::get_efforts(double dt, std::vector<double>& joints, std::vector<double>& motors) const {
  for (const Law& law : laws_) {
    double effort = law.effort;
    if (law.row) effort += law.row->getAppliedImpulse(0) / dt;
    if (law.motor >= 0) motors[at(law.motor)] = effort;
    if (law.limit) {
      effort += (law.limit->getAppliedImpulse(0) - law.limit->getAppliedImpulse(1)) / dt;
    }
    joints[at(model_->joints[at(plan_.joints[at(law.link)])].speed_offset)] += effort;
  }
}

bool Tree::is_sound() const {
  const double* const u = multibody_->getVelocityVector();
  for (int i = 0; i < 6 + multibody_->getNumDofs(); ++i) {
    if (!(std::abs(u[i]) < 1e6)) return false;
  }
  for (int link = 0; link < links_; ++link) {
    if (multibody_->getLink(link).m_dofCount != 1) continue;
    if (!std::isfinite(multibody_->getJointPos(link))) return false;
  }
  return multibody_->getBasePos().length2() < 1e12;
}

double Tree::fastest() const {
  const double* const u = multibody_->getVelocityVector();
  double sum = 0.0;
  for (int i = 0; i < 6 + multibody_->getNumDofs(); ++i) {
    if (i < 3 || i > 5) sum += std::abs(u[i]);
  }
  return sum;
}

void Tree::save(std::vector<double>& out) const {
  const btMultiBody& body = *multibody_;
  const btVector3& p = body.getBasePos();
  const btQuaternion& q = body.getWorldToBaseRot();
  out.assign({p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
  for (int link = 0; link < links_; ++link) {
    const double* const position = body.getJointPosMultiDof(link);
    out.insert(out.end(), position, position + body.getLink(link).m_posVarCount);
  }
  const double* const u = body.getVelocityVector();
  out.insert(out.end(), u, u + 6 + body.getNumDofs());
}

void Tree::restore(const std::vector<double>& saved) {
  btMultiBody& body = *multibody_;
  const double* from = saved.data();
  body.setBasePos(btVector3(from[0], from[1], from[2]));
  body.setWorldToBaseRot(btQuaternion(from[3], from[4], from[5], from[6]));
  from += 7;
  for (int link = 0; link < links_; ++link) {
    body.setJointPosMultiDof(link, from);
    from += body.getLink(link).m_posVarCount;
  }
  body.setBaseOmega(btVector3(from[0], from[1], from[2]));
  body.setBaseVel(btVector3(from[3], from[4], from[5]));
  from += 6;
  for (int link = 0; link < links_; ++link) {
    body.setJointVelMultiDof(link, from);
    from += body.getLink(link).m_dofCount;
  }
  fresh_ = false;
  body.updateCollisionObjectWorldTransforms(turns_, origins_);
}

}  // namespace cogrsim::bullet

#include "trees.h"

#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/ScrewJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <utility>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/body_trees.h"

namespace cogrsim::dart_engine {

namespace {

using namespace dart::dynamics;
using Isometry = Eigen::Isometry3d;

Inertia weightless() {
  Inertia out;
  out.setMass(0.0);
  out.setMoment(Eigen::Matrix3d::Zero());
  return out;
}

// The joint between two frames, and the body beyond it.
template <class Type>
std::pair<dart::dynamics::Joint*, BodyNode*> make(const SkeletonPtr& skeleton, BodyNode* parent,
                                                  typename Type::Properties properties,
                                                  const std::string& name, const Inertia& inertia) {
  properties.mName = name;
  const auto made = skeleton->createJointAndBodyNodePair<Type>(
      parent, properties, BodyNode::Properties(BodyNode::AspectProperties(name, inertia)));
  return {made.first, made.second};
}

std::pair<dart::dynamics::Joint*, BodyNode*> make(const cogrsim::Joint& joint, int speed,
                                                  bool reversed, const SkeletonPtr& skeleton,
                                                  BodyNode* parent, const std::string& name,
                                                  const Inertia& inertia) {
  const Vec3 axis = (reversed ? -1.0 : 1.0) * axis_direction(joint.type, speed);
  if (joint.type == JointType::screw) {
    ScrewJoint::Properties it;
    it.mAxis = axis;
    it.mPitch = joint.pitch;
    return make<ScrewJoint>(skeleton, parent, it, name, inertia);
  }
  if (axis_turns(joint.type, speed)) {
    RevoluteJoint::Properties it;
    it.mAxis = axis;
    return make<RevoluteJoint>(skeleton, parent, it, name, inertia);
  }
  PrismaticJoint::Properties it;
  it.mAxis = axis;
  return make<PrismaticJoint>(skeleton, parent, it, name, inertia);
}

}  // namespace

Trees::Trees(const SceneModel& model, const std::vector<Pose>& poses)
    : model_(&model),
      nodes_(model.bodies.size()),
      body_links_(model.bodies.size(), -1),
      joint_links_(model.joints.size(), -1),
      parts_(model.bodies.size(), 1) {
  const BodyTrees trees = grow_body_trees(model, [](std::size_t) { return false; });
  const auto is_dynamic = [&](int b) {
    return b != kWorld && model.bodies[b].kind == BodyKind::dynamic;
  };
  std::vector<int> loops;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const cogrsim::Joint& joint = model.joints[j];
    const bool child = is_dynamic(joint.child);
    if (joint.removed || joint.type == JointType::free || (!child && !is_dynamic(joint.parent)))
      continue;
    const auto holds = [&](int b) { return b != kWorld && trees.joint[b] == static_cast<int>(j); };
    if (holds(joint.parent) || holds(joint.child)) continue;
    loops.push_back(static_cast<int>(j));
    ++parts_[child ? joint.child : joint.parent];
  }
  const auto grow = [&](const auto& self, int from) -> void {
    for (const int b : trees.children[from]) {
      Link link;
      link.body = b;
      link.joint = trees.joint[b];
      add_link(link, from, poses);
      self(self, b);
    }
  };
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    const int index = static_cast<int>(b);
    if (body.removed) continue;
    if (body.kind == BodyKind::static_body) {
      add_static(index, poses[b]);
    } else if (trees.joint[b] < 0) {
      add_free(index);
    } else if (trees.parent[b] == kWorld) {
      Link link;
      link.body = index;
      link.joint = trees.joint[b];
      add_link(link, kWorld, poses);
    } else {
      continue;
    }
    grow(grow, index);
  }
  for (const int j : loops) close_loop(j, poses);
}

SkeletonPtr Trees::add_skeleton(const std::string& name) {
  return skeletons_.emplace_back(Skeleton::create(name));
}

Inertia Trees::inertia(int body) const {
  const Body& it = model_->bodies[body];
  const double share = 1.0 / parts_[body];
  Inertia out;
  out.setMass(share * it.mass);
  out.setLocalCOM(it.com);
  out.setMoment(share * it.inertia);
  return out;
}

void Trees::add_static(int body, const Pose& pose) {
  const std::string& name = model_->bodies[body].name;
  const SkeletonPtr skeleton = add_skeleton(name);
  WeldJoint::Properties it;
  it.mT_ParentBodyToJoint = to_dart(pose);
  nodes_[body] = make<WeldJoint>(skeleton, nullptr, it, name, Inertia()).second;
  skeleton->setMobile(false);
}

void Trees::add_free(int body) {
  const Body& it = model_->bodies[body];
  const SkeletonPtr skeleton = add_skeleton(it.name);
  Link link;
  link.body = body;
  link.kinematic = it.kind == BodyKind::kinematic;
  FreeJoint::Properties free;
  // At the centre of mass, whose motion DART then integrates.
  if (!link.kinematic) free.mT_ChildBodyToJoint.translation() = it.com;
  if (link.kinematic) free.mActuatorType = dart::dynamics::Joint::ACCELERATION;
  const auto made =
      make<FreeJoint>(skeleton, nullptr, free, it.name, link.kinematic ? Inertia() : inertia(body));
  link.joints = {made.first};
  link.node = nodes_[body] = made.second;
  body_links_[body] = static_cast<int>(links_.size());
  links_.push_back(std::move(link));
}

void Trees::add_link(Link link, int inboard, const std::vector<Pose>& poses) {
  const cogrsim::Joint& joint = joint_of(link);
  // A part of a body that holds on to the body itself is not where the tree comes from.
  link.reversed = link.slave ? joint.child != link.body : joint.parent == link.body;
  Isometry inner = to_dart(link.reversed ? joint.X_CM : joint.X_PF);
  const Isometry outer = to_dart(link.reversed ? joint.X_PF : joint.X_CM);
  BodyNode* parent = inboard == kWorld ? nullptr : nodes_[inboard];
  std::string name = model_->bodies[link.body].name;
  if (link.slave) name += " at " + joint.name;
  SkeletonPtr skeleton;
  if (!parent || !parent->getSkeleton()->isMobile()) {
    if (parent) inner = to_dart(poses[inboard]) * inner;
    parent = nullptr;
    skeleton = add_skeleton(name);
  } else {
    skeleton = parent->getSkeleton();
  }
  const bool ball = joint.type == JointType::ball;
  const auto count = ball ? 0 : static_cast<std::size_t>(speed_count(joint.type));
  link.joints.resize(std::max(count, std::size_t(1)));
  const Inertia own = inertia(link.body);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t axis = link.reversed ? count - 1 - k : k;
    const bool last = k + 1 == count;
    const auto made = make(joint, static_cast<int>(axis), link.reversed, skeleton, parent,
                           last ? name : name + " " + std::to_string(k), last ? own : weightless());
    made.first->setTransformFromParentBodyNode(k == 0 ? inner : Isometry::Identity());
    made.first->setTransformFromChildBodyNode(last ? outer : Isometry::Identity());
    link.joints[axis] = made.first;
    parent = link.node = made.second;
  }
  if (ball) {
    std::tie(link.joints[0], link.node) =
        make<BallJoint>(skeleton, parent, BallJoint::Properties(), name, own);
  } else if (count == 0) {
    std::tie(link.joints[0], link.node) =
        make<WeldJoint>(skeleton, parent, WeldJoint::Properties(), name, own);
  }
  if (count == 0) {
    link.joints[0]->setTransformFromParentBodyNode(inner);
    link.joints[0]->setTransformFromChildBodyNode(outer);
  }
  const int index = static_cast<int>(links_.size());
  if (!link.slave) {
    nodes_[link.body] = link.node;
    body_links_[link.body] = index;
  }
  joint_links_[link.joint] = index;
  links_.push_back(std::move(link));
}

void Trees::close_loop(int j, const std::vector<Pose>& poses) {
  const cogrsim::Joint& joint = model_->joints[j];
  const bool child = joint.child != kWorld && model_->bodies[joint.child].kind == BodyKind::dynamic;
  Link link;
  link.body = child ? joint.child : joint.parent;
  link.joint = j;
  link.slave = true;
  add_link(link, child ? joint.parent : joint.child, poses);
  BodyNode *part = links_.back().node, *whole = nodes_[link.body];
  // Where fixed joints hold both together already there is nothing to weld.
  const auto held_by = [](BodyNode* node) {
    while (node && node->getParentJoint()->getNumDofs() == 0) node = node->getParentBodyNode();
    return node;
  };
  if (held_by(part) == held_by(whole)) return;
  const auto weld = std::make_shared<LoopWeld>(part, whole);
  weld->setRelativeTransform(Isometry::Identity());
  weld->joint = j;
  welds_.push_back(weld);
}

void Trees::set_free(const Link& link, const Pose& X_WB, const Twist& V_WB) const {
  const Vec3 at = link.joints[0]->getTransformFromChildBodyNode().translation();
  const Vec3 r = X_WB.q * at;
  const Pose X{X_WB.p + r, X_WB.q};
  Eigen::Vector6d V;
  V << X.q.conjugate() * V_WB.angular, X.q.conjugate() * V_WB.at(r);
  link.joints[0]->setPositions(FreeJoint::convertToPositions(to_dart(X)));
  link.joints[0]->setVelocities(V);
}

void Trees::set_joint(const Link& link, const double* q, const double* u) const {
  const JointType type = joint_of(link).type;
  if (type == JointType::ball) {
    const Quat R(q[0], q[1], q[2], q[3]);
    const Vec3 w(u[0], u[1], u[2]);  // of M in F, axes of F
    const Mat3 turn = Quat(link.reversed ? Quat(R.conjugate()) : R).normalized().toRotationMatrix();
    link.joints[0]->setPositions(BallJoint::convertToPositions(turn));
    link.joints[0]->setVelocities(link.reversed ? Vec3(-w) : Vec3(R.conjugate() * w));
    return;
  }
  for (int i = 0; i < speed_count(type); ++i) {
    link.joints[i]->setPosition(0, q[i]);
    link.joints[i]->setVelocity(0, u[i]);
  }
}

void Trees::get_joint(const Link& link, double* q, double* u) const {
  const JointType type = joint_of(link).type;
  if (type == JointType::ball) {
    const Mat3 turn = BallJoint::convertToRotation(link.joints[0]->getPositions());
    const Vec3 w = link.joints[0]->getVelocities();
    Quat R(turn);
    if (link.reversed) R = R.conjugate();
    // The sign that is nearest to what was.
    const double sign = R.coeffs().dot(Quat(q[0], q[1], q[2], q[3]).coeffs()) < 0.0 ? -1.0 : 1.0;
    const double values[] = {R.w(), R.x(), R.y(), R.z()};
    for (int i = 0; i < 4; ++i) q[i] = sign * values[i];
    const Vec3 in_F = link.reversed ? Vec3(-w) : Vec3(R * w);
    for (int i = 0; i < 3; ++i) u[i] = in_F[i];
    return;
  }
  for (int i = 0; i < speed_count(type); ++i) {
    q[i] = link.joints[i]->getPosition(0);
    u[i] = link.joints[i]->getVelocity(0);
  }
}

void Trees::set_all(const WorldState& state) const {
  for (const Link& link : links_) {
    const auto b = static_cast<std::size_t>(link.body);
    if (link.joint < 0) {
      set_free(link, state.poses[b], state.twists[b]);
      continue;
    }
    const cogrsim::Joint& joint = joint_of(link);
    set_joint(link, state.joint_positions.data() + joint.position_offset,
              state.joint_velocities.data() + joint.speed_offset);
  }
}

Motion Trees::motion(const Link& link) {
  Motion out;
  for (const dart::dynamics::Joint* joint : link.joints) {
    out.push_back(joint->getPositions());
    out.push_back(joint->getVelocities());
  }
  return out;
}

void Trees::set_motion(const Link& link, const Motion& motion) {
  for (std::size_t k = 0; k < link.joints.size(); ++k) {
    link.joints[k]->setPositions(motion[2 * k]);
    link.joints[k]->setVelocities(motion[2 * k + 1]);
  }
}

void Trees::take_impact(const WorldState& seen, const std::vector<int>& bodies) const {
  for (const SkeletonPtr& skeleton : skeletons_) {
    bool touched = false;
    for (const int b : bodies)
      touched = touched || (b != kWorld && node(b) && node(b)->getSkeleton() == skeleton);
    if (!touched || !skeleton->isMobile() || skeleton->getNumDofs() == 0) continue;
    Eigen::VectorXd momentum = Eigen::VectorXd::Zero(Eigen::Index(skeleton->getNumDofs()));
    for (const Link& link : links_) {
      if (link.node->getSkeleton() != skeleton) continue;
      const Twist& V = seen.twists[link.body];
      const Mat3 R = link.node->getTransform().linear().transpose();
      Eigen::Vector6d in_body;
      in_body << R * V.angular, R * V.linear;
      momentum +=
          skeleton->getJacobian(link.node).transpose() * (link.node->getSpatialInertia() * in_body);
    }
    const bool moved_by_hand = skeleton->getJoint(0)->isKinematic();
    if (moved_by_hand) continue;  // its own velocity is prescribed: the next step adjusts the rest
    skeleton->setVelocities(skeleton->getMassMatrix().ldlt().solve(momentum));
  }
}

}  // namespace cogrsim::dart_engine

#include "multibody_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

/// A joint is made of turns and shifts about and along axes of its frame F, from F to M.
struct Factor {
  bool turns;
  btVector3 axis;
  int speed;  ///< of the scene's joint
};

std::vector<Factor> factors_of(JointType type) {
  const btVector3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  switch (type) {
    case JointType::hinge:
      return {{true, z, 0}};
    case JointType::slider:
      return {{false, z, 0}};
    case JointType::cylindrical:
      return {{true, z, 0}, {false, z, 1}};
    case JointType::universal:
      return {{true, x, 0}, {true, y, 1}};
    case JointType::planar:
      return {{false, x, 0}, {false, y, 1}, {true, z, 2}};
    default:
      return {};
  }
}

bool dynamic(const SceneModel& model, int body) {
  return body != kWorld && model.bodies[static_cast<std::size_t>(body)].kind == BodyKind::dynamic;
}

/// The body's frame in its principal frame.
btTransform principal_inverse(const std::vector<RigidBody>& bodies, int body) {
  if (body == kWorld) return btTransform::getIdentity();
  const RigidBody& b = bodies[static_cast<std::size_t>(body)];
  // What does not move is written in world axes.
  if (!b.dynamic()) return to_bt(b.anchor());
  return to_bt(b.X_BP().inverse());
}

btQuaternion unit(const double* q) { return {q[1], q[2], q[3], q[0]}; }

/// `q` after turning by the rotation vector `r` of the axes it leads to.
btQuaternion turned(const btQuaternion& q, const btVector3& r) {
  const double angle = r.length();
  if (angle == 0.0) return q;
  btQuaternion out = btQuaternion(r / angle, angle) * q;
  out.normalize();
  return out;
}

}  // namespace

std::string MultibodyTree::obstacle(const SceneModel& model, const std::vector<int>& joints,
                                    int& culprit) {
  // Sets of bodies connected so far; all that stands still is one.
  std::vector<int> set(model.bodies.size() + 1);
  for (std::size_t b = 0; b < set.size(); ++b) set[b] = static_cast<int>(b);
  const auto find = [&](int body) {
    int s = dynamic(model, body) ? body + 1 : 0;
    while (set[static_cast<std::size_t>(s)] != s) s = set[static_cast<std::size_t>(s)];
    return s;
  };
  for (const int j : joints) {
    culprit = j;
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    if (joint.type == JointType::screw) return "is a screw, which a btMultiBody does not have";
    for (const int body : {joint.parent, joint.child}) {
      if (body == kWorld) continue;
      if (model.bodies[static_cast<std::size_t>(body)].kind == BodyKind::kinematic) {
        return "hangs on a kinematic body, which a btMultiBody does not";
      }
    }
    const int a = find(joint.parent), b = find(joint.child);
    if (a == b) return "closes a loop";
    set[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  culprit = -1;
  return {};
}

MultibodyTree::MultibodyTree(const SceneModel& model, const std::vector<int>& joints,
                             std::vector<RigidBody>& bodies) {
  // Outwards from what stands still, else from the first joint's parent.
  std::vector<std::vector<int>> at_body(model.bodies.size());
  int root = -1;
  for (const int j : joints) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    for (const int body : {joint.parent, joint.child}) {
      if (dynamic(model, body)) {
        at_body[static_cast<std::size_t>(body)].push_back(j);
      } else {
        root = j;
      }
    }
  }
  std::vector<char> used(model.joints.size());
  std::vector<int> queue;  // bodies
  int link_count = 0;
  const auto go = [&](int j, bool reversed, int from) {
    used[static_cast<std::size_t>(j)] = 1;
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    const int body = reversed ? joint.parent : joint.child;
    TreeJoint t;
    t.joint = j;
    t.type = joint.type;
    t.count = cogrsim::speed_count(joint.type);
    t.reversed = reversed;
    t.from = from;
    const btTransform F = principal_inverse(bodies, joint.parent) * to_bt(joint.X_PF);
    const btTransform M = principal_inverse(bodies, joint.child) * to_bt(joint.X_CM);
    t.X_from = reversed ? M : F;
    t.X_to = reversed ? F : M;
    link_count += std::max(1, static_cast<int>(factors_of(joint.type).size()));
    t.to = link_count - 1;
    joints_.push_back(t);
    position_offsets_.push_back(joint.position_offset);
    bodies_.push_back(body);
    body_links_.push_back(t.to);
    queue.push_back(body);
  };
  if (root >= 0) {
    go(root, dynamic(model, model.joints[static_cast<std::size_t>(root)].parent), -1);
  } else {
    base_ = model.joints[static_cast<std::size_t>(joints.front())].parent;
    bodies_.push_back(base_);
    body_links_.push_back(-1);
    queue.push_back(base_);
  }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const int body = queue[k], link = body_links_[k];
    for (const int j : at_body[static_cast<std::size_t>(body)]) {
      if (used[static_cast<std::size_t>(j)]) continue;
      go(j, model.joints[static_cast<std::size_t>(j)].child == body, link);
    }
  }

  const RigidBody* base = base_ >= 0 ? &bodies[static_cast<std::size_t>(base_)] : nullptr;
  multibody_ = std::make_unique<btMultiBody>(link_count, base != nullptr ? base->mass() : 0.0,
                                             base != nullptr ? base->moments() : btVector3(0, 0, 0),
                                             base == nullptr, false);
  int link = 0;
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const int carried = bodies_[k + (floating() ? 1 : 0)];
    add_joint(joints_[k], bodies[static_cast<std::size_t>(carried)], link);
  }
  multibody_->finalizeMultiDof();
  multibody_->setLinearDamping(0.0);
  multibody_->setAngularDamping(0.0);
  multibody_->setUseGyroTerm(true);
  multibody_->setMaxCoordinateVelocity(std::numeric_limits<double>::max());
  multibody_->setCanSleep(false);
  multibody_->clearForcesAndTorques();
  const btVector3 gravity = to_bt(model.physics.gravity);
  masses_.push_back(base != nullptr ? base->mass() : 0.0);
  moments_.push_back(base != nullptr ? base->moments() : btVector3(0, 0, 0));
  multibody_->addBaseForce(gravity * masses_.front());
  for (int i = 0; i < link_count; ++i) {
    const btMultibodyLink& l = multibody_->getLink(i);
    multibody_->addLinkForce(i, gravity * l.m_mass);
    masses_.push_back(l.m_mass);
    moments_.push_back(l.m_inertiaLocal);
    parents_.push_back(l.m_parent);
    first_dof_.push_back(static_cast<int>(dofs_.size()));
    for (int d = 0; d < l.m_dofCount; ++d) {
      dofs_.push_back({});
      dofs_.back().turns = l.m_jointType != btMultibodyLink::ePrismatic;
    }
  }
  first_dof_.push_back(static_cast<int>(dofs_.size()));
  frames_.resize(static_cast<std::size_t>(link_count) + 1, btTransform::getIdentity());
  for (TreeJoint& joint : joints_) {
    const std::vector<Factor> factors = factors_of(joint.type);
    const int count = static_cast<int>(factors.size());
    const int first_link = joint.to - std::max(count, 1) + 1;
    joint.first = 6 + first_dof_[static_cast<std::size_t>(first_link)];
    for (int k = 0; k < count; ++k) {
      joint.order[factors[static_cast<std::size_t>(k)].speed] =
          joint.first + (joint.reversed ? count - 1 - k : k);
    }
    if (joint.type == JointType::ball) {
      for (int k = 0; k < 3; ++k) joint.order[k] = joint.first + k;
    }
  }
}

void MultibodyTree::add_joint(const TreeJoint& joint, const RigidBody& body, int& link) {
  std::vector<Factor> factors = factors_of(joint.type);
  if (joint.reversed) std::reverse(factors.begin(), factors.end());
  const double sign = joint.reversed ? -1.0 : 1.0;
  const btTransform identity = btTransform::getIdentity();
  const std::size_t count = std::max<std::size_t>(1, factors.size());
  for (std::size_t k = 0; k < count; ++k, ++link) {
    const bool last = k + 1 == count;
    const int parent = k == 0 ? joint.from : link - 1;
    const btTransform& G = k == 0 ? joint.X_from : identity;
    const btTransform& K = last ? joint.X_to : identity;
    const double mass = last ? body.mass() : 0.0;
    const btVector3 moments = last ? body.moments() : btVector3(0, 0, 0);
    const btQuaternion to_this = K.getRotation() * G.getRotation().inverse();
    const btVector3 pivot = G.getOrigin(), com = -K.getOrigin();
    if (joint.type == JointType::fixed) {
      multibody_->setupFixed(link, mass, moments, parent, to_this, pivot, com);
    } else if (joint.type == JointType::ball) {
      multibody_->setupSpherical(link, mass, moments, parent, to_this, pivot, com, true);
    } else {
      const btVector3 axis = K.getBasis() * (factors[k].axis * sign);
      if (factors[k].turns) {
        multibody_->setupRevolute(link, mass, moments, parent, to_this, axis, pivot, com, true);
      } else {
        multibody_->setupPrismatic(link, mass, moments, parent, to_this, axis, pivot, com, true);
      }
    }
  }
}

void MultibodyTree::set_positions(const std::vector<double>& q, const btTransform& X_WBase) {
  if (floating() && !(placed_ && frames_[0] == X_WBase)) {
    placed_ = false;
    multibody_->setBaseWorldTransform(X_WBase);
    frames_[0] = X_WBase;
  }
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const TreeJoint& joint = joints_[k];
    const double* own = q.data() + position_offsets_[k];
    if (joint.type == JointType::fixed) continue;
    if (joint.type == JointType::ball) {
      const btQuaternion K = joint.X_to.getRotation();
      const btQuaternion turn = joint.reversed ? unit(own).inverse() : unit(own);
      const btQuaternion in_link = K * turn * K.inverse();
      const double values[4] = {in_link.x(), in_link.y(), in_link.z(), in_link.w()};
      if (!std::equal(values, values + 4, multibody_->getJointPosMultiDof(joint.to))) {
        multibody_->setJointPosMultiDof(joint.to, values);
        placed_ = false;
      }
      continue;
    }
    for (int i = 0; i < joint.count; ++i) {
      // One speed per link here.
      const int first_link = joint.to - (joint.count - 1);
      const int link = first_link + joint.speed(i) - joint.first;
      if (multibody_->getJointPos(link) == own[i]) continue;
      multibody_->setJointPos(link, own[i]);
      placed_ = false;
    }
  }
  // A step begins where the last one ended: mostly nothing has moved in between.
  if (!placed_) update_frames();
  placed_ = true;
}

void MultibodyTree::update_frames() {
  const int n = multibody_->getNumLinks();
  for (int i = 0; i < n; ++i) {
    const btMultibodyLink& link = multibody_->getLink(i);
    const btTransform& parent = frames_[static_cast<std::size_t>(link.m_parent + 1)];
    btTransform& X = frames_[static_cast<std::size_t>(i + 1)];
    X.getBasis() = parent.getBasis() * btMatrix3x3(link.m_cachedRotParentToThis.inverse());
    X.setOrigin(parent.getOrigin() + X.getBasis() * link.m_cachedRVector);
    const int first = first_dof_[static_cast<std::size_t>(i)];
    for (int d = 0; d < link.m_dofCount; ++d) {
      Dof& dof = dofs_[static_cast<std::size_t>(first + d)];
      dof.ang = X.getBasis() * link.getAxisTop(d);
      dof.lin = X.getBasis() * link.getAxisBottom(d);
    }
  }
}

btTransform MultibodyTree::X_WM(const TreeJoint& joint) const {
  return joint.reversed ? frame(joint.from) * joint.X_from : frame(joint.to) * joint.X_to;
}
btTransform MultibodyTree::X_WF(const TreeJoint& joint) const {
  return joint.reversed ? frame(joint.to) * joint.X_to : frame(joint.from) * joint.X_from;
}
btVector3 MultibodyTree::origin(const TreeJoint& joint) const {
  return joint.reversed ? frame(joint.from) * joint.X_from.getOrigin()
                        : frame(joint.to) * joint.X_to.getOrigin();
}

void MultibodyTree::velocities(const std::vector<double>& u, std::vector<LinkVector>& out) const {
  out.resize(frames_.size());
  out[0] = {{u[3], u[4], u[5]}, {u[0], u[1], u[2]}};
  for (std::size_t i = 0; i < parents_.size(); ++i) {
    const auto parent = static_cast<std::size_t>(parents_[i] + 1);
    LinkVector v = out[parent];
    v.lin += v.ang.cross(frames_[i + 1].getOrigin() - frames_[parent].getOrigin());
    for (int d = first_dof_[i]; d < first_dof_[i + 1]; ++d) {
      const Dof& dof = dofs_[static_cast<std::size_t>(d)];
      const double speed = u[static_cast<std::size_t>(d) + 6];
      v.lin += dof.lin * speed;
      v.ang += dof.ang * speed;
    }
    out[i + 1] = v;
  }
}

void MultibodyTree::speeds(const std::vector<LinkVector>& links, std::vector<double>& out) const {
  out.assign(static_cast<std::size_t>(speed_count()), 0.0);
  if (floating()) {
    for (int k = 0; k < 3; ++k) {
      out[static_cast<std::size_t>(k)] = links[0].ang[k];
      out[static_cast<std::size_t>(k) + 3] = links[0].lin[k];
    }
  }
  for (const TreeJoint& joint : joints_) {
    const int n = joint.count;
    if (n == 0) continue;
    const LinkVector& a = links[static_cast<std::size_t>(joint.from + 1)];
    const LinkVector& b = links[static_cast<std::size_t>(joint.to + 1)];
    const btVector3 w = b.ang - a.ang;
    const btVector3 at = origin(joint);
    const btVector3 v = b.lin + b.ang.cross(at - frame(joint.to).getOrigin()) -
                        (a.lin + a.ang.cross(at - frame(joint.from).getOrigin()));
    for (int k = 0; k < n; ++k) {
      const auto s = static_cast<std::size_t>(joint.first + k);
      const Dof& dof = dofs_[s - 6];
      out[s] = dof.turns ? dof.ang.dot(w) : dof.lin.dot(v);
    }
  }
}

void MultibodyTree::project(std::vector<LinkVector>& forces, std::vector<double>& out) const {
  out.assign(static_cast<std::size_t>(speed_count()), 0.0);
  for (std::size_t i = parents_.size(); i-- > 0;) {
    const LinkVector& f = forces[i + 1];
    for (int d = first_dof_[i]; d < first_dof_[i + 1]; ++d) {
      const Dof& dof = dofs_[static_cast<std::size_t>(d)];
      out[static_cast<std::size_t>(d) + 6] = dof.lin.dot(f.lin) + dof.ang.dot(f.ang);
    }
    const auto parent = static_cast<std::size_t>(parents_[i] + 1);
    LinkVector& below = forces[parent];
    below.lin += f.lin;
    below.ang += f.ang + (frames_[i + 1].getOrigin() - frames_[parent].getOrigin()).cross(f.lin);
  }
  if (!floating()) return;
  for (int k = 0; k < 3; ++k) {
    out[static_cast<std::size_t>(k)] = forces[0].ang[k];
    out[static_cast<std::size_t>(k) + 3] = forces[0].lin[k];
  }
}

void MultibodyTree::accelerations(const std::vector<double>& u, std::vector<double>& out) {
  multibody_->setBaseOmega({u[0], u[1], u[2]});
  multibody_->setBaseVel({u[3], u[4], u[5]});
  for (std::size_t i = 0; i < parents_.size(); ++i) {
    const int first = first_dof_[i];
    if (first < first_dof_[i + 1]) {
      multibody_->setJointVelMultiDof(static_cast<int>(i), u.data() + first + 6);
    }
  }
  // A step of no length leaves the accelerations in the second part of the scratch space.
  multibody_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0.0, scratch_r_, scratch_v_,
                                                                   scratch_m_, false, false, false);
  const btScalar* found = &scratch_r_[multibody_->getNumDofs()];
  out.assign(found, found + speed_count());
}

void MultibodyTree::bias(const std::vector<double>& u, std::vector<double>& out) {
  velocities(u, velocities_);
  rates_.assign(frames_.size(), {});
  forces_.assign(frames_.size(), {});
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const LinkVector& v = velocities_[i];
    LinkVector& rate = rates_[i];
    if (i > 0) {
      const auto parent = static_cast<std::size_t>(parents_[i - 1] + 1);
      const LinkVector& below = velocities_[parent];
      const btVector3 arm = frames_[i].getOrigin() - frames_[parent].getOrigin();
      const btVector3 turning = v.ang - below.ang;
      // The part of the relative velocity that turns with the link: the joint's.
      const btVector3 joint = v.lin - below.lin - below.ang.cross(arm);
      rate.ang = rates_[parent].ang + below.ang.cross(turning);
      rate.lin = rates_[parent].lin + rates_[parent].ang.cross(arm) +
                 below.ang.cross(v.lin - below.lin) + v.ang.cross(joint);
    }
    if (masses_[i] == 0.0) continue;
    const btMatrix3x3& R = frames_[i].getBasis();
    const btVector3 momentum = R * ((v.ang * R) * moments_[i]);
    forces_[i].lin = rate.lin * masses_[i];
    forces_[i].ang = R * ((rate.ang * R) * moments_[i]) + v.ang.cross(momentum);
  }
  project(forces_, out);
}

void MultibodyTree::respond(const std::vector<double>& impulses, std::vector<double>& out) {
  out.resize(static_cast<std::size_t>(speed_count()));
  multibody_->calcAccelerationDeltasMultiDof(impulses.data(), out.data(), scratch_r_, scratch_v_);
  if (!floating()) std::fill(out.begin(), out.begin() + 6, 0.0);
}

void MultibodyTree::advance(const std::vector<double>& u, double dt, std::vector<double>& q,
                            btTransform& X_WBase) const {
  if (floating()) {
    X_WBase.setOrigin(X_WBase.getOrigin() + btVector3(u[3], u[4], u[5]) * dt);
    X_WBase.setRotation(turned(X_WBase.getRotation(), btVector3(u[0], u[1], u[2]) * dt));
  }
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const TreeJoint& joint = joints_[k];
    double* own = q.data() + position_offsets_[k];
    if (joint.type == JointType::ball) {
      const auto s = static_cast<std::size_t>(joint.first);
      // From the link's axes to F's; of M in F.
      const btTransform& X = frame(joint.to);
      const btVector3 world = X.getBasis() * btVector3(u[s], u[s + 1], u[s + 2]);
      const btVector3 w = world * X_WF(joint).getBasis();
      const btQuaternion next = turned(unit(own), w * (joint.reversed ? -dt : dt));
      own[0] = next.w();
      own[1] = next.x();
      own[2] = next.y();
      own[3] = next.z();
      continue;
    }
    for (int i = 0; i < joint.count; ++i) {
      own[i] += dt * u[static_cast<std::size_t>(joint.speed(i))];
    }
  }
}

}  // namespace cogrsim::bullet

#include "mechanism/reactions.h"

namespace cogrsim::dynamics {
namespace {

// Force and torque about the world's origin; or momentum in the same sense.
struct Momenta {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};

struct LinkState {
  Momenta momentum;
  Vec3 com = Vec3::Zero();
};

LinkState state_of(const Mechanism& m, const Link& link) {
  const LinkMotion& motion = m.motion(link);
  const Mat3& R = motion.X.R;
  LinkState out;
  out.com = motion.X * link.com;
  out.momentum.linear = link.mass * motion.velocity_at(out.com);
  out.momentum.angular =
      R * (link.inertia * (R.transpose() * motion.angular)) + out.com.cross(out.momentum.linear);
  return out;
}

void add_contacts(const Mechanism& m, const StepRecord& record, std::vector<Momenta>& gained) {
  for (const ContactRecord& c : *record.contacts) {
    const int bodies[2] = {(*record.colliders)[std::size_t(c.collider_a)].body,
                           (*record.colliders)[std::size_t(c.collider_b)].body};
    for (int side = 0; side < 2; ++side) {
      const int link = m.body_link(bodies[side]);
      if (link < 0) continue;
      const double sign = side == 0 ? -1.0 : 1.0;
      gained[std::size_t(link)].linear -= sign * c.impulse.force;
      gained[std::size_t(link)].angular -=
          sign * (c.point.cross(c.impulse.force) + c.impulse.torque);
    }
  }
}

// Adds the welds' wrenches of one component to the momenta their links gained otherwise.
void share_loops(Mechanism& m, Component& c, const StepRecord& record,
                 const std::vector<Momenta>& through, std::vector<Momenta>& own) {
  const SceneModel& model = m.model();
  update_component(m, c);
  // s . (wrench through the joint) is the joint's effort along s.
  Eigen::VectorXd excess = Eigen::VectorXd::Zero(c.size());
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const Link& link = m.links()[std::size_t(c.links[i])];
    const Momenta& w = through[std::size_t(c.links[i])];
    const Spatial about_origin{w.angular / record.dt - c.origin.cross(w.linear / record.dt),
                               w.linear / record.dt};
    for (int k = 0; k < link.nu; ++k) {
      const int local = c.linkage->first[i] + k;
      excess[local] = dot(c.linkage->motion[std::size_t(local)], about_origin);
      if (link.plan.joint < 0) continue;
      const Joint& joint = model.joints[std::size_t(link.plan.joint)];
      for (int model_axis = 0; model_axis < link.nu; ++model_axis)
        if (link.u_map[std::size_t(model_axis)] == k)
          excess[local] -= (*record.joint_efforts)[std::size_t(joint.speed_offset + model_axis)];
    }
  }
  const Eigen::MatrixXd Gt = c.linkage->loops.G.transpose();
  const Eigen::VectorXd f = Gt.completeOrthogonalDecomposition().solve(excess);
  for (std::size_t w = 0; w < c.linkage->welds.size(); ++w) {
    const Vec3 torque = f.segment<3>(Eigen::Index(6 * w)) * record.dt;
    const Vec3 force = f.segment<3>(Eigen::Index(6 * w + 3)) * record.dt;
    const Vec3 at = m.motion(m.links()[std::size_t(c.linkage->welds[w].shadow)]).X.p;
    const Vec3 moment = torque + at.cross(force);
    Momenta& shadow = own[std::size_t(c.linkage->welds[w].shadow)];
    shadow.linear -= force;
    shadow.angular -= moment;
    if (c.linkage->welds[w].primary < 0) continue;
    Momenta& primary = own[std::size_t(c.linkage->welds[w].primary)];
    primary.linear += force;
    primary.angular += moment;
  }
}

std::vector<Momenta> sum_outboard(const Mechanism& m, std::vector<Momenta> own) {
  for (std::size_t i = own.size(); i-- > 0;) {
    const int parent = m.links()[i].plan.parent;
    if (parent < 0) continue;
    own[std::size_t(parent)].linear += own[i].linear;
    own[std::size_t(parent)].angular += own[i].angular;
  }
  return own;
}

}  // namespace

void calc_joint_reactions(Mechanism& m, const StepRecord& record, std::vector<Wrench>& out) {
  const SceneModel& model = m.model();
  out.assign(model.joints.size(), Wrench());
  if (record.dt <= 0.0) return;
  const std::vector<Link>& links = m.links();
  std::vector<Momenta> own(links.size());
  std::vector<Vec3> start_com(links.size());

  const Values q = m.state.q(), u = m.state.u();
  m.state.change_q() = *record.start_q;
  m.state.change_u() = *record.start_u;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const LinkState s = state_of(m, links[i]);
    own[i].linear = -s.momentum.linear;
    own[i].angular = -s.momentum.angular;
    start_com[i] = s.com;
  }
  m.state.change_q() = q;
  m.state.change_u() = u;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].kinematic) continue;
    const LinkState s = state_of(m, links[i]);
    const Vec3 force = m.loads()[i].force * record.dt, torque = m.loads()[i].torque * record.dt;
    own[i].linear += s.momentum.linear - force;
    own[i].angular += s.momentum.angular - (0.5 * (start_com[i] + s.com)).cross(force) - torque;
  }
  add_contacts(m, record, own);

  std::vector<Momenta> through = sum_outboard(m, own);
  if (m.has_loops()) {
    for (Component& c : m.components())
      if (c.has_loops()) share_loops(m, c, record, through, own);
    through = sum_outboard(m, own);
  }

  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    if (link.plan.joint < 0) continue;
    const Joint& joint = model.joints[std::size_t(link.plan.joint)];
    const double sign = (link.plan.reversed ? -1.0 : 1.0) / record.dt;
    Vec3 at = joint.X_CM.p;  // in the child, wherever that is
    const int child = link.plan.reversed ? link.plan.parent : int(i);
    if (child >= 0)
      at = m.motion(links[std::size_t(child)]).X * joint.X_CM.p;
    else if (joint.child >= 0)
      at = model.bodies[std::size_t(joint.child)].X_WB * joint.X_CM.p;
    Wrench& wrench = out[std::size_t(link.plan.joint)];
    wrench.force = sign * through[i].linear;
    wrench.torque = sign * (through[i].angular - at.cross(through[i].linear));
  }
}

}  // namespace cogrsim::dynamics

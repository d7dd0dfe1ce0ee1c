// State of a MujocoWorld: reading, writing, reporting, saving.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "convert.h"
#include "world.h"

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/scene_state.h"

namespace cogrsim::mujoco {

void MujocoWorld::get_coordinates(Coordinates& out) const {
  const mjModel& m = *model_;
  const mjData& d = *data_;
  out.qpos.assign(d.qpos, d.qpos + m.nq);
  out.qvel.assign(d.qvel, d.qvel + m.nv);
  out.warmstart.assign(d.qacc_warmstart, d.qacc_warmstart + m.nv);
}

void MujocoWorld::put_back(const Coordinates& from) const {
  std::copy(from.qpos.begin(), from.qpos.end(), data_->qpos);
  std::copy(from.qvel.begin(), from.qvel.end(), data_->qvel);
  std::copy(from.warmstart.begin(), from.warmstart.end(), data_->qacc_warmstart);
}

void MujocoWorld::find_kinematics(Kinematics wanted) const {
  if (kinematics_ == wanted) return;
  const mjModel* const m = model_.get();
  mjData* const d = data_.get();
  Coordinates now;
  get_coordinates(now);
  if (wanted == Kinematics::before) put_back(before_);
  mj_kinematics(m, d);
  mj_comPos(m, d);
  mj_comVel(m, d);
  put_back(now);  // MuJoCo has normalised its quaternions, and reading must change nothing
  kinematics_ = wanted;
}

Pose MujocoWorld::pose(int body) const {
  const auto b = static_cast<std::size_t>(body);
  const int i = program_->bodies[b];
  if (i <= 0) return program_->static_poses[b];
  const Quat q = quat_at(data_->xquat + 4 * i);
  return {vec_at(data_->xpos + 3 * i) - q * program_->origins[b], q};
}

Twist MujocoWorld::twist(int body) const {
  const auto b = static_cast<std::size_t>(body);
  const int i = program_->bodies[b];
  if (i <= 0) return {};
  if (const int dof = program_->free_dof[b]; dof >= 0) {
    const Quat q = quat_at(data_->xquat + 4 * i);
    const Twist V{vec_at(data_->qvel + dof), q * vec_at(data_->qvel + dof + 3)};
    return {V.at(-(q * program_->origins[b])), V.angular};
  }
  // About the centre of mass of the whole tree.
  const Twist V{vec_at(data_->cvel + 6 * i + 3), vec_at(data_->cvel + 6 * i)};
  const Vec3 centre = vec_at(data_->subtree_com + 3 * model_->body_rootid[i]);
  return {V.at(vec_at(data_->xpos + 3 * i) - centre), V.angular};
}

bool MujocoWorld::read_joint(int j, double* q, double* u) const {
  const Joint& joint = program_->scene->joints[j];
  const TreeJoint& in_tree = program_->joints[j];
  if (in_tree.joint < 0) return false;
  const double *qpos = data_->qpos + in_tree.qpos, *qvel = data_->qvel + in_tree.dof;
  if (joint.type != JointType::ball) {
    for (int i = 0; i < speed_count(joint.type); ++i) {
      q[i] = qpos[in_tree.axis[i]];
      u[i] = qvel[in_tree.axis[i]];
    }
    return true;
  }
  // MuJoCo's turn of the moved body and rate, both in the moved body's axes.
  const Quat turn = quat_at(qpos).normalized();
  const Quat& q_BN = in_tree.reversed ? joint.X_PF.q : joint.X_CM.q;
  const Quat in_N = q_BN.conjugate() * turn * q_BN;
  const Vec3 rate = q_BN.conjugate() * vec_at(qvel);
  put(q, in_tree.reversed ? Quat(in_N.conjugate()) : in_N);
  const Vec3 in_F = in_tree.reversed ? Vec3(-rate) : Vec3(in_N * rate);
  std::copy_n(in_F.data(), 3, u);
  return true;
}

void MujocoWorld::put_joint(std::size_t j, const double* q, const double* u) {
  const Joint& joint = program_->scene->joints[j];
  const TreeJoint& in_tree = program_->joints[j];
  if (in_tree.joint < 0) return;
  double *qpos = data_->qpos + in_tree.qpos, *qvel = data_->qvel + in_tree.dof;
  if (joint.type != JointType::ball) {
    for (int i = 0; i < speed_count(joint.type); ++i) {
      qpos[in_tree.axis[i]] = q[i];
      qvel[in_tree.axis[i]] = u[i];
    }
    if (joint.type == JointType::screw) {
      qpos[1] = joint.pitch / (2.0 * kPi) * q[0];
      qvel[1] = joint.pitch / (2.0 * kPi) * u[0];
    }
    return;
  }
  const Quat q_FM = quat_at(q).normalized();
  const Quat& q_BN = in_tree.reversed ? joint.X_PF.q : joint.X_CM.q;
  const Quat in_N = in_tree.reversed ? Quat(q_FM.conjugate()) : q_FM;
  put(qpos, q_BN * in_N * q_BN.conjugate());
  put(qvel,
      Vec3(q_BN * (in_tree.reversed ? Vec3(-vec_at(u)) : Vec3(q_FM.conjugate() * vec_at(u)))));
}

void MujocoWorld::put_free(std::size_t b, const Pose& X, const Twist& V) {
  const Vec3 r = X.q * program_->origins[b];
  put(data_->qpos + program_->free_qpos[b], Vec3(X.p + r));
  put(data_->qpos + program_->free_qpos[b] + 3, X.q);
  put(data_->qvel + program_->free_dof[b], V.at(r));
  put(data_->qvel + program_->free_dof[b] + 3, Vec3(X.q.conjugate() * V.angular));
}

void MujocoWorld::put_state(const WorldState& state, std::size_t first) {
  const SceneModel& scene = *program_->scene;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (program_->free_qpos[b] >= 0) put_free(b, state.poses[b], state.twists[b]);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    double q[7];
    std::copy_n(state.joint_positions.begin() + joint.position_offset, position_count(joint.type),
                q);
    if (j >= first) std::transform(q, q + position_count(joint.type), q, settled);
    put_joint(j, q, state.joint_velocities.data() + joint.speed_offset);
  }
  mju_zero(data_->qacc_warmstart, int(model_->nv));
  forget_step();
}

void MujocoWorld::forget_step() {
  stepped_ = false;
  unchecked_ = true;
  kinematics_ = Kinematics::none;
  find_responses();
  laws_.reset(responses_.size());
}

void MujocoWorld::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  const SceneModel& scene = *program_->scene;
  const mjModel& m = *model_;
  const mjData& d = *data_;
  for (std::size_t i = 0; i < scene.motors.size(); ++i) {
    const int a = program_->actuators[i];
    if (a < 0) continue;
    const auto k = static_cast<std::size_t>(a);
    motors[i] = laws_.is_damped(k) ? laws_.effort(k, speed_of(k)) : d.actuator_force[a];
  }
  if (joints.empty()) return;
  // By MuJoCo's speeds: springs, dampers and motors, dry friction and limits; their rows come before
  // those of contacts.
  std::vector<double>& effort = scratch_;
  effort.assign(static_cast<std::size_t>(m.nv + d.nefc), 0.0);
  for (int row = d.ne; row < d.nefc; ++row) {
    const int type = d.efc_type[row];
    if (type != mjCNSTR_FRICTION_DOF && type != mjCNSTR_LIMIT_JOINT) break;
    effort[m.nv + row] = d.efc_force[row];
  }
  mj_mulJacTVec(&m, data_.get(), effort.data(), effort.data() + m.nv);
  for (int i = 0; i < m.nv; ++i) {
    // Of stiff drives by the speed at the end of the step.
    const double stiff = m.dof_damping[i] - program_->model->dof_damping[i];
    effort[i] += d.qfrc_passive[i] + d.qfrc_actuator[i] + stiff * (before_.qvel[i] - d.qvel[i]);
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const TreeJoint& in_tree = program_->joints[j];
    if (in_tree.joint < 0) continue;
    double* const to = joints.data() + joint.speed_offset;
    const auto dof = static_cast<std::size_t>(in_tree.dof);
    if (joint.type == JointType::ball) {
      const Quat& q_BN = in_tree.reversed ? joint.X_PF.q : joint.X_CM.q;
      const Vec3 in_N = q_BN.conjugate() * vec_at(effort.data() + dof);
      const Vec3 in_F =
          in_tree.reversed
              ? Vec3(-in_N)
              : Vec3(q_BN.conjugate() * quat_at(d.qpos + in_tree.qpos).normalized() * q_BN * in_N);
      std::copy_n(in_F.data(), 3, to);
      continue;
    }
    for (int i = 0; i < speed_count(joint.type); ++i)
      to[i] = effort[dof + static_cast<std::size_t>(in_tree.axis[i])];
    if (joint.type == JointType::screw) to[0] += joint.pitch / (2.0 * kPi) * effort[dof + 1];
  }
}

Result<> MujocoWorld::write(const WorldState& state) {
  put_state(state, program_->references.size());
  return {};
}

void MujocoWorld::read_contacts(std::vector<Contact>& out) const {
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& it = data_->contact[i];
    double force[6];
    mj_contactForce(model_.get(), data_.get(), i, force);
    Contact& contact = out.emplace_back();
    std::tie(contact.body_a, contact.shape_a) = program_->geoms[it.geom1];
    std::tie(contact.body_b, contact.shape_b) = program_->geoms[it.geom2];
    contact.point = vec_at(it.pos);
    contact.normal = vec_at(it.frame);  // from 1 to 2
    contact.depth = -it.dist;
    contact.force = force[0] * vec_at(it.frame) + force[1] * vec_at(it.frame + 3) +
                    force[2] * vec_at(it.frame + 6);
  }
}

void MujocoWorld::read_reactions(std::vector<Wrench>& out) const {
  const SceneModel& scene = *program_->scene;
  mjModel* const m = model_.get();
  mjData* const d = data_.get();
  find_kinematics(Kinematics::before);  // as when the forces were found
  // With the accelerations that came out: implicit damping is not in those of the forces.
  if (m->nu > 0 &&
      !std::equal(m->dof_damping, m->dof_damping + m->nv, program_->model->dof_damping))
    for (int i = 0; i < m->nv; ++i) d->qacc[i] = (d->qvel[i] - before_.qvel[i]) / m->opt.timestep;
  mj_rnePostConstraint(m, d);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const TreeJoint& in_tree = program_->joints[j];
    if (in_tree.body <= 0) continue;
    const double* const wrench = d->cfrc_int + 6 * in_tree.body;
    const Vec3 centre = vec_at(d->subtree_com + 3 * m->body_rootid[in_tree.body]);
    const Vec3 M = pose_of(joint.child) * joint.X_CM.p, force = vec_at(wrench + 3);
    const double sign = in_tree.reversed ? -1.0 : 1.0;
    out[j] = {sign * force, sign * (vec_at(wrench) + (centre - M).cross(force))};
  }
}

HostedWorld::MemoryPtr MujocoWorld::save_memory() const {
  auto out = std::make_shared<Memory>();
  out->program = program_;
  get_coordinates(out->coordinates);
  out->responses = responses_;
  out->at_bound = laws_.at_bound;
  return out;
}

Result<> MujocoWorld::restore_memory(const SceneModelPtr&, const MemoryPtr& memory,
                                     const WorldState&) {
  const auto& saved = static_cast<const Memory&>(*memory);
  if (saved.program != program_)
    if (auto adopted = adopt(saved.program); !adopted) return adopted;
  put_back(saved.coordinates);
  forget_step();
  responses_ = saved.responses;
  laws_.at_bound = saved.at_bound;
  return {};
}

}  // namespace cogrsim::mujoco

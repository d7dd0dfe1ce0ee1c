// Changing the scene of a running MujocoWorld: MuJoCo's model is compiled anew, and the state carried
// over.
#include <algorithm>

#include "convert.h"
#include "world.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/scene_change.h"

namespace cogrsim::mujoco {

Result<> MujocoWorld::add(const SceneModelPtr& next) {
  const auto change = find_scene_change(*program_->scene, *next, SceneStep::add);
  if (!change) return tl::unexpected(change.error());
  see(Kinematics::now);
  std::vector<int> sudden;
  for (const int j : change->attached) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    auto fits = check_attachment(joint, pose_of(joint.parent), pose_of(joint.child));
    if (!fits) return fits;
    sudden.insert(sudden.end(), {joint.parent, joint.child});
  }
  return become(next, change->attached, {}, sudden);
}

Result<> MujocoWorld::remove(const SceneModelPtr& next) {
  const auto change = find_scene_change(*program_->scene, *next, SceneStep::remove);
  if (!change) return tl::unexpected(change.error());
  return become(next, {}, {}, {});
}

Result<> MujocoWorld::change(const SceneModelPtr& next) {
  const auto change = find_scene_change(*program_->scene, *next, SceneStep::change);
  if (!change) return tl::unexpected(change.error());
  std::vector<int> sudden = change->kinds;
  for (const Joint& joint : next->joints) {
    if (joint.removed) continue;
    const auto& kinds = change->kinds;
    if (std::find(kinds.begin(), kinds.end(), joint.parent) != kinds.end()) {
      sudden.push_back(joint.child);
    }
    if (std::find(kinds.begin(), kinds.end(), joint.child) != kinds.end()) {
      sudden.push_back(joint.parent);
    }
  }
  return become(next, {}, change->kinds, sudden);
}

Result<> MujocoWorld::become(const SceneModelPtr& next, const std::vector<int>& attached,
                             const std::vector<int>& stopped, const std::vector<int>& sudden) {
  const SceneModel& scene = *next;
  WorldState now;
  std::vector<Contact> contacts;
  std::vector<Wrench> reactions;
  get_state(now);
  get_contacts(contacts);
  get_joint_reactions(reactions);
  for (std::size_t b = now.poses.size(); b < scene.bodies.size(); ++b) {
    now.poses.push_back(scene.bodies[b].X_WB);
    now.twists.push_back(scene.bodies[b].kind == BodyKind::fixed ? Twist() : scene.bodies[b].V_WB);
  }
  for (const int b : stopped) now.twists[static_cast<std::size_t>(b)] = {};
  const std::size_t before = program_->references.size();
  std::vector<Reference> references = program_->references;
  now.joint_positions.resize(static_cast<std::size_t>(scene.joint_positions));
  now.joint_velocities.resize(static_cast<std::size_t>(scene.joint_speeds));
  now.joint_efforts.resize(static_cast<std::size_t>(scene.joint_speeds));
  for (std::size_t j = before; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const bool there =
        std::find(attached.begin(), attached.end(), static_cast<int>(j)) != attached.end();
    references.push_back(reference_of(scene, j, now.poses, there));
    double* const q = now.joint_positions.data() + joint.position_offset;
    std::copy(joint.position.begin(), joint.position.end(), q);
    std::copy(joint.velocity.begin(), joint.velocity.end(),
              now.joint_velocities.begin() + joint.speed_offset);
    if (!there) continue;
    const auto pose = [&](int b) {
      return b == kWorld ? Pose() : now.poses[static_cast<std::size_t>(b)];
    };
    joint_position(joint, relative_pose(joint, pose(joint.parent), pose(joint.child)),
                   joint.position.data(), q);
  }

  const auto program = make_program(next, std::move(references), now.poses);
  if (!program) return tl::unexpected(program.error());
  const ProgramPtr old = program_;
  const Coordinates was = coordinates();
  if (auto adopted = adopt(*program); !adopted) return adopted;
  forget_reports();
  kinematic_.resize(scene.bodies.size());
  std::copy(now.twists.begin() + static_cast<std::ptrdiff_t>(old->bodies.size()), now.twists.end(),
            kinematic_.begin() + static_cast<std::ptrdiff_t>(old->bodies.size()));

  // The last step's reports stay, but for what is gone.
  now.motor_efforts.resize(scene.motors.size());
  for (std::size_t m = 0; m < scene.motors.size(); ++m) {
    if (scene.motors[m].removed) now.motor_efforts[m] = 0.0;
  }
  reactions.resize(scene.joints.size());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (!scene.joints[j].removed) continue;
    reactions[j] = {};
    std::fill_n(now.joint_efforts.begin() + scene.joints[j].speed_offset,
                speed_count(scene.joints[j].type), 0.0);
  }
  contacts.erase(std::remove_if(contacts.begin(), contacts.end(),
                                [&](const Contact& c) {
                                  return scene.bodies[static_cast<std::size_t>(c.body_a)].removed ||
                                         scene.bodies[static_cast<std::size_t>(c.body_b)].removed;
                                }),
                 contacts.end());
  kept_ = std::move(now);
  kept_contacts_ = std::move(contacts);
  kept_reactions_ = std::move(reactions);
  carry_over(*old, was);
  if (!sudden.empty()) join(sudden);
  return {};
}

void MujocoWorld::carry_over(const Program& old, const Coordinates& was) {
  const Program& is = *program_;
  mjData& d = *data_;
  // What is still MuJoCo's joint of the same kind goes over bit by bit.
  const auto copy = [&](int qpos, int old_qpos, int nq, int dof, int old_dof, int nv) {
    std::copy_n(was.qpos.begin() + old_qpos, nq, d.qpos + qpos);
    std::copy_n(was.qvel.begin() + old_dof, nv, d.qvel + dof);
    std::copy_n(was.warmstart.begin() + old_dof, nv, d.qacc_warmstart + dof);
  };
  for (std::size_t b = 0; b < is.bodies.size(); ++b) {
    if (is.free_qpos[b] < 0) continue;
    if (b < old.bodies.size() && old.free_qpos[b] >= 0 && old.origins[b] == is.origins[b]) {
      copy(is.free_qpos[b], old.free_qpos[b], 7, is.free_dof[b], old.free_dof[b], 6);
    } else {
      put_free(b, kept_.poses[b], kept_.twists[b]);
    }
  }
  for (std::size_t j = 0; j < is.joints.size(); ++j) {
    const TreeJoint& place = is.joints[j];
    if (place.joint < 0) continue;
    const Joint& joint = is.scene->joints[j];
    if (j < old.joints.size() && old.joints[j].joint >= 0 &&
        old.joints[j].reversed == place.reversed) {
      const bool screw = joint.type == JointType::screw;
      copy(place.qpos, old.joints[j].qpos, screw ? 2 : position_count(joint.type), place.dof,
           old.joints[j].dof, screw ? 2 : speed_count(joint.type));
    } else {
      put_joint(j, kept_.joint_positions.data() + joint.position_offset,
                kept_.joint_velocities.data() + joint.speed_offset);
    }
  }
}

void MujocoWorld::join(const std::vector<int>& sudden) {
  const mjModel* const m = model_.get();
  mjData* const d = data_.get();
  const auto count = static_cast<std::size_t>(m->nv);
  if (count == 0) return;
  std::vector<char> touched(static_cast<std::size_t>(m->nbody));  // by root
  for (const int b : sudden) {
    const int body = b == kWorld ? 0 : program_->bodies[static_cast<std::size_t>(b)];
    if (body > 0) touched[static_cast<std::size_t>(m->body_rootid[body])] = 1;
  }
  see(Kinematics::now);
  // A plastic impact: of all velocities that the joints allow those with the momentum there was,
  // M u = sum J^T (m v, I w), with MuJoCo's M and J.
  std::vector<double> momentum(count), jacobian(6 * count);
  const auto moves = [&](int body) {
    return body > 0 && touched[static_cast<std::size_t>(m->body_rootid[body])];
  };
  for (int i = 1; i < m->nbody; ++i) {
    const int b = program_->owners[static_cast<std::size_t>(i)];
    if (!moves(i) || b < 0) continue;
    const Twist& V = kept_.twists[static_cast<std::size_t>(b)];
    const Vec3 v = V.at(vec_at(d->xipos + 3 * i) - pose_of(b).p);
    const Mat3 R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d->ximat + 9 * i);
    const Vec3 P = m->body_mass[i] * v;
    const Vec3 L = R * vec_at(m->body_inertia + 3 * i).cwiseProduct(R.transpose() * V.angular);
    mj_jacBodyCom(m, d, jacobian.data(), jacobian.data() + 3 * count, i);
    for (std::size_t k = 0; k < 3 * count; ++k) {
      momentum[k % count] += jacobian[k] * P[static_cast<Eigen::Index>(k / count)] +
                             jacobian[3 * count + k] * L[static_cast<Eigen::Index>(k / count)];
    }
  }
  const bool found = guarded([&] {
    mj_crb(m, d);
    mj_factorM(m, d);
    mj_solveM(m, d, momentum.data(), momentum.data(), 1);
  });
  for (int i = 0; found && i < m->nv; ++i) {
    if (moves(m->dof_bodyid[i])) d->qvel[i] = momentum[static_cast<std::size_t>(i)];
  }
  seen_ = Kinematics::none;
}

}  // namespace cogrsim::mujoco

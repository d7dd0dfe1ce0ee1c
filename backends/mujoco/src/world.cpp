#include "world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>

#include "convert.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::mujoco {

namespace {

/// Written so that a NaN is bad. Beyond it MuJoCo resets its data.
bool is_bad(double x) { return !(std::abs(x) < mjMAXVAL); }
bool any_bad(const double* values, int count) {
  return std::any_of(values, values + count, is_bad);
}

int clamped(double value) { return static_cast<int>(std::min(value, 2e9)); }

}  // namespace

Result<std::unique_ptr<World>> MujocoWorld::create(const SceneModelPtr& model) {
  std::vector<Pose> poses;
  for (const Body& body : model->bodies) poses.push_back(body.X_WB);
  std::vector<Reference> references;
  for (std::size_t j = 0; j < model->joints.size(); ++j) {
    references.push_back(reference_of(*model, j, poses, false));
  }
  const auto program = make_program(model, std::move(references), std::move(poses));
  if (!program) return tl::unexpected(program.error());
  std::unique_ptr<MujocoWorld> world(new MujocoWorld);
  world->initial_ = *program;
  if (auto begun = world->reset(); !begun) return tl::unexpected(begun.error());
  return world;
}

Result<> MujocoWorld::adopt(const ProgramPtr& program) {
  mjModel* copy = nullptr;
  if (!guarded([&] { copy = mj_copyModel(nullptr, program->model.get()); })) {
    return fail("MuJoCo: " + last_error());
  }
  ModelOwner before(copy);
  std::swap(before, model_);
  int contacts = 16, rows = 16 + copy->nemax + copy->nv;
  for (const auto& [b, s] : program->geoms) {
    contacts +=
        program->scene->bodies[static_cast<std::size_t>(b)].kind == BodyKind::dynamic ? 2 : 0;
  }
  rows += 4 * contacts;
  if (auto made = make_room(contacts, rows, 0); !made) {
    model_ = std::move(before);
    return made;
  }
  program_ = program;
  return {};
}

Result<> MujocoWorld::make_room(int contacts, int rows, int stack) {
  mjModel& m = *model_;
  const auto before = std::make_tuple(m.nconmax, m.njmax, m.nstack);
  m.nconmax = contacts;
  m.njmax = rows;
  if (stack == 0) {
    // MuJoCo's own rule, as long as that is not much; where it is not enough there will be more.
    const double size = static_cast<double>(rows) + m.neq + m.nv, bodies = m.nbody;
    stack = clamped(std::min(5 * size * size, 3e6) + bodies * bodies +
                    20.0 * (m.nq + m.nv + m.nu + m.nbody + m.njnt + m.ngeom + m.neq) + 1000);
  }
  m.nstack = stack;
  auto data = make_data(m);
  if (!data) {
    std::tie(m.nconmax, m.njmax, m.nstack) = before;
    return tl::unexpected(data.error());
  }
  data_ = std::move(*data);
  seen_ = Kinematics::none;
  return {};
}

bool MujocoWorld::make_more_room(const std::string& lack) {
  const mjModel& m = *model_;
  const auto more = [](int count) { return clamped(1.5 * count) + 16; };
  if (lack == "contacts") return bool(make_room(more(m.nconmax), m.njmax, 0));
  if (lack == "rows") return bool(make_room(m.nconmax, more(m.njmax), 0));
  return m.nstack < 1000000000 && make_room(m.nconmax, m.njmax, 2 * m.nstack);
}

void MujocoWorld::start() {
  const SceneModel& scene = *program_->scene;
  time_ = 0.0;
  kept_ = {};
  for (const Body& body : scene.bodies) {
    kept_.poses.push_back(body.X_WB);
    kept_.twists.push_back(body.kind == BodyKind::fixed ? Twist() : body.V_WB);
  }
  kinematic_ = kept_.twists;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (program_->free_qpos[b] < 0) continue;
    const Pose X = kept_.poses[b];
    double before[7];
    double* const qpos = data_->qpos + program_->free_qpos[b];
    std::copy_n(qpos, 7, before);
    put_free(b, X, kept_.twists[b]);
    // Its turn as MuJoCo's compiler normalised it.
    if (vec_at(before) == vec_at(qpos)) std::copy_n(before, 7, qpos);
  }
  kept_.joint_positions.resize(static_cast<std::size_t>(scene.joint_positions));
  kept_.joint_velocities.resize(static_cast<std::size_t>(scene.joint_speeds));
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    double* const q = kept_.joint_positions.data() + joint.position_offset;
    std::transform(joint.position.begin(), joint.position.end(), q, settled);
    std::copy(joint.velocity.begin(), joint.velocity.end(),
              kept_.joint_velocities.begin() + joint.speed_offset);
    put_joint(j, q, joint.velocity.data());
  }
  forget_reports();
}

void MujocoWorld::forget_reports() {
  const SceneModel& scene = *program_->scene;
  kept_.joint_efforts.assign(static_cast<std::size_t>(scene.joint_speeds), 0.0);
  kept_.motor_efforts.assign(scene.motors.size(), 0.0);
  kept_contacts_.clear();
  kept_reactions_.assign(scene.joints.size(), {});
  stepped_ = false;
  unchecked_ = true;
  seen_ = Kinematics::none;
}

MujocoWorld::Coordinates MujocoWorld::coordinates() const {
  const mjModel& m = *model_;
  const mjData& d = *data_;
  return {{d.qpos, d.qpos + m.nq},
          {d.qvel, d.qvel + m.nv},
          {d.qacc_warmstart, d.qacc_warmstart + m.nv}};
}

void MujocoWorld::keep_before() {
  const mjModel& m = *model_;
  const mjData& d = *data_;
  before_.qpos.assign(d.qpos, d.qpos + m.nq);
  before_.qvel.assign(d.qvel, d.qvel + m.nv);
  before_.warmstart.assign(d.qacc_warmstart, d.qacc_warmstart + m.nv);
}

void MujocoWorld::put_back(const Coordinates& from) const {
  std::copy(from.qpos.begin(), from.qpos.end(), data_->qpos);
  std::copy(from.qvel.begin(), from.qvel.end(), data_->qvel);
  std::copy(from.warmstart.begin(), from.warmstart.end(), data_->qacc_warmstart);
}

void MujocoWorld::set_drives(double dt, const std::vector<Drive>& drives) {
  const std::size_t motors = program_->actuators.size();
  for (std::size_t i = 0; i < motors; ++i) {
    const int a = program_->actuators[i];
    if (a < 0) continue;
    const Drive& drive = drives[i];
    const Motion& motion = program_->motions[static_cast<std::size_t>(a)];
    // MuJoCo's actuators are explicit: a gain beyond this would turn the axis back and forth.
    const double most = motion.share / (dt * motion.inverse_inertia);
    double kp = 0.0, kd = most, bias = 0.0;
    if (!drive.is_speed_source()) {
      kp = drive.kp;
      kd = drive.kd;
      bias = drive.bias;
      const double gain = kd + 0.5 * dt * kp;
      if (gain > most) {
        kp *= most / gain;
        kd *= most / gain;
      }
    }
    data_->ctrl[a] = bias + kp * drive.position + kd * drive.velocity;
    model_->actuator_biasprm[mjNBIAS * a + 1] = -kp;
    model_->actuator_biasprm[mjNBIAS * a + 2] = -kd;
    model_->actuator_forcerange[2 * a] = -drive.max_effort;
    model_->actuator_forcerange[2 * a + 1] = drive.max_effort;
  }
}

void MujocoWorld::hold_kinematic() {
  for (const int b : program_->kinematic) {
    const auto i = static_cast<std::size_t>(b);
    const int body = program_->bodies[i];
    const Quat q = quat_at(data_->qpos + program_->free_qpos[i] + 3).normalized();
    put(data_->qvel + program_->free_dof[i], kinematic_[i].linear);
    put(data_->qvel + program_->free_dof[i] + 3, Vec3(q.conjugate() * kinematic_[i].angular));
    put(data_->xfrc_applied + 6 * body,
        Vec3(-model_->body_mass[body] * vec_at(model_->opt.gravity)));
  }
}

void MujocoWorld::move_kinematic(double dt) {
  for (const int b : program_->kinematic) {
    const auto i = static_cast<std::size_t>(b);
    const Twist& V = kinematic_[i];
    const double* const from = before_.qpos.data() + program_->free_qpos[i];
    const Quat q = (rotation_by(dt * V.angular) * quat_at(from + 3)).normalized();
    put(data_->qpos + program_->free_qpos[i], Vec3(vec_at(from) + dt * V.linear));
    put(data_->qpos + program_->free_qpos[i] + 3, q);
    put(data_->qvel + program_->free_dof[i], V.linear);
    put(data_->qvel + program_->free_dof[i] + 3, Vec3(q.conjugate() * V.angular));
  }
}

StepResult MujocoWorld::step(double dt, const std::vector<Drive>& drives) {
  if (unchecked_) {
    if (const int bad = find_bad(); bad >= 0) return diverged(bad, "");
    unchecked_ = false;
  }
  if (!program_->kinematic.empty()) hold_kinematic();
  keep_before();
  model_->opt.timestep = dt;
  for (;;) {
    set_drives(dt, drives);
    if (!guarded([&] { mj_step(model_.get(), data_.get()); })) {
      data_->pstack = 0;
      if (last_error() != "Stack overflow") return diverged(-1, "MuJoCo: " + last_error());
      if (!make_more_room("stack")) return diverged(-1, "MuJoCo: its stack is too small");
    } else {
      const mjWarningStat* const found = data_->warning;
      if (found[mjWARN_BADQPOS].number + found[mjWARN_BADQVEL].number +
              found[mjWARN_BADQACC].number + found[mjWARN_BADCTRL].number >
          0) {
        const bool control = found[mjWARN_BADCTRL].number > 0;
        const int where = found[control ? mjWARN_BADCTRL : mjWARN_BADQACC].lastinfo;
        return diverged(control ? body_of_motor(where) : body_of_dof(where), "");
      }
      const bool full = found[mjWARN_CONTACTFULL].number > 0;
      if (!full && found[mjWARN_CNSTRFULL].number == 0) break;
      if (!make_more_room(full ? "contacts" : "rows")) {
        return diverged(-1,
                        "MuJoCo has no room for more contacts: it counts the bytes of its "
                        "matrices in 31 bits");
      }
    }
    put_back(before_);
    if (!program_->kinematic.empty()) hold_kinematic();
  }
  if (any_bad(data_->qpos, model_->nq) || any_bad(data_->qvel, model_->nv)) {
    return diverged(find_bad(), "");
  }
  if (!program_->kinematic.empty()) move_kinematic(dt);
  time_ += dt;
  dt_ = dt;
  stepped_ = true;
  seen_ = Kinematics::none;
  if (!program_->followed.empty()) follow(kept_.joint_positions);
  return {};
}

StepResult MujocoWorld::diverged(int body, const std::string& what) {
  // Without a step before, the coordinates are those that were set.
  if (!unchecked_) put_back(before_);
  std::memset(data_->warning, 0, sizeof data_->warning);
  forget_reports();
  const SceneModel& scene = *program_->scene;
  for (std::size_t b = 0; body < 0 && b < scene.bodies.size(); ++b) {
    if (program_->bodies[b] > 0 && scene.bodies[b].kind == BodyKind::dynamic) {
      body = static_cast<int>(b);
    }
  }
  if (!what.empty()) return {StepStatus::diverged, body, what};
  return {
      StepStatus::diverged, body,
      "body '" + (body < 0 ? std::string() : scene.bodies[static_cast<std::size_t>(body)].name) +
          "' has left MuJoCo's bounds (1e10 of its place, velocity, acceleration or effort) or " +
          "is not a number"};
}

int MujocoWorld::find_bad() const {
  const mjModel& m = *model_;
  int worst = -1;
  for (int j = 0; j < m.njnt; ++j) {
    const int type = m.jnt_type[j], b = program_->owners[static_cast<std::size_t>(m.jnt_bodyid[j])];
    const int nq = type == mjJNT_FREE ? 7 : type == mjJNT_BALL ? 4 : 1;
    const int nv = type == mjJNT_FREE ? 6 : type == mjJNT_BALL ? 3 : 1;
    if (!any_bad(data_->qpos + m.jnt_qposadr[j], nq) &&
        !any_bad(data_->qvel + m.jnt_dofadr[j], nv)) {
      continue;
    }
    if (worst < 0 || b < worst) worst = b;
  }
  return worst;
}

int MujocoWorld::body_of_dof(int dof) const {
  return program_->owners[static_cast<std::size_t>(model_->dof_bodyid[dof])];
}

int MujocoWorld::body_of_motor(int actuator) const {
  return program_
      ->owners[static_cast<std::size_t>(model_->jnt_bodyid[model_->actuator_trnid[2 * actuator]])];
}

void* MujocoWorld::extension(std::string_view id) {
  if (id == JointReactions::kId) return static_cast<JointReactions*>(this);
  if (id == KinematicDrive::kId) return static_cast<KinematicDrive*>(this);
  return nullptr;
}

Result<> MujocoWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*program_->scene, body, twist); !fine) return fine;
  kinematic_[static_cast<std::size_t>(body)] = twist;
  put(data_->qvel + program_->free_dof[static_cast<std::size_t>(body)], twist.linear);
  const Quat q =
      quat_at(data_->qpos + program_->free_qpos[static_cast<std::size_t>(body)] + 3).normalized();
  put(data_->qvel + program_->free_dof[static_cast<std::size_t>(body)] + 3,
      Vec3(q.conjugate() * twist.angular));
  seen_ = Kinematics::none;
  return {};
}

}  // namespace cogrsim::mujoco

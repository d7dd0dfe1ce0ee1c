#include "world.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "convert.h"

namespace cogrsim::mujoco {

namespace {

/// Written so that a NaN is bad. Beyond it MuJoCo resets its data.
bool any_bad(const double* from, const double* to) {
  return std::any_of(from, to, [](double x) { return !(std::abs(x) < mjMAXVAL); });
}

int clamped(double value) { return static_cast<int>(std::min(value, 2e9)); }

}  // namespace

Result<> MujocoWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  ProgramPtr program = initial_;
  if (!program || program->scene != model) {
    auto made = make_program(model, begin.poses, {}, {});
    if (!made) return tl::unexpected(made.error());
    program = *made;
  }
  if (auto adopted = adopt(program); !adopted) return adopted;
  initial_ = program;
  put_state(begin, 0);
  // Turns as MuJoCo's compiler normalised them.
  for (const int i : program_->free_qpos)
    if (i >= 0 && vec_at(model_->qpos0 + i) == vec_at(data_->qpos + i))
      std::copy_n(model_->qpos0 + i, 7, data_->qpos + i);
  return {};
}

Result<> MujocoWorld::rebuild(const SceneModelPtr& next, const WorldState& begin,
                              const SceneChange& change) {
  const std::size_t first = program_->references.size();
  const auto program = make_program(next, begin.poses, program_->references, change.attached);
  if (!program) return tl::unexpected(program.error());
  if (auto adopted = adopt(*program); !adopted) return adopted;
  put_state(begin, first);
  return {};
}

Result<> MujocoWorld::adopt(const ProgramPtr& program) {
  mjModel* copy = nullptr;
  const auto done = guarded([&] { copy = mj_copyModel(nullptr, program->model.get()); });
  if (!done) return done;
  ModelOwner model(copy);
  if (auto made = make_room(*model, contact_room_, stack_room_); !made) return made;
  model_ = std::move(model);
  program_ = program;
  return {};
}

Result<> MujocoWorld::make_room(mjModel& m, double contacts, double stack) {
  const auto movable = std::count(m.geom_conaffinity, m.geom_conaffinity + m.ngeom, 3);
  m.nconmax = clamped(contacts * (16.0 + 2.0 * static_cast<double>(movable)));
  m.njmax = clamped(16.0 + double(m.nemax + m.njnt) + 4.0 * double(m.nconmax));
  const double rows = double(m.njmax + m.neq + m.nv);  // a matrix has its square
  const double sizes = double(m.nq + m.nv + m.nu + m.nbody + m.njnt + m.ngeom + m.neq);
  const double numbers = stack * (std::min(5 * rows * rows, 3e7) +
                                  double(m.nbody) * double(m.nbody) + 20.0 * sizes + 1000.0);
#if mjVERSION_HEADER < 230
  m.nstack = clamped(numbers);
#else  // bytes, in which contacts and their rows lie, too
  m.narena = static_cast<decltype(m.narena)>(8.0 * (numbers + rows * (double(m.nv) + 20.0)) +
                                             double(sizeof(mjContact)) * double(m.nconmax));
#endif
  auto data = make_data(m);
  if (!data) return tl::unexpected(data.error());
  data_ = std::move(*data);
  contact_room_ = contacts;
  stack_room_ = stack;
  kinematics_ = Kinematics::none;
  return {};
}

void MujocoWorld::set_drives(double dt, const std::vector<Drive>& drives) {
  mjModel& m = *model_;
  if (m.nu > 0) std::copy_n(program_->model->dof_damping, m.nv, m.dof_damping);
  for (std::size_t i = 0; i < program_->actuators.size(); ++i) {
    const int a = program_->actuators[i];
    if (a < 0) continue;
    const auto k = static_cast<std::size_t>(a);
    const int joint = m.actuator_trnid[2 * a], dof = m.jnt_dofadr[joint];
    const GainLimits limits(program_->implicit, dt, responses_[k], program_->crowds[dof]);
    const ActuatorLaw law = laws_.law(k, drives[i], limits, data_->qpos[m.jnt_qposadr[joint]]);
    data_->ctrl[a] = law.effort;
    m.actuator_biasprm[mjNBIAS * a + 1] = -law.kp;
    m.actuator_biasprm[mjNBIAS * a + 2] = -law.kd;
    m.actuator_forcerange[2 * a] = -law.max_effort;
    m.actuator_forcerange[2 * a + 1] = law.max_effort;
    m.dof_damping[dof] += law.damping;
  }
}

double MujocoWorld::speed_of(std::size_t actuator) const {
  return data_->qvel[model_->jnt_dofadr[model_->actuator_trnid[2 * actuator]]];
}

double MujocoWorld::response_of(int dof) const {
  const mjModel& m = *model_;
  std::vector<double>& y = scratch_;
#if mjVERSION_HEADER < 300
  // MuJoCo's inertia is M = L^T D L, with zeros but for a speed and those before it in its tree.
  // The response is (M^-1)_ii = y . D^-1 y, where L^T y is the unit vector.
  y.resize(std::max(y.size(), static_cast<std::size_t>(m.nv)));
  for (int k = dof; k >= 0; k = m.dof_parentid[k]) y[k] = k == dof ? 1.0 : 0.0;
  double response = 0.0;
  for (int k = dof; k >= 0; k = m.dof_parentid[k]) {
    const double* entry = data_->qLD + m.dof_Madr[k];
    for (int j = m.dof_parentid[k]; j >= 0; j = m.dof_parentid[j]) y[j] -= *++entry * y[k];
    response += y[k] * y[k] * data_->qLDiagInv[k];
  }
  return response;
#else  // L lies in another order: M^-1 of a unit impulse, in all trees
  y.assign(2 * static_cast<std::size_t>(m.nv), 0.0);
  y[m.nv + dof] = 1.0;
  mj_solveM(&m, data_.get(), y.data(), y.data() + m.nv, 1);
  return y[dof];
#endif
}

void MujocoWorld::find_responses() {
  const mjModel& m = *model_;
  responses_.resize(m.nu);
  for (std::size_t a = 0; a < responses_.size(); ++a) {
    const int dof = m.jnt_dofadr[m.actuator_trnid[2 * a]];
    // That of the reference configuration, unless the axis has become a good deal lighter.
    const double reference = m.dof_invweight0[dof], now = stepped_ ? response_of(dof) : 0.0;
    responses_[a] = now > 1.25 * reference ? now : reference;
  }
}

void MujocoWorld::apply_forces() {
  const bool none = external_.empty() && !program_->other_weights;
  if (none && !has_external_forces_) return;
  has_external_forces_ = !none;
  const Vec3 gravity = vec_at(model_->opt.gravity);
  for (std::size_t b = 0; b < model()->bodies.size(); ++b) {
    const Body& it = model()->bodies[b];
    if (it.removed || it.kind != BodyKind::dynamic) continue;
    const Wrench external = b < external_.size() ? external_[b] : Wrench();
    double* const applied = data_->xfrc_applied + 6 * program_->bodies[b];
    put(applied, Vec3((it.gravity_scale - 1.0) * it.mass * gravity + external.force));
    put(applied + 3, external.torque);
  }
}

void MujocoWorld::hold_kinematic() {
  for (const int body : program_->kinematic) {
    const auto b = static_cast<std::size_t>(body);
    const double* const qpos = data_->qpos + program_->free_qpos[b];
    put_free(b, {vec_at(qpos), quat_at(qpos + 3)}, twists()[b]);
    // Nothing pulls at it.
    const int i = program_->bodies[b];
    put(data_->xfrc_applied + 6 * i, Vec3(-model_->body_mass[i] * vec_at(model_->opt.gravity)));
  }
}

StepResult MujocoWorld::advance(double dt, const std::vector<Drive>& drives,
                                const std::vector<double>&) {
  if (unchecked_) {
    if (const int bad = find_bad(); bad >= 0) return lost(bad, "");
    unchecked_ = false;
  }
  get_coordinates(before_);
  model_->opt.timestep = dt;
  for (bool first = true;; first = false) {
    set_drives(dt, drives);
    apply_forces();
    hold_kinematic();
    const auto done = guarded([&] { mj_step(model_.get(), data_.get()); });
    const mjWarningStat* const found = data_->warning;
    const bool full = found[mjWARN_CONTACTFULL].number + found[mjWARN_CNSTRFULL].number > 0;
    if (done && !full) {
      // Stiff drives were taken to be within their bounds, or beyond, and may be otherwise.
      bool corrected = false;
      for (std::size_t k = 0; k < responses_.size(); ++k)
        corrected = laws_.correct(k, speed_of(k), first) || corrected;
      if (!corrected) break;
      put_back(before_);
      continue;
    }
    if (!done) data_->pstack = 0;
    if (!done && done.error().message.find("tack overflow") == std::string::npos)
      return lost(-1, done.error().message);
    // Its memory was too small: the step is undone, and repeated with more.
    const auto made =
        make_room(*model_, contact_room_ * (done ? 1.25 : 1.0), stack_room_ * (done ? 1 : 2));
    if (!made) return lost(-1, made.error().message);
    put_back(before_);
  }
  if (const int bad = find_bad(); bad >= 0) return lost(bad, "");
  hold_kinematic();
  stepped_ = true;
  find_responses();
  kinematics_ = Kinematics::none;
  return {};
}

StepResult MujocoWorld::lost(int body, const std::string& what) {
  // Without a step before, the coordinates are those that were set.
  if (!unchecked_) put_back(before_);
  std::memset(data_->warning, 0, sizeof data_->warning);
  forget_step();
  if (body < 0) return {StepStatus::diverged, body, what};
  return diverged(body, "1e10 of its position, velocity, acceleration or effort");
}

int MujocoWorld::find_bad() const {
  const mjModel& m = *model_;
  const mjData& d = *data_;
  const auto owner = [&](int body) { return program_->owners[body]; };
  if (const auto& found = d.warning[mjWARN_BADCTRL]; found.number > 0)
    return owner(m.jnt_bodyid[m.actuator_trnid[2 * found.lastinfo]]);
  if (const auto& found = d.warning[mjWARN_BADQACC]; found.number > 0)
    return owner(m.dof_bodyid[found.lastinfo]);
  for (int j = 0; j < m.njnt; ++j) {
    const bool last = j + 1 == m.njnt;
    const double* const q_end = d.qpos + (last ? m.nq : m.jnt_qposadr[j + 1]);
    const double* const u_end = d.qvel + (last ? m.nv : m.jnt_dofadr[j + 1]);
    if (any_bad(d.qpos + m.jnt_qposadr[j], q_end) || any_bad(d.qvel + m.jnt_dofadr[j], u_end))
      return owner(m.jnt_bodyid[j]);
  }
  return -1;
}

void MujocoWorld::move_kinematic(int) {
  hold_kinematic();
  kinematics_ = Kinematics::none;
}

}  // namespace cogrsim::mujoco

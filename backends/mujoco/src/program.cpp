#include "program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "convert.h"

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::mujoco {

namespace {

void find_indices(Program& out) {
  const SceneModel& scene = *out.scene;
  const mjModel& m = *out.model;
  const auto id = [&](int kind, const std::string& name) {
    return mj_name2id(&m, kind, name.c_str());
  };
  out.bodies.assign(scene.bodies.size(), -1);
  out.owners.assign(static_cast<std::size_t>(m.nbody), -1);
  out.free_qpos.assign(scene.bodies.size(), -1);
  out.free_dof.assign(scene.bodies.size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].removed) continue;
    out.bodies[b] = std::max(0, id(mjOBJ_BODY, fmt::format("b{}", b)));
    if (out.bodies[b] == 0) continue;
    out.owners[out.bodies[b]] = static_cast<int>(b);
    const int joint = m.body_jntadr[out.bodies[b]];
    if (joint < 0 || m.jnt_type[joint] != mjJNT_FREE) continue;
    out.free_qpos[b] = m.jnt_qposadr[joint];
    out.free_dof[b] = m.jnt_dofadr[joint];
  }
  // MuJoCo numbers geoms by body, the world's first.
  const auto written = std::exchange(out.geoms, {});
  out.geoms.resize(written.size());
  for (std::size_t g = 0; g < written.size(); ++g)
    out.geoms[id(mjOBJ_GEOM, fmt::format("g{}", g))] = written[g];
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    TreeJoint& in_tree = out.joints[j];
    const Joint& joint = scene.joints[j];
    if (in_tree.body < 0) continue;
    in_tree.body = out.bodies[in_tree.reversed ? joint.parent : joint.child];
    in_tree.joint = id(mjOBJ_JOINT, fmt::format("j{}_0", j));
    if (in_tree.joint < 0) continue;
    in_tree.qpos = m.jnt_qposadr[in_tree.joint];
    in_tree.dof = m.jnt_dofadr[in_tree.joint];
  }
}

/// What the text could not say as exactly, or not at all.
void complete_model(Program& out) {
  const SceneModel& scene = *out.scene;
  mjModel& m = *out.model;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const TreeJoint& in_tree = out.joints[j];
    for (std::size_t i = 0; in_tree.joint >= 0 && i < joint.axes.size(); ++i) {
      double* const range = m.jnt_range + 2 * (in_tree.joint + in_tree.axis[i]);
      range[0] = joint.type == JointType::ball ? 0.0 : joint.axes[i].lower;
      range[1] = joint.axes[i].upper;
    }
    const int equality = mj_name2id(&m, mjOBJ_EQUALITY, fmt::format("e{}_0", j).c_str());
    if (equality < 0) continue;
    const auto origin = [&](int b) { return b == kWorld ? Vec3(0, 0, 0) : out.origins[b]; };
    const auto eq_data = [&](int k) { return m.eq_data + mjNEQDATA * (equality + k); };
    if (joint.type == JointType::fixed) {
      put(eq_data(0), Vec3(joint.X_CM.p - origin(joint.child)));
      put(eq_data(0) + 3, Vec3(joint.X_PF.p - origin(joint.parent)));
      put(eq_data(0) + 6, (joint.X_PF.q * joint.X_CM.q.conjugate()).normalized());
      continue;
    }
    // MuJoCo takes the point on the second body from where the bodies were made, which is right
    // unless the loop was closed later.
    for (int k = 0; k < (joint.type == JointType::ball ? 1 : 2); ++k) {
      const Vec3 in_F = joint.X_PF.inverse() * (vec_at(eq_data(k)) + origin(joint.parent));
      const Vec3 wanted = joint.X_CM * in_F - origin(joint.child);
      if ((vec_at(eq_data(k) + 3) - wanted).norm() > 1e-9) put(eq_data(k) + 3, wanted);
    }
  }
  for (std::size_t g = 0; g < out.geoms.size(); ++g) {
    const auto& [b, s] = out.geoms[g];
    const Shape& shape = scene.bodies[b].shapes[s];
    if (shape.type != ShapeType::heightmap) continue;
    const HeightGrid& grid = *scene.heightmaps[shape.heightmap];
    const int hfield = m.geom_dataid[g];
    const double low = *std::min_element(grid.heights.begin(), grid.heights.end());
    const double rise = m.hfield_size[4 * hfield + 2];
    float* const data = m.hfield_data + m.hfield_adr[hfield];
    for (std::size_t i = 0; i < grid.heights.size(); ++i)
      data[i] = static_cast<float>((grid.heights[i] - low) / rise);
  }
  if (out.kinematic.empty()) return;
  // The solver's tolerance goes by the mean inertia: that of what is moved by forces.
  double sum = 0.0, count = 0.0;
  for (int i = 0; i < m.nv; ++i) {
    if (scene.bodies[out.owners[m.dof_bodyid[i]]].kind == BodyKind::kinematic) continue;
    sum += m.dof_M0[i];
    ++count;
  }
  if (count > 0) m.stat.meaninertia = sum / count;
}

/// Program::crowds and implicit.
Result<> find_crowds(Program& out) {
  const mjModel& m = *out.model;
  if (m.opt.integrator == mjINT_RK4) out.implicit = ImplicitPart::none;
  if (m.opt.integrator == mjINT_IMPLICIT) out.implicit = ImplicitPart::all_damping;
  out.crowds.assign(static_cast<std::size_t>(m.nv), 1.0);
  if (m.nu == 0) return {};
  const auto data = make_data(m);  // in the reference configuration
  if (!data) return tl::unexpected(data.error());
  for (const auto find : {mj_kinematics, mj_comPos, mj_crb, mj_factorM}) find(&m, data->get());
  std::vector<int> dofs;
  for (std::size_t i = 0; i < out.actuators.size(); ++i) {
    const int a = out.actuators[i];
    if (a >= 0 && may_have_gain(*out.scene, out.scene->motors[i]))
      dofs.push_back(m.jnt_dofadr[m.actuator_trnid[2 * a]]);
  }
  std::vector<double> column(m.nv);
  for (const int i : dofs) {
    std::fill(column.begin(), column.end(), 0.0);
    column[i] = 1.0;
    mj_solveM(&m, data->get(), column.data(), column.data(), 1);
    out.crowds[i] = 0.0;
    for (const int k : dofs)
      out.crowds[i] += std::abs(column[k]) / std::sqrt(m.dof_invweight0[i] * m.dof_invweight0[k]);
  }
  return {};
}

Reference reference_of(const Joint& joint, const Pose& X_WP, const Pose& X_WC) {
  const bool drawn_here = std::all_of(joint.position.begin(), joint.position.end(),
                                      [](double q) { return settled(q) == 0.0; });
  Reference out;
  out.X_PC = joint.type == JointType::ball || (joint.type != JointType::free && !drawn_here)
                 ? joint.X_PF * joint.X_CM.inverse()
             : joint.parent == kWorld ? X_WC
                                      : X_WP.inverse() * X_WC;
  return out;
}

}  // namespace

Result<ProgramPtr> make_program(const SceneModelPtr& scene, std::vector<Pose> poses,
                                std::vector<Reference> references,
                                const std::vector<int>& attached) {
  auto out = std::make_shared<Program>();
  out->scene = scene;
  const auto pose = [&](int b) { return b == kWorld ? Pose() : poses[b]; };
  for (std::size_t j = references.size(); j < scene->joints.size(); ++j) {
    const Joint& joint = scene->joints[j];
    references.push_back(reference_of(joint, pose(joint.parent), pose(joint.child)));
  }
  for (const int j : attached) references[j].attached = true;
  out->references = std::move(references);
  out->static_poses = std::move(poses);
  auto options = read_options(*scene);
  if (!options) return tl::unexpected(options.error());
  out->options = *options;
  const auto mjcf = write_mjcf(*out);
  if (!mjcf) return tl::unexpected(mjcf.error());
  auto model = compile(*mjcf);
  if (!model) {
    model.error().locate(source_position(*scene, scene->physics.origin));
    return tl::unexpected(model.error());
  }
  out->model = std::move(*model);
  find_indices(*out);
  complete_model(*out);
  if (auto found = find_crowds(*out); !found) return tl::unexpected(found.error());
  out->warnings =
      gain_warnings(*scene, "mujoco", [&](int j, int axis) -> std::optional<GainLimits> {
        const TreeJoint& in_tree = out->joints[j];
        if (in_tree.joint < 0) return std::nullopt;
        const int dof = out->model->jnt_dofadr[in_tree.joint + in_tree.axis[axis]];
        return GainLimits(out->implicit, scene->physics.step, out->model->dof_invweight0[dof],
                          out->crowds[dof]);
      });
  return ProgramPtr(std::move(out));
}

}  // namespace cogrsim::mujoco

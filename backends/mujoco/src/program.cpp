#include "program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "convert.h"
#include "mjcf.h"

#include "cogrsim/model/joint_kinematics.h"

namespace cogrsim::mujoco {

namespace {

/// Beyond it the motors of a tree get a share each; below, rounding of what hardly couples.
constexpr double kFreeCoupling = 1.25;

void find_places(Program& out) {
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
    out.owners[static_cast<std::size_t>(out.bodies[b])] = static_cast<int>(b);
    const int joint = m.body_jntadr[out.bodies[b]];
    if (joint < 0 || m.jnt_type[joint] != mjJNT_FREE) continue;
    out.free_qpos[b] = m.jnt_qposadr[joint];
    out.free_dof[b] = m.jnt_dofadr[joint];
  }
  // MuJoCo numbers geoms by body, the world's first.
  const auto written = std::exchange(out.geoms, {});
  out.geoms.resize(written.size());
  for (std::size_t g = 0; g < written.size(); ++g) {
    out.geoms[static_cast<std::size_t>(id(mjOBJ_GEOM, fmt::format("g{}", g)))] = written[g];
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    TreeJoint& place = out.joints[j];
    const Joint& joint = scene.joints[j];
    if (out.equalities[j] >= 0) out.equalities[j] = id(mjOBJ_EQUALITY, fmt::format("e{}_0", j));
    if (place.body < 0) continue;
    place.body = out.bodies[static_cast<std::size_t>(place.reversed ? joint.parent : joint.child)];
    place.joint = id(mjOBJ_JOINT, fmt::format("j{}_0", j));
    if (place.joint < 0) continue;
    place.qpos = m.jnt_qposadr[place.joint];
    place.dof = m.jnt_dofadr[place.joint];
  }
}

/// What the text could not say as exactly, or not at all.
void complete_model(Program& out) {
  const SceneModel& scene = *out.scene;
  mjModel& m = *out.model;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const TreeJoint& place = out.joints[j];
    for (std::size_t i = 0; place.joint >= 0 && i < joint.axes.size(); ++i) {
      double* const range = m.jnt_range + 2 * (place.joint + place.axis[i]);
      range[0] = joint.type == JointType::ball ? 0.0 : joint.axes[i].lower;
      range[1] = joint.axes[i].upper;
    }
    if (out.equalities[j] < 0) continue;
    const auto origin = [&](int b) {
      return b == kWorld ? Vec3(0, 0, 0) : out.origins[static_cast<std::size_t>(b)];
    };
    const auto eq_data = [&](int k) { return m.eq_data + mjNEQDATA * (out.equalities[j] + k); };
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
    const Shape& shape =
        scene.bodies[static_cast<std::size_t>(b)].shapes[static_cast<std::size_t>(s)];
    if (shape.type != ShapeType::heightmap) continue;
    const HeightGrid& grid = scene.heightmaps[static_cast<std::size_t>(shape.heightmap)];
    const int hfield = m.geom_dataid[g];
    const double low = *std::min_element(grid.heights.begin(), grid.heights.end());
    const double rise = m.hfield_size[4 * hfield + 2];
    float* const data = m.hfield_data + m.hfield_adr[hfield];
    for (std::size_t i = 0; i < grid.heights.size(); ++i) {
      data[i] = static_cast<float>((grid.heights[i] - low) / rise);
    }
  }
  if (out.kinematic.empty()) return;
  // The solver's tolerance goes by the mean inertia: that of what is moved by forces.
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < m.nv; ++i) {
    const int b = out.owners[static_cast<std::size_t>(m.dof_bodyid[i])];
    if (scene.bodies[static_cast<std::size_t>(b)].kind == BodyKind::kinematic) continue;
    sum += m.dof_M0[i];
    ++count;
  }
  if (count > 0) m.stat.meaninertia = sum / count;
}

/// How the axes that motors drive move: alone, and with each other.
Result<> find_motions(Program& out) {
  mjModel& m = *out.model;
  const auto count = static_cast<std::size_t>(m.nu);
  out.motions.resize(count);
  if (count == 0) return {};
  auto data = make_data(m);
  if (!data) return tl::unexpected(data.error());
  mjData& d = **data;
  std::vector<double> response(static_cast<std::size_t>(m.nv));
  if (!guarded([&] { mj_fwdPosition(&m, &d); })) return fail("MuJoCo: " + last_error());
  for (std::size_t i = 0; i < count; ++i) {
    out.motions[i].joint = m.actuator_trnid[2 * i];
    out.motions[i].inverse_inertia = m.dof_invweight0[m.jnt_dofadr[out.motions[i].joint]];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto dof = [&](std::size_t k) {
      return static_cast<std::size_t>(m.jnt_dofadr[out.motions[k].joint]);
    };
    std::fill(response.begin(), response.end(), 0.0);
    response[dof(i)] = 1.0;
    mj_solveM(&m, &d, response.data(), response.data(), 1);
    double coupling = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      coupling += std::abs(response[dof(k)]) /
                  std::sqrt(out.motions[i].inverse_inertia * out.motions[k].inverse_inertia);
    }
    if (coupling > kFreeCoupling) out.motions[i].share = 1.0 / coupling;
  }
  return {};
}

}  // namespace

Reference reference_of(const SceneModel& scene, std::size_t j, const std::vector<Pose>& poses,
                       bool attached) {
  const Joint& joint = scene.joints[j];
  const auto pose = [&](int b) {
    return b == kWorld ? Pose() : poses[static_cast<std::size_t>(b)];
  };
  const Pose X_WP = pose(joint.parent), X_WC = pose(joint.child);
  Reference out;
  double q[7] = {};
  std::copy(joint.position.begin(), joint.position.end(), q);
  if (attached) joint_position(joint, relative_pose(joint, X_WP, X_WC), joint.position.data(), q);
  if (joint.type != JointType::ball && joint.type != JointType::free) {
    std::transform(q, q + position_count(joint.type), out.q.begin(), settled);
  }
  if (joint.type == JointType::ball) {
    out.X_PC = joint.X_PF * joint.X_CM.inverse();  // where its quaternion is one, as MuJoCo's is
  } else if (attached) {
    out.X_PC = joint.X_PF * joint_pose(joint, q) * joint.X_CM.inverse();
  } else {
    out.X_PC = joint.parent == kWorld ? X_WC : X_WP.inverse() * X_WC;
  }
  return out;
}

Result<ProgramPtr> make_program(const SceneModelPtr& scene, std::vector<Reference> references,
                                std::vector<Pose> places) {
  auto out = std::make_shared<Program>();
  out->scene = scene;
  out->references = std::move(references);
  out->places = std::move(places);
  auto options = read_options(*scene);
  if (!options) return tl::unexpected(options.error());
  out->options = *options;
  const auto mjcf = write_mjcf(*out);
  if (!mjcf) return tl::unexpected(mjcf.error());
  auto model = compile(*mjcf);
  if (!model) {
    model.error().where = place_of(*scene, scene->physics.origin);
    return tl::unexpected(model.error());
  }
  out->model = std::move(*model);
  find_places(*out);
  complete_model(*out);
  if (auto found = find_motions(*out); !found) return tl::unexpected(found.error());
  return ProgramPtr(std::move(out));
}

}  // namespace cogrsim::mujoco

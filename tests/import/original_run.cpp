#include "original_run.h"

#include <mujoco/mujoco.h>

#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/import_model.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::test {

namespace {

struct Free {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
  void operator()(mjData* d) const { mj_deleteData(d); }
};

bool is_urdf(const std::string& path) { return std::filesystem::path(path).extension() == ".urdf"; }

/// Whether a name of the scene is that of the file: characters that a scene does not take are others,
/// and a joint that is called as a body has an ending.
bool is_named(const std::string& in_scene, const char* there) {
  if (there == nullptr) return false;
  const std::string own = in_scene.substr(in_scene.rfind('.') + 1);
  std::string wanted = there;
  for (char& c : wanted)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
  return own == wanted || own == wanted + "_joint";
}

/// The options of the file's solver.
Parameters options_of(const mjModel& m) {
  Parameters out;
  const char* const integrators[] = {"Euler", "RK4", "implicit"};
  const char* const solvers[] = {"PGS", "CG", "Newton"};
  out["integrator"] = std::string(integrators[m.opt.integrator]);
  out["solver"] = std::string(solvers[m.opt.solver]);
  out["cone"] = std::string(m.opt.cone == mjCONE_ELLIPTIC ? "elliptic" : "pyramidal");
  out["iterations"] = std::int64_t{m.opt.iterations};
  out["tolerance"] = m.opt.tolerance;
  out["noslip-iterations"] = std::int64_t{m.opt.noslip_iterations};
  out["impratio"] = m.opt.impratio;
  return out;
}

/// The import, with the controls that the original starts with.
Result<SceneModelPtr> imported(const std::string& path, const std::string& keyframe,
                               const mjModel& m, const mjData& d,
                               const std::shared_ptr<PluginLoader>& loader) {
  dsl::ImportOptions options;
  options.keyframe = keyframe;
  options.floor = false;
  options.refer = true;
  // MuJoCo holds the root of a URDF, and reads no drives of it.
  options.fixed_base = is_urdf(path);
  options.scene_folder = std::filesystem::absolute(path).parent_path().string();
  const dsl::ImportResult read = dsl::import_model(path, options);
  if (read.scene.empty()) return fail("import: " + dsl::to_text(read.diagnostics));
  dsl::LoaderCatalog catalog(loader);
  dsl::CompileOptions compile;
  compile.plugins = &catalog;
  const dsl::CompileResult compiled =
      dsl::compile_text(read.scene, options.scene_folder + "/imported.scene.xml", compile);
  if (!compiled.ok()) return fail("the imported scene: " + dsl::to_text(compiled.diagnostics));
  auto model = std::make_shared<SceneModel>(*compiled.model);
  if (is_urdf(path)) model->motors.clear();
  for (Motor& motor : model->motors) {
    const std::string& joint = model->joints[std::size_t(motor.joint)].name;
    for (int a = 0; a < m.nu; ++a) {
      const char* const there = mj_id2name(&m, mjOBJ_JOINT, m.actuator_trnid[2 * a]);
      if (m.actuator_trntype[a] == mjTRN_JOINT && is_named(joint, there)) motor.target = d.ctrl[a];
    }
  }
  model->physics.step = m.opt.timestep;
  // Those that the import has itself stay.
  model->physics.engine_options["mujoco"].merge(options_of(m));
  return SceneModelPtr(std::move(model));
}

}  // namespace

Result<OriginalRun> run_beside_original(const std::string& path, const std::string& keyframe,
                                        double seconds) {
  char error[1000] = "";
  const std::unique_ptr<mjModel, Free> m(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
  if (!m) return fail(std::string("MuJoCo: ") + error);
  const std::unique_ptr<mjData, Free> d(mj_makeData(m.get()));
  if (!keyframe.empty()) {
    const int key = mj_name2id(m.get(), mjOBJ_KEY, keyframe.c_str());
    if (key < 0) return fail("there is no keyframe '" + keyframe + "'");
    mj_resetDataKeyframe(m.get(), d.get(), key);
  }
  const auto loader = std::make_shared<PluginLoader>();
  const auto model = imported(path, keyframe, *m, *d, loader);
  if (!model) return tl::unexpected(model.error());
  SimulationOptions options;
  options.backend = "mujoco";
  auto simulation = Simulation::create(*model, options, loader);
  if (!simulation) return tl::unexpected(to_error(*first_error(simulation.error())));

  OriginalRun out;
  out.steps = static_cast<int>(std::lround(seconds / m->opt.timestep));
  std::vector<const Joint*> joints(std::size_t(m->njnt));
  std::vector<int> bases(std::size_t(m->njnt), -1);
  for (int j = 0; j < m->njnt; ++j) {
    const char* const body = mj_id2name(m.get(), mjOBJ_BODY, m->jnt_bodyid[j]);
    const char* const name = mj_id2name(m.get(), mjOBJ_JOINT, j);
    if (m->jnt_type[j] == mjJNT_FREE) {
      for (std::size_t b = 0; b < (*model)->bodies.size(); ++b)
        if (is_named((*model)->bodies[b].name, body)) bases[std::size_t(j)] = static_cast<int>(b);
      continue;
    }
    if (m->jnt_type[j] == mjJNT_BALL) continue;
    for (const Joint& joint : (*model)->joints)
      if (is_named(joint.name, name) && position_count(joint.type) == 1)
        joints[std::size_t(j)] = &joint;
    ++(joints[std::size_t(j)] ? out.joints : out.missing);
  }
  // A URDF has no start: both begin where the import does, within the limits.
  const FramePtr first = (*simulation)->frame();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!joints[j] || !is_urdf(path)) continue;
    d->qpos[m->jnt_qposadr[j]] =
        first->state.joint_positions[std::size_t(joints[j]->position_offset)];
  }
  for (int step = 0; step < out.steps; ++step) {
    mj_step(m.get(), d.get());
    if ((*simulation)->step() == RunStatus::diverged) return fail("the import diverged");
    out.touching = std::max(out.touching, d->ncon);
    const FramePtr frame = (*simulation)->frame();
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const double* const there = d->qpos + m->jnt_qposadr[j];
      if (bases[j] >= 0) {
        const Pose& X = frame->state.poses[std::size_t(bases[j])];
        const Quat q = Quat(there[3], there[4], there[5], there[6]).normalized();
        out.base_apart = std::max(
            {out.base_apart, (X.p - Vec3(there[0], there[1], there[2])).cwiseAbs().maxCoeff(),
             (X.q.toRotationMatrix() - q.toRotationMatrix()).cwiseAbs().maxCoeff()});
      }
      if (!joints[j]) continue;
      // Ours are zero where the model is drawn, theirs are `ref` there.
      const auto offset = std::size_t(joints[j]->position_offset);
      const double apart =
          std::abs(frame->state.joint_positions[offset] - (*there - m->qpos0[m->jnt_qposadr[j]]));
      if (apart <= out.apart) continue;
      out.apart = apart;
      out.furthest = joints[j]->name;
    }
  }
  return out;
}

}  // namespace cogrsim::test

#include "engine.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

namespace cogrsim::mujoco {

namespace {

void on_error(const char* message) {
  if (std::strstr(message, "ould not allocate")) throw std::bad_alloc();
  throw EngineError(message);
}

/// Called by MuJoCo before it looks for forces. The solref of contacts that bounce has next to no
/// damping, by which friction would not act on what slides: its rows get the damping of others.
/// That solref, and by its stiffness which contacts bounce, our models have in options that are
/// unused without the flag `override`.
void keep_friction(const mjModel* m, mjData* d) {
  const mjtNum* const usual = m->opt.o_solref;
  for (int i = 0; i < (m->opt.o_margin < 0 ? d->ncon : 0); ++i) {
    const mjContact& it = d->contact[i];
    if (it.efc_address < 0 || it.dim == 1 || it.solref[0] != m->opt.o_solimp[0]) continue;
    const mjtNum wanted = usual[0] > 0
                              ? 2 / (it.solimp[1] * std::max(usual[0], 2 * m->opt.timestep))
                              : -usual[1] / it.solimp[1];
    const mjtNum missing = std::max(0.0, wanted - d->efc_KBIP[4 * it.efc_address + 1]);
    mjtNum* const aref = d->efc_aref + it.efc_address;
    const mjtNum* const vel = d->efc_vel + it.efc_address;
    const bool elliptic = d->efc_type[it.efc_address] == mjCNSTR_CONTACT_ELLIPTIC;
    for (int k = 0; k + 1 < it.dim; ++k) {
      const int a = elliptic ? k + 1 : 2 * k;
      const mjtNum slip = elliptic ? vel[a] : (vel[a] - vel[a + 1]) / 2;  // times the friction
      aref[a] -= missing * slip;
      if (!elliptic) aref[a + 1] += missing * slip;
    }
  }
}

void on_warning(const char*) {}  // mjData::warning counts them, and is read after each step

}  // namespace

void install_handlers() {
  mju_user_error = on_error;
  mju_user_warning = on_warning;
  mjcb_control = keep_friction;
  // The program may use MuJoCo after this library has been unloaded.
  static const std::shared_ptr<void> installed(nullptr, [](void*) {
    mju_user_error = mju_user_warning = nullptr;
    mjcb_control = nullptr;
  });
}

Result<ModelOwner> compile(const std::string& mjcf) {
  if (mj_version() != mjVERSION_HEADER)
    return fail("built for another MuJoCo than " + std::string(mj_versionString()) +
                ": build again");
  const auto files = std::make_unique<mjVFS>();  // 2 MB, too much for a stack
  mj_defaultVFS(files.get());
  char problem[1000] = "";
  ModelOwner model;
  const auto done = guarded([&] {
#if mjVERSION_HEADER < 320
    mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(mjcf.size()));
    std::copy(mjcf.begin(), mjcf.end(), static_cast<char*>(files->filedata[0]));
#else
    mj_addBufferVFS(files.get(), "scene.xml", mjcf.data(), static_cast<int>(mjcf.size()));
#endif
    model.reset(mj_loadXML("scene.xml", files.get(), problem, sizeof problem));
  });
  mj_deleteVFS(files.get());
  if (!done) return tl::unexpected(done.error());
  mj_freeLastXML();
  if (!model) return fail(std::string("MuJoCo: ") + problem);
  return model;
}

Result<DataOwner> make_data(const mjModel& model) {
  mjData* data = nullptr;
  if (auto made = guarded([&] { data = mj_makeData(&model); }); !made)
    return tl::unexpected(made.error());
  if (!data)
    return fail("MuJoCo counts the bytes of its matrices in 31 bits, and this scene has " +
                std::to_string(model.nv) + " degrees of freedom and " +
                std::to_string(model.njmax) + " constraint rows: more than 2 GB");
  return DataOwner(data);
}

}  // namespace cogrsim::mujoco

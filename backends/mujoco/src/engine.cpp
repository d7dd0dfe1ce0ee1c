#include "engine.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace cogrsim::mujoco {

namespace {

void on_error(const char* message) {
  if (std::strstr(message, "ould not allocate")) throw std::bad_alloc();
  throw EngineError(message);
}

void on_warning(const char*) {}  // mjData::warning counts them, and is read after each step

}  // namespace

void install_handlers() {
  mju_user_error = on_error;
  mju_user_warning = on_warning;
}

Result<ModelOwner> compile(const std::string& mjcf) {
  const auto files = std::make_unique<mjVFS>();  // 2 MB, too much for a stack
  mj_defaultVFS(files.get());
  char problem[1000] = "";
  ModelOwner model;
  const auto done = guarded([&] {
    mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(mjcf.size()));
    std::copy(mjcf.begin(), mjcf.end(), static_cast<char*>(files->filedata[0]));
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
  if (!data) {
    return fail("MuJoCo counts the bytes of its matrices in 31 bits, and this scene has " +
                std::to_string(model.nv) + " degrees of freedom and " +
                std::to_string(model.njmax) + " constraint rows: more than 2 GB");
  }
  return DataOwner(data);
}

}  // namespace cogrsim::mujoco

#include "engine.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <new>

namespace cogrsim::mujoco {

namespace {

thread_local std::jmp_buf* t_way_out = nullptr;
thread_local char t_message[1000] = "";

/// Thrown where nobody called guarded(): in MuJoCo's compiler, which is C++ itself and unwinds.
struct EngineError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void on_error(const char* message) {
  std::strncpy(t_message, message, sizeof t_message - 1);
  if (t_way_out) std::longjmp(*t_way_out, 1);
  throw EngineError(t_message);
}

void on_warning(const char*) {}  // mjData::warning counts them, and that is looked at

void throw_if_no_memory(const char* message) {
  if (std::strstr(message, "ould not allocate")) throw std::bad_alloc();
}

}  // namespace

void install_handlers() {
  mju_user_error = on_error;
  mju_user_warning = on_warning;
}

bool guarded(void (*call)(void*), void* context) {
  std::jmp_buf here;
  if (setjmp(here) != 0) {
    t_way_out = nullptr;
    throw_if_no_memory(t_message);
    return false;
  }
  t_way_out = &here;
  call(context);
  t_way_out = nullptr;
  return true;
}

const std::string& last_error() {
  thread_local std::string text;
  text = t_message;
  return text;
}

Result<ModelOwner> compile(const std::string& mjcf) {
  const auto files = std::make_unique<mjVFS>();  // 2 MB, too much for a stack
  mj_defaultVFS(files.get());
  char problem[1000] = "";
  ModelOwner model;
  try {
    mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(mjcf.size()));
    std::copy(mjcf.begin(), mjcf.end(), static_cast<char*>(files->filedata[0]));
    model.reset(mj_loadXML("scene.xml", files.get(), problem, sizeof problem));
  } catch (const EngineError& error) {
    mj_deleteVFS(files.get());
    throw_if_no_memory(error.what());
    return fail(std::string("MuJoCo: ") + error.what());
  }
  mj_deleteVFS(files.get());
  mj_freeLastXML();
  if (model) return model;
  throw_if_no_memory(problem);
  return fail(std::string("MuJoCo: ") + problem);
}

Result<DataOwner> make_data(const mjModel& model) {
  mjData* data = nullptr;
  if (!guarded([&] { data = mj_makeData(&model); })) return fail("MuJoCo: " + last_error());
  if (!data) {
    return fail("MuJoCo counts the bytes of its matrices in 31 bits, and this scene has " +
                std::to_string(model.nv) + " degrees of freedom and " +
                std::to_string(model.njmax) + " conditions: more than 2 GB");
  }
  return DataOwner(data);
}

}  // namespace cogrsim::mujoco

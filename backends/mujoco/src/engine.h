// MuJoCo's memory and its errors: what would end the process comes back as a value.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::mujoco {

static_assert(sizeof(mjtNum) == sizeof(double), "MuJoCo must be built for double precision");

struct DeleteModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DeleteData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelOwner = std::unique_ptr<mjModel, DeleteModel>;
using DataOwner = std::unique_ptr<mjData, DeleteData>;

/// Thrown by MuJoCo's error handler, which must not return. MuJoCo's functions in C have unwind
/// tables on all 64-bit platforms and own nothing that unwinding would have to release.
struct EngineError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Takes MuJoCo's handlers of errors and warnings, which are one for the whole process. To be called
/// before anything else of MuJoCo.
void install_handlers();

/// Calls `call()`. Errors: MuJoCo's. Throws std::bad_alloc where MuJoCo had no memory.
template <class Call>
Result<> guarded(Call&& call) {
  try {
    call();
  } catch (const EngineError& error) {
    return fail(std::string("MuJoCo: ") + error.what());
  }
  return {};
}

/// Compiles MJCF. Errors: what MuJoCo says.
Result<ModelOwner> compile(const std::string& mjcf);

/// Errors: no such data can be made, as the model is too large.
Result<DataOwner> make_data(const mjModel& model);

}  // namespace cogrsim::mujoco

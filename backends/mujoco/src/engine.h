// MuJoCo's memory and its errors: what it would print and end the process with comes back as a value.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
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

/// Takes MuJoCo's handlers of errors and warnings, which are one for the whole process. To be called
/// before anything else of MuJoCo.
void install_handlers();

/// Calls `call(context)`, which must do nothing but call MuJoCo's C functions: an error of MuJoCo's
/// leaves it by longjmp. False: there was one, see last_error(). Throws std::bad_alloc where MuJoCo
/// had no memory.
bool guarded(void (*call)(void*), void* context);

template <class Call>
bool guarded(Call&& call) {
  return guarded([](void* context) { (*static_cast<Call*>(context))(); }, &call);
}

/// What MuJoCo found last on this thread.
const std::string& last_error();

/// Compiles MJCF. Errors: what MuJoCo says.
Result<ModelOwner> compile(const std::string& mjcf);

/// Errors: no such data can be made, as the model is too large.
Result<DataOwner> make_data(const mjModel& model);

}  // namespace cogrsim::mujoco

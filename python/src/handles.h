// What Python controllers, supervisors and sensors are given. Each object can be used only inside the
// calls of its owner, so that none outlives what it refers to.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "cogrsim/assembly/assembly.h"
#include "common.h"

namespace cogrsim::python {

/// Whether a call into a plugin is under way.
struct Gate {
  bool open = false;
  bool configuring = false;  ///< in configure(), where the SDK collects names that do not exist
  std::thread::id thread;
  std::uint64_t call = 0;  ///< number of the call that opened it
  void check(const std::string& what) const;
};
using GatePtr = std::shared_ptr<Gate>;

/// Opens a gate for the duration of a call.
class Opening {
 public:
  explicit Opening(Gate& gate) : gate_(gate), before_(gate) {
    static std::atomic<std::uint64_t> calls = 0;
    gate_.open = true;
    gate_.call = ++calls;
    gate_.thread = std::this_thread::get_id();
  }
  ~Opening() { gate_ = before_; }
  Opening(const Opening&) = delete;
  Opening& operator=(const Opening&) = delete;

 private:
  Gate& gate_;
  Gate before_;
};

using TablePtr = std::shared_ptr<const ParameterTable>;

struct PyAssembly {
  Assembly assembly;
  GatePtr gate;
  TablePtr table;
};

py::object to_python(const ParameterValue& value);

/// Calls Python code of a plugin. An exception becomes std::runtime_error with its traceback.
template <class Function>
void call_python(Gate& gate, Function&& function) {
  const Lock lock;
  const Opening opening(gate);
  std::string failure;
  try {
    function();
  } catch (py::error_already_set& error) {
    failure = exception_text(error);
  } catch (const py::cast_error& error) {
    failure = error.what();
  }
  if (!failure.empty()) throw std::runtime_error(failure);
}

}  // namespace cogrsim::python

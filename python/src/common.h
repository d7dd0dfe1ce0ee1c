// Helpers of all binding files: errors, locks, and conversions with checks.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/result.h"
#include "cogrsim/core/types.h"

namespace cogrsim::python {

namespace py = pybind11;

/// A text that may quote bytes of a file that are no UTF-8.
py::str shown(const std::string& text);
/// Raises cogrsim.TYPE(text, diagnostics).
[[noreturn]] void raise(const char* type, const std::string& text,
                        const std::vector<Diagnostic>& diagnostics = {});
[[noreturn]] void raise(const Error& error);
/// Raises cogrsim.TYPE with the diagnostics in compiler style.
[[noreturn]] void raise(const char* type, const std::vector<Diagnostic>& diagnostics);

/// The value of a Result, or its error as cogrsim.Error.
template <class T>
T value_of(Result<T>&& result) {
  if (!result) raise(result.error());
  return std::move(*result);
}
inline void check(const Result<>& result) {
  if (!result) raise(result.error());
}

/// A method whose object pybind11 holds in a shared_ptr: it refuses one that was not constructed.
template <class T, class R, class... A>
auto held(R (*method)(T&, A...)) {
  return [method](const std::shared_ptr<std::remove_const_t<T>>& self, A... arguments) -> R {
    return method(*self, std::forward<A>(arguments)...);
  };
}

/// The interpreter ends: calls of other threads that step raise SystemExit from now on, which ends a thread
/// without a word: one that prints while the interpreter ends would end the process by a signal. Waits for
/// the calls that are under way, 5 s at most; those of which some are left then sleep until the process ends,
/// as a thread that takes the lock of an interpreter that is gone would end it.
void end_calls();
/// Whether another thread has called end_calls().
bool ends_elsewhere();
/// Raises SystemExit then.
void refuse_at_exit();
/// Number of calls under way.
extern std::atomic<int> calls_under_way;

/// The interpreter's lock, in a thread that may not have it.
class Lock {
 public:
  Lock();

 private:
  std::optional<py::gil_scoped_acquire> lock_;
};

/// Without the interpreter's lock, in a call for which end_calls() waits. Raises SystemExit as
/// refuse_at_exit() does.
class Unlock {
 public:
  Unlock();
  ~Unlock();
  Unlock(const Unlock&) = delete;
  Unlock& operator=(const Unlock&) = delete;

 private:
  std::optional<py::gil_scoped_release> unlock_;
};

/// Number of fork()s that lead to this process, which has none of the threads from before them.
extern std::atomic<int> forks;
/// Counts them from now on.
void count_forks();

/// "'a', 'b', 'c' and 12 more".
std::string list_of(const std::vector<std::string>& names);
/// Raises KeyError: "there is no WHAT 'name'", with the nearest names or those that exist.
[[noreturn]] void raise_unknown(const std::string& what, const std::string& name,
                                const std::vector<std::string>& names);

/// A Python object that threads without the interpreter's lock may own.
using Held = std::shared_ptr<py::object>;
Held hold(py::object object);

/// While it exists, a KeyboardInterrupt inside a callback of this thread waits for check(), and the
/// callbacks until then run as ever.
class InterruptLater {
 public:
  InterruptLater();
  ~InterruptLater();
  InterruptLater(const InterruptLater&) = delete;
  InterruptLater& operator=(const InterruptLater&) = delete;

  bool waiting() const { return waiting_; }
  /// Raises one that waits, or that of a signal. The caller holds the interpreter's lock.
  void check();

 private:
  friend void interrupted();
  bool waiting_ = false;
  InterruptLater* outer_;
};

/// Passes on a KeyboardInterrupt that a callback ended with.
void interrupted();

/// The message of the current Python exception with its traceback. A KeyboardInterrupt is handed to
/// interrupted(), and the result is then empty.
std::string exception_text(py::error_already_set& error);

std::string type_name(const py::handle& value);
/// A text in UTF-8. Raises TypeError, ValueError.
std::string text_of(const py::handle& given, const std::string& name);

/// A path as text; accepts str, bytes and os.PathLike. Raises TypeError, ValueError.
std::string path_of(const py::object& path);

/// An array of numbers as float64 in C order, after a check of its type and shape. A size of -1
/// stands for any. Errors: TypeError, ValueError with what is expected and what was given.
py::array_t<double> numbers(const py::object& given, const std::string& name,
                            std::initializer_list<py::ssize_t> shape);
Vec3 vector_of(const py::object& given, const std::string& name);
/// A quaternion w x y z of any length but zero; None: no rotation.
Quat quaternion_of(const py::object& given, const std::string& name);
Pose pose_of(const py::object& position, const py::object& orientation);
py::tuple to_python(const Vec3& v);
py::tuple to_python(const Quat& q);  // w x y z

/// A read-only view of memory that `owner` keeps alive.
py::array view(const py::dtype& type, std::vector<py::ssize_t> shape,
               std::vector<py::ssize_t> strides, const void* data, const py::object& owner);
/// A read-only array that owns `values`.
py::array owned(std::vector<double> values, std::vector<py::ssize_t> shape);
/// A read-only array (n, 3) of its own.
py::array rows_of(const std::vector<Vec3>& vectors);
/// Name of a view's owner in Python.
py::object owner_of(std::shared_ptr<const void> memory);

void bind_batch(py::module_& m);
void bind_controllers(py::module_& m);
void bind_frame(py::module_& m);
void bind_frame_views(py::module_& m);
void bind_handles(py::module_& m);
void bind_import(py::module_& m);
void bind_recording(py::module_& m);
void bind_rendering(py::module_& m);
void bind_scene(py::module_& m);
void bind_signals(py::module_& m);
void bind_simulation(py::module_& m);
void bind_supervisors(py::module_& m);

}  // namespace cogrsim::python

#include "common.h"

#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::python {

py::str shown(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
}

void raise(const char* type, const std::string& text, const std::vector<Diagnostic>& diagnostics) {
  const py::object cls = py::module_::import("cogrsim._errors").attr(type);
  PyErr_SetObject(cls.ptr(), cls(shown(printable(text)), py::cast(diagnostics)).ptr());
  throw py::error_already_set();
}

void raise(const Error& error) {
  std::string text = error.text();
  constexpr std::string_view kOption = "--overwrite";
  if (const std::size_t at = text.find(kOption); at != std::string::npos)
    text.replace(at, kOption.size(), "overwrite=True");
  if (!error.code.empty()) text = "[" + error.code + "] " + text;
  raise("Error", text, {to_diagnostic(error)});
}

void raise(const char* type, const std::vector<Diagnostic>& diagnostics) {
  raise(type, dsl::to_text(diagnostics), diagnostics);
}

std::string type_name(const py::handle& value) {
  return py::type::handle_of(value).attr("__name__").cast<std::string>();
}

std::string text_of(const py::handle& given, const std::string& name) {
  if (!py::isinstance<py::str>(given))
    throw py::type_error(name + ": expected a text, given " + type_name(given));
  py::ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(given.ptr(), &size);
  if (text == nullptr) throw py::error_already_set();  // a ValueError: half of a surrogate pair
  return {text, static_cast<std::size_t>(size)};
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 12;
  std::string out;
  for (std::size_t i = 0; i < names.size() && i < kShown; ++i) {
    out += (i == 0 ? "'" : ", '") + names[i] + "'";
  }
  if (names.size() > kShown) out += " and " + std::to_string(names.size() - kShown) + " more";
  return out;
}

void raise_unknown(const std::string& what, const std::string& name,
                   const std::vector<std::string>& names) {
  std::string text = "there is no " + what + " '" + name + "'";
  const std::string near = nearest_name(name, names);
  if (!near.empty()) text += "; did you mean '" + near + "'?";
  text += names.empty() ? "; there are none" : "; there are " + list_of(names);
  throw py::key_error(text);
}

namespace {

std::atomic<bool> at_exit = false, gone = false;  // gone: nobody may take the lock any more
std::atomic<std::thread::id> exit_thread;
std::atomic<int> locking = 0;  // threads that are about to have the lock

bool is_left_behind() { return gone && exit_thread.load() != std::this_thread::get_id(); }

template <class Take>
void take_lock(Take&& take) {
  ++locking;
  if (is_left_behind()) {
    --locking;
    while (true) ::pause();
  }
  take();
  --locking;
}

/// Whether `count` becomes 0 within 5 s, seen by the thread that has the lock.
bool becomes_none(const std::atomic<int>& count) {
  for (int i = 0; i < 500 && count > 0; ++i) {
    const py::gil_scoped_release unlock;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return count <= 0;
}

}  // namespace

Lock::Lock() {
  take_lock([&] { lock_.emplace(); });
}

Unlock::Unlock() {
  refuse_at_exit();
  ++calls_under_way;
  unlock_.emplace();
}

Unlock::~Unlock() {
  take_lock([&] { unlock_.reset(); });
  --calls_under_way;
}

Held hold(py::object object) {
  return Held(new py::object(std::move(object)), [](py::object* held) {
    if (!Py_IsInitialized() || is_left_behind()) return;  // the interpreter's objects go with it
    const Lock lock;
    delete held;
  });
}

namespace {

thread_local InterruptLater* current_interrupt = nullptr;

}  // namespace

InterruptLater::InterruptLater() : outer_(std::exchange(current_interrupt, this)) {}

InterruptLater::~InterruptLater() {
  current_interrupt = outer_;
  if (waiting_) interrupted();
}

std::atomic<int> calls_under_way = 0;
std::atomic<int> forks = 0;

void count_forks() {
  ::pthread_atfork(nullptr, nullptr, [] {
    ++forks;
    calls_under_way = locking = 0;  // of threads that stayed in the parent
  });
}

void end_calls() {
  exit_thread = std::this_thread::get_id();
  at_exit = true;
  if (becomes_none(calls_under_way)) return;
  gone = true;
  static_cast<void>(becomes_none(locking));
}

bool ends_elsewhere() { return at_exit && exit_thread.load() != std::this_thread::get_id(); }

void refuse_at_exit() {
  if (!ends_elsewhere()) return;
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

void InterruptLater::check() {
  refuse_at_exit();
  if (std::exchange(waiting_, false)) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void interrupted() {
  if (current_interrupt != nullptr) {
    current_interrupt->waiting_ = true;
  } else {
    PyErr_SetInterrupt();
  }
}

std::string exception_text(py::error_already_set& error) {
  if (error.matches(PyExc_KeyboardInterrupt)) {
    interrupted();
    return {};
  }
  try {
    const py::object lines =
        py::module_::import("traceback")
            .attr("format_exception")(error.type(), error.value(), error.trace());
    auto text = py::str("").attr("join")(lines).cast<std::string>();
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
  } catch (const std::exception&) {
    return error.what();
  }
}

std::string path_of(const py::object& path) {
  const auto bytes = py::module_::import("os").attr("fsencode")(path).cast<std::string>();
  if (bytes.find('\0') != std::string::npos)
    throw py::value_error("path: expected one without a zero byte");
  return bytes;
}

namespace {

std::string shape_text(const std::vector<py::ssize_t>& shape) {
  std::string out = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) {
    out += (i == 0 ? "" : ", ") + (shape[i] < 0 ? std::string("any") : std::to_string(shape[i]));
  }
  return out + (shape.size() == 1 ? ",)" : ")");
}

}  // namespace

py::array_t<double> numbers(const py::object& given, const std::string& name,
                            std::initializer_list<py::ssize_t> shape) {
  py::array array;
  try {
    array = py::isinstance<py::array>(given)
                ? py::reinterpret_borrow<py::array>(given)
                : py::module_::import("numpy").attr("asarray")(given).cast<py::array>();
  } catch (py::error_already_set& error) {
    throw py::type_error(name + ": expected an array of numbers of the shape " + shape_text(shape) +
                         "; " + py::str(error.value()).cast<std::string>());
  }
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') {
    throw py::type_error(name + ": expected real numbers (float64), given the dtype " +
                         py::str(array.dtype()).cast<std::string>());
  }
  std::vector<py::ssize_t> has(array.shape(), array.shape() + array.ndim());
  bool fits = has.size() == shape.size();
  for (std::size_t i = 0; fits && i < has.size(); ++i) {
    const py::ssize_t wanted = *(shape.begin() + static_cast<std::ptrdiff_t>(i));
    fits = wanted < 0 || wanted == has[i];
  }
  if (!fits) {
    throw py::value_error(name + ": expected the shape " + shape_text(shape) + ", given " +
                          shape_text(has));
  }
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

Vec3 vector_of(const py::object& given, const std::string& name) {
  const py::array_t<double> values = numbers(given, name, {3});
  return {values.at(0), values.at(1), values.at(2)};
}

Quat quaternion_of(const py::object& given, const std::string& name) {
  if (given.is_none()) return Quat(1, 0, 0, 0);
  const py::array_t<double> values = numbers(given, name, {4});
  const Quat q(values.at(0), values.at(1), values.at(2), values.at(3));
  const double norm = q.norm();
  if (!(norm > 1e-9) || !(norm < 1e9)) {
    throw py::value_error(name + ": expected a quaternion w x y z whose length is not 0");
  }
  return q.normalized();
}

Pose pose_of(const py::object& position, const py::object& orientation) {
  const Pose X{position.is_none() ? Vec3(0, 0, 0) : vector_of(position, "position"),
               quaternion_of(orientation, "orientation")};
  if (!X.p.allFinite()) throw py::value_error("position: expected finite numbers [m]");
  return X;
}

py::tuple to_python(const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); }
py::tuple to_python(const Quat& q) { return py::make_tuple(q.w(), q.x(), q.y(), q.z()); }

py::array view(const py::dtype& type, std::vector<py::ssize_t> shape,
               std::vector<py::ssize_t> strides, const void* data, const py::object& owner) {
  // An empty vector has no memory, and numpy would then allocate some of its own.
  static const double nothing = 0.0;
  py::array out(type, std::move(shape), std::move(strides), data ? data : &nothing, owner);
  py::detail::array_proxy(out.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return out;
}

py::object owner_of(std::shared_ptr<const void> memory) {
  using Memory = std::shared_ptr<const void>;
  return py::capsule(new Memory(std::move(memory)),
                     [](void* held) { delete static_cast<Memory*>(held); });
}

py::array owned(std::vector<double> values, std::vector<py::ssize_t> shape) {
  const auto memory = std::make_shared<const std::vector<double>>(std::move(values));
  std::vector<py::ssize_t> strides(shape.size());
  py::ssize_t stride = sizeof(double);
  for (std::size_t i = shape.size(); i-- > 0;) {
    strides[i] = stride;
    stride *= shape[i];
  }
  return view(py::dtype::of<double>(), std::move(shape), std::move(strides), memory->data(),
              owner_of(memory));
}

py::array rows_of(const std::vector<Vec3>& vectors) {
  std::vector<double> values;
  for (const Vec3& v : vectors) values.insert(values.end(), {v.x(), v.y(), v.z()});
  return owned(std::move(values), {static_cast<py::ssize_t>(vectors.size()), 3});
}

}  // namespace cogrsim::python

// Many worlds at once: the part of VectorEnv that calls Batch.
#include "cogrsim/simulation/batch.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "simulation.h"

namespace cogrsim::python {

namespace {

struct PyBatch {
  static constexpr const char* kWhat = "environment";
  std::vector<ScenePtr> scenes;
  std::unique_ptr<Batch> batch;
  Held buffer;  ///< of the caller, into which observations are written
  Held fixed;   ///< a weak reference, with which numpy does not resize it
  const void* written = nullptr;  ///< its memory
  Usage usage;
  std::vector<std::size_t> warned;  ///< by world: number of messages that have been looked at

  ~PyBatch() {
    if (ends_elsewhere() || (usage.made_after && *usage.made_after != forks)) {
      static_cast<void>(batch.release());  // its threads cannot be waited for
      return;
    }
    // Worker threads may wait for the interpreter's lock.
    const Unlock unlock;
    batch.reset();
  }
};
using BatchPtr = std::shared_ptr<PyBatch>;

py::array copy_of(const double* data, py::ssize_t rows, py::ssize_t columns) {
  return py::array_t<double>({rows, columns}, data);
}

/// A scene per world, each on one of the engines in turn.
std::vector<SceneModelPtr> models_of(const std::vector<ScenePtr>& scenes, int count,
                                     const std::vector<std::string>& backends) {
  std::map<std::pair<std::size_t, std::size_t>, SceneModelPtr> made;  // by scene and engine
  std::vector<SceneModelPtr> out;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const std::size_t scene = i % scenes.size();
    const std::size_t engine = i % std::max(backends.size(), std::size_t{1});
    SceneModelPtr& model = made[{scene, engine}];
    if (!model && backends.empty()) model = scenes[scene]->model;
    if (!model) {
      auto on_engine = std::make_shared<SceneModel>(*scenes[scene]->model);
      on_engine->physics.backend = backends[engine];
      model = std::move(on_engine);
    }
    out.push_back(model);
  }
  return out;
}

BatchPtr make_batch(const std::vector<py::object>& scenes, int count,
                    const std::vector<std::string>& actions,
                    const std::vector<std::string>& observations, const std::string& done,
                    const std::string& reward, const std::vector<std::string>& backends,
                    double step, int threads, const std::vector<std::uint64_t>& seeds,
                    double duration, bool auto_reset, double missing,
                    const std::vector<std::string>& without) {
  if (count < 1)
    throw py::value_error("n: expected at least 1 world, given " + std::to_string(count));
  if (count > kMostWorlds)
    throw py::value_error(
        fmt::format("n: expected at most {} worlds, given {}", kMostWorlds, count));
  auto out = std::make_shared<PyBatch>();
  for (const py::object& scene : scenes) out->scenes.push_back(scene_of(scene));
  if (out->scenes.empty()) throw py::value_error("scene: expected at least one");
  BatchOptions options;
  options.actions = actions;
  options.observations = observations;
  options.done = done;
  options.reward = reward;
  options.step = step;
  options.threads = threads;
  options.seeds = seeds;
  options.duration = duration;
  options.auto_reset = auto_reset;
  options.missing = missing;
  options.without = without;
  auto made = [&] {
    const Unlock unlock;
    return Batch::create(models_of(out->scenes, count, backends), options,
                         out->scenes.front()->loader);
  }();
  if (!made) raise("Error", made.error());
  out->batch = std::move(*made);
  out->usage.made_after = forks;
  return out;
}

int checked_world(const PyBatch& self, int world) {
  if (world >= 0 && world < self.batch->size()) return world;
  throw py::index_error("there is no world " + std::to_string(world) + "; there are " +
                        std::to_string(self.batch->size()));
}

void set_actions(PyBatch& self, const py::object& given) {
  Batch::Table table = self.batch->actions();
  const py::array_t<double> values = numbers(given, "actions", {table.rows(), table.cols()});
  const double* const data = values.data();
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    if (std::isfinite(data[i])) continue;
    throw py::value_error("actions: expected finite numbers; world " +
                          std::to_string(i / table.cols()) + " has " + std::to_string(data[i]));
  }
  std::copy_n(data, table.size(), table.data());
}

/// What is wrong with an array as a table of observations; empty: nothing.
std::string trouble_of(const py::array& array, const Batch::ConstTable& table) {
  if (array.ndim() != 2 || array.shape(0) != table.rows() || array.shape(1) != table.cols())
    return "the shape " + py::str(array.attr("shape")).cast<std::string>();
  if (!array.writeable() || (array.flags() & py::array::c_style) == 0)
    return "one that is read-only or has gaps";
  return {};
}

std::string expected_buffer(const Batch::ConstTable& table) {
  return fmt::format(
      "buffer: expected a writeable, C-contiguous float64 array of the shape ({}, {})",
      table.rows(), table.cols());
}

/// The caller may have changed its array since observe_into().
void check_buffer(PyBatch& self) {
  if (!self.buffer) return;
  const auto array = self.buffer->cast<py::array>();
  const Batch::ConstTable table = self.batch->observations();
  std::string trouble = trouble_of(array, table);
  if (trouble.empty() && array.data() != self.written) trouble = "one with other memory";
  if (!trouble.empty())
    throw py::value_error(expected_buffer(table) +
                          ", and the array of observe_into() has changed: it is now " + trouble);
}

void step(PyBatch& self, const py::object& actions, int steps) {
  if (steps < 1)
    throw py::value_error("steps: expected at least 1, given " + std::to_string(steps));
  const Use use(self);
  check_buffer(self);
  if (!actions.is_none()) set_actions(self, actions);
  {
    const Unlock unlock;
    self.batch->step(steps);
  }
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void reset(PyBatch& self, const std::vector<std::uint64_t>& seeds, const std::vector<int>& worlds) {
  const Use use(self);
  check_buffer(self);
  if (!seeds.empty() && seeds.size() != worlds.size()) {
    throw py::value_error("seed: expected " + std::to_string(worlds.size()) + " seeds, given " +
                          std::to_string(seeds.size()));
  }
  for (const int world : worlds) checked_world(self, world);
  const Unlock unlock;
  if (seeds.empty() && worlds.size() == static_cast<std::size_t>(self.batch->size())) {
    self.batch->reset_all();
    return;
  }
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const auto done = self.batch->reset(
        worlds[i], seeds.empty() ? std::optional<std::uint64_t>() : std::optional(seeds[i]));
    if (done) continue;
    const Lock lock;
    raise(done.error());
  }
}

void observe_into(PyBatch& self, const py::object& buffer) {
  const Use use(self);
  if (buffer.is_none()) {
    self.batch->observe_into(nullptr);
    self.buffer.reset();
    self.fixed.reset();
    return;
  }
  const Batch::ConstTable table = self.batch->observations();
  const std::string expected = expected_buffer(table);
  if (!py::isinstance<py::array>(buffer)) throw py::type_error(expected);
  const auto array = buffer.cast<py::array>();
  if (!array.dtype().is(py::dtype::of<double>())) {
    throw py::type_error(expected + ", given the dtype " +
                         py::str(array.dtype()).cast<std::string>());
  }
  if (const std::string trouble = trouble_of(array, table); !trouble.empty())
    throw py::value_error(expected + ", given " + trouble);
  self.batch->observe_into(static_cast<double*>(py::array(array).mutable_data()));
  self.buffer = hold(buffer);
  self.fixed = hold(py::weakref(buffer));
  self.written = array.data();
}

py::object observations(PyBatch& self) {
  const Use use(self);
  if (self.buffer) return *self.buffer;
  const Batch::ConstTable table = self.batch->observations();
  return copy_of(table.data(), table.rows(), table.cols());
}

template <class T, class Test>
py::array_t<T> of_worlds(const std::vector<EpisodeEnd>& ends, Test&& test) {
  py::array_t<T> out(static_cast<py::ssize_t>(ends.size()));
  std::transform(ends.begin(), ends.end(), out.mutable_data(), test);
  return out;
}

/// Shows new errors of the worlds as RunWarning, but for those whose episode ended: infos have the reason.
void warn_of_worlds(PyBatch& self) {
  self.warned.resize(static_cast<std::size_t>(self.batch->size()), 0);
  std::vector<std::string> errors;
  for (int i = 0; i < self.batch->size(); ++i) {
    const std::vector<std::string> found = new_errors(self.batch->world(i), self.warned[i]);
    if (self.batch->ends()[i] != EpisodeEnd::none) continue;
    for (const std::string& text : found)
      errors.push_back(self.batch->size() == 1 ? text : fmt::format("world {}: {}", i, text));
  }
  warn(errors);
}

/// Steps, and gives (observations, rewards, terminated, truncated, whether any episode has ended).
py::tuple advance_worlds(PyBatch& self, const py::object& actions, int steps) {
  step(self, actions, steps);
  const py::object seen = observations(self);
  {
    const Use use(self);
    warn_of_worlds(self);
  }
  const Use use(self);
  const std::vector<EpisodeEnd>& ends = self.batch->ends();
  const std::vector<double>& rewards = self.batch->rewards();
  return py::make_tuple(
      seen, py::array_t<double>(static_cast<py::ssize_t>(rewards.size()), rewards.data()),
      of_worlds<bool>(
          ends, [](EpisodeEnd end) { return end != EpisodeEnd::none && end != EpisodeEnd::time; }),
      of_worlds<bool>(ends, [](EpisodeEnd end) { return end == EpisodeEnd::time; }),
      std::any_of(ends.begin(), ends.end(),
                  [](EpisodeEnd end) { return end != EpisodeEnd::none; }));
}

}  // namespace

void bind_batch(py::module_& m) {
  py::class_<PyBatch, BatchPtr>(m, "_Batch")
      .def(py::init(&make_batch), py::arg("scenes"), py::arg("n"), py::arg("actions"),
           py::arg("observations"), py::arg("done"), py::arg("reward"), py::arg("backends"),
           py::arg("step"), py::arg("threads"), py::arg("seeds"), py::arg("duration"),
           py::arg("auto_reset"), py::arg("missing"), py::arg("without"))
      .def("step", held(&step), py::arg("actions"), py::arg("steps"))
      .def("advance", held(&advance_worlds), py::arg("actions"), py::arg("steps"))
      .def("reset", held(&reset), py::arg("seeds"), py::arg("worlds"))
      .def("observe_into", held(&observe_into), py::arg("buffer"))
      .def("observations", held(&observations))
      .def("final_observations", held(+[](PyBatch& s) {
             const Use use(s);
             const Batch::ConstTable table = s.batch->final_observations();
             return copy_of(table.data(), table.rows(), table.cols());
           }))
      .def("actions", held(+[](PyBatch& s) {
             const Use use(s);
             const Batch::Table table = s.batch->actions();
             return copy_of(table.data(), table.rows(), table.cols());
           }))
      .def("ends", held(+[](PyBatch& s) {
             const Use use(s);
             std::vector<const char*> out;
             for (const EpisodeEnd end : s.batch->ends()) out.push_back(to_string(end));
             return out;
           }))
      .def("end_message", held(+[](PyBatch& s, int world) {
             const Use use(s);
             return s.batch->end_message(checked_world(s, world));
           }))
      .def("seed", held(+[](PyBatch& s, int world) {
             const Use use(s);
             return s.batch->seed(checked_world(s, world));
           }))
      .def("frame", held(+[](PyBatch& s, int world) {
             const Use use(s);
             return to_python(s.batch->world(checked_world(s, world)).frame());
           }))
      .def("messages", held(+[](PyBatch& s, int world) {
             const Use use(s);
             return s.batch->world(checked_world(s, world)).messages();
           }))
      .def("backend", held(+[](PyBatch& s, int world) {
             const Use use(s);
             return s.batch->world(checked_world(s, world)).backend().name();
           }))
      .def_property_readonly("dt", held(+[](PyBatch& s) {
                               const Use use(s);
                               return s.batch->world(0).dt();
                             }))
      .def_property_readonly("size", held(+[](const PyBatch& s) { return s.batch->size(); }))
      .def_property_readonly("threads", held(+[](const PyBatch& s) { return s.batch->threads(); }));
}

}  // namespace cogrsim::python

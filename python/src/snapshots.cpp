// Snapshots: in memory, as bytes, in files.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "cogrsim/simulation/snapshot_file.h"
#include "simulation.h"

namespace cogrsim::python {

namespace {

namespace fs = std::filesystem;

struct PySnapshot {
  ScenePtr scene;  // keeps the engine loaded, whose objects the snapshot owns
  SimulationSnapshotPtr snapshot;
  double time = 0.0;
};

/// A folder of its own that is removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "cogrsim-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      raise("Error", "no folder can be made in '" + fs::temp_directory_path().string() + "'");
    }
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::string file() const { return (path_ / "run.snapshot").string(); }

 private:
  fs::path path_;
};

void write(Session& session, const std::string& path, bool overwrite) {
  const Use use(session);
  OutputRules rules;
  rules.overwrite = overwrite;
  rules.inputs = session.scene->files;
  check(write_snapshot(*session.simulation, path, session.scene->set, rules));
}

py::bytes bytes_of(const SessionPtr& session) {
  const ScratchFolder folder;
  write(*session, folder.file(), false);
  std::ifstream in(folder.file(), std::ios::binary);
  return py::bytes(
      std::string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()));
}

SnapshotFile file_of(const py::object& snapshot) {
  if (!py::isinstance<py::bytes>(snapshot)) return value_of(SnapshotFile::read(path_of(snapshot)));
  const ScratchFolder folder;
  std::ofstream(folder.file(), std::ios::binary) << snapshot.cast<std::string>();
  return value_of(SnapshotFile::read(folder.file()));
}

SessionPtr resumed(const py::object& snapshot, const py::object& scene, const py::object& backend,
                   double step, const std::optional<std::uint64_t>& seed, double speed,
                   const std::string& isolation, std::vector<std::string> without) {
  const SnapshotFile file = file_of(snapshot);
  auto session = std::make_shared<Session>();
  session->scene = scene_of(scene);
  SimulationOptions options =
      simulation_options(backend, step, seed, speed, isolation, std::move(without));
  if (backend.is_none()) options.backend = file.info().backend;
  if (!seed) options.seed = file.info().seed;
  if (step == 0.0) options.step = file.info().step;
  auto made = [&] {
    const Unlock unlock;
    return resume(file, session->scene->model, options, session->scene->loader);
  }();
  if (!made) raise("Error", made.error());
  session->simulation = std::move(made->simulation);
  session->notes = std::move(made->notes);
  return session;
}

}  // namespace

void bind_snapshots(py::module_& m, py::class_<Session, SessionPtr>& type) {
  py::class_<PySnapshot>(m, "Snapshot", "The state of a run at a step boundary, in memory.")
      .def("__repr__", [](const PySnapshot& s) {
        return fmt::format("<Snapshot of '{}' at {:.6g} s>", s.scene->model->name, s.time);
      });
  type.def(
          "save",
          [](const SessionPtr& session) {
            const Use use(*session);
            return PySnapshot{session->scene, session->simulation->save(),
                              session->simulation->time()};
          },
          "The state of the run as a Snapshot in memory, without the inner state of controllers.")
      .def(
          "restore",
          [](const SessionPtr& session, const PySnapshot& snapshot, bool restart_controllers) {
            const Use use(*session);
            Result<> done = [&]() -> Result<> {
              const Unlock unlock;
              return session->simulation->restore(snapshot.snapshot, restart_controllers);
            }();
            check(done);
          },
          py::arg("snapshot"), py::kw_only(), py::arg("restart_controllers") = false,
          "Return to a Snapshot of this scene and engine. Controllers keep their inner state, or "
          "are\n"
          "created again. Raises Error: it is from another scene or engine.")
      .def("save_bytes", &bytes_of,
           "The state of the run, with that of controllers, as bytes: the contents of a snapshot "
           "file,\n"
           "for cogrsim.resume() and `cogrsim run --from`.")
      .def(
          "write_snapshot",
          [](const SessionPtr& session, const py::object& path, bool overwrite) {
            write(*session, path_of(path), overwrite);
          },
          py::arg("path"), py::kw_only(), py::arg("overwrite") = false,
          "Write save_bytes() to a file. A snapshot there is replaced; another file only if "
          "overwrite.");
  const auto none = py::none();
  m.def("resume", &resumed, py::arg("snapshot"), py::arg("scene"), py::arg("backend") = none,
        py::kw_only(), py::arg("step") = 0.0, py::arg("seed") = none,
        py::arg("speed") = std::numeric_limits<double>::infinity(), py::arg("isolation") = "none",
        py::arg("without") = std::vector<std::string>(),
        "A Simulation of `scene` that continues from a snapshot: bytes of save_bytes(), or the "
        "path of a\n"
        "file. The engine, step and seed are those of the snapshot unless given, and the scene may "
        "have\n"
        "been edited; what could not be transferred is in .notes. `without` is as in Simulation.\n"
        "Raises Error: no snapshot, damaged, or of a scene with another name.");
}

}  // namespace cogrsim::python

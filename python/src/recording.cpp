// Recordings: writing them during a run, and reading them.
#include "cogrsim/recording/recording.h"

#include <filesystem>

#include "simulation.h"
#include "tables.h"

namespace cogrsim::python {

namespace {

struct PyRecorder {
  static constexpr const char* kWhat = "recorder";
  SessionPtr session;  // outlives the recorder
  std::unique_ptr<Recorder> recorder;
  std::string path;
  bool finished = false;
  Usage usage;

  ~PyRecorder() {
    if (usage.made_after && *usage.made_after != forks) static_cast<void>(recorder.release());
  }
};

std::shared_ptr<PyRecorder> record(const SessionPtr& session, const py::object& path, double every,
                                   bool contacts, bool images, bool jpeg, bool overwrite) {
  const Use use(*session);
  RecorderOptions options;
  options.path = path_of(path);
  options.rules.overwrite = overwrite;
  options.rules.inputs = session->scene->files;
  options.every = every;
  options.contacts = contacts;
  options.images = images;
  options.jpeg = jpeg;
  options.parameters = session->scene->set;
  options.attachments = scene_files(
      *session->scene->model, std::filesystem::path(session->scene->path).parent_path().string());
  auto out = std::make_shared<PyRecorder>();
  out->session = session;
  out->path = options.path;
  out->recorder = value_of(Recorder::start(*session->simulation, std::move(options)));
  out->usage.made_after = forks;
  return out;
}

void finish(PyRecorder& self) {
  const Use writing(self);
  const Use use(*self.session);
  if (self.finished) return;
  self.finished = true;
  const RunStatus status = self.session->simulation->status();
  const Result<> done = [&] {
    const Unlock unlock;
    return self.recorder->finish(status == RunStatus::running ? RunStatus::completed : status);
  }();
  check(done);
}

struct PyRecording {
  static constexpr const char* kWhat = "recording";
  std::unique_ptr<Recording> recording;
  std::string path;
  Usage usage;
};

std::size_t index_in(const PyRecording& self, py::ssize_t index) {
  const auto count = static_cast<py::ssize_t>(self.recording->frame_count());
  const py::ssize_t at = index < 0 ? index + count : index;
  if (at >= 0 && at < count) return static_cast<std::size_t>(at);
  throw py::index_error("there is no frame " + std::to_string(index) + "; there are " +
                        std::to_string(count));
}

/// Visits all frames without the interpreter's lock, and looks for Ctrl-C.
template <class Visit>
void visit_frames(PyRecording& self, const FrameContents& wanted, const std::string& who,
                  Visit&& visit) {
  const Unlock unlock;
  for (std::size_t i = 0; i < self.recording->frame_count(); ++i) {
    const auto frame = self.recording->frame(i);
    if (!frame || i % 256 == 255 || !covers((*frame)->contents, wanted)) {
      const Lock lock;
      if (!frame) raise(frame.error());
      check_contents(**frame, wanted, who);
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    visit(**frame);
  }
}

std::vector<std::string> sensors_in(PyRecording& self) {
  if (self.recording->frame_count() == 0) return {};
  return names_of(
      value_of(self.recording->frame(self.recording->frame_count() - 1))->model->sensors);
}

py::tuple table(PyRecording& self, const std::string& name) {
  const Use use(self);
  int sensor = -1;
  std::vector<Channel> channels;
  if (self.recording->frame_count() > 0) {
    const FramePtr last = value_of(self.recording->frame(self.recording->frame_count() - 1));
    for (std::size_t i = 0; i < last->model->sensors.size(); ++i) {
      if (last->model->sensors[i].name != name) continue;
      sensor = static_cast<int>(i);
      channels = self.recording->channels(sensor);
    }
  }
  const auto tabulator = make_tabulator(name, sensor, channels);
  if (!tabulator) {
    std::vector<std::string> names = {"frames", "bodies", "joints", "contacts", "events"};
    for (const std::string& one : sensors_in(self)) names.push_back(one);
    raise_unknown("table", name, names);
  }
  FrameContents wanted;
  wanted.contacts = name == "contacts";
  visit_frames(self, wanted, "table 'contacts'",
               [&](const Frame& frame) { tabulator->add(frame); });
  return tabulator->finish();
}

py::tuple signal(PyRecording& self, const std::string& text) {
  const Use use(self);
  std::vector<double> times, values;
  if (self.recording->frame_count() > 0) {
    const FramePtr last = value_of(self.recording->frame(self.recording->frame_count() - 1));
    const Signal parsed = parse_signal(scope_of(*last), text);
    visit_frames(self, parsed.needs(), "signal '" + text + "'", [&](const Frame& frame) {
      times.push_back(frame.time);
      values.push_back(parsed.evaluate(frame));
    });
  }
  const auto count = static_cast<py::ssize_t>(times.size());
  return py::make_tuple(owned(std::move(times), {count}), owned(std::move(values), {count}));
}

py::dict info_of(const PyRecording& self) {
  const RecordingInfo& info = self.recording->info();
  py::dict out;
  out["scene"] = info.scene;
  out["backend"] = info.backend;
  out["engine_version"] = info.engine_version;
  out["library_version"] = info.library_version;
  out["status"] = info.status;
  out["seed"] = info.seed;
  out["step"] = info.step;
  out["start"] = info.start;
  out["end"] = info.end;
  out["frames"] = info.frames;
  out["dropped"] = info.dropped;
  out["complete"] = info.complete;
  out["damage"] = info.damage;
  out["set"] = info.parameters;
  py::dict attachments;
  for (const Attachment& one : info.attachments)
    attachments[py::str(one.name)] = py::bytes(one.data);
  out["attachments"] = attachments;
  if (info.provenance) {
    out["provenance"] = py::module_::import("json").attr("loads")(to_json_text(*info.provenance));
  } else {
    out["provenance"] = py::none();
  }
  return out;
}

}  // namespace

void bind_recording(py::module_& m) {
  py::class_<PyRecorder, std::shared_ptr<PyRecorder>>(
      m, "Recorder", "Writes a recording during the run; `with` finishes it.")
      .def("finish", &finish,
           "Write the rest and the end of the file. Raises Error: the disk was full, or frames "
           "were dropped.")
      .def_property_readonly(
          "problem", [](const PyRecorder& s) { return s.recorder->problem(); },
          "The first error so far; '': none")
      .def("__enter__", [](const std::shared_ptr<PyRecorder>& s) { return s; })
      .def("__exit__", [](PyRecorder& s, const py::args&) { finish(s); })
      .def("__repr__", [](const PyRecorder& s) {
        return "<Recorder '" + s.path + "'" + (s.finished ? ", finished>" : ">");
      });
  m.def("_record", &record, py::arg("simulation"), py::arg("path"), py::kw_only(),
        py::arg("every") = 0.0, py::arg("contacts") = true, py::arg("images") = true,
        py::arg("jpeg") = false, py::arg("overwrite") = false);

  py::class_<PyRecording, std::shared_ptr<PyRecording>>(m, "_Recording")
      .def(py::init([](const py::object& path) {
        auto out = std::make_shared<PyRecording>();
        out->path = path_of(path);
        Result<std::unique_ptr<Recording>> opened = [&] {
          const Unlock unlock;
          return Recording::open(out->path);
        }();
        out->recording = value_of(std::move(opened));
        return out;
      }))
      .def_property_readonly("path", held(+[](const PyRecording& s) { return s.path; }))
      .def("info", held(&info_of))
      .def("count", held(+[](const PyRecording& s) { return s.recording->frame_count(); }))
      .def("sensors", held(+[](PyRecording& s) {
             const Use use(s);
             return sensors_in(s);
           }))
      .def("messages", held(+[](const PyRecording& s) { return s.recording->messages(); }))
      .def("frame", held(+[](PyRecording& s, py::ssize_t index) {
             const Use use(s);
             return to_python(value_of(s.recording->frame(index_in(s, index))));
           }))
      .def("frame_at", held(+[](PyRecording& s, double time) {
             const Use use(s);
             if (s.recording->frame_count() == 0)
               throw py::index_error("the recording has no frames");
             return to_python(value_of(s.recording->frame(s.recording->index_at(time))));
           }))
      .def("table", held(&table))
      .def("signal", held(&signal));
}

}  // namespace cogrsim::python

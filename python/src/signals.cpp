// Signals that are parsed once and evaluated on many frames.
#include "simulation.h"

namespace cogrsim::python {

namespace {

struct PySignal {
  Signal signal;
  std::weak_ptr<Session> session;
};

double value_now(const PySignal& self) {
  const auto session = self.session.lock();
  if (!session) {
    throw std::runtime_error("signal '" + self.signal.text() +
                             "': its simulation does not exist any more; pass a frame");
  }
  const Use use(*session);
  return self.signal.evaluate(*session->simulation->frame());
}

}  // namespace

void bind_signals(py::module_& m) {
  py::class_<PySignal>(m, "Signal", "A quantity that has one value in every frame.")
      .def_property_readonly(
          "text", [](const PySignal& s) { return s.signal.text(); },
          "The signal with the full names of the scene")
      .def_property_readonly(
          "unit", [](const PySignal& s) { return s.signal.unit(); },
          "'m/s', 'N*m'; '1': none, '': unknown")
      .def_property_readonly("value", &value_now,
                             "In the present frame of its simulation; NaN: none")
      .def(
          "__call__",
          [](const PySignal& s, const PyFrame& frame) { return value_of(s.signal, *frame.frame); },
          py::arg("frame"),
          "The value in a frame, in `unit`; NaN: none. Raises Error: it needs contacts, and nobody "
          "asked for\nthem before the step of the frame")
      .def("__repr__", [](const PySignal& s) {
        return "<Signal " + s.signal.text() + " [" + s.signal.unit() + "]>";
      });
  m.def("_signal", [](const std::shared_ptr<Session>& session, const std::string& text) {
    const Use use(*session);
    return PySignal{parse_signal(scope_of(*session->simulation->frame()), text), session};
  });
}

}  // namespace cogrsim::python

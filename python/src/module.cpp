// The module cogrsim._cogrsim.
#include "common.h"
#include "policy.h"

PYBIND11_MODULE(_cogrsim, m) {
  using namespace cogrsim::python;
  m.doc() = "The compiled part of cogrsim.";
  m.attr("__version__") = COGRSIM_VERSION;
  bind_scene(m);
  bind_frame(m);
  bind_frame_views(m);
  bind_simulation(m);
  bind_signals(m);
  bind_handles(m);
  bind_controllers(m);
  bind_supervisors(m);
  bind_batch(m);
  bind_recording(m);
  bind_rendering(m);
  bind_import(m);
  bind_policy(m);
}

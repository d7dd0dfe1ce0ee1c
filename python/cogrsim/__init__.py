"""CogRSim: robot simulation on several physics engines.

    import cogrsim as cg
    scene = cg.compile("cart.scene.xml", set={"length": "0.8 m"})
    sim = cg.Simulation(scene, backend="simbody")
    frame = sim.run_until(2.0)
    frame.position, frame["cart.pivot"].position

All quantities are in SI units, orientations are quaternions w x y z, names are those of scenes and of C++.
"""

import atexit as _atexit
import warnings as _warnings

from ._errors import CompileError, Error, RunWarning, _diagnostic
from ._cogrsim import (ControllerInput, Diagnostic, Element, Event, ExportedModel, Frame, ImportedModel, ImportEntry,
                       InputHandle,
                       Message, Motor, Observation, Policy, PolicyMemory, Reading, Recorder, Robot, Scene,
                       SensorContext, SensorHandle, Signal, Simulation, Snapshot, SupervisorContext, Tick, check, compile,
                       compile_string, explain, export_model, import_model, resume)
from .control import Channel, Controller, Output, Parameter, Sensor, Supervisor, channel, output, parameter
from .recording import Recording

from . import _cogrsim as _c
from ._cogrsim import __version__
from ._sensors import name_readings as _name_readings


def _signal(self, text):
    """A signal of the scene such as 'distance(robot, wall)', parsed once, for this simulation and its frames.

    Raises ValueError: the signal is wrong, with the most similar names.
    """
    return _c._signal(self, text)


def _record(self, path, *, every=0.0, contacts=True, images=True, jpeg=False, overwrite=False):
    """Start recording into an MCAP file, before the first step; returns a Recorder for `with`.

    every: time between recorded frames [s]; 0: every step. Raises Error: the file cannot be written.
    """
    return _c._record(self, path, every=every, contacts=contacts, images=images, jpeg=jpeg,
                      overwrite=overwrite)


def _frame_png(self):
    """PNG of the frame, for notebooks; None without a renderer."""
    from ._png import encoded
    try:
        return encoded(_c._render(self, "iso", width=640, height=400)["color"])
    except Error:
        return None


def _report_html(self):
    """The report as a table, for notebooks."""
    from html import escape
    rows = []
    for entry in self.report:
        cells = (entry.fidelity, entry.element, entry.message, f"{entry.file}:{entry.line}")
        rows.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    return (f"<table><caption>{escape(repr(self)[1:-1])}</caption><thead><tr><th>fidelity</th><th>element</th>"
            f"<th>message</th><th>place</th></tr></thead><tbody>{''.join(rows)}</tbody></table>")


# A fault is shown whenever it occurs. By default Python would show one per line of a program, so not that of the
# second engine of a loop. Filters of the user come first.
_warnings.filterwarnings("always", category=RunWarning, append=True)
_name_readings(Reading, SensorHandle)
ImportedModel._repr_html_ = ExportedModel._repr_html_ = _report_html
Frame._repr_png_ = _frame_png
Simulation._repr_png_ = lambda self: _frame_png(self.frame)
Simulation.signal = _signal
Simulation.record = _record


def render(frame, view="iso", *, width=640, height=480, fov=0.0, shadows=True, depth=False, labels=False,
           scene=None):
    """An image of a frame: (height, width, 3) uint8, read-only.

    view: a <view> of the scene, or "front", "back", "left", "right", "top", "bottom", "iso". fov: horizontal
    field of view [rad]; 0: that of the view. With depth or labels a dict: "color", "depth" (height, width)
    float32 [m] (inf: background), "labels" (height, width) int32 body indices (-1: background).
    Raises KeyError: no such view; Error: no renderer is installed.
    """
    out = _c._render(frame, view, width=width, height=height, fov=fov, depth=depth, labels=labels,
                     shadows=shadows, scene=scene)
    return out if depth or labels else out["color"]


_LATE = {"SceneBuilder": "builder", "SceneElement": "builder", "VectorEnv": "env", "Env": "env",
         "compare": "comparison", "Comparison": "comparison", "Divergence": "comparison",
         "Picture": "tools", "Page": "tools", "test": "tools", "sweep": "tools", "plot": "tools",
         "figure": "tools", "map": "tools", "bundle": "tools"}


def __getattr__(name):
    # numpy, subprocess and gymnasium take longer to import than all the rest.
    if name not in _LATE:
        raise AttributeError(f"module 'cogrsim' has no attribute {name!r}")
    import importlib
    value = getattr(importlib.import_module("." + _LATE[name], __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(set(globals()) | set(_LATE))


_atexit.register(_c._end_calls)


def _no_pickle(self, protocol):
    raise TypeError(f"a {type(self).__name__} cannot be pickled or copied; frames never change, and a run is saved by "
                    "Simulation.save() or save_bytes()")


def _not_made(cls, *_, **__):
    raise TypeError(f"a {cls.__name__} is made by functions of cogrsim, not by its class")


for _name, _class in list(vars(_c).items()):
    if isinstance(_class, type):
        _class.__module__ = "cogrsim"
        _class.__reduce_ex__ = _no_pickle  # that of object makes an instance of pybind11's base, which aborts
        if _name not in ("Simulation", "Policy", "_Batch", "_Recording"):
            _class.__new__ = _not_made  # without an __init__() that is called the instance would have no memory
_c.Diagnostic.__reduce_ex__ = lambda self, protocol: (_diagnostic, (self._state(),))
del _name, _class

__all__ = [name for name in __dir__() if not name.startswith("_")]

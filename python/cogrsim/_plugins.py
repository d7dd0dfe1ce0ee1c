"""Finds the classes behind names such as "py:steer.Steer", and runs controllers of them in processes of their own."""

import difflib
import importlib
import os
import sys

from . import control

_BASES = {"controller": control.Controller, "supervisor": control.Supervisor, "sensor": control.Sensor}


class NotFound(LookupError):
    """There is no such class."""


class WrongKind(TypeError):
    """The class is none of that kind."""


def _import(name, folders):
    if name in sys.modules:
        return sys.modules[name]
    added = [folder for folder in folders if folder not in sys.path]
    sys.path[:0] = added
    try:
        return importlib.import_module(name)
    finally:
        for folder in added:
            sys.path.remove(folder)


def find(kind, name, folders):
    """The class. Raises NotFound, WrongKind, and what its module raises."""
    module_name, _, class_name = name[len("py:"):].rpartition(".")
    if not module_name or not class_name:
        raise NotFound(f"'{name}' is no Python class; write \"py:MODULE.CLASS\"")
    try:
        module = _import(module_name, folders)
    except ModuleNotFoundError as error:
        if error.name is None or not (module_name + ".").startswith(error.name + "."):
            raise
        raise NotFound(
            f"there is no Python module '{module_name}' for the {kind} '{name}'; it is searched like "
            "`import`, and in the folders of plugin_path and COGRSIM_PLUGIN_PATH first") from None
    base = _BASES[kind]
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        classes = [key for key, value in vars(module).items()
                   if isinstance(value, type) and issubclass(value, base) and value is not base]
        near = difflib.get_close_matches(class_name, classes, 1)
        there = f"did you mean '{near[0]}'?" if near else "there are " + (", ".join(classes) or "none")
        raise NotFound(f"module '{module_name}' has no {kind} '{class_name}'; {there}")
    if not issubclass(found, base):
        raise WrongKind(f"'{name}' is not derived from cogrsim.{base.__name__}")
    return found


def host_command(name):
    """The command that runs the controller in a process of its own, where modules are found as in this one."""
    if name.startswith("py:__main__."):
        raise NotFound(f"'{name}' is defined in the program itself, which its own process does not run; "
                          "put the class into a module, or leave isolation=\"process\" out")
    if not sys.executable:
        raise NotFound("the path of the Python interpreter is not known (sys.executable is empty)")
    path = [os.fsdecode(folder) for folder in sys.path]
    return [sys.executable, "-u", "-c",
            f"import sys; sys.path[:] = {path!r}; from cogrsim._plugins import serve; serve()"]


def serve():
    """Runs one controller for the simulation that has started this process."""
    from . import _cogrsim
    sys.exit(_cogrsim._serve_isolated_controller())

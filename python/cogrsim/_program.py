"""What runs in the program `cogrsim`: its arguments and results."""

import json
import math
import operator
import os
import shutil
import subprocess
import tempfile

from . import _cogrsim
from ._errors import Error


def program():
    """Path of the program `cogrsim`: COGRSIM_PROGRAM, that of this installation or build tree, or the first in
    PATH. Raises Error if there is none."""
    named = os.environ.get("COGRSIM_PROGRAM")
    if named:
        return named
    folder = os.path.dirname(os.path.abspath(__file__))
    for _ in range(6):
        folder = os.path.dirname(folder)
        found = os.path.join(folder, "bin", "cogrsim")
        if os.access(found, os.X_OK):
            return found
    found = shutil.which("cogrsim")
    if found:
        return found
    raise Error("the program 'cogrsim', which does this, is not found\n"
                "help: install it, or name it in COGRSIM_PROGRAM")


def run(arguments):
    """Run the program; returns the completed process with its output as text."""
    return subprocess.run([program(), *arguments], capture_output=True, text=True, check=False)


def run_json(arguments):
    """Run a command that has --json; returns its result and the process. Raises Error: it wrote none."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "result.json")
        done = run([*arguments, "--json", path])
        if not os.path.exists(path):
            raise Error(done.stderr.strip() or f"cogrsim {arguments[0]} failed ({done.returncode})")
        with open(path, encoding="utf-8") as file:
            return json.load(file), done


def of_type(name, value, kinds, expected):
    """The value. Raises TypeError: it is of none of these types."""
    if not isinstance(value, kinds):
        raise TypeError(f"{name}: expected {expected}, given {value!r}")
    return value


def text(name, value, expected="a text"):
    """The value. Raises TypeError: it is not a str."""
    return of_type(name, value, str, expected)


def number(name, value, expected="a number"):
    """The value as a float. Raises TypeError: it is not a number; ValueError: it is not finite."""
    if isinstance(value, (str, bytes)) or not hasattr(value, "__float__") and not hasattr(value, "__index__"):
        raise TypeError(f"{name}: expected {expected}, given {value!r}")
    out = float(value)
    if not math.isfinite(out):
        raise ValueError(f"{name}: expected {expected}, finite, given {value!r}")
    return out


def whole(name, value):
    """The value as an int. Raises TypeError: it is not a whole number."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, given {value!r}") from None


def one_of(name, value, known):
    """The value. Raises ValueError: it is none of these."""
    if value not in known:
        raise ValueError(f"{name}: expected one of {', '.join(map(repr, known))}, given {value!r}")
    return value


def file_path(name, value):
    """A path as an argument, never taken for an option. Raises TypeError: it is none."""
    path = os.fspath(of_type(name, value, (str, os.PathLike), "a path"))
    return os.path.join(os.curdir, path) if path.startswith("-") else path


def mapping(name, value, expected):
    """The value as a dict, empty for None. Raises TypeError: it is none."""
    if value is None:
        return {}
    if not hasattr(value, "items"):
        raise TypeError(f"{name}: expected a dict of {expected}, given {value!r}")
    return dict(value.items())


def scene_arguments(scene, set=None, plugin_path=()):
    """Arguments for a scene: a path, or a Scene compiled from a file, with its parameters. Raises ValueError,
    TypeError."""
    settings = {}
    of_type("scene", scene, (str, os.PathLike, _cogrsim.Scene), "the path of a scene file or a Scene")
    if isinstance(scene, _cogrsim.Scene):
        settings = dict(scene.set)
        if not scene.path:
            raise ValueError("scene: expected a scene file, given a Scene that was compiled from a text")
        scene = scene.path
    arguments = [file_path("scene", scene)]
    for name, value in {**settings, **mapping("set", set, "parameters by name")}.items():
        arguments += ["--set", f"{name}={value}"]
    for folder in entries("plugin_path", plugin_path, "folders"):
        arguments += ["--plugin-path", file_path("plugin_path", folder)]
    return arguments


def seed_of(scene):
    """The seed that a Scene was compiled with; None: that of its file."""
    return scene.seed if isinstance(scene, _cogrsim.Scene) else None


def entries(name, values, expected):
    """The values as a list. Raises TypeError: a str, or nothing that has entries."""
    if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name}: expected a list of {expected}, given {values!r}")
    return list(values)


def list_argument(name, values):
    """Arguments for a list of names; none for an empty one. Raises TypeError: a str."""
    if isinstance(values, str):
        raise TypeError(f"{name}: expected a list of names, given a str; write [{values!r}]")
    names = [text(name, value, "a list of names") for value in entries(name, values, "names")]
    return [f"--{name}", ",".join(names)] if names else []


def seeds_argument(seeds):
    numbers = [whole("seeds", one) for one in entries("seeds", seeds, "whole numbers")]
    return ["--seeds", ",".join(map(str, numbers))] if numbers else []


def time_argument(name, value):
    """Arguments for a time [s]; none for None."""
    return [] if value is None else [f"--{name}", f"{number(name, value, 'a time [s]')!r} s"]

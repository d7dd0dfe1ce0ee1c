"""What runs in the program `cogrsim`: its arguments and results."""

import json
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


def scene_arguments(scene, set=None, plugin_path=()):
    """Arguments for a scene: a path, or a Scene compiled from a file, with its parameters. Raises ValueError."""
    settings = {}
    if isinstance(scene, _cogrsim.Scene):
        settings = dict(scene.set)
        if not scene.path:
            raise ValueError("scene: expected a scene file, given a Scene that was compiled from a text")
        scene = scene.path
    arguments = [os.fspath(scene)]
    for name, value in {**settings, **(set or {})}.items():
        arguments += ["--set", f"{name}={value}"]
    for folder in plugin_path:
        arguments += ["--plugin-path", os.fspath(folder)]
    return arguments


def list_argument(name, values):
    """Arguments for a list of names; none for an empty one. Raises TypeError: a str."""
    if isinstance(values, str):
        raise TypeError(f"{name}: expected a list of names, given a str; write [{values!r}]")
    return [f"--{name}", ",".join(values)] if len(values) > 0 else []


def seeds_argument(seeds):
    return ["--seeds", ",".join(str(int(one)) for one in seeds)] if len(seeds) > 0 else []


def time_argument(name, value):
    """Arguments for a time [s]; none for None."""
    return [] if value is None else [f"--{name}", f"{float(value)!r} s"]

"""Scene tests, sweeps, figures, maps and pages: the program's commands as functions."""

import csv
import json
import math
import os
import tempfile
from collections.abc import Mapping

from . import _cogrsim
from ._errors import Error
from ._program import (entries, file_path, list_argument, mapping, number, of_type, one_of, run, scene_arguments,
                       seed_of, seeds_argument, text, time_argument, whole)
from .recording import Recording


_KINDS = ("svg", "png")


class Picture:
    """A drawing: `data` as bytes, of the format `kind` ("svg" or "png"). A notebook shows it."""

    def __init__(self, kind, data):
        self.kind = one_of("kind", kind, _KINDS)
        self.data = of_type("data", data, bytes, "bytes")

    def save(self, path, *, overwrite=False):
        """Write it to a file. Raises FileExistsError: it exists and overwrite is False; OSError."""
        with open(os.fspath(path), "wb" if overwrite else "xb") as file:
            file.write(self.data)

    def _repr_mimebundle_(self, include=None, exclude=None):
        return {"image/svg+xml": self.data.decode()} if self.kind == "svg" else {"image/png": self.data}

    def __repr__(self):
        return f"<Picture, {self.kind}, {len(self.data)} bytes>"


class Page:
    """A page in HTML that needs no other file: `html`. A notebook shows it in a frame of `height` pixels."""

    def __init__(self, html, height=520):
        self.html, self.height = text("html", html), whole("height", height)

    def save(self, path, *, overwrite=False):
        """Write it to a file. Raises FileExistsError: it exists and overwrite is False; OSError."""
        with open(os.fspath(path), "w" if overwrite else "x", encoding="utf-8") as file:
            file.write(self.html)

    def _repr_html_(self):
        from html import escape
        return (f'<iframe srcdoc="{escape(self.html)}" sandbox="allow-scripts allow-downloads" '
                f'style="width:100%;height:{self.height}px;border:1px solid #8884"></iframe>')

    def __repr__(self):
        return f"<Page, {len(self.html)} characters>"


def _recorded(source):
    return isinstance(source, Recording) or (
        isinstance(source, (str, os.PathLike)) and os.fspath(source).endswith(".mcap"))


def _files(source, set, plugin_path, without, **of_scenes):
    """Arguments for a recording, or for a scene. Raises ValueError: what only scenes have, with a recording."""
    if not _recorded(source):
        of_type("source", source, (str, os.PathLike, _cogrsim.Scene), "a scene or a recording")
        arguments = scene_arguments(source, set, plugin_path)
        if seed_of(source) is not None:
            arguments += ["--seed", str(seed_of(source))]
        for name, value in of_scenes.items():
            arguments += [f"--{name}", text(name, value)] if value is not None else []
        return arguments + list_argument("without", without)
    for name, value in {"set": set, "plugin_path": plugin_path, "without": without, **of_scenes}.items():
        if value:
            raise ValueError(f"{name}: only a scene takes it; the source is a recording")
    return [file_path("source", source.path if isinstance(source, Recording) else source)]


def _made(arguments, name, read):
    """What the program wrote into the file `name`."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, name)
        done = run([*arguments, "-o", path])
        if not os.path.exists(path):
            raise Error(done.stderr.strip() or f"cogrsim {arguments[0]} failed ({done.returncode})")
        return read(path)


def _bytes(path):
    with open(path, "rb") as file:
        return file.read()


def _text(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def test(scenes, backends=(), *, seeds=(), filter=None, timeout=None, set=None, plugin_path=(),
         without=()):
    """Run the tests of a scene, of several, or of a folder: list of dict, one per case.

    Keys as `cogrsim test --json` has them: scene, test, backends, seed, status ("passed", "failed",
    "error": the scene does not compile, …),
    message, verdicts, … backends: empty: the test's, else those in libraries; ["all"]: also those in processes of
    their own, but for what cannot run the scene. Raises Error: no tests could be run, or none has `filter` in its name.
    """
    if isinstance(scenes, (str, os.PathLike, _cogrsim.Scene)):
        scenes = [scenes]
    scenes = entries("scenes", scenes, "scenes")
    if not scenes:
        raise ValueError("scenes: expected at least one scene")
    if not seeds and any(seed_of(scene) is not None for scene in scenes):
        if len(scenes) > 1:
            raise ValueError("scenes: expected files, or one Scene, where seeds were given to compile()")
        seeds = [seed_of(scenes[0])]
    arguments = ["test", "--json", "-", *list_argument("backends", backends), *seeds_argument(seeds),
                 *time_argument("timeout", timeout), *list_argument("without", without)]
    if filter is not None:
        arguments += ["--filter", text("filter", filter)]
    for scene in scenes:
        arguments += scene_arguments(scene, set if scene is scenes[-1] else None,
                                     plugin_path if scene is scenes[-1] else ())
    done = run(arguments)
    try:
        return json.loads(done.stdout)["cases"]
    except (ValueError, KeyError):
        raise Error(done.stderr.strip() or f"cogrsim test failed ({done.returncode})") from None


def sweep(scene, vary=None, *, backends=(), seeds=(), measure=None, until=None, step=None, jobs=None,
          output=None, set=None, plugin_path=(), without=()):
    """Run a scene many times: a structured array with one row per run, the columns of results.csv.

    vary: values by <param>, as a list or a text such as "3cm..5cm:5"; several make a grid. measure: numbers by
    name, "SIGNAL@TAKE". backends: empty: the scene's; ["all"]: those that run the scene. output: folder of the study, which is continued if it is there; None: not kept.
    Raises Error with what the program printed.
    """
    import numpy

    if not seeds and seed_of(scene) is not None:
        seeds = [seed_of(scene)]
    arguments = ["sweep", *scene_arguments(scene, set, plugin_path), *list_argument("backends", backends),
                 *seeds_argument(seeds), *time_argument("until", until), *time_argument("step", step),
                 *list_argument("without", without)]
    for name, values in mapping("vary", vary, "values by parameter").items():
        if not isinstance(values, str):
            values = ",".join(str(v) for v in entries(f"vary[{name!r}]", values, "values"))
        arguments += ["--vary", f"{name}={values}"]
    for name, signal in mapping("measure", measure, "signals by name").items():
        arguments += ["--measure", f"{name}={signal}"]
    if jobs is not None:
        arguments += ["--jobs", str(whole("jobs", jobs))]
    with tempfile.TemporaryDirectory() as folder:
        folder = file_path("output", output) if output is not None else os.path.join(folder, "study")
        done = run([*arguments, "-o", folder])
        path = os.path.join(folder, "results.csv")
        if not os.path.exists(path):
            raise Error(done.stderr.strip() or f"cogrsim sweep failed ({done.returncode})")
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))
    names, rows = rows[0], rows[1:]

    def column(values):
        try:
            return numpy.array([float(v) if v else numpy.nan for v in values])
        except ValueError:
            return numpy.array(values, dtype=str)

    columns = [column([row[i] for row in rows]) for i in range(len(names))]
    out = numpy.empty(len(rows), dtype=[(n, c.dtype if len(rows) else float) for n, c in zip(names, columns)])
    for n, c in zip(names, columns):
        out[n] = c
    return out


def plot(source, y=(), *, x=None, z=None, kind=None, title=None, plot=None, every=None, format="svg"):
    """A figure of a recording (a path, a Recording, or a list of these): a Picture.

    y: signals, each a series; x, z, kind, title: as <plot> has them. plot: instead, the name of a plot of the
    scene. Raises Error: an unknown signal, with the nearest; no gnuplot.
    """
    one_of("format", format, _KINDS)
    sources = source if isinstance(source, (list, tuple)) else [source]
    if not sources:
        raise ValueError("source: expected at least one recording")
    arguments = ["plot"] + [part for one in sources for part in _files(one, None, (), ())]
    for signal in [y] if isinstance(y, str) else entries("y", y, "signals"):
        arguments += ["--y", text("y", signal, "signals")]
    for name, value in (("x", x), ("z", z), ("kind", kind), ("title", title), ("plot", plot)):
        if value is not None:
            arguments += [f"--{name}", text(name, value)]
    arguments += time_argument("every", every)
    return Picture(format, _made(arguments, "figure." + format, _bytes))


def figure(series, *, x="", y="", title="", format="svg"):
    """A figure of curves from arrays: a Picture.

    series: pairs of arrays (times, values), (n,) each, by the label of the curve; NaN leaves a gap. x, y: labels of
    the axes, with units: "time [s]". Raises TypeError, ValueError: no arrays of numbers, or of other lengths;
    Error: no gnuplot.
    """
    import numpy

    one_of("format", format, _KINDS)
    curves = []
    for label, pair in of_type("series", series, Mapping, "a dict of pairs of arrays by label").items():
        place = f"series[{label!r}]"
        pair = entries(place, pair, "two arrays")
        try:
            arrays = [numpy.asarray(one, dtype=float) for one in pair]
        except (TypeError, ValueError) as error:
            raise TypeError(f"{place}: expected two arrays of numbers, (n,) each; {error}") from None
        if len(arrays) != 2 or arrays[0].ndim != 1 or arrays[0].shape != arrays[1].shape:
            raise ValueError(f"{place}: expected two arrays of the shape (n,), given the shapes "
                             f"{', '.join(str(one.shape) for one in arrays)}")
        columns = [[v if math.isfinite(v) else None for v in one.tolist()] for one in arrays]
        curves.append({"label": text("series", label, "labels that are texts"), "x": columns[0], "y": columns[1]})
    data = {"format": "cogrsim-figure", "version": 1, "kind": "curve", "name": "figure",
            "title": text("title", title), "x": {"label": text("x", x)}, "y": {"label": text("y", y)},
            "series": curves}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "data.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(data, file)
        return Picture(format, _made(["plot", path], "figure." + format, _bytes))


def map(source, *, at=None, area=None, width=900, trail=(), backend=None, set=None, plugin_path=(), format="svg",
        without=()):
    """The plan view of a scene or recording with the robots' paths, at the time `at` [s]: a Picture.

    area: (x, y, x, y) [m]; None: everything. trail: bodies or assemblies to follow; empty: the robots.
    Raises Error with what the program printed.
    """
    one_of("format", format, _KINDS)
    arguments = ["map", *_files(source, set, plugin_path, without, backend=backend), *time_argument("at", at),
                 "--width", str(whole("width", width)), *list_argument("trail", trail)]
    if area is not None:
        corners = [number("area", v, "numbers x, y, x, y [m]") for v in entries("area", area, "numbers")]
        arguments += ["--area", ",".join(repr(v) for v in corners)]
    return Picture(format, _made(arguments, "map." + format, _bytes))


def bundle(source, *, backend=None, duration=None, every=None, set=None, plugin_path=(), height=520, without=()):
    """A run on one page, in 3D, with its timeline and curves: a Page. `source`: a recording, or a scene, which
    is run. Raises Error with what the program printed."""
    whole("height", height)
    arguments = ["bundle", *_files(source, set, plugin_path, without, backend=backend),
                 *time_argument("duration", duration), *time_argument("every", every)]
    return Page(_made(arguments, "run.html", _text), height)


for _thing in (Picture, Page, test, sweep, plot, figure, map, bundle):
    _thing.__module__ = "cogrsim"

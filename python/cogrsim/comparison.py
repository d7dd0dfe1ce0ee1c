"""Comparing engines: the results of `cogrsim compare`, as arrays."""

from ._errors import Error
from ._program import list_argument, number, run_json, scene_arguments, seed_of, seeds_argument, text, time_argument, whole


class Divergence:
    """Distances between the reference and the other runs over time.

    times (nsample,) [s]; position: dict by (body, backend) of arrays (nsample,), the largest distance of the
    body to that of the reference in each interval [m]; angle, the same [rad].
    """

    def __init__(self, data):
        import numpy

        self.reference = data["backends"][0]
        self.times = numpy.array(data["curve_times"])
        self.position, self.angle = {}, {}
        for entry in data["bodies"]:
            key = (entry["name"], entry["other"])
            for kind, into in (("position", self.position), ("angle", self.angle)):
                if entry[kind]:
                    into[key] = numpy.array(entry[kind]["curve"])

    def plot(self, axes=None, most=8):
        """Draw the `most` largest distances over time.

        Returns the axes of matplotlib, `axes` or new ones; where matplotlib is not installed, a Picture.
        """
        worst = sorted(self.position, key=lambda key: -self.position[key].max(initial=0.0))[:whole("most", most)]
        curves = {f"{name}, {other}": (self.times[:len(curve)], curve)
                  for name, other in worst for curve in [self.position[name, other]]}
        labels = ("time [s]", f"distance to {self.reference} [m]")
        if axes is None:
            try:
                import matplotlib.pyplot
            except ImportError:
                from .tools import figure
                return figure(curves, x=labels[0], y=labels[1])
            axes = matplotlib.pyplot.subplots()[1]
        for label, curve in curves.items():
            axes.plot(*curve, label=label)
        axes.set_xlabel(labels[0])
        axes.set_ylabel(labels[1])
        if curves:
            axes.legend()
        return axes

    def __repr__(self):
        return f"<Divergence from {self.reference}: {len(self.position)} curves, {len(self.times)} times>"


class Comparison:
    """The result of compare(). data: all of it, as `cogrsim compare --json` writes it."""

    def __init__(self, data):
        self.data = data

    @property
    def backends(self):
        """The engines as named; the first is the reference."""
        return self.data["backends"]

    @property
    def runs(self):
        """list of dict: backend, status, state_hash, energy, contacts, deepest_penetration, wall_time, …"""
        return self.data["runs"]

    @property
    def first_over(self):
        """Time at which two runs first differ by more than the threshold [s]; None: never."""
        return self.data["first_over"]["time"]

    @property
    def divergence(self):
        """Distances over time: a Divergence."""
        return Divergence(self.data)

    def table(self, name="bodies"):
        """"bodies" or "joints": name, reference, other, the largest, the root mean square and the last
        difference [m] and [rad], as a structured array. Raises KeyError."""
        import numpy

        if name not in ("bodies", "joints"):
            raise KeyError(f"there is no table '{name}'; there are 'bodies' and 'joints'")
        distance = "position" if name == "bodies" else "distance"
        entries = self.data[name]
        length = max([1] + [len(e[key]) for e in entries for key in ("name", "reference", "other")])
        kinds = [(key, f"U{length}") for key in ("name", "reference", "other")]
        kinds += [(f"{what}_{key}", float) for what in (distance, "angle") for key in ("max", "rms", "end")]
        kinds += [("first_over", float)]
        out = numpy.full(len(entries), numpy.nan, dtype=kinds)
        for row, entry in zip(out, entries):
            for key in ("name", "reference", "other"):
                row[key] = entry[key]
            for what in (distance, "angle"):
                for key in ("max", "rms", "end"):
                    if entry[what]:
                        row[f"{what}_{key}"] = entry[what][key]
            if entry["first_over"] is not None:
                row["first_over"] = entry["first_over"]
        return out

    @property
    def study(self):
        """Means, deviations and confidence intervals over `seeds`, as a dict; None without seeds."""
        return self.data["study"]

    def _repr_html_(self):
        from html import escape
        first = self.data["first_over"]
        rows = []
        for run in self.runs:
            over = [e["first_over"] for name in ("bodies", "joints") for e in self.data[name]
                    if e["other"] == run["label"] and e["first_over"] is not None]
            when = "reference" if run["label"] == self.backends[0] else f"{min(over):.4g} s" if over else "never"
            cells = [run["label"], run["status"], f"{run['time']:.4g} s", when, run["state_hash"]]
            rows.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
        limit = self.data["thresholds"]
        end = ("no body is further" if first["time"] is None else
               f"first over at {first['time']:.4g} s: {first['name']}, further")
        return (f"<table><caption>{escape(self.data['scene'])}</caption><thead><tr><th>engine</th><th>status</th>"
                f"<th>end</th><th>first over</th><th>state hash</th></tr></thead><tbody>{''.join(rows)}</tbody></table>"
                f"<p>{escape(end)} than {limit['position']:.4g} m or {limit['angle']:.4g} rad from the reference</p>")

    def __repr__(self):
        return f"<Comparison of '{self.data['scene']}' on {', '.join(self.backends)}>"


def compare(scene, backends=(), *, seeds=(), duration=None, step=None, shake=None, set=None, seed=None,
            plugin_path=(), threshold=None, without=()):
    """Run a scene on several engines side by side: a Comparison.

    scene: path of a scene file, or a Scene compiled from one. backends: names, also with options; the first
    is the reference; empty: those in libraries; ["all"]: also those in processes of their own, but for what cannot
    run the scene, which is in data["diagnostics"]. seeds: repetitions. duration, step: [s]; None: those of the scene. shake:
    largest random displacement of the start of each repetition [m]. threshold: "5mm,2deg". without: features of the
    scene that are left out, such as ["couplings"]; ["lacking"]: of each engine what it lacks.
    Runs the program `cogrsim compare`, so controllers in Python are not available in it.
    Raises Error with what the program printed; ValueError: a scene that is not a file.
    """
    arguments = ["compare", *scene_arguments(scene, set, plugin_path), *list_argument("backends", backends),
                 *seeds_argument(seeds), *list_argument("without", without)]
    arguments += [*time_argument("duration", duration), *time_argument("step", step)]
    if shake is not None:
        arguments += ["--shake", f"{number('shake', shake, 'a length [m]')!r} m"]
    if seed is None and not seeds:
        seed = seed_of(scene)
    if seed is not None:
        arguments += ["--seed", str(whole("seed", seed))]
    if threshold is not None:
        arguments += ["--threshold", text("threshold", threshold, "a text such as '5mm,2deg'")]
    data, done = run_json(arguments)
    if not data["runs"]:
        raise Error(done.stderr.strip() or "cogrsim compare failed")
    return Comparison(data)


for _class in (Divergence, Comparison, compare):
    _class.__module__ = "cogrsim"

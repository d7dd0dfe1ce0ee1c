"""Recordings of runs."""

from . import _cogrsim


class Recording:
    """A recorded run in a file of `cogrsim run --record` or Simulation recordings.

    len(recording) frames, recording[i] is a Frame, bit-identical to that of the run; iteration gives all.
    Raises Error: the file does not exist, is no recording, or nothing of it can be read.
    """

    def __init__(self, path):
        import os
        self.path = os.fspath(path)
        self._file = _cogrsim._Recording(path)

    def _repr_html_(self):
        from ._errors import Error
        from .tools import bundle
        try:
            return bundle(self)._repr_html_()
        except Error:  # no program, or the file has gone
            return None

    @property
    def info(self):
        """dict: scene, backend, engine_version, seed, step [s], start and end [s], status, complete, damage,
        set (parameters), attachments (bytes by name), provenance, …"""
        return self._file.info()

    @property
    def messages(self):
        """list of Message of the run."""
        return self._file.messages()

    @property
    def tables(self):
        """Names that table() accepts."""
        return ["frames", "bodies", "joints", "contacts", "events"] + self._file.sensors()

    def __len__(self):
        return self._file.count()

    def __getitem__(self, index):
        return self._file.frame(index)

    def at(self, time):
        """The last Frame at or before `time` [s]."""
        return self._file.frame_at(time)

    def table(self, name):
        """A table over all frames as a structured array, for pandas.DataFrame(…) too.

        name: "frames", "bodies", "joints", "contacts", "events", or the name of a sensor; the columns are
        those of `cogrsim replay --csv`, in SI units. Raises KeyError naming the tables that exist.
        """
        import numpy

        columns, names = self._file.table(name)
        whole = {"step", "sequence", "coordinate"}
        data = {}
        for column, values in columns.items():
            if column in names:
                texts = numpy.array(names[column] or [""], dtype=str)
                data[column] = texts[values.astype(int)]
            elif column in whole and name != "contacts":
                data[column] = values.astype(numpy.int64)
            elif column == "valid":
                data[column] = values != 0.0
            else:
                data[column] = values
        kinds = [(column, values.dtype) for column, values in data.items()]
        count = len(next(iter(data.values()))) if data else 0
        out = numpy.empty(count, dtype=kinds)
        for column, values in data.items():
            out[column] = values
        return out

    def signal(self, text):
        """(times [s], values) of a signal over all frames. Raises ValueError: the signal is wrong."""
        return self._file.signal(text)

    def __repr__(self):
        return f"<Recording '{self._file.path}': {len(self)} frames>"


Recording.__module__ = "cogrsim"

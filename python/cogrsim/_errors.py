"""Exceptions and warnings of cogrsim."""


def _diagnostic(state):
    """A Diagnostic that was pickled."""
    from . import _cogrsim
    return _cogrsim._diagnostic(state)


class Error(Exception):
    """An error of a scene, a run or a file: what, where, and the remedy.

    diagnostics: list of Diagnostic with severity, code, file, line, column, message and remedy; may be
    empty. An error without a position in a file has file '' and line 0.
    """

    def __init__(self, text="", diagnostics=()):
        super().__init__(text)
        self.diagnostics = list(diagnostics)

    def __str__(self):
        return self.args[0] if self.args else ""


class CompileError(Error):
    """A scene or model has errors; the text has file, line, column, code, message and remedy of each."""


class RunWarning(RuntimeWarning):
    """An error of a run that did not raise: a fault of a controller, a rejected command, a divergence."""


for _class in (Error, CompileError, RunWarning):
    _class.__module__ = "cogrsim"

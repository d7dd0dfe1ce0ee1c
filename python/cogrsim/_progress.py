"""The line of progress of run_until() and run_for()."""

import shutil
import sys
import time


class Progress:
    """A line on standard error that is rewritten, at most ten times a second.

    Shown in terminals and notebooks; elsewhere, such as in a file, nothing is written.
    """

    def __init__(self, start, end):
        self._start, self._end, self._now = start, end, start
        self._began, self._shown = time.monotonic(), 0.0
        stream = sys.stderr
        self._notebook = type(stream).__module__.startswith("ipykernel")
        terminal = getattr(stream, "isatty", lambda: False)()
        self._stream = stream if self._notebook or terminal else None
        self._length = 0

    def _text(self, width):
        whole = self._end - self._start
        part = min(max((self._now - self._start) / whole, 0.0), 1.0) if whole > 0.0 else 1.0
        took = time.monotonic() - self._began
        tail = f" {100.0 * part:3.0f} %  {self._now:.2f} s of {self._end:.6g} s"
        # The start of a run says nothing about its speed.
        if took > 0.2 and part > 0.0:
            tail += f"  {(self._now - self._start) / took:.3g}x  {took / part - took:.0f} s left"
        bar = min(width - 1 - len(tail) - 2, 30)
        if bar >= 5:
            filled = int(part * bar + 0.5)
            tail = "[" + "#" * filled + "-" * (bar - filled) + "]" + tail
        return tail.strip()[:width - 1]

    def _write(self, more=""):
        width = 80 if self._notebook else shutil.get_terminal_size().columns
        text = self._text(max(width, 2))
        try:
            # Blanks cover what is left of a longer line before.
            self._stream.write("\r" + text.ljust(self._length) + more)
            self._stream.flush()
        except (OSError, ValueError):  # closed
            self._stream = None
        self._length = len(text)

    def show(self, now):
        """The simulated time [s] has come to `now`."""
        self._now = now
        if self._stream is not None and time.monotonic() - self._shown >= 0.1:
            self._shown = time.monotonic()
            self._write()

    def end(self):
        """The line remains, with the last time."""
        if self._stream is not None:
            self._write("\n")

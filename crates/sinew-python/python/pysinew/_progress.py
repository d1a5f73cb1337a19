"""Progress of long computations: a bar on a terminal or in a notebook, lines elsewhere."""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any, Union

from .errors import CaseError, SinewWarning

# Called with a stage, the share of it that is done, the seconds left (infinite while unknown) and a message.
Listener = Callable[[str, float, float, str], None]
# None: a bar for whatever takes longer than a second; False: nothing; or a function of your own.
ProgressArgument = Union[None, bool, Listener]

# Folder of this package.
PACKAGE = os.path.join(os.path.dirname(__file__), "")
# Seconds before anything is shown.
PATIENCE = 1.0
# Seconds between two lines where there is neither a terminal nor a notebook.
PAUSE = 10.0


def duration(seconds: float) -> str:
    """Time for people, such as `3 min 05 s`."""
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{int(seconds // 60)} min {int(seconds % 60):02d} s"


def _redraws() -> bool:
    """Whether standard error shows a line that is written over."""
    shell = sys.modules.get("IPython")
    if shell is not None:
        found: Any = shell.get_ipython()
        if found is not None and type(found).__name__ == "ZMQInteractiveShell":
            return True
    return bool(getattr(sys.stderr, "isatty", lambda: False)())


class Bar:
    """Writes to standard error."""

    def __init__(self) -> None:
        self.start = self.last = time.monotonic()
        self.redraws = _redraws()
        self.width = 0

    def _write(self, text: str) -> None:
        print(text, end="", file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if self.width:
            self._write("\r" + " " * self.width + "\r")
            self.width = 0

    def progress(self, stage: str, fraction: float, seconds_left: float, message: str) -> None:
        now = time.monotonic()
        if now - self.start < PATIENCE or (not self.redraws and now - self.last < PAUSE):
            return
        self.last = now
        left = f"{duration(seconds_left)} left  " if seconds_left < float("inf") else ""
        text = f"{stage:<24} {100 * fraction:3.0f} %  {left}{message}".rstrip()
        if self.redraws:
            full = int(24 * min(max(fraction, 0.0), 1.0))
            text = f"{stage:<24} {'━' * full:<24} {100 * fraction:3.0f} %  {left}{message}"[:110]
            self._write("\r" + text.ljust(self.width))
            self.width = len(text)
        else:
            self._write(text + "\n")

    def finished(self, stage: str, outcome: str, seconds: float) -> None:
        self._clear()
        if seconds >= PATIENCE:
            self._write(f"{stage:<24} {outcome} in {duration(seconds)}\n")

    def warning(self, text: str) -> None:
        self._clear()
        warnings.warn(text, SinewWarning, stacklevel=_level())

    def close(self) -> None:
        self._clear()


class Silent(Bar):
    """Shows nothing but warnings."""

    def progress(self, stage: str, fraction: float, seconds_left: float, message: str) -> None:
        pass

    def finished(self, stage: str, outcome: str, seconds: float) -> None:
        pass


class Told(Silent):
    """Hands progress to a function."""

    def __init__(self, listener: Listener) -> None:
        super().__init__()
        self.listener = listener

    def progress(self, stage: str, fraction: float, seconds_left: float, message: str) -> None:
        self.listener(stage, fraction, seconds_left, message)


class shown:
    """A listener for one computation, whose bar is cleared at the end."""

    def __init__(self, progress: ProgressArgument) -> None:
        if progress is not None and not isinstance(progress, bool) and not callable(progress):
            raise CaseError(f"progress = {progress!r}: give None, False or a function of stage, fraction, seconds left and message")
        if callable(progress):
            self.bar: Bar = Told(progress)
        else:
            self.bar = Silent() if progress is False else Bar()

    def __enter__(self) -> Bar:
        return self.bar

    def __exit__(self, *_: object) -> None:
        self.bar.close()


def warn(texts: list[str]) -> None:
    """Warns of each text once, at the line that called this package."""
    for text in dict.fromkeys(texts):
        warnings.warn(text, SinewWarning, stacklevel=_level())


def _level() -> int:
    """The level of the stack at which this package was called, seen from the caller."""
    frame: Any = sys._getframe(1)
    level = 1
    while frame is not None and frame.f_code.co_filename.startswith(PACKAGE):
        frame, level = frame.f_back, level + 1
    return level

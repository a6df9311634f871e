"""What a contestant did in its time."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Stopped(Exception):
    """The time limit is over."""


@dataclasses.dataclass(frozen=True)
class Run:
    """The outcome of one run.

    - `y`: where it ended.
    - `points`: CPU seconds since its start and where it stood then, in order; the last one is the end.
    - `stopped`: whether the time limit ended it.
    """

    y: Array
    points: tuple[tuple[float, Array], ...]
    stopped: bool


class Trace:
    """Notes where a run stands; the costs are computed afterwards, so that noting takes no time."""

    def __init__(self, limit: float, y: Array):
        self._began = time.process_time()
        self._limit = limit
        self._points = [(0.0, np.array(y))]
        self.late = False

    def see(self, y: Array) -> None:
        """Notes a position; raises `Stopped` beyond the limit."""
        seconds = time.process_time() - self._began
        self._points.append((seconds, np.array(y)))
        if seconds > self._limit:
            self.late = True
            raise Stopped

    def end(self, y: Array) -> Run:
        """The run that ended by itself at `y`."""
        self._points.append((time.process_time() - self._began, np.array(y)))
        return Run(np.array(y), tuple(self._points), False)

    def stop(self) -> Run:
        """The run that the limit ended."""
        return Run(self._points[-1][1], tuple(self._points), True)

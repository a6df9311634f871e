"""How long each pass takes."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

import moderngl

from .context import Device


class PassTimes:
    """Milliseconds by pass.

    A software device's timer queries are wrong, so there each pass is waited for and the wall clock is read. A GPU is
    not made to wait: its own clock tells how long the pass took.
    """

    def __init__(self, device: Device):
        self._ctx = device.ctx
        self._waits = device.is_software
        self._queries: list[tuple[str, moderngl.Query]] = []
        self._milliseconds: dict[str, float] = {}

    @contextlib.contextmanager
    def measure(self, name: str, waits: bool) -> Iterator[None]:
        """Adds what happens inside to a pass; `waits` also counts the processor's work, which a GPU's clock omits."""
        if self._waits or waits:
            started = time.perf_counter()
            yield
            self._ctx.finish()
            self._add(name, 1e3 * (time.perf_counter() - started))
        else:
            query = self._ctx.query(time=True)
            with query:
                yield
            self._queries.append((name, query))

    def total(self) -> dict[str, float]:
        """Milliseconds by pass so far; waits for the device if it has not finished."""
        for name, query in self._queries:
            self._add(name, query.elapsed / 1e6)
        self._queries.clear()
        return dict(self._milliseconds)

    def _add(self, name: str, milliseconds: float) -> None:
        self._milliseconds[name] = self._milliseconds.get(name, 0.0) + milliseconds

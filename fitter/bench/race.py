"""Our fit and the peers on one problem: the same data, loss and final cost, in interleaved rounds."""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Callable, Sequence

import jax
import numpy as np

from .peers import OURS, contestant
from .problem import Problem
from .trace import Run

# A final cost further above the best than this is not the same minimum.
SAME = 1e-6
# Points of a curve whose cost is computed: enough to draw it.
_POINTS_MAX = 60


@dataclasses.dataclass(frozen=True)
class Row:
    """One contestant.

    - `cpu`, `wall`: median seconds of a fit.
    - `excess`: final cost over the best one inside the bounds, minus 1.
    - `stopped`: whether the time limit ended it.
    - `inside`: whether it kept the bounds.
    - `curve`: CPU seconds and excess, in order.
    - `absent`: why it was not run, if so; then the rest means nothing.
    """

    cpu: float = float("nan")
    wall: float = float("nan")
    excess: float = float("nan")
    stopped: bool = False
    inside: bool = True
    curve: tuple[tuple[float, float], ...] = ()
    absent: str = ""


@dataclasses.dataclass(frozen=True)
class Race:
    """All contestants on one problem.

    - `title`: what was fitted to what.
    - `model`, `samples`, `source`: the problem.
    - `start`: where the peers start, as text.
    - `rows`: name -> figures, ours first.
    - `rounds`, `limit`: how often, and after how many CPU seconds a run was stopped.
    """

    title: str
    model: str
    samples: int
    source: str
    start: str
    rows: dict[str, Row]
    rounds: int
    limit: float

    def ratio(self, name: str) -> float:
        """The CPU time of a contestant over ours."""
        return self.rows[name].cpu / self.rows[OURS].cpu


def race(
    title: str, problem: Problem, names: Sequence[str], rounds: int, limit: float, say: Callable[[str], None]
) -> Race:
    """Runs the contestants; see `Race`. A run that was stopped by the limit is not repeated."""
    with jax.enable_x64(True):
        ready, absent = {}, {}
        for name in names:
            say(f"{title}: preparing {name}")
            one = contestant(name, problem)
            (absent if isinstance(one, str) else ready)[name] = one
        traces: dict[str, Run] = {}
        for name, one in ready.items():
            if one.trace is not one.run:
                say(f"{title}: following {name}")
                traces[name] = one.trace(limit)
        times: dict[str, list[tuple[float, float]]] = {name: [] for name in ready}
        last: dict[str, Run] = {}
        for index in range(rounds):
            for name, one in ready.items():
                if any(run.stopped for run in (traces.get(name), last.get(name)) if run):
                    continue
                say(f"{title}: round {index + 1} of {rounds}, {name}")
                began = time.process_time(), time.perf_counter()
                last[name] = one.run(limit)
                times[name].append((time.process_time() - began[0], time.perf_counter() - began[1]))
                traces.setdefault(name, last[name])
        costs = {name: _costs(problem, traces[name]) for name in ready}
        ends = {name: problem.cost((last.get(name) or traces[name]).y) for name in ready}
    inside = {name: problem.inside((last.get(name) or traces[name]).y) for name in ready}
    best = min(ends[name] for name in ready if inside[name])
    rows = {}
    for name in names:
        if name in absent:
            rows[name] = Row(absent=absent[name])
            continue
        cpu, wall = zip(*(times[name] or [(traces[name].points[-1][0], float("nan"))]), strict=True)
        curve = tuple((seconds, cost / best - 1) for seconds, cost in costs[name])
        rows[name] = Row(
            statistics.median(cpu),
            statistics.median(wall),
            ends[name] / best - 1,
            traces[name].stopped,
            inside[name],
            curve,
        )
    return Race(
        title, problem.model, len(problem.data), problem.data.source, problem.start_described(), rows, rounds, limit
    )


def _costs(problem: Problem, run: Run) -> list[tuple[float, float]]:
    """CPU seconds and the lowest finite cost until then, at some points of a run."""
    chosen = np.unique(np.round(np.geomspace(1, len(run.points), _POINTS_MAX)).astype(int) - 1)
    found, lowest = [], float("inf")
    for seconds, y in (run.points[i] for i in chosen):
        cost = problem.cost(y)
        lowest = min(lowest, cost) if np.isfinite(cost) else lowest
        found.append((seconds, lowest))
    return found

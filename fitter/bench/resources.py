"""What a fit takes besides its warm time: memory, the whole process, growth with the samples, many fits."""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

import fitter

from ..reflectance import Reflectance
from . import material
from .peers import contestant
from .problem import GAUGE, LOSS, MAX_THETA_DEG, Problem

_MINUTES_MAX = 10


@dataclasses.dataclass(frozen=True)
class Memory:
    """Megabytes: of the process with the data loaded, and by which its peak then exceeded that in the first fit, which
    compiles, and in the second."""

    loaded: float
    first: float
    second: float


@dataclasses.dataclass(frozen=True)
class Process:
    """Wall seconds of whole processes: `brdf fit` with an empty compilation cache and with a warm one, and of
    `python -c "import jax"`."""

    first: float
    second: float
    jax: float


@dataclasses.dataclass(frozen=True)
class Scaling:
    """CPU seconds of a fit by samples, and the straight line through them.

    - `points`: samples and median CPU seconds.
    - `intercept`, `slope`: seconds, and seconds per sample; the line minimises relative differences.
    - `deviation`: the largest relative difference from the line.
    """

    points: tuple[tuple[int, float], ...]
    intercept: float
    slope: float
    deviation: float


@dataclasses.dataclass(frozen=True)
class Throughput:
    """Fits of different materials one after the other or together.

    - `per_second`: fits per wall second.
    - `cores`: CPU time over wall time.
    - `absent`: why it was not run, if so.
    """

    per_second: float = float("nan")
    cores: float = float("nan")
    absent: str = ""


def fit(model: str, data: Reflectance) -> fitter.FitResult:
    """Our fit of the benchmark, without the bootstrap and the profiles, which no peer has."""
    fixed = Problem(model, data).fixed
    return fitter.fit(model, data, fixed=fixed, loss=LOSS, max_theta_deg=MAX_THETA_DEG, quick=True)


def memory(path: pathlib.Path, model: str) -> Memory:
    """Measures in a process of its own."""
    done = _checked([sys.executable, "-m", "fitter.bench.memory", str(path), model])
    return Memory(**json.loads(done.stdout))


def process(path: str, model: str, rounds: int) -> Process:
    """Measures whole processes in interleaved rounds; the cache is empty at the start of each."""
    command = ["-c", "from fitter.cli.main import main; main()", "fit", path, "--model", model, "-q"]
    seconds: dict[str, list[float]] = {"first": [], "second": [], "jax": []}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | {"BRDF_CACHE_DIR": cache}
            for name in ("first", "second"):
                seconds[name].append(wall([sys.executable, *command], environment))
            seconds["jax"].append(wall([sys.executable, "-c", "import jax"], environment))
    return Process(**{name: statistics.median(found) for name, found in seconds.items()})


def wall(command: Sequence[str], environment: dict[str, str]) -> float:
    """Seconds that a process takes; raises `RuntimeError` with its last words if it fails."""
    began = time.perf_counter()
    _checked(command, environment)
    return time.perf_counter() - began


def _checked(command: Sequence[str], environment: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(command, capture_output=True, text=True, timeout=60 * _MINUTES_MAX, env=environment)
    if done.returncode != 0:
        raise RuntimeError(f"`{' '.join(command)}` ended with {done.returncode}: {done.stderr[-500:]}")
    return done


def scaling(model: str, sizes: Sequence[int], folder: pathlib.Path, rounds: int, say: Callable[[str], None]) -> Scaling:
    """Fits tables of growing size."""
    tables = []
    for samples in sizes:
        say(f"scaling: a table of {samples} samples")
        tables.append(material.load(material.table(model, material.table_size(samples), folder)))
        fit(model, tables[-1])  # compiles
    seconds: list[list[float]] = [[] for _ in tables]
    for _ in range(rounds):
        for data, times in zip(tables, seconds, strict=True):
            say(f"scaling: fitting {len(data)} samples")
            began = time.process_time()
            fit(model, data)
            times.append(time.process_time() - began)
    return line([len(data) for data in tables], [statistics.median(times) for times in seconds])


def line(samples: Sequence[int], seconds: Sequence[float]) -> Scaling:
    """The straight line through the points that minimises relative differences."""
    n, t = np.asarray(samples, float), np.asarray(seconds, float)
    (intercept, slope), *_ = np.linalg.lstsq(np.stack([1 / t, n / t], axis=1), np.ones(len(n)), rcond=None)
    deviation = float(np.max(np.abs((intercept + slope * n) / t - 1)))
    return Scaling(tuple(zip(samples, seconds, strict=True)), float(intercept), float(slope), deviation)


def many(
    model: str, count: int, folder: pathlib.Path, rounds: int, say: Callable[[str], None]
) -> dict[str, Throughput]:
    """Fits slices of different materials: a loop over `fitter.fit`, `fitter.fit_many`, a loop over Optimistix."""
    say(f"many fits: {count} slices")
    slices = material.slices(count, folder)
    runs: dict[str, Callable[[], Any]] = {"loop over fitter.fit": lambda: [fit(model, data) for data in slices]}
    found: dict[str, Throughput] = {}
    options = {"loss": LOSS, "max_theta_deg": MAX_THETA_DEG, "quick": True, "fixed": GAUGE.get(model, {})}
    source = f"{material.slices_path(count, folder)}:*"
    cache = jax.config.values["jax_compilation_cache_dir"]
    runs["fitter.fit_many"] = lambda: list(
        fitter.fit_many([source], model, output=folder / "fits", force=True, cache=cache, **options)
    )
    with jax.enable_x64(True):
        problems = [contestant("Optimistix LM", Problem(model, data)) for data in slices]
        if isinstance(problems[0], str):
            found["loop over Optimistix LM"] = Throughput(absent=problems[0])
        else:
            runs["loop over Optimistix LM"] = lambda: [p.run(float("inf")) for p in problems if not isinstance(p, str)]
        for run in runs.values():
            run()  # compiles
        seconds: dict[str, list[tuple[float, float]]] = {name: [] for name in runs}
        for _ in range(rounds):
            for name, run in runs.items():
                say(f"many fits: {name}")
                began = _cpu(), time.perf_counter()
                run()
                seconds[name].append((_cpu() - began[0], time.perf_counter() - began[1]))
    for name, times in seconds.items():
        cpu, wall = (statistics.median(column) for column in zip(*times, strict=True))
        found[name] = Throughput(count / wall, cpu / wall)
    return found


def _cpu() -> float:
    """CPU seconds of this process and of its finished children."""
    import resource

    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)

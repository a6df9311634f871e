"""Runs the measurements of `brdf bench fit`."""

from __future__ import annotations

import dataclasses
import pathlib
import tempfile
from collections.abc import Callable, Sequence

import numpy as np

from ..formats import merl, read
from . import material, resources
from .fit_report import FitBench
from .peers import OURS, names
from .problem import Problem
from .race import race

SECTIONS = ("table", "slice", "scaling", "memory", "process", "many")
# The first model races against every peer and stands in the plot, the others against Optimistix.
MODELS = ("lambert+ggx", "ggx", "lambert+beckmann", "lambert+ggx+ggx", "disney")
_REFERENCE = "Optimistix LM"
# Sizes of the tables for the growth with the samples: shares of the largest.
_SHARES = (0.01, 0.03, 0.1, 0.3, 1.0)


@dataclasses.dataclass(frozen=True)
class Settings:
    """What is measured, and how.

    - `data`: a MERL `.binary` or other measurement that stands for the full table; None for a synthetic one.
    - `models`: expressions.
    - `samples`: of the synthetic table, about; None for MERL's own size.
    - `rounds`, `limit`: interleaved rounds, and CPU seconds after which a run is stopped.
    - `materials`: how many different slices are fitted for the throughput.
    - `sections`: of `SECTIONS`.
    """

    data: str | None
    models: Sequence[str]
    samples: int | None
    rounds: int
    limit: float
    materials: int
    sections: Sequence[str]


def bench(settings: Settings, say: Callable[[str], None]) -> FitBench:
    """Measures everything that `settings` ask for; `say` is told what is being done.

    Raises `UserError` for an unknown model, `FileError` for a file that cannot be read.
    """
    with tempfile.TemporaryDirectory() as folder:
        return _bench(settings, pathlib.Path(folder), say)


def _bench(settings: Settings, folder: pathlib.Path, say: Callable[[str], None]) -> FitBench:
    size = material.table_size(settings.samples)
    first, *others = settings.models
    wanted = set(settings.sections)

    def path(model: str) -> pathlib.Path:
        if settings.data is not None:
            return pathlib.Path(settings.data)
        say(f"tabulating a material for {model}, {' x '.join(map(str, size))}")
        return material.table(model, size, folder)

    races = []
    if "table" in wanted:
        for model in (first, *others):
            problem = Problem(model, material.load(path(model)))
            entrants = names() if model == first else (OURS, _REFERENCE)
            title = f"{model}, table"
            races.append(race(title, problem, entrants, settings.rounds, settings.limit, say))
    if "slice" in wanted:
        problem = Problem(first, read(_slice_file(settings.data, first, folder)))
        races.append(race(f"{first}, slice", problem, names(), settings.rounds, settings.limit, say))
    scaling = memory = process = many = None
    if "scaling" in wanted:
        most = settings.samples or int(np.prod(merl.SIZE) * 0.76)
        sizes = [round(share * most) for share in _SHARES]
        scaling = resources.scaling(first, sizes, folder, settings.rounds, say)
    if "memory" in wanted:
        say("memory: fitting in another process")
        memory = resources.memory(path(first), first)
    if "process" in wanted:
        say("whole processes")
        process = resources.process(_slice_file(settings.data, first, folder), first, settings.rounds)
    if "many" in wanted:
        many = resources.many(first, settings.materials, folder, settings.rounds, say)
    return FitBench(races, scaling, memory, process, many, first, settings.rounds, settings.limit, settings.materials)


def _slice_file(data: str | None, model: str, folder: pathlib.Path) -> str:
    """Writes the slice of the table as the `.npz` that `brdf fit` reads. It is one of a full table, whatever size the
    synthetic table has."""
    whole = read(data or material.table(model, (*merl.SIZE[:2], 2), folder))
    path = folder / "slice.npz"
    np.savez(path, slice=material.slice_values(whole))
    return f"{path}:slice"

"""The figures of `brdf bench fit`: as text, as the page of the docs, and as plain data."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import math
import os
from collections.abc import Sequence
from typing import Any

from . import material
from .peers import names, setup
from .problem import GAUGE
from .race import SAME, Race, Row
from .resources import Memory, Process, Scaling, Throughput
from .tables import Table, aligned, filled, piped


@dataclasses.dataclass(frozen=True)
class FitBench:
    """Everything that was measured; None where it was not.

    - `races`: the fits of tables, then of the slice.
    - `many`: name -> throughput over `materials` slices.
    - `model`: of all but the races.
    """

    races: Sequence[Race]
    scaling: Scaling | None
    memory: Memory | None
    process: Process | None
    many: dict[str, Throughput] | None
    model: str
    rounds: int
    limit: float
    materials: int


# What others publish about their time, as far as we have read it ourselves.
_PUBLISHED = (
    "Published figures of C++ fitters: n/a. ALTA (its tutorial fits MERL with the Ceres of the table), Bagher 2012 and "
    "Bieron and Peers 2020 state no time in what we could read of them. The C++ peer is therefore Ceres itself. "
    'Of another kind of model, a Gaussian process ("Fast and Accurate Gaussian Process Modelling of Real-World '
    'Materials", 2026), its abstract says that one material takes "only a few seconds".'
)


def data(found: FitBench) -> dict[str, Any]:
    """JSON-serialisable: no number is NaN."""
    return _finite(dataclasses.asdict(found))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def text(found: FitBench) -> str:
    """Tables of aligned columns."""
    parts = []
    for race in found.races:
        parts += [filled(_title(race)), aligned(_rows(race))]
    parts += [filled(sentence) for sentence in _sentences(found)]
    if found.many:
        parts.append(aligned(_many(found.many)))
    return "\n\n".join(parts)


def markdown(found: FitBench, plot: str | None) -> str:
    """The page of the docs, with the picture `plot` (a path beside the page) if there is one."""
    parts = ["<!-- Made by `brdf bench fit --markdown`. -->", "# Speed of a fit", _how(found)]
    if plot:
        parts.append(f"![Cost above the best, over CPU time]({plot})")
    for race in found.races:
        parts += [f"## {race.title}", _title(race), piped(_rows(race))]
    sentences = _sentences(found)
    if sentences:
        parts += ["## What else a fit takes", *sentences]
    if found.many:
        parts.append(piped(_many(found.many)))
    parts += [
        "## How each was run",
        _starts(found),
        "\n".join(f"- {name}: {setup(name)}." for name in names()),
        _PUBLISHED,
    ]
    return "\n\n".join(parts) + "\n"


def _how(found: FitBench) -> str:
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in ("jax", "numpy"))
    return (
        f"CPU seconds (of all threads) and wall seconds, median of {found.rounds} interleaved rounds on "
        f"{os.cpu_count()} cores with {versions}; float64, everything compiled before. All minimise the plain "
        "sum of squares of log(1 + f cos_i) - log(1 + y cos_i) over all samples; each final cost is computed anew by "
        f"the same function, and one more than {SAME:g} above the best (relative) is not the same minimum. "
        "Seconds differ between machines; compare the ratios."
    )


def _title(race: Race) -> str:
    held = ", ".join(f"{name} = {number:g}" for name, number in GAUGE.get(race.model, {}).items())
    return (
        f"{race.model} fitted to {race.samples} samples of {race.source}"
        + (f", with {held} held" if held else "")
        + f"; runs are stopped after {race.limit:g} s of CPU time."
    )


def _rows(race: Race) -> Table:
    rows: Table = [("", "CPU s", "wall s", "CPU / ours", "cost above best")]
    for name, row in race.rows.items():
        if row.absent:
            rows.append((name, "n/a", "", "", row.absent))
            continue
        seconds = f"stopped after {row.cpu:.0f}" if row.stopped else f"{row.cpu:.3g}"
        ratio = f"{'> ' if row.stopped else ''}{race.ratio(name):.3g}"
        rows.append((name, seconds, "" if row.stopped else f"{row.wall:.3g}", ratio, _excess(row)))
    return rows


def _excess(row: Row) -> str:
    """Differences below 1e-12 are the rounding of a sum over a million samples."""
    number = "< 1e-12" if abs(row.excess) < 1e-12 else f"{row.excess:.0e}"
    notes = [] if row.inside else ["out of bounds"]
    if row.excess > SAME:
        notes.append("not the same minimum")
    return ", ".join([number, *notes])


def _sentences(found: FitBench) -> list[str]:
    sentences = []
    if found.scaling:
        one = found.scaling
        points = ", ".join(f"{samples}: {seconds:.3g} s" for samples, seconds in one.points)
        sentences.append(
            f"Growth: CPU time of {found.model} on tables by number of samples: {points}. The straight line through "
            f"them is {1e3 * one.intercept:.0f} ms + {1e9 * one.slope:.0f} ns per sample, from which no point is off "
            f"by more than {100 * one.deviation:.0f} %."
        )
    if found.memory:
        one = found.memory
        sentences.append(
            f"Memory: a process that has loaded the table holds {one.loaded:.0f} MB; its peak in the fit exceeds that "
            f"by {one.first:.0f} MB, compiler included, and in a second fit by {one.second:.0f} MB."
        )
    if found.process:
        one = found.process
        sentences.append(
            f"Whole process, wall time: `brdf fit` of the slice takes {one.first:.2f} s with an empty compilation "
            f"cache and {one.second:.2f} s in the second run, which is {one.second / one.jax:.2f} times "
            f'`python -c "import jax"` ({one.jax:.2f} s).'
        )
    if found.many:
        sentences.append(
            f"Many fits: {found.materials} slices of different materials, {found.model}; core usage is CPU over wall "
            "time."
        )
    return sentences


def _many(found: dict[str, Throughput]) -> Table:
    reference = found.get("loop over Optimistix LM", Throughput()).per_second
    rows: Table = [("", "fits per s", "cores used", "x Optimistix")]
    for name, one in found.items():
        if one.absent:
            rows.append((name, "n/a", "", one.absent))
            continue
        ratio = f"{one.per_second / reference:.3g}" if math.isfinite(reference) else ""
        rows.append((name, f"{one.per_second:.3g}", f"{one.cores:.2f}", ratio))
    return rows


def _starts(found: FitBench) -> str:
    starts = "; ".join(f"{model}: {start}" for model, start in {race.model: race.start for race in found.races}.items())
    return (
        f"Synthetic tables hold {material.described()}. Ours finds its own start; the peers start at a common one from "
        f"which they reach the same minimum ({starts})."
    )

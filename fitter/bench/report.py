"""The figures of `brdf bench models`: as text, as the page of the docs, and as plain data."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import os
from collections.abc import Mapping
from typing import Any

from .measure import Cost, Speed
from .mitsuba import Peers
from .tables import Table, aligned, filled, piped


@dataclasses.dataclass(frozen=True)
class Bench:
    """Everything that was measured.

    - `speeds`: model -> figures.
    - `costs`: what may be absent -> the costs without and with it.
    - `points`, `dtype`, `rounds`, `one_core`: how.
    """

    speeds: Mapping[str, Speed]
    costs: Mapping[tuple[str, str], tuple[Cost, Cost]]
    peers: Peers
    points: int
    dtype: str
    rounds: int
    one_core: bool


def data(found: Bench) -> dict[str, Any]:
    """JSON-serialisable."""
    return {
        **{name: getattr(found, name) for name in ("points", "dtype", "rounds", "one_core")},
        "models": {name: dataclasses.asdict(one) for name, one in found.speeds.items()},
        "absent": [
            {"without": names[0], "with": names[1], "costs": [dataclasses.asdict(one) for one in pair]}
            for names, pair in found.costs.items()
        ],
        "mitsuba": {
            "note": found.peers.note,
            "models": {name: dataclasses.asdict(one) for name, one in found.peers.rows.items()},
        },
    }


def text(found: Bench) -> str:
    """Tables of aligned columns."""
    parts = [filled(_how(found)), aligned(_speeds(found))]
    if found.costs:
        parts += [filled(_ABSENT), aligned(_costs(found))]
    return "\n\n".join([*parts, filled(_mitsuba(found)), *([aligned(_peers(found))] if found.peers.rows else [])])


def markdown(found: Bench) -> str:
    """The page of the docs."""
    parts = ["<!-- Made by `brdf bench models --markdown`. -->", "# Speed of the models", _how(found)]
    parts += [_ratios(found), piped(_speeds(found))]
    if found.costs:
        parts += ["## What is absent costs nothing", _ABSENT, piped(_costs(found))]
    parts += ["## Mitsuba 3", _mitsuba(found), *([piped(_peers(found))] if found.peers.rows else [])]
    return "\n\n".join(parts) + "\n"


def _how(found: Bench) -> str:
    core = "one core (the process is bound to it)" if found.one_core else "all cores (this system binds no process)"
    versions = " and ".join(f"{name} {importlib.metadata.version(name)}" for name in ("jax", "numpy"))
    return (
        f"Millions of evaluations per CPU second on {core} of {os.cpu_count()}, with {versions}: {found.dtype}, "
        f"{found.points} pairs of directions per call in arrays (3, n), parameters at their defaults; warm, median of "
        f"{found.rounds} interleaved rounds. "
        "NumPy runs the model's own jaxpr operation by operation on whole arrays, without dead code or repetitions. "
        "The gradient is that to all live parameters, in forward mode as a fit takes it: one derivative per "
        "parameter, three per colour where a model mixes channels. The difference is the largest relative one of the "
        "two values."
    )


def _ratios(found: Bench) -> str:
    value = sorted(one.value / one.numpy_value for one in found.speeds.values())
    gradient = sorted(one.gradient / one.numpy_gradient for one in found.speeds.values())
    return (
        f"Compiled models are {value[0]:.1f} to {value[-1]:.1f} times as fast as NumPy in values, and "
        f"{gradient[0]:.1f} to {gradient[-1]:.1f} times with the gradient."
    )


_ABSENT = (
    "A static choice, or a weight that is known to be 0 beforehand, decides what is in the program at all: without a "
    "lobe, not one of its operations is left. In the table above all weights are numbers, whatever their value. "
    "Floating-point operations are XLA's count after simplification; array operations are those of the jaxpr."
)


def _speeds(found: Bench) -> Table:
    rows: Table = [("model", "value", "x NumPy", "with gradient", "x NumPy", "derivatives", "difference")]
    for name, one in found.speeds.items():
        ratios = (one.value / one.numpy_value, one.gradient / one.numpy_gradient)
        cells = (_millions(one.value), f"{ratios[0]:.1f}", _millions(one.gradient), f"{ratios[1]:.1f}")
        rows.append((name, *cells, str(one.derivatives), f"{one.difference:.0e}"))
    return rows


def _costs(found: Bench) -> Table:
    rows: Table = [("model", "flops per value", "array operations", "millions per s")]
    for names, pair in found.costs.items():
        for name, one in zip(names, pair, strict=True):
            rows.append((name, f"{one.flops:.0f}", str(one.operations), _millions(one.per_second)))
    return rows


def _mitsuba(found: Bench) -> str:
    return (
        f"{found.peers.note}. float32, values alone, both vectorised and in interleaved rounds, with sixteen times the "
        "points per call, since Mitsuba traces its program anew each time. Its principled model is another formula "
        "than Disney's of 2012, and its Beckmann masking is a rational fit: differences there are not rounding."
    )


def _peers(found: Bench) -> Table:
    rows: Table = [("model", "Mitsuba", "ours", "theirs", "ours / theirs", "median difference", "largest")]
    for name, one in found.peers.rows.items():
        label = f"{name} ({one.choices})" if one.choices else name
        cells = (_millions(one.ours), _millions(one.theirs), f"{one.ours / one.theirs:.2f}")
        rows.append((label, one.plugin, *cells, f"{one.median:.0e}", f"{one.largest:.0e}"))
    return rows


def _millions(per_second: float) -> str:
    return f"{per_second / 1e6:.0f}" if per_second > 1e8 else f"{per_second / 1e6:.3g}"

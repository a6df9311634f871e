"""What the stress test found, for a terminal, as Markdown for the docs, and as plain data."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from brdf.material import Material
from brdf.model import AbstractBRDF
from brdf.parameter import choices
from brdf.registry import split

from .accuracy import BAR, KAPPA, SMALLEST, Errors
from .points import GRAZING
from .run import Stressed
from .sweep import Counts, Offender

_COLUMNS = {
    "median": "median",
    "p99.9": "p99.9",
    "max": "max",
    "max_conditioned": f"max, kappa <= {KAPPA:g}",
    "max_units": "max / (eps max(1, kappa))",
    "of_bar": "share of the bar",
}


def text(found: Stressed) -> str:
    """One model, for a terminal."""
    head = f"{found.name}: {found.points:,} points, {len(found.structures)} combinations of choices"
    lines = [f"{head}, {found.seconds:.0f} s: {'passed' if found.passed else 'FAILED'}"]
    lines += [f"  {counts.arithmetic:12}  {counts.points:>10,} points, {_faults(counts)}" for counts in found.counts]
    if any(errors.errors for errors in found.errors):
        lines.append("  relative error against 50 digits")
        lines.append(f"  {'':12}  " + "  ".join(_COLUMNS.values()))
        for errors in found.errors:
            row = [f"{text:>{len(head)}}" for text, head in zip(_row(errors), _COLUMNS.values(), strict=True)]
            lines.append(f"  {errors.arithmetic:12}  " + "  ".join(row))
    for counts in found.counts:
        lines += [_offender(offender) for offender in counts.offenders]
    lines += [_worst(errors) for errors in found.errors if errors.worst_ratio > 1]
    return "\n".join(lines)


def _faults(counts: Counts) -> str:
    return ", ".join(f"{number:,} x {fault}" for fault, number in counts.faults.items() if number) or "no fault"


def _row(errors: Errors) -> list[str]:
    figures = errors.figures()
    formats = {"max_units": ".1f", "of_bar": ".2f"}
    return [f"{figures[key]:{formats.get(key, '.1e')}}" if key in figures else "" for key in _COLUMNS]


def _numbers(array: Any) -> str:
    """Numbers with every digit: what is printed reads back to the same float."""
    return json.dumps(np.asarray(array, np.float64).tolist())


def _offender(offender: Offender) -> str:
    lines = [f"  {offender.fault} in {offender.arithmetic}", *_point(offender.model, offender.wi, offender.wo)]
    lines.append(f"    value {_numbers(offender.value)}")
    broken = {name: g for name, g in offender.gradient.items() if not np.isfinite(g).all()}
    lines += [f"    gradient by {name} {_numbers(gradient)}" for name, gradient in broken.items()]
    return "\n".join(lines)


def _worst(errors: Errors) -> str:
    worst = errors.worst
    assert worst is not None
    lines = [f"  error {worst.error:.1e} at kappa {worst.kappa:.1e} in {errors.arithmetic}"]
    lines += [*_point(worst.model, worst.wi, worst.wo), f"    value {_numbers(worst.value)}"]
    return "\n".join([*lines, f"    exact [{', '.join(worst.exact)}]"])


def _point(model: AbstractBRDF, wi: Any, wo: Any) -> list[str]:
    parameters = json.dumps(Material(model).to_dict()["parameters"])
    return [f"    parameters {parameters}", f"    wi {_numbers(wi)}", f"    wo {_numbers(wo)}"]


def data(found: Sequence[Stressed]) -> dict[str, Any]:
    """Everything as plain data for JSON: model -> verdict, counts, first offenders and errors."""
    return {
        one.name: {
            "passed": one.passed,
            "points": one.points,
            "seconds": round(one.seconds, 1),
            "choices": [_choices(structure) for structure in one.structures],
            "faults": {counts.arithmetic: counts.faults for counts in one.counts},
            "offenders": [_offender(offender) for counts in one.counts for offender in counts.offenders],
            "errors": {errors.arithmetic: errors.figures() for errors in one.errors},
        }
        for one in found
    }


def _choices(model: AbstractBRDF) -> dict[str, dict[str, str]]:
    return {name: {c.name: getattr(lobe, c.name) for c in choices(lobe)} for name, lobe in split(model).items()}


def markdown(found: Sequence[Stressed], seed: int) -> str:
    """The page of the docs."""
    arithmetics = list(dict.fromkeys(counts.arithmetic for one in found for counts in one.counts))
    lines = [_INTRODUCTION.format(seed=seed, grazing=GRAZING)]
    lines += [f"| model | combinations of choices | {' | '.join(arithmetics)} | faults |"]
    lines += ["|---" * (len(arithmetics) + 3) + "|"]
    for one in found:
        tried = " | ".join(f"{counts.points:,}" for counts in one.counts)
        faults = "; ".join(f"{c.arithmetic}: {_faults(c)}" for c in one.counts if any(c.faults.values())) or "0"
        lines.append(f"| `{one.name}` | {len(one.structures)} | {tried} | {faults} |")
    lines += [_ERRORS.format(bar=BAR, kappa=KAPPA, small=SMALLEST["float32"], tiny=SMALLEST["float64"])]
    lines += [f"| model | arithmetic | values | {' | '.join(_COLUMNS.values())} |", "|---" * (len(_COLUMNS) + 3) + "|"]
    for one in found:
        for errors in one.errors:
            row = " | ".join(_row(errors))
            lines.append(f"| `{one.name}` | {errors.arithmetic} | {errors.figures()['values']:,} | {row} |")
    return "\n".join(lines)


_INTRODUCTION = """\
# Stress test

Made by `brdf stress --markdown --seed {seed}`; `brdf stress MODEL` repeats it for one model or a sum.

## What never may happen

Every model is evaluated at random and at adversarial directions: exact mirror, near mirror at the width of the lobe,
retro-reflection, grazing down to a cosine of {grazing:g}, normal incidence, `wi` almost and exactly `-wo`, both sides
of the cut of the azimuth, and the floating-point numbers next to them; with parameters at, next to and between their
bounds, and with every option of every static choice at least once. A fault is a NaN, an Inf or a negative number among
the values, light below the horizon, or a NaN or an Inf among the derivatives by any parameter or component of a
direction. The table counts evaluations of a pair of directions with a set of parameters; in JAX each has its gradient.
A GLSL compiler may turn a NaN into a number before anyone sees it, as llvmpipe does in `max` and `clamp`.
"""
_ERRORS = """
## Error against 50 digits

The truth is the model's own formula, as JAX traces it, evaluated with 50 digits at the same binary numbers, so that
this is what rounding does to the formula, and not a test of the formula. Relative errors are per channel; values below
{small:g} in float32 and {tiny:g} in float64 are left out, since their factors may have underflowed.

kappa is the condition number: the sum over parameters and directions of |x df/dx| / |f|. One rounding of the inputs
changes the value by about eps kappa (eps = 1.2e-7 and 2.2e-16), and so does, a few times over, any algorithm without
extra precision. The bar in float32 is {bar:g} where kappa is at most {kappa:g}, and {bar:g} kappa / {kappa:g} beyond:
in the tail of a Gaussian, with a large exponent, at a difference that is cut at zero, between opposite directions at
the horizon. In float64 it is the same number of eps. It forgives more than necessary near the mirror direction, where
the half vector is exact though kappa is large, and where compensated arithmetic does better; the raw maximum shows it.
"""

"""Where a fit starts: every value of the shape parameters is tried, the colours of each solved for.

With the shape parameters held, a sum of lobes is linear in its colours or nearly so: a few damped Gauss-Newton steps
find the best colours inside their bounds (variable projection, Golub and Pereyra 1973). This replaces a multi-start:
the slope of a lobe is never far from one of the values that its declaration lists.

- Golub, Pereyra 1973, "The Differentiation of Pseudo-Inverses and Nonlinear Least Squares Problems Whose Variables
  Separate".
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from brdf.parameter import choices as choices_of
from brdf.parameter import parameters
from brdf.registry import name_of, split

from .minimise import Problem, minimise
from .unknowns import Unknown, Unknowns

# Steps for the colours of a candidate. A few are enough to rank it.
_STEPS = 4
# A colour step that would lower the cost by a smaller share changes no rank.
_RTOL = 1e-3
# Up to this many combinations of shape parameters are enumerated.
_ENUMERATED_MAX = 20_000
# Most combinations of shape parameters that are tried; of more, a random choice.
_COMBINATIONS_MAX = 400
_SEED = 19730401


def candidates(unknowns: Unknowns, given: Mapping[int, float] | None = None) -> Float[np.ndarray, "m k"]:
    """The solver's vectors whose shape parameters are scanned, with the colours at the middle of their bounds.

    **Arguments:**

    - `given`: element -> value that all candidates have.

    **Returns:**

    At most 400 rows. Of interchangeable lobes the first has the smallest slope.
    """
    given = dict(given or {})
    shapes = [u for u in unknowns.free if u.parameter.kind == "scalar" and u.offset not in given]
    choices = [u.parameter.starts for u in shapes]
    total = math.prod(map(len, choices))
    if total <= _ENUMERATED_MAX:
        combinations = itertools.product(*choices)
    else:
        rng = np.random.default_rng(_SEED)
        combinations = (tuple(rng.choice(starts) for starts in choices) for _ in range(4 * _COMBINATIONS_MAX))
    groups = interchangeable(unknowns)
    lower, upper = unknowns.bounds()
    middle = 0.5 * (lower + upper)
    middle[list(given)] = list(given.values())
    rows: dict[tuple[float, ...], None] = {}
    for values in combinations:
        row = middle.copy()
        for unknown, value in zip(shapes, values, strict=True):
            row[unknown.offset] = unknown.inward(value)
        rows[tuple(sort_lobes(row, groups))] = None
    distinct = np.array([row for row in rows if not _repeats(np.array(row), groups)] or list(rows))
    if len(distinct) > _COMBINATIONS_MAX:
        kept = np.random.default_rng(_SEED).choice(len(distinct), _COMBINATIONS_MAX, replace=False)
        distinct = distinct[np.sort(kept)]
    return distinct


def scan(problem: Problem, rows: Float[np.ndarray, "m k"]) -> tuple[Float[np.ndarray, "m k"], Float[np.ndarray, " m"]]:
    """Solves for the colours of every candidate on the first chunk of the samples.

    **Returns:** the candidates with their colours, and their costs.
    """
    is_colour = np.zeros(problem.unknowns.size, bool)
    for unknown in problem.unknowns.free:
        is_colour[unknown.elements] = unknown.parameter.kind == "color"
    solved, costs = rows.copy(), np.full(len(rows), np.inf)
    for place, row in enumerate(rows):
        lower, upper = np.where(is_colour, problem.lower, row), np.where(is_colour, problem.upper, row)
        found = minimise(
            lambda y: problem.assess(y, count=1),
            row,
            lower,
            upper,
            rtol=_RTOL,
            atol=0.0,
            max_steps=_STEPS if is_colour.any() else 1,
        )
        if np.isfinite(found.cost):
            solved[place], costs[place] = found.y, found.cost
    return solved, costs


# One lobe's elements in the solver's vector, those of an interchangeable lobe in the same order.
Group = list[list[Unknown]]


def interchangeable(unknowns: Unknowns) -> list[Group]:
    """Lobes whose exchange changes nothing: one model, equal in all but what is free, and nothing tied.

    **Returns:** groups of two or more lobes, each lobe as its free parameters, one slope or more among them.
    """
    lobes = split(unknowns.template)
    groups: dict[str, Group] = {}
    for name, lobe in lobes.items():
        own = [u for u in unknowns.free if name in (place[0] for place in u.places)]
        if not any(u.parameter.slope for u in own) or any(len(u.places) > 1 for u in own):
            continue
        free = {u.parameter.name for u in own}
        held = {p.name: np.asarray(getattr(lobe, p.name)).tolist() for p in parameters(lobe) if p.name not in free}
        chosen = {c.name: getattr(lobe, c.name) for c in choices_of(lobe)}
        spans = [(u.parameter.name, u.parameter.lower, u.parameter.upper) for u in own]
        groups.setdefault(repr((name_of(lobe), spans, held, chosen)), []).append(own)
    return [group for group in groups.values() if len(group) > 1]


def sort_lobes(y: Float[np.ndarray, " k"], groups: list[Group]) -> Float[np.ndarray, " k"]:
    """The same point with interchangeable lobes in rising order of their slopes."""
    y = y.copy()
    for group in groups:
        values = [np.concatenate([y[u.elements] for u in lobe]) for lobe in group]
        order = sorted(range(len(group)), key=lambda place: _slope(y, group[place]))
        for lobe, place in zip(group, order, strict=True):
            for unknown, part in zip(lobe, _parts(lobe, values[place]), strict=True):
                y[unknown.elements] = part
    return y


def _slope(y: Float[np.ndarray, " k"], lobe: list[Unknown]) -> float:
    return float(np.mean([y[u.offset] for u in lobe if u.parameter.slope]))


def _parts(lobe: list[Unknown], values: np.ndarray) -> list[np.ndarray]:
    return np.split(values, np.cumsum([u.parameter.size for u in lobe])[:-1])


def _repeats(y: Float[np.ndarray, " k"], groups: list[Group]) -> bool:
    """Whether two interchangeable lobes have the same slope: as a start one of them would be idle."""
    return any(len({_slope(y, lobe) for lobe in group}) < len(group) for group in groups)

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
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from brdf.parameter import Parameter, parameters
from brdf.parameter import choices as choices_of
from brdf.registry import name_of, split

from .minimise import Problem, minimise
from .unknowns import Unknown, Unknowns

# Steps for the colours of a candidate. A few are enough to rank it.
_STEPS = 4
# The same where parameters that are not linear are solved for with them.
_STEPS_BENT = 6
# A colour step that would lower the cost by a smaller share changes no rank.
_RTOL = 1e-3
# About the most combinations of shape parameters that are tried.
_COMBINATIONS_MAX = 160
# Candidates whose parameters of a single start are drawn at random.
_DRAWN = 48
_SEED = 19730401
# A little anisotropy, as a share of the most.
_SOME = 0.2
# The factor by which the slopes of a divided lobe go apart.
_APART = 1.7
# Slopes whose ratio is smaller, or other shapes that differ by a smaller share of their range, are near.
_NEAR_FACTOR, _NEAR_SHARE = 1.5, 0.1


def candidates(unknowns: Unknowns, given: Mapping[int, float] | None = None) -> Float[np.ndarray, "m k"]:
    """The solver's vectors whose shape parameters are scanned, with the colours at the middle of their bounds.

    **Arguments:**

    - `given`: element -> value that all candidates have.

    **Returns:**

    At most 160 rows, and 48 more where a shape parameter declares but one start: in these it is drawn at random. Of
    interchangeable lobes the first has the smallest slope.
    """
    given = dict(given or {})
    shapes = [u for u in unknowns.free if u.parameter.kind == "scalar" and u.offset not in given]
    groups = interchangeable(unknowns)
    lower, upper = unknowns.bounds()
    middle = 0.5 * (lower + upper)
    middle[list(given)] = list(given.values())
    rows: dict[tuple[float, ...], None] = {}
    for values in itertools.product(*_thinned(shapes, groups)):
        row = middle.copy()
        for unknown, value in zip(shapes, values, strict=True):
            row[unknown.offset] = unknown.inward(value)
        rows[tuple(sort_lobes(row, groups))] = None
    distinct = [np.array(row) for row in rows]
    distinct = np.array([row for row in distinct if not _repeats(row, groups)] or distinct)
    single = [u.offset for u in shapes if len(u.parameter.starts) == 1]
    if not single:
        return distinct
    rng = np.random.default_rng(_SEED)
    drawn = np.resize(rng.permutation(distinct), (_DRAWN, len(middle)))
    loose = [u.offset for u in shapes if not u.parameter.slope]
    drawn[:, loose] = rng.uniform(lower[loose], upper[loose], (_DRAWN, len(loose)))
    return np.concatenate([distinct, drawn])


def _starts(parameter: Parameter) -> tuple[float, ...]:
    """The declared starts; those of a slope go on down to its lower bound by factors of two."""
    if not parameter.slope:
        return parameter.starts
    lowest = parameter.starts[0]
    below = [lowest / 2**n for n in range(1, 1 + int(math.log2(lowest / parameter.lower)))]
    return (*reversed(below), *parameter.starts)


def _thinned(shapes: Sequence[Unknown], groups: list[Group]) -> list[Sequence[float]]:
    """Evenly fewer starts of each shape, so that there are not too many combinations."""
    choices = [_starts(shape.parameter) for shape in shapes]
    alike = [[shapes.index(u) for lobe in group for u in lobe if u.parameter.slope and u in shapes] for group in groups]

    def combinations(counts: list[int]) -> float:
        """Without those that differ by an exchange of lobes, or in which two of them have the same slope."""
        total = float(math.prod(counts))
        for places in alike:
            if len({counts[place] for place in places}) == 1:
                total *= math.comb(counts[places[0]], len(places)) / counts[places[0]] ** len(places)
        return total

    power, counts = 1.0, [len(values) for values in choices]
    while combinations(counts) > _COMBINATIONS_MAX and power > 0:
        power -= 0.02
        counts = [max(round(len(values) ** power), 1) for values in choices]
    # The middles of equal parts.
    return [
        [values[int((place + 0.5) * len(values) / count)] for place in range(count)]
        for values, count in zip(choices, counts, strict=True)
    ]


def scan(problem: Problem, rows: Float[np.ndarray, "m k"]) -> tuple[Float[np.ndarray, "m k"], Float[np.ndarray, " m"]]:
    """Solves for all but the scanned shapes of every candidate on the first chunk of the samples.

    **Returns:** the candidates with what was solved for, and their costs.
    """
    free = problem.unknowns.free
    solvable = np.zeros(problem.unknowns.size, bool)
    for unknown in free:
        solvable[unknown.elements] = unknown.parameter.kind == "color" or len(unknown.parameter.starts) == 1
    steps = _STEPS if all(u.parameter.kind == "color" or len(u.parameter.starts) > 1 for u in free) else _STEPS_BENT
    solved, costs = rows.copy(), np.full(len(rows), np.inf)
    for place, row in enumerate(rows):
        lower, upper = np.where(solvable, problem.lower, row), np.where(solvable, problem.upper, row)
        found = minimise(
            lambda y: problem.assess(y, count=1),
            row,
            lower,
            upper,
            rtol=_RTOL,
            atol=0.0,
            max_steps=steps if solvable.any() else 1,
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


def near(unknowns: Unknowns, a: Float[np.ndarray, " k"], b: Float[np.ndarray, " k"]) -> bool:
    """Whether two starts differ so little in their shapes that they lead to the same minimum."""
    for u in unknowns.free:
        if u.parameter.kind == "color":
            continue
        x, y = float(a[u.offset]), float(b[u.offset])
        if u.parameter.slope:
            if not 1 / _NEAR_FACTOR < x / y < _NEAR_FACTOR:
                return False
        elif abs(x - y) > _NEAR_SHARE * (u.parameter.upper - u.parameter.lower):
            return False
    return True


def elsewhere(unknowns: Unknowns, y: Float[np.ndarray, " k"]) -> list[Float[np.ndarray, " k"]]:
    """Points that a descent cannot reach from a minimum and that may lie lower.

    An angle that ended at a bound is the same at the other one. An anisotropy that ended at 0 may have been pushed
    there because the angle of its axes was half wrong, by a quarter turn. Of two specular lobes of different models
    each may explain what the other should.
    """
    found = []
    turned = y.copy()
    for u in unknowns.free:
        p = u.parameter
        if not p.azimuthal or p.unit != "rad":
            continue
        if y[u.offset] in (p.lower, p.upper):
            turned[u.offset] = p.lower + p.upper - y[u.offset]
        for other in unknowns.free:
            if other is not u and other.parameter.azimuthal and other.lobe == u.lobe and y[other.offset] == 0:
                middle = 0.5 * (p.lower + p.upper)
                turned[u.offset] = y[u.offset] + (middle - p.lower) * (1 if y[u.offset] < middle else -1)
                turned[other.offset] = _SOME * other.parameter.upper
    if not np.array_equal(turned, y):
        found.append(turned)
    lobes: dict[str, list[Unknown]] = {}
    for u in unknowns.free:
        lobes.setdefault(u.lobe, []).append(u)
    models = split(unknowns.template)
    for (a, own), (b, other) in itertools.combinations(lobes.items(), 2):
        pairs = [(_slopes(lobe), [u for u in lobe if u.parameter.kind == "color"]) for lobe in (own, other)]
        if not all(slopes and colors for slopes, colors in pairs):
            continue
        if name_of(models[a]) == name_of(models[b]):
            found += [_divided(y, one, two) for one, two in ((own, other), (other, own))]
            continue
        swapped = y.copy()
        for kind in (0, 1):
            for u, v in zip(pairs[0][kind], pairs[1][kind], strict=False):
                swapped[u.elements], swapped[v.elements] = y[v.elements], y[u.elements]
        found.append(swapped)
    lower, upper = unknowns.bounds()
    return [np.clip(point, lower, upper) for point in found]


def _divided(y: Float[np.ndarray, " k"], one: list[Unknown], two: list[Unknown]) -> Float[np.ndarray, " k"]:
    """The same point with both of two lobes in the place of the first, one wider and one narrower."""
    y = y.copy()
    for u, v in zip(one, two, strict=False):
        if u.parameter.name == v.parameter.name and u.parameter.size == v.parameter.size:
            ours, theirs = (_APART, 1 / _APART) if u.parameter.slope else (1.0, 1.0)
            if u.parameter.kind == "color":
                ours = theirs = 0.5
            y[v.elements], y[u.elements] = theirs * y[u.elements], ours * y[u.elements]
    return y


def _slopes(lobe: list[Unknown]) -> list[Unknown]:
    return [u for u in lobe if u.parameter.slope]

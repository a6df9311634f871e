"""The search for round lobes of one width side by side, which make the streak of a brushed highlight.

Amplitudes are the best ones for each shape, as in `stacked_lobes`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from .round_samples import Array, Samples
from .round_shape import MIRRORED, NOTHING, WIDTHS, Shape

# How far apart they lie along the wide direction at most, in units of their width, so that a lamp's image is a streak
# and not a row of lamps; and how many there are.
_APART = 1.3
_COUNT_MIN, _COUNT_MAX = 5, 13
# Of the farthest ones in units of a spread that is searched.
_REACH = 1.6


def brushed_lobes(samples: Samples, at_horizon: Array, cost: float) -> Shape:
    """The best of each second width, and then of those around it and of all powers.

    **Arguments:** `at_horizon`: shape (v, c, m), of the kernels that end at the horizon; `cost`: with those alone.
    """
    costs: dict[tuple[float, int, int], float] = {}
    spreads = range(2, len(WIDTHS), 2)

    def look(powers: Sequence[float], widths: Sequence[int]) -> tuple[float, int, int]:
        for one in itertools.product(powers, widths, spreads):
            shape = _row(*one)
            if shape is not None and one not in costs:
                costs[one] = samples.cost(np.concatenate([shape.columns(samples), at_horizon], axis=-1))
        return min(costs, key=costs.__getitem__)

    _, middle, _ = look([math.inf], spreads)
    best = look([2.0, math.inf], range(middle - 1, min(middle + 2, len(WIDTHS))))
    shape = _row(*best)
    return NOTHING if shape is None or costs[best] >= cost else shape


def _row(power: float, width: int, spread: int) -> Shape | None:
    """Lobes of one of `WIDTHS`, evenly spaced over one of them; None if they are too far apart or all in one place."""
    reach = _REACH * WIDTHS[spread]
    n = max(2 * math.ceil(reach / (_APART * WIDTHS[width])) + 1, _COUNT_MIN)
    if WIDTHS[spread] < 0.5 * WIDTHS[width] or n > _COUNT_MAX:
        return None
    tilt, lean = np.tile(MIRRORED, (n, 1)), np.arange(-(n // 2), n // 2 + 1) * (reach / (n // 2))
    return Shape(np.full(n, power), np.full(n, math.log(WIDTHS[width])), tilt, lean)

"""Which samples a judgement of models leaves out of the fit: whole blocks of neighbouring angles.

Samples beside one another are nearly the same measurement: leaving out single ones would only ask a model to
interpolate between them. So the angle of incidence is cut into contiguous blocks, and blocks are left out whole, each
fold every fourth of them, so that the ends of the range are asked for as little beyond what was seen as the middle.

What the angle of incidence is depends on the measurement. In a table over half and difference angles it is theta_d, at
which the highlight reflects; elsewhere it is theta_i. A measurement at one incident angle leaves out blocks of theta_o
instead, and if there is but one of these too, of theta_h.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from .reflectance import Reflectance
from .rusinkiewicz import half_difference

FOLDS = 4
# Blocks of angles: three per fold. Over 80 degrees they are 7 degrees wide, far wider than a table's rows.
_BLOCKS = 12
# Angles that differ by less are the same; instruments repeat theirs to a tenth of a degree or so.
_SAME_DEG = 0.25


@dataclasses.dataclass(frozen=True)
class Blocks:
    """The block of angles to which each sample belongs.

    - `angle`: `theta_d`, `theta_i`, `theta_o` or `theta_h`.
    - `block`: (n,) int, from 0 in rising order of the angle.
    - `count`: how many blocks there are, at most 12; below 2 nothing can be left out.
    """

    angle: str
    block: np.ndarray
    count: int

    @property
    def folds(self) -> int:
        """How many fits leave something out: at most 4, and 0 where nothing can be."""
        return 0 if self.count < 2 else min(FOLDS, self.count)

    def held_out(self, fold: int) -> np.ndarray:
        """(n,) bool: the samples that a fold leaves out, every fourth block."""
        return self.block % self.folds == fold


def blocks(data: Reflectance) -> Blocks:
    """Cuts a measurement's angles of incidence into blocks that hold equally many distinct angles."""
    angles = half_difference(data.wi, data.wo)
    known = {
        "theta_d": angles.theta_d,
        "theta_i": _polar(data.wi),
        "theta_o": _polar(data.wo),
        "theta_h": angles.theta_h,
    }
    if data.grid is None or "theta_d" not in data.grid.axes:
        del known["theta_d"]
    found = Blocks("theta_i", np.zeros(len(data), int), 1)
    for name, angle in known.items():
        steps = np.round(np.degrees(angle) / _SAME_DEG).astype(int)
        distinct, place = np.unique(steps, return_inverse=True)
        count = min(_BLOCKS, len(distinct))
        candidate = Blocks(name, place * count // len(distinct), count)
        if count >= FOLDS:
            return candidate
        if count > found.count:
            found = candidate
    return found


def _polar(w: np.ndarray) -> np.ndarray:
    return np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2])

"""How different two pictures are to the eye and in numbers.

- Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", by its authors' package.
"""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from typing import Any

import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

# What lies behind the sphere, encoded: the sky is the same in all pictures.
_GROUND = 0.5
# Pixels covered by as much count as the sphere's.
_INSIDE = 0.5


@dataclasses.dataclass(frozen=True)
class Difference:
    """Between a picture and the truth.

    - `flip`, `flip_inside`: mean FLIP of the whole picture, and of the sphere.
    - `rmse`: of the sphere, sRGB-encoded, white being 1.
    """

    flip: float
    flip_inside: float
    rmse: float


def check_flip() -> None:
    """Raises `UserError` when the package of FLIP is not installed."""
    if importlib.util.find_spec("flip_evaluator") is None:
        raise UserError(
            "`flip_evaluator`, which measures FLIP, is not installed. Run: pip install 'flip-evaluator>=1.7'"
        )


def difference(reference: NDArray[np.float32], test: NDArray[np.float32]) -> Difference:
    """The difference of two pictures for displays with coverage, shape (h, w, 4), in [0, 1]."""
    flip: Any = importlib.import_module("flip_evaluator")
    inside = reference[..., 3] > _INSIDE
    pictures = [_on_ground(one) for one in (reference, test)]
    flips, mean, _ = flip.evaluate(pictures[0], pictures[1], "LDR", applyMagma=False)
    squares = (pictures[0] - pictures[1])[inside].astype(np.float64) ** 2
    return Difference(float(mean), float(np.asarray(flips)[inside].mean()), float(np.sqrt(squares.mean())))


def _on_ground(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    coverage = picture[..., 3:]
    return np.clip(picture[..., :3] * coverage + _GROUND * (1 - coverage), 0, 1).astype(np.float32)

"""The sun of an environment, taken out of it: a small light that is strong enough to show a highlight's own shape.

A round lobe's image of it is round in directions of light, where a microfacet's is round in half vectors: away from the
mirror's axis one is half as wide as the other, and no sum of a few round lobes hides it. So a material is lit by such a
light by its own values, and by blurs of the rest alone.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .environment import Environment
from .lamps import find_lamps

if TYPE_CHECKING:
    from .round_lobes import RoundLobes

# From its brightest texel, in radians, and in texels of a coarser picture. The sun's radius is 0.005.
_RADIUS, _TEXELS = 0.03, 2
# Of all light, in each texel's brightest channel: with less it does not stand out.
_SHARE_MIN = 0.02
# Of the root mean square of angles within it: narrower kernels show its own shape. One that is as narrow is twice as
# high in the middle for a point, where the picture is white anyway.
_WIDTHS = 0.7
# Of round lobes: what misses less looks the same.
_MISFIT_MIN = 0.02


@dataclasses.dataclass(frozen=True, eq=False)
class Sun:
    """A light without size.

    - `direction`: shape (3,), float64, unit, in the environment's axes.
    - `irradiance`: shape (3,), float32, on a surface that faces it.
    - `spread`: the root mean square of its light's angles from there, in radians.
    - `rest`: the environment without it.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float32]
    spread: float
    rest: Environment


def light_of(environment: Environment, lobes: RoundLobes) -> tuple[Environment, Sun | None]:
    """What a material's look-ups are of, and the sun by which it is lit apart from them, if it is.

    Round lobes that fit well need no help, and a narrow highlight shows the sun's own shape.
    """
    sun = find_sun(environment) if lobes.misfit > _MISFIT_MIN else None
    width = lobes.highlight_width
    if sun is None or (width is not None and width < _WIDTHS * sun.spread):
        return environment, None
    return sun.rest, sun


@functools.lru_cache(8)
def find_sun(environment: Environment) -> Sun | None:
    """What lies around the brightest texel and above the limit of `lamps`, if it holds light that counts."""
    lamps = find_lamps(environment)
    strength = lamps.fluxes.max(axis=1)
    if not len(strength):
        return None
    directions = lamps.directions.astype(np.float64)
    height, width = environment.pixels.shape[:2]
    texel = np.pi / height
    is_near = np.linalg.norm(directions - directions[strength.argmax()], axis=1) < max(_RADIUS, _TEXELS * texel)
    if strength[is_near].sum() < _SHARE_MIN * strength.sum() / lamps.share:
        return None
    middle = strength[is_near] @ directions[is_near]
    middle /= np.linalg.norm(middle)
    squares = np.square(directions[is_near] - middle).sum(axis=1)
    # Between texels light is interpolated, which spreads each of them by a sixth of its squared width either way.
    spread = math.sqrt(np.average(squares, weights=strength[is_near]) + texel**2 / 3)
    pixels = environment.pixels.copy()
    x, y, z = directions[is_near].T
    row = (np.arctan2(np.hypot(x, z), y) / np.pi * height).astype(int)
    column = ((0.5 + np.arctan2(x, -z) / (2 * np.pi)) * width).astype(int)
    pixels[row, column] = np.minimum(pixels[row, column], np.float32(lamps.limit))
    rest = Environment(pixels, f"{environment.name} without its sun")
    return Sun(middle, lamps.fluxes[is_near].sum(axis=0), spread, rest)

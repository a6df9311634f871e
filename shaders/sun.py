"""The sun of an environment, taken out of it: one compact light, strong enough to show a highlight's own shape.

A round lobe's image of it is round in directions of light, where a microfacet's is round in half vectors: away from the
mirror's axis one is half as wide as the other, and no sum of a few round lobes hides it. So a material is lit by such a
light by its own values, and by blurs of the rest alone. A studio's spot light is a sun too; a soft box is none.

Lobes that are narrower than the sun show its shape, which those values for its middle do not have: they blur the
environment with it, and what they reflect of it is taken off.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .environment import Environment
from .kernel import Kernel
from .lamps import find_bright

if TYPE_CHECKING:
    from .round_lobes import RoundLobes

# From its middle, in radians, and in texels of a coarse picture. The sun's own is 0.005, its glow's a few times that.
_RADII, _TEXELS = (0.03, 0.06, 0.12, 0.2), 2
# Within twice the radius there is no more than so many times the light: else it is a part of something larger.
_COMPACT = 1.15
# Of all light, in each texel's brightest channel: with less it does not stand out.
_SHARE_MIN = 0.02
_STEPS_TO_MIDDLE = 4
# Of the root mean square of angles within it: narrower kernels show its own shape. One that is as narrow is twice as
# high in the middle for a point, where the picture is white anyway.
_WIDTHS = 0.7
# Of round lobes: what misses less looks the same.
_MISFIT_MIN = 0.02


@dataclasses.dataclass(frozen=True, eq=False)
class Sun:
    """A small light.

    - `direction`: shape (3,), float64, unit, in the environment's axes.
    - `irradiance`: shape (3,), float32, on a surface that faces it.
    - `spread`: the root mean square of its light's angles from there, in radians.
    - `rest`: the environment without it.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float32]
    spread: float
    rest: Environment

    @property
    def edge(self) -> float:
        """By which it rises and sets, as a cosine: a disc of this spread on the horizon lights as much as a strip that
        reaches so far to both sides."""
        return 1.2 * self.spread


def sun_of(environment: Environment, lobes: RoundLobes) -> Sun | None:
    """The sun by which a material is lit apart from its look-ups, if it is: round lobes that fit well need no help, and
    a mirror shows the sun's own shape."""
    sun = find_sun(environment) if lobes.misfit > _MISFIT_MIN else None
    return None if sun is None or all(is_narrow(lobes, kernel, sun) for kernel in lobes.kernels) else sun


def is_narrow(lobes: RoundLobes, kernel: Kernel, sun: Sun | None) -> bool:
    """Whether one of a material's kernels shows the sun's own shape, and so blurs the environment with it.

    None does if all together are wide enough: narrow ones then are a part of one highlight, or of its rim.
    """
    if sun is None or lobes.highlight_width is None or lobes.highlight_width >= _WIDTHS * sun.spread:
        return False
    return kernel.power > 0 and kernel.width < _WIDTHS * sun.spread


def light_of(environment: Environment, lobes: RoundLobes, kernel: Kernel) -> Environment:
    """What one of a material's kernels blurs."""
    sun = sun_of(environment, lobes)
    return environment if sun is None or is_narrow(lobes, kernel, sun) else sun.rest


@functools.lru_cache(8)
def find_sun(environment: Environment) -> Sun | None:
    """The light about the brightest texel, if it is compact and holds light that counts."""
    bright = find_bright(environment)
    directions, strength = bright.directions.astype(np.float64), bright.fluxes.max(axis=1)
    height, width = environment.pixels.shape[:2]
    texel = np.pi / height
    if bright.share < _SHARE_MIN:
        return None
    least = _SHARE_MIN * float(strength.sum()) / bright.share
    compact = _compact(directions, strength, least, texel)
    if compact is None:
        return None
    middle, is_near = compact
    squares = np.square(directions[is_near] - middle).sum(axis=1)
    # Between texels light is interpolated, which spreads each of them by a sixth of its squared width either way.
    spread = math.sqrt(np.average(squares, weights=strength[is_near]) + texel**2 / 3)
    pixels = environment.pixels.copy()
    x, y, z = directions[is_near].T
    row = (np.arctan2(np.hypot(x, z), y) / np.pi * height).astype(int)
    column = ((0.5 + np.arctan2(x, -z) / (2 * np.pi)) * width).astype(int)
    pixels[row, column] = np.minimum(pixels[row, column], np.float32(bright.limit))
    rest = Environment(pixels, f"{environment.name} without its sun")
    return Sun(middle, bright.fluxes[is_near].sum(axis=0), spread, rest)


def _compact(
    directions: NDArray[np.float64], strength: NDArray[np.float32], least: float, texel: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]] | None:
    """The middle of the smallest compact light about the brightest texel that has this strength, and what belongs to
    it."""
    for radius in _RADII:
        radius = max(radius, _TEXELS * texel)
        middle = directions[strength.argmax()]
        is_near = np.linalg.norm(directions - middle, axis=1) < radius
        for _ in range(_STEPS_TO_MIDDLE):
            middle = strength[is_near] @ directions[is_near]
            middle /= np.linalg.norm(middle)
            is_near = np.linalg.norm(directions - middle, axis=1) < radius
        inside = strength[is_near].sum()
        around = strength[np.linalg.norm(directions - middle, axis=1) < 2 * radius].sum()
        if inside >= least and around <= _COMPACT * inside:
            return middle, is_near
    return None

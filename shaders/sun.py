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

# From its middle, in radians, and in texels of a coarse picture. The sun's own is 0.005, its glow's a few times that. A
# picture whose texels are larger has none.
_RADII, _TEXELS = (0.03, 0.06, 0.12, 0.2), 2
# Within twice the radius there is no more than so many times the light: else it is a part of something larger.
_COMPACT = 1.15
# Of all light, in each texel's brightest channel: with less it does not stand out.
_SHARE_MIN = 0.02
_STEPS_TO_MIDDLE = 4
# Of the root mean square of angles within it, the widths below which a kernel shows its shape: beside wider ones, and
# where all are narrow. A narrow highlight that is lit apart is too small and too high, where the picture is white; a
# narrow one that is looked up has a cube's texels for its shape.
_SHAPE, _ALL_SHAPE = 0.7, 0.2
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
    if sun is None:
        return None
    width = lobes.highlight_width
    is_mirror = width is not None and width < _ALL_SHAPE * sun.spread and all(_narrow(lobes, sun))
    return None if is_mirror else sun


def is_narrow(lobes: RoundLobes, kernel: Kernel, sun: Sun | None) -> bool:
    """Whether one of a material's kernels shows the sun's own shape, and so blurs the environment with it.

    None does if all together are wide enough, since narrow ones then are a part of one highlight, or of its rim; nor if
    all of them are narrow.
    """
    if sun is None or lobes.highlight_width is None or lobes.highlight_width >= _SHAPE * sun.spread:
        return False
    narrow = _narrow(lobes, sun)
    return narrow[lobes.kernels.index(kernel)] and not all(narrow)


def _narrow(lobes: RoundLobes, sun: Sun) -> list[bool]:
    """Which of a material's kernels are narrower than the sun."""
    return [kernel.power > 0 and kernel.width < _SHAPE * sun.spread for kernel in lobes.kernels]


def light_of(environment: Environment, lobes: RoundLobes, kernel: Kernel) -> Environment:
    """What one of a material's kernels blurs."""
    sun = sun_of(environment, lobes)
    return environment if sun is None or is_narrow(lobes, kernel, sun) else sun.rest


@functools.lru_cache(8)
def find_sun(environment: Environment) -> Sun | None:
    """The light about the brightest texel, if it is compact and holds light that counts."""
    height, width = environment.pixels.shape[:2]
    texel = np.pi / height
    bright = find_bright(environment)
    if bright.share < _SHARE_MIN or _TEXELS * texel > _RADII[-1]:
        return None
    directions, strength = bright.directions.astype(np.float64), bright.fluxes.max(axis=1)
    least = _SHARE_MIN * float(strength.sum()) / bright.share
    compact = _compact(directions, strength, least, texel)
    if compact is None:
        return None
    middle, own = compact
    squares = np.square(directions[own] - middle).sum(axis=1)
    # Between texels light is interpolated, which spreads each of them by a sixth of its squared width either way.
    spread = math.sqrt(np.average(squares, weights=strength[own]) + texel**2 / 3)
    pixels = environment.pixels.copy()
    x, y, z = directions[own].T
    row = (np.arctan2(np.hypot(x, z), y) / np.pi * height).astype(int)
    column = ((0.5 + np.arctan2(x, -z) / (2 * np.pi)) * width).astype(int)
    pixels[row, column] = np.minimum(pixels[row, column], np.float32(bright.limit))
    rest = Environment(pixels, f"{environment.name} without its sun")
    return Sun(middle, bright.fluxes[own].sum(axis=0), spread, rest)


def _compact(
    directions: NDArray[np.float64], strength: NDArray[np.float32], least: float, texel: float
) -> tuple[NDArray[np.float64], NDArray[np.intp]] | None:
    """The middle of the smallest compact light about the brightest texel that has this strength, and which of the
    texels belong to it."""
    brightest = directions[strength.argmax()]
    within = np.linalg.norm(directions - brightest, axis=1) < 4 * _RADII[-1]
    # What is farther away is looked at no more.
    directions, strength, texels = directions[within], strength[within], np.flatnonzero(within)
    for radius in _RADII:
        radius = max(radius, _TEXELS * texel)
        middle = brightest
        is_near = np.linalg.norm(directions - middle, axis=1) < radius
        for _ in range(_STEPS_TO_MIDDLE):
            middle = strength[is_near] @ directions[is_near]
            middle /= np.linalg.norm(middle)
            is_near = np.linalg.norm(directions - middle, axis=1) < radius
        inside = strength[is_near].sum()
        around = strength[np.linalg.norm(directions - middle, axis=1) < 2 * radius].sum()
        if inside >= least and around <= _COMPACT * inside:
            return middle, texels[is_near]
    return None

"""Round kernels: how light from around a direction is weighted when an environment is blurred for a lobe.

A kernel of width alpha weighs the angle theta from its middle by

    (1 + tan^2(theta / 2) / alpha^2)^-power,    exp(-tan^2(theta / 2) / alpha^2) for an infinite power:

seen along the normal, a mirror's image blurred by GGX (power 2), by Beckmann and its likes (infinite), or by the tails
between and beyond them. Two more have no width and end at the horizon of the normal that they lie about: the cosine of
a diffuse surface, and cos / (cos + 1/4), to which very rough facets tend. The integral of each is 1.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .harmonics import kernel_coefficients

POWERS = (1.5, 2.0, 3.0, math.inf)
# Widths are those of a geometric row, so that materials that nearly agree share their blurred environments.
STEPS_PER_OCTAVE = 4
# Below it a kernel is narrower than a texel of the picture that it blurs: the picture itself serves.
WIDTH_MIN = 0.004
# Narrower kernels are sampled, wider ones convolved, which costs the square of 1 / width.
WIDTH_SAMPLED = 0.03
# Of spherical harmonics, for the widest too, which need less but share what is found out about an environment.
DEGREE_MIN = 40
_NODES = 512
_CROWDING = 4


@dataclasses.dataclass(frozen=True, order=True)
class Kernel:
    """A round kernel.

    - `power`: one of `POWERS`, or 0 for one that ends at the horizon.
    - `step`: the width is `2 ** (step / STEPS_PER_OCTAVE)`; of those of power 0, a number.
    """

    power: float
    step: int

    @property
    def width(self) -> float:
        return 2.0 ** (self.step / STEPS_PER_OCTAVE)

    @property
    def name(self) -> str:
        """Short, unique and fit for a file's name."""
        if self.power == 0:
            return "cosine" if self == COSINE else "saturated"
        return f"{'gaussian' if math.isinf(self.power) else f'power{self.power:g}'}_{self.width:.4f}"

    @property
    def degree(self) -> int:
        """The degree in spherical harmonics above which 1e-2 of the kernel's height, or less, is left."""
        if self.power == 0:
            return DEGREE_MIN
        return max(math.ceil((3.2 if math.isinf(self.power) else 4.6) / self.width), DEGREE_MIN)

    @property
    def is_smooth(self) -> bool:
        """Whether 1e-4 of the kernel's height, or less, is left above its degree."""
        return self.power > 0 and self.width >= 10 / DEGREE_MIN

    @property
    def texels(self) -> int:
        """Texels along an edge of the cube that holds an environment blurred by it.

        Three to its half width or more, but for the narrowest, whose pictures are no better for more than they have.
        Between them values are interpolated linearly, and that is what is left of a wide blur's error, even of an even
        sky: these have more.
        """
        if self.power == 0:
            return 64
        wanted = max(3.2 / self.width, min(24 / self.width, 80))
        return int(np.clip(8 * math.ceil(wanted / 8), 40, 128))

    def values(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The kernel in 1/sr at x = tan^2(theta / 2)."""
        return _shape(x, self) / _integral(self)

    def coefficients(self) -> NDArray[np.float64]:
        """What the blur multiplies each degree of spherical harmonics by, from 0 to `degree`."""
        return _coefficients(self)


COSINE = Kernel(0.0, 0)
SATURATED = Kernel(0.0, 1)


def nearest_kernel(power: float, width: float) -> Kernel:
    """The kernel whose width is next to the wanted one."""
    return Kernel(power, round(STEPS_PER_OCTAVE * math.log2(width)))


def round_values(x: NDArray[np.float64], power: float, width: float) -> NDArray[np.float64]:
    """A kernel of any width, in 1/sr at x = tan^2(theta / 2)."""
    return _round(x, power, width) / _round_integral(power, width)


def _round(x: NDArray[np.float64], power: float, width: float) -> NDArray[np.float64]:
    q = x / width**2
    if math.isinf(power):
        return np.exp(-np.minimum(q, 700.0))
    base = 1 / (1 + q)
    # Powers are multiples of a half: products are several times as quick as `**`.
    raised = np.sqrt(base) if power % 1 else np.ones(1)
    for _ in range(int(power)):
        raised = raised * base
    return raised


def _shape(x: NDArray[np.float64], kernel: Kernel) -> NDArray[np.float64]:
    if kernel.power:
        return _round(x, kernel.power, kernel.width)
    cosine = np.maximum((1 - x) / (1 + x), 0.0)
    return cosine if kernel == COSINE else cosine / (cosine + 0.25)


def _integrate(shape: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> float:
    """Over all directions, by the midpoint rule in u, theta = u^4 pi."""
    u = (np.arange(_NODES) + 0.5) / _NODES
    theta = np.pi * u**_CROWDING
    value = shape(np.tan(0.5 * theta) ** 2) * np.sin(theta) * u ** (_CROWDING - 1)
    return float(2 * np.pi * np.pi * _CROWDING / _NODES * value.sum())


@functools.cache
def _integral(kernel: Kernel) -> float:
    return _integrate(lambda x: _shape(x, kernel))


@functools.lru_cache(4096)
def _round_integral(power: float, width: float) -> float:
    return _integrate(lambda x: _round(x, power, width))


@functools.cache
def _coefficients(kernel: Kernel) -> NDArray[np.float64]:
    return kernel_coefficients(lambda x: _shape(x, kernel), kernel.degree)

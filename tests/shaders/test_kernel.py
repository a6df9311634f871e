"""Round kernels: their integrals, names and widths. Oracles: adaptive quadrature, and sums over degrees."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad

from shaders.harmonics import kernel_coefficients
from shaders.kernel import COSINE, POWERS, SATURATED, STEPS_PER_OCTAVE, Kernel, nearest_kernel, round_values

WIDTHS = (0.002, 0.03, 0.25, 0.3, 1.0)
KERNELS = [COSINE, SATURATED, *(nearest_kernel(*one) for one in itertools.product(POWERS, WIDTHS))]


def _integral(kernel: Kernel) -> float:
    """Over the sphere, in the logarithm of tan(theta / 2): d omega = 8 pi t dt / (1 + t^2)^2."""

    def density(s: float) -> float:
        t = math.exp(s)
        return float(kernel.values(np.array([t * t]))[0]) * 8 * math.pi * t * t / (1 + t * t) ** 2

    # Kernels that end at the horizon do so at t = 1.
    parts = [quad(density, low, high, limit=400)[0] for low, high in ((-30, -8), (-8, 0), (0, 8), (8, 30))]
    return sum(parts)


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda one: one.name)
def test_a_kernel_integrates_to_one(kernel: Kernel):
    assert _integral(kernel) == pytest.approx(1, rel=2e-4)


def test_a_kernel_of_any_width_is_that_of_its_step():
    x = np.geomspace(1e-8, 10, 50)
    for kernel in KERNELS[2:]:
        np.testing.assert_allclose(round_values(x, kernel.power, kernel.width), kernel.values(x), rtol=1e-12)


def test_names_are_unique():
    # The widths of lobes, 1.5e-3 to 1.4, and more.
    steps = range(-10 * STEPS_PER_OCTAVE, 2 * STEPS_PER_OCTAVE)
    kernels = [COSINE, SATURATED, *(Kernel(*one) for one in itertools.product(POWERS, steps))]
    assert len({kernel.name for kernel in kernels}) == len(kernels)


def test_the_nearest_kernel_is_within_half_a_step():
    for width in np.geomspace(1e-3, 2, 77):
        step = abs(math.log2(nearest_kernel(2.0, width).width / width)) * STEPS_PER_OCTAVE
        assert step <= 0.5 + 1e-9


@pytest.mark.parametrize(
    "kernel", [one for one in KERNELS if one.width >= 0.03 or one.power == 0], ids=lambda one: one.name
)
def test_beyond_its_degree_little_of_a_kernel_is_left(kernel: Kernel):
    # Its height is the sum of (2 l + 1) / (4 pi) times its coefficients.
    found = kernel_coefficients(kernel.values, kernel.degree)
    np.testing.assert_array_equal(found.shape, kernel.coefficients().shape)
    height = ((2 * np.arange(len(found)) + 1) * kernel.coefficients()).sum() / (4 * math.pi)
    assert height == pytest.approx(float(kernel.values(np.zeros(1))[0]), rel=1e-2)


@pytest.mark.parametrize("kernel", [one for one in KERNELS if one.is_smooth], ids=lambda one: one.name)
def test_of_a_smooth_kernel_next_to_nothing_is_left(kernel: Kernel):
    found = kernel_coefficients(kernel.values, 4 * kernel.degree)
    parts = (2 * np.arange(len(found)) + 1) * found
    assert np.abs(parts[kernel.degree + 1 :]).sum() <= 1e-4 * parts.sum()

"""The picture for displays. Oracle: the specification of Khronos PBR Neutral and IEC 61966-2-1, in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import brdf
from shaders import Environment, Part, Scene, render

pytestmark = pytest.mark.gpu


def _shown(color: ArrayLike) -> NDArray[np.float32]:
    """What a display gets for a sky of one colour."""
    sky = Environment(np.broadcast_to(np.asarray(color, np.float32), (8, 16, 3)).copy(), "even")
    display = render(Scene((Part(brdf.build("lambert")),), sky, width=16, height=16, samples=6)).display
    assert display is not None
    return display[0, 0]


def test_a_grey_below_the_shoulder_only_loses_the_offset():
    # 0.5 - 0.04 = 0.46, whose sRGB encoding is 0.7084.
    np.testing.assert_allclose(_shown(0.5), 1.055 * 0.46 ** (1 / 2.4) - 0.055, atol=1e-5)


def test_a_bright_grey_is_compressed_to_just_below_white():
    assert 0.98 < _shown(50.0).max() < 1


def _khronos_neutral(color: NDArray[np.float64]) -> NDArray[np.float64]:
    """The specification of Khronos PBR Neutral (2024) by its formulas: F90 = 0.04, Ks = 0.8 - F90, Kd = 0.15."""
    x = color.min()
    offset = x - x * x / (4 * 0.04) if x <= 2 * 0.04 else 0.04
    shifted = color - offset
    p, ks = shifted.max(), 0.8 - 0.04
    if p <= ks:
        return shifted
    compressed = 1 - (1 - ks) ** 2 / (p + 1 - 2 * ks)
    g = 1 / (0.15 * (p - compressed) + 1)
    return shifted * (compressed / p) * g + compressed * (1 - g)


@pytest.mark.parametrize(
    "color",
    [
        pytest.param((6.0, 0.7, 0.1), id="saturated and bright"),
        pytest.param((0.02, 0.9, 1.5), id="saturated with a dark channel"),
        pytest.param((0.06, 0.03, 0.01), id="dark"),
        pytest.param((0.079, 0.9, 0.081), id="at the end of the toe"),
    ],
)
def test_the_tone_map_of_a_colour_is_that_of_the_specification(color: tuple[float, float, float]):
    mapped = _khronos_neutral(np.array(color))
    expected = np.where(mapped <= 0.0031308, 12.92 * mapped, 1.055 * mapped ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(_shown(color), expected, atol=1e-5)  # float32, with sRGB's slope of 13 at 0

"""From an environment to the table by which a shader chooses directions in proportion to its light.

A list names every texel as often as it is to be drawn, so that one look-up inverts the distribution, and the density
of a texel is its number of entries: exact, however coarse. The direction lies about the texel's centre with the tent
by which textures are interpolated; the density is therefore the interpolation of the texels' densities, and fits the
interpolated radiance.

- Karlik, Sik, Vevoda, Skrivan, Krivanek 2019, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance
  Sampling": some of what lies below the mean is left to the other density.
- Hilbert 1891, "Ueber die stetige Abbildung einer Linie auf ein Flaechenstueck": neighbours on the curve are neighbours
  in the sky, so that evenly spread numbers become evenly spread directions.

The shader's side is `glsl/light_table.glsl`.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

# Luminance of linear Rec. 709 (ITU-R BT.709).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
# Larger pictures are listed in square blocks, as few as bring them to this width.
_WIDTH_MAX = 2048
# Of the mean, what is left to the other density: less noise in studio and sunset than with 0 or 1, by some percent.
_LEFT = 0.5
# Entries of the list: four for a mean texel of 1024 x 512.
_ENTRIES_LOG2 = 21


@dataclasses.dataclass(frozen=True)
class LightTable:
    """Texels of a latitude-longitude picture, listed in the order of a Hilbert curve, each as often as it is drawn.

    - `density`: shape (h, w), float32: the probability of a texel times h w / (2 pi^2), which divided by the sine of
      the polar angle is the density in 1/sr; 0 where no direction is drawn.
    - `cells`: shape (2^n,), uint32: row 2^16 + column of the first texel of a block.
    - `block`: texels a side of a block; all of its texels are as likely.
    - `is_even`: whether the light is the same from everywhere, so that drawing it is of no use.
    """

    density: NDArray[np.float32]
    cells: NDArray[np.uint32]
    block: int
    is_even: bool


def light_table(pixels: NDArray[np.float32]) -> LightTable:
    """The table of an environment's pixels, shape (h, w, 3).

    It chooses by the luminance above half the mean. Directions below it are never drawn: use it beside another density
    that reaches them, as a material's proposals do.
    """
    height, width = pixels.shape[:2]
    block = -(-width // _WIDTH_MAX)
    luminance, texels = _blocks(pixels @ _LUMINANCE, block)
    sine = np.sin(np.pi * np.minimum((np.arange(len(luminance)) + 0.5) * block / height, 1))
    solid_angle = texels * sine[:, None]
    mean = float((luminance * solid_angle).sum() / solid_angle.sum())
    above = np.maximum(luminance - _LEFT * mean, 0)
    # A constant picture's mean is rounded.
    is_even = float(np.ptp(luminance)) <= 1e-5 * mean
    counts = _apportioned((np.ones_like(above) if is_even else above) * solid_angle, 1 << _ENTRIES_LOG2)
    row, column = _hilbert_curve(*luminance.shape)
    cells = ((row.astype(np.uint32) << np.uint32(16)) + column.astype(np.uint32)) * np.uint32(block)
    share = counts / (texels * (counts.sum() * 2 * np.pi**2 / (height * width)))
    density = np.repeat(np.repeat(share.astype(np.float32), block, axis=0), block, axis=1)[:height, :width]
    return LightTable(np.ascontiguousarray(density), np.repeat(cells, counts[row, column]), block, is_even)


def _blocks(luminance: NDArray[np.float32], block: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The mean luminance of square blocks, and how many texels each has: those at the last edges are incomplete."""
    height, width = luminance.shape
    starts = np.arange(0, height, block), np.arange(0, width, block)
    total = np.add.reduceat(np.add.reduceat(luminance.astype(np.float64), starts[0], axis=0), starts[1], axis=1)
    texels = np.minimum(height - starts[0], block)[:, None] * np.minimum(width - starts[1], block)[None, :].astype(
        float
    )
    return total / texels, texels


def _apportioned(weight: NDArray[np.float64], entries: int) -> NDArray[np.int64]:
    """Whole numbers close to a multiple of the weights, which sum to `entries`."""
    scale = entries / weight.sum()
    counts = np.zeros(weight.shape, np.int64)
    # Rounding drops many small weights; the others then share what these do not take.
    for _ in range(8):
        counts = np.floor(weight * scale + 0.5).astype(np.int64)
        scale *= entries / max(int(counts.sum()), 1)
    missing = entries - int(counts.sum())
    step = 1 if missing > 0 else -1
    # The heaviest ones notice a change least.
    heaviest = np.argpartition(-weight.reshape(-1), min(abs(missing), weight.size - 1))
    flat = counts.reshape(-1)
    while missing:
        some = heaviest[: abs(missing)]
        if step < 0:
            some = some[flat[some] > 0]
        flat[some] += step
        missing -= step * len(some)
    return counts


def _hilbert_curve(height: int, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of a grid's cells in the order of a Hilbert curve over the enclosing square."""
    x = y = np.zeros(1, np.int64)
    side = 1
    while side < max(height, width):
        # Four copies of the curve, the first and the last one turned so that their ends meet.
        x, y = (
            np.concatenate([y, x, x + side, 2 * side - 1 - y]),
            np.concatenate([x, y + side, y + side, side - 1 - x]),
        )
        side *= 2
    inside = (x < width) & (y < height)
    return y[inside], x[inside]

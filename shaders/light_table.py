"""From an environment to the table by which a shader chooses directions in proportion to its light.

- Pharr, Jakob, Humphreys 2016, "Physically Based Rendering", section 14.2.4.
- Chen, Asau 1974, "On Generating Random Variates from an Empirical Distribution": the guide.
- Hilbert 1891, "Ueber die stetige Abbildung einer Linie auf ein Flaechenstueck": neighbours on the curve are neighbours
  in the sky, so that evenly spread numbers become evenly spread directions.

The shader's side is `glsl/environment.glsl`.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

# Luminance of linear Rec. 709 (ITU-R BT.709).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Larger pictures are averaged down to this width for the table; any table is right, a finer one is only less noisy.
_WIDTH_MAX = 2048
# Of the light, spread evenly over the sky: a dark direction keeps a density above zero. A cell with far less than 2^-32
# of the light, as beside the poles of a large picture, is still never drawn, since `cumulative` cannot count it: its
# share goes to a neighbour on the curve, and the other densities that the shader samples beside this one reach it.
_UNIFORM = 1e-3


@dataclasses.dataclass(frozen=True)
class LightTable:
    """Cells of a latitude-longitude grid, chosen by light, in the order of a Hilbert curve.

    - `pdf`: shape (h, w), float32, 1/sr, constant over a cell.
    - `cells`: shape (h w,), uint32: row 2^16 + column of the k-th cell on the curve.
    - `cumulative`: shape (h w,), uint32: the light before the k-th cell, in units of 2^-32 of all light; two equal
      entries mean that the cell of the first is never drawn.
    - `guide`: shape (2^g, 2), uint32: the cells on the curve between which the parts k / 2^g to (k + 1) / 2^g of the
      light lie.
    """

    pdf: NDArray[np.float32]
    cells: NDArray[np.uint32]
    cumulative: NDArray[np.uint32]
    guide: NDArray[np.uint32]


def light_table(pixels: NDArray[np.float32]) -> LightTable:
    """The table of an environment's pixels, shape (h, w, 3), computed in float64.

    A cell's weight is the mean luminance of the *interpolated* picture over it times its solid angle: a texel beside
    the sun is lit by the interpolation, and would be a firefly if its own dark value decided.
    """
    luminance = _reduced(pixels.astype(np.float64) @ _LUMINANCE)
    # The mean of a linear interpolation over a texel is 1/8, 6/8, 1/8 of its neighbours and itself.
    luminance = 0.125 * (np.roll(luminance, 1, axis=1) + np.roll(luminance, -1, axis=1)) + 0.75 * luminance
    padded = np.pad(luminance, ((1, 1), (0, 0)), mode="edge")
    luminance = 0.125 * (padded[:-2] + padded[2:]) + 0.75 * luminance
    height, width = luminance.shape
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = ((edges[:-1] - edges[1:]) * (2 * np.pi / width))[:, None]
    mean = float((luminance * solid_angle).sum() / (4 * np.pi))
    level = luminance + _UNIFORM * mean if mean > 0 else np.ones_like(luminance)
    weight = level * solid_angle
    total = weight.sum()
    cells = _hilbert_order(height, width)
    before = np.concatenate([[0.0], np.cumsum(weight.reshape(-1)[cells])[:-1]]) / total
    cumulative = np.minimum(before * 2.0**32, 2.0**32 - 1).astype(np.uint32)
    guides = max(1 << (len(cells) - 1).bit_length(), 2)
    starts = np.arange(guides + 1) * (2**32 // guides)
    at = np.searchsorted(cumulative, starts, side="right") - 1
    row, column = np.divmod(cells, width)
    return LightTable(
        pdf=(level / total).astype(np.float32),
        cells=(row * 2**16 + column).astype(np.uint32),
        cumulative=cumulative,
        guide=np.stack([at[:-1], at[1:]], axis=-1).astype(np.uint32),
    )


def _reduced(luminance: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean over square blocks, the smallest that bring the width to the limit."""
    height, width = luminance.shape
    block = -(-width // _WIDTH_MAX)
    if block == 1:
        return luminance
    # Edge texels repeat into the last, incomplete blocks.
    padded = np.pad(luminance, ((0, -height % block), (0, -width % block)), mode="edge")
    return padded.reshape(padded.shape[0] // block, block, padded.shape[1] // block, block).mean(axis=(1, 3))


def _hilbert_order(height: int, width: int) -> NDArray[np.intp]:
    """The cells of a grid in the order in which a Hilbert curve over the enclosing square visits them."""
    row, column = (axis.reshape(-1) for axis in np.mgrid[:height, :width])
    x, y = column.copy(), row.copy()
    place = np.zeros(len(x), np.int64)
    side = 1 << (max(height, width) - 1).bit_length()
    half = side // 2
    while half:
        right, lower = (x & half) > 0, (y & half) > 0
        place += half * half * ((3 * right) ^ lower)
        # Each quarter holds a turned copy of the curve.
        flip = right & ~lower
        x, y = np.where(flip, side - 1 - x, x), np.where(flip, side - 1 - y, y)
        x, y = np.where(lower, x, y), np.where(lower, y, x)
        half //= 2
    return np.argsort(place)

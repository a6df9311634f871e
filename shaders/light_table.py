"""From an environment to the table by which a shader chooses directions by their light times a kernel about an axis.

The texels are listed along a Hilbert curve, each as often as its light says, and the list is cut into segments of about
equal light, between texels. In a segment one look-up inverts the distribution. For each kernel and each of a grid of
axes a segment has slots in proportion to its light times the kernel's mean over it, and one look-up chooses a slot. The
kernels are the clamped cosine, for what is diffuse, and GGX lobes of some widths. The density of a texel is a product
of two whole numbers, entries and slots: exact, however coarse the table is. The direction lies about the texel's centre
with the tent by which radiance is interpolated.

- Karlik, Sik, Vevoda, Skrivan, Krivanek 2019, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance
  Sampling": some of what lies below the mean is left to the other density.
- Hilbert 1891, "Ueber die stetige Abbildung einer Linie auf ein Flaechenstueck": neighbours on the curve are neighbours
  in the sky, so that evenly spread numbers become evenly spread directions.

The shader's side is `glsl/light_table.glsl`, which has the same numbers of segments, entries, slots, axes and
kernels.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

# Luminance of linear Rec. 709 (ITU-R BT.709).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
# Larger pictures are listed in square blocks, as few as bring them to this width.
_WIDTH_MAX = 2048
# Of the mean, what is left to the other density, which draws an even light better: with 0.25 clear and overcast skies
# are up to 1.6 times as noisy, with 1 the studio is by a tenth.
_LEFT = 0.5
SEGMENTS = 64
# Entries of each segment's part of the list: two for a mean texel of 1024 x 512. Half as many leave more noise than
# they save time.
ENTRIES = 16384
# Of each axis.
SLOTS = 512
# Rows and columns of the grid of axes, a latitude-longitude picture.
AXES = 24, 48
# Slopes of the kernels after the cosine: wider lobes take the cosine, narrower ones find no narrower segments.
WIDTHS = 0.4, 0.2, 0.1, 0.05
# Added to cosines, so that no segment that any of a cell's axes sees is without slots.
_COSINE_MARGIN = 0.1
# Added to the square of a width, for axes that lie anywhere in their cell: the mean squared distance from its middle,
# as a slope, which is that of half vectors.
_CELL = (np.pi / AXES[0]) ** 2 / 6 / 4
# Every so many entries a direction stands for its segment.
_STRIDE = 512


@dataclasses.dataclass(frozen=True)
class LightTable:
    """Texels of a latitude-longitude picture, listed in the order of a Hilbert curve, each as often as it is drawn.

    - `density`: shape (h, w), float32: the probability of a texel in a slot of its segment times h w / (2 pi^2), which
      times the segment's slots and divided by the sine of the polar angle is the density in 1/sr; 0 where no direction
      is drawn. The lowest six bits are not the density's: they number the segment.
    - `cells`: shape (64, 16384), uint32: row 2^16 + column of the first texel of a block, for each segment.
    - `slots`: shape (5 24 48, 192), uint32: for each kernel and axis 512 slots, the segment of each in a byte, the
      lowest first, and then for each segment its first slot 2^16 + how many it has.
    - `block`: texels a side of a block; all of its texels are as likely.
    - `is_even`: whether the light is the same from everywhere, so that drawing it is of no use.
    """

    density: NDArray[np.float32]
    cells: NDArray[np.uint32]
    slots: NDArray[np.uint32]
    block: int
    is_even: bool


def light_table(pixels: NDArray[np.float32]) -> LightTable:
    """The table of an environment's pixels, shape (h, w, 3).

    It chooses by the luminance above half of the mean. Directions below it are never drawn: use it beside another
    density that reaches them, as a material's proposals do.
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
    row, column = _hilbert_curve(*luminance.shape)
    weight = ((np.ones_like(above) if is_even else above) * solid_angle)[row, column]
    end = np.cumsum(weight / weight.sum())
    # A texel is of the segment in which its middle lies.
    middle = np.maximum.accumulate(end - 0.5 * weight / weight.sum())
    segment = np.minimum((SEGMENTS * middle).astype(np.int64), SEGMENTS - 1)
    counts = _apportioned(weight, segment)
    # Beside a sun, what is too dim for its sum has no entries.
    is_listed = np.bincount(segment, counts, SEGMENTS) > 0
    light = np.where(is_listed, np.bincount(segment, weight, SEGMENTS), 0.0)
    listed = ((row.astype(np.uint32) << np.uint32(16)) + column.astype(np.uint32)) * np.uint32(block)
    cells = np.zeros((SEGMENTS, ENTRIES), np.uint32)
    cells[is_listed] = np.repeat(listed, counts).reshape(-1, ENTRIES)
    share = np.empty(luminance.shape)
    share[row, column] = counts / (texels[row, column] * (ENTRIES * SLOTS * 2 * np.pi**2 / (height * width)))
    numbers = np.empty(luminance.shape, np.uint32)
    numbers[row, column] = segment
    marked = ((share.astype(np.float32).view(np.uint32) & ~np.uint32(SEGMENTS - 1)) | numbers).view(np.float32)
    density = np.repeat(np.repeat(marked, block, axis=0), block, axis=1)[:height, :width]
    places = np.stack([cells[:, ::_STRIDE] >> 16, cells[:, ::_STRIDE] & 65535], -1) + 0.5 * block
    slots = _slots(light, _directions_at(places / (height, width)))
    return LightTable(np.ascontiguousarray(density), cells, slots, block, is_even)


def _slots(light: NDArray[np.float64], towards: NDArray[np.float32]) -> NDArray[np.uint32]:
    """`LightTable.slots` of segments with so much light each, in the directions `towards`, shape (64, n, 3)."""
    grid = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in AXES), indexing="ij"), -1) / AXES
    axes = _directions_at(grid).reshape(-1, 3)
    cosine = axes @ towards.reshape(-1, 3).T
    # tan^2 of half the angle; opposite to the axis any large number does.
    slope2 = np.maximum(1 - cosine, 0) / np.maximum(1 + cosine, 1e-6)
    values = [np.maximum(cosine + _COSINE_MARGIN, 0)]
    values += [np.square(1 / (1 + slope2 / np.float32(width**2 + _CELL))) for width in WIDTHS]
    means = [one.reshape(len(axes), *towards.shape[:2]).mean(axis=-1) for one in values]
    return np.concatenate([_apportioned_slots(light * mean, light) for mean in means])


def _apportioned_slots(weight: NDArray[np.float64], light: NDArray[np.float64]) -> NDArray[np.uint32]:
    """The slots of segments with these weights, shape (n, 64); at least one of each that has any."""
    # An axis that sees no segment has to choose one all the same.
    weight = np.where(weight.sum(axis=1, keepdims=True) > 0, weight, light)
    seen = weight > 0
    total = np.cumsum(weight, axis=1)
    rest = np.rint(total * ((SLOTS - seen.sum(axis=1)) / total[:, -1])[:, None]).astype(np.int64)
    end = rest + np.cumsum(seen, axis=1)
    first = np.concatenate([np.zeros((len(end), 1), np.int64), end[:, :-1]], axis=1)
    numbers = np.broadcast_to(np.arange(SEGMENTS, dtype=np.uint8), end.shape)
    chosen = np.repeat(numbers.reshape(-1), (end - first).reshape(-1)).reshape(-1, SLOTS)
    packed = ((first << 16) + (end - first)).astype(np.uint32)
    return np.concatenate([np.ascontiguousarray(chosen).view("<u4"), packed], axis=1)


def _directions_at(places: NDArray[np.float64]) -> NDArray[np.float32]:
    """Directions at places (v, u) of the picture, shape (..., 2); see environment.py."""
    polar, azimuth = np.pi * places[..., 0], 2 * np.pi * (places[..., 1] - 0.5)
    sine = np.sin(polar)
    return np.stack([sine * np.sin(azimuth), np.cos(polar), -sine * np.cos(azimuth)], -1).astype(np.float32)


def _blocks(luminance: NDArray[np.float32], block: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The mean luminance of square blocks, and how many texels each has: those at the last edges are incomplete."""
    height, width = luminance.shape
    starts = np.arange(0, height, block), np.arange(0, width, block)
    total = np.add.reduceat(np.add.reduceat(luminance.astype(np.float64), starts[0], axis=0), starts[1], axis=1)
    texels = np.minimum(height - starts[0], block)[:, None] * np.minimum(width - starts[1], block)[None, :].astype(
        float
    )
    return total / texels, texels


def _apportioned(weight: NDArray[np.float64], segment: NDArray[np.int64]) -> NDArray[np.int64]:
    """How often each weight is listed: sums to `ENTRIES` over each segment that has weight. Segments ascend."""
    scale = ENTRIES / np.maximum(np.bincount(segment, weight, SEGMENTS), 1e-300)
    # What would be rounded to nothing is left to the other density, unless it is most of its segment.
    large = np.where(weight * scale[segment] >= 0.5, weight, 0.0)
    is_most = np.bincount(segment, large, SEGMENTS) * scale > 0.5 * ENTRIES
    weight = np.where(is_most[segment], large, weight)
    end = np.concatenate([[0.0], np.cumsum(weight)])
    # Rounded sums and not rounded weights: small neighbours share entries.
    bounds = end[np.searchsorted(segment, np.arange(SEGMENTS + 1))]
    start, light = bounds[:-1], np.maximum(np.diff(bounds), 1e-300)
    place = [(one - start[segment]) / light[segment] for one in (end[:-1], end[1:])]
    return np.diff(np.rint(np.multiply(place, ENTRIES)).astype(np.int64), axis=0)[0]


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

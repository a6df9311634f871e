"""What is brighter than an environment's mean, as a few lights: suns, lamps and windows, which the directions that a
material proposes would find too seldom and then, where each stands for a large solid angle, take for larger."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from .environment import Environment

Array = NDArray[np.float64]

# The limit above which light is hot, in units of the mean radiance.
_LIMIT = 1.0
# With less of the light above it, directions do as well without lights.
_SHARE_MIN = 0.02
# Lights in each frame.
IN_FRAME = 2
# Wider pictures are taken in blocks: a block has one place, which is that of its light.
_WIDTH_MAX = 512
# Part of the solid angle over which a light is spread: directions that stand for less read the light itself. Of 1/64 to
# 16, the one with the smallest errors at slopes of 0.01 to 0.36.
_REACH = 0.25


@dataclasses.dataclass(frozen=True, eq=False)
class HotLights:
    """What lies above a limit in an environment, split into lights of about as much flux, neighbours side by side.

    - `limit`: in radiance, per channel.
    - `directions`: shape (n, 3), unit, in the environment's axes.
    - `fluxes`: shape (n, 3): radiance above the limit times solid angle.
    - `solid_angle`: a direction that stands for less sees the light itself better than as one of these.
    """

    limit: float
    directions: Array
    fluxes: Array
    solid_angle: float

    def pack(self) -> bytes:
        """Pairs of a direction and a flux, as `glsl/pass/still.frag` reads them."""
        pairs = np.zeros((len(self.directions), 2, 4), np.float32)
        pairs[:, 0, :3], pairs[:, 1, :3] = self.directions, self.fluxes
        return pairs.tobytes()


@dataclasses.dataclass(frozen=True, eq=False)
class _Blocks:
    """Blocks of hot texels: `place`, (n, 3), the mean of their directions by flux, `own`, (n,), of their solid angles;
    `flux`, (n, 3), and `weight`, (n,), its sum."""

    place: Array
    own: Array
    flux: Array
    weight: Array

    def __getitem__(self, which: NDArray[np.intp]) -> _Blocks:
        return _Blocks(self.place[which], self.own[which], self.flux[which], self.weight[which])

    def scaled(self, part: float) -> _Blocks:
        return _Blocks(self.place, part * self.own, part * self.flux, part * self.weight)


@functools.lru_cache(8)
def find_hot_lights(environment: Environment, frames: int) -> HotLights | None:
    """`IN_FRAME * frames` lights whose fluxes sum to all that is above the limit; `None` if that is next to nothing."""
    pixels = environment.pixels
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:]) * (2 * np.pi / width)
    light = float((pixels.max(axis=2).sum(axis=1, dtype=np.float64) * solid_angle).sum())
    limit = _LIMIT * light / (4 * np.pi)
    blocks = _blocks(pixels, solid_angle, limit)
    if blocks.flux.sum(axis=0).max() <= _SHARE_MIN * light:
        return None
    groups = _split(blocks, IN_FRAME * frames)
    weights = [one.weight.sum() for one in groups]
    means = np.stack([np.average(one.place, axis=0, weights=one.weight) for one in groups])
    length = np.linalg.norm(means, axis=1)
    own = [np.average(one.own, weights=one.weight) for one in groups]
    # Of the cap with as long a mean, and of a texel.
    spread = 4 * np.pi * (1 - length) + own
    fluxes = np.stack([one.flux.sum(axis=0) for one in groups])
    return HotLights(limit, means / length[:, None], fluxes, _REACH * float(np.average(spread, weights=weights)))


def _blocks(pixels: NDArray[np.float32], solid_angle: Array, limit: float) -> _Blocks:
    """All blocks with light above the limit."""
    height, width = pixels.shape[:2]
    side = -(-width // _WIDTH_MAX)
    azimuth = 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)
    starts = np.arange(0, width, side)
    found = []
    for top in range(0, height, side):
        rows = slice(top, min(top + side, height))
        flux = np.maximum(pixels[rows].astype(np.float64) - limit, 0) * solid_angle[rows, None, None]
        polar = np.pi * (np.arange(rows.start, rows.stop) + 0.5) / height
        weight = flux.sum(axis=2)
        by_row = np.sin(polar) @ weight
        own = solid_angle[rows] @ weight
        moment = np.stack(
            [by_row * np.sin(azimuth), np.cos(polar) @ weight, -by_row * np.cos(azimuth), own, weight.sum(0)]
        )
        sums = np.concatenate([moment, flux.sum(axis=0).T])
        sums = np.add.reduceat(sums, starts, axis=1)
        found.append(sums[:, sums[4] > 0])
    x = np.concatenate(found, axis=1).T
    return _Blocks(x[:, :3] / x[:, 4:5], x[:, 3] / x[:, 4], x[:, 5:], x[:, 4])


def _split(blocks: _Blocks, count: int) -> list[_Blocks]:
    """The blocks in so many groups of about as much flux, neighbours side by side."""
    if count == 1:
        return [blocks]
    if len(blocks.weight) == 1:
        return count * [blocks.scaled(1 / count)]
    # Along the axis in which they are furthest apart, where the variance between both sides is largest.
    total = blocks.weight.sum()
    apart = blocks.place - blocks.weight @ blocks.place / total
    axis = int(np.argmax(blocks.weight @ apart**2))
    order = np.argsort(apart[:, axis], kind="stable")
    before = np.cumsum(blocks.weight[order])[:-1]
    moment = np.cumsum((blocks.weight * apart[:, axis])[order])[:-1]
    cut = int(np.argmax(moment**2 / (before * (total - before))))
    part = int(np.clip(round(count * before[cut] / total), 1, count - 1))
    return _split(blocks[order[: cut + 1]], part) + _split(blocks[order[cut + 1 :]], count - part)

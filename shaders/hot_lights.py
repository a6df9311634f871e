"""What is far brighter than the rest of an environment, as a few lights: suns and lamps, which directions of a material's
proposals would find too seldom, and then too bright."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from .environment import Environment

# A texel is hot above this multiple of the mean radiance.
_EXCESS_MIN = 8.0
# With less of the light in what is above it, directions do as well without.
_SHARE_MIN = 0.02
# Lights in each frame, at most, and hot texels for each of them before there is another.
_IN_FRAME = 4
_TEXELS = 16


@dataclasses.dataclass(frozen=True, eq=False)
class HotLights:
    """What lies above a limit in an environment, split into `in_frame * frames` lights of about as much flux.

    - `limit`: in radiance, per channel; infinite if there are no lights.
    - `in_frame`: lights of each frame: those from the frame's number on in steps of the number of frames.
    - `directions`: shape (n, 3), unit, in the environment's axes.
    - `fluxes`: shape (n, 3): radiance above the limit times solid angle.
    - `solid_angle`: over which the light of one is spread, the mean by flux.
    """

    limit: float
    in_frame: int
    directions: NDArray[np.float64]
    fluxes: NDArray[np.float64]
    solid_angle: float

    def pack(self) -> bytes:
        """Pairs of a direction and a flux, as `glsl/pass/still.frag` reads them."""
        pairs = np.zeros((len(self.directions), 2, 4), np.float32)
        pairs[:, 0, :3], pairs[:, 1, :3] = self.directions, self.fluxes
        return pairs.tobytes()


@dataclasses.dataclass(frozen=True, eq=False)
class _Texels:
    """Hot texels: `corner` and `extent`, (n, 2), of what each spans in polar angle and azimuth; `flux`, (n, 3)."""

    corner: NDArray[np.float64]
    extent: NDArray[np.float64]
    flux: NDArray[np.float64]

    @property
    def weight(self) -> NDArray[np.float64]:
        return self.flux.sum(axis=1)

    @property
    def directions(self) -> NDArray[np.float64]:
        polar, azimuth = (self.corner + 0.5 * self.extent).T
        sine = np.sin(polar)
        return np.stack([sine * np.sin(azimuth), np.cos(polar), -sine * np.cos(azimuth)], axis=1)

    @property
    def mean(self) -> NDArray[np.float64]:
        """Of the directions, by flux; the shorter, the further they are apart."""
        return np.average(self.directions, axis=0, weights=self.weight)

    @property
    def spread(self) -> float:
        """The solid angle of a cap with the same mean, and one texel."""
        own = np.sin(self.corner[:, 0] + 0.5 * self.extent[:, 0]) * self.extent.prod(axis=1)
        return float(4 * np.pi * (1 - np.linalg.norm(self.mean)) + np.average(own, weights=self.weight))

    def __getitem__(self, which: NDArray[np.intp]) -> _Texels:
        return _Texels(self.corner[which], self.extent[which], self.flux[which])


@functools.lru_cache(8)
def find_hot_lights(environment: Environment, frames: int) -> HotLights:
    """The lights of an environment for so many frames; their fluxes sum to all that is above the limit."""
    pixels = environment.pixels
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:]) * (2 * np.pi / width)
    peak = pixels.max(axis=2)
    light = float((peak.sum(axis=1, dtype=np.float64) * solid_angle).sum())
    limit = _EXCESS_MIN * light / (4 * np.pi)
    row, column = np.nonzero(peak > limit)
    flux = np.maximum(pixels[row, column].astype(np.float64) - limit, 0) * solid_angle[row, None]
    if flux.sum(axis=0).max() <= _SHARE_MIN * light:
        return HotLights(np.inf, 0, np.zeros((0, 3)), np.zeros((0, 3)), 0.0)
    extent = np.array([np.pi / height, 2 * np.pi / width])
    corner = np.stack([row, column - 0.5 * width], axis=1) * extent
    in_frame = min(-(-len(row) // _TEXELS), _IN_FRAME)
    groups = _split(_Texels(corner, np.broadcast_to(extent, corner.shape), flux), in_frame * frames)
    means = np.stack([one.mean for one in groups])
    fluxes = np.stack([one.flux.sum(axis=0) for one in groups])
    spread = np.average([one.spread for one in groups], weights=fluxes.sum(axis=1))
    directions = means / np.linalg.norm(means, axis=1, keepdims=True)
    return HotLights(limit, in_frame, directions, fluxes, float(spread))


def _split(texels: _Texels, count: int) -> list[_Texels]:
    """The texels in so many groups of about as much flux, neighbours side by side."""
    if count == 1:
        return [texels]
    first, second = _halves(texels)
    share = first.weight.sum() / texels.weight.sum()
    part = int(np.clip(round(share * count), 1, count - 1))
    return _split(first, part) + _split(second, count - part)


def _halves(texels: _Texels) -> tuple[_Texels, _Texels]:
    """The texels in two groups as far apart as can be; one texel in its halves."""
    if len(texels.flux) == 1:
        half = texels.extent * np.where(texels.extent == texels.extent.max(), 0.5, 1.0)
        return _Texels(texels.corner, half, 0.5 * texels.flux), _Texels(
            texels.corner + texels.extent - half, half, 0.5 * texels.flux
        )
    weight, directions = texels.weight, texels.directions
    axis = int(np.argmax(weight @ (directions - texels.mean) ** 2))
    order = np.argsort(directions[:, axis], kind="stable")
    # Where the variance between both parts is largest.
    before = np.cumsum(weight[order])[:-1]
    moment = np.cumsum((weight * (directions[:, axis] - texels.mean[axis]))[order])[:-1]
    cut = 1 + int(np.argmax(moment**2 / (before * (weight.sum() - before))))
    return texels[order[:cut]], texels[order[cut:]]

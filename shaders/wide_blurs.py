"""Environments blurred by kernels that are not narrow: exactly, on the processor.

A blur is a product in spherical harmonics (`harmonics`), in which one analysis of the environment serves all kernels.
For those that have too few degrees for it, the brightest texels (`lamps`), if they hold light that counts, are left out
and weighed by the kernel itself.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from .cube_texels import texel_directions
from .environment import Environment
from .harmonics import analyse, analyse_points, synthesise
from .kept_tables import kept
from .kernel import Kernel
from .lamps import find_strong_lamps, merge_lamps

# Rows of a picture per degree: with fewer, its texels, which count as points, are told from an even light.
_ROWS_PER_DEGREE = 4
# No picture is interpolated to more texels than this across.
_WIDTH_MAX = 1024
# Rows of the blurred picture per texel of a cube's edge: their errors do not add to it.
_ROWS_PER_TEXEL = 3.2
# They are a multiple of it: quick to transform, and kernels of about one width share the tables of a height.
_ROWS_STEP = 32
# A lamp opposite to a texel has no tangent.
_FAR = 1e-7
# Names the way in which environments are blurred: another one must not find what this one kept.
_KIND = "blur-6"


def blurred_texels(environment: Environment, kernel: Kernel) -> NDArray[np.float32]:
    """The environment blurred by a kernel, at the texels of a cube map.

    **Returns:** shape (6, n, n, 4) with n = `kernel.texels`; the last of the four is 1.
    """
    ingredients = (environment.digest.encode(), kernel.name.encode())
    return np.asarray(kept(_KIND, ingredients, lambda: {"texels": _texels(environment, kernel)})["texels"], np.float32)


def _texels(environment: Environment, kernel: Kernel) -> NDArray[np.float32]:
    texels = kernel.texels
    picture = blurred_pixels(environment, kernel)
    places, weights = _places(texels, len(picture))
    flat = picture.swapaxes(0, 1).reshape(-1, 3)  # as it lies in memory
    found = np.ones((len(places[0]), 4), np.float32)
    found[:, :3] = sum(np.take(flat, place, axis=0) * weight for place, weight in zip(places, weights, strict=True))
    if not kernel.is_smooth:
        found[:, :3] += _lamps_blurred(environment, kernel)
    return found.reshape(6, texels, texels, 4)


def _lamps_blurred(environment: Environment, kernel: Kernel) -> NDArray[np.float32]:
    lamps = merge_lamps(find_strong_lamps(environment), kernel.width)
    directions = texel_directions(kernel.texels).reshape(-1, 3)
    found = np.zeros((len(directions), 3), np.float32)
    for direction, flux in zip(lamps.directions, lamps.fluxes, strict=True):
        cosine = (directions @ direction).astype(np.float64)
        x = np.maximum(1 - cosine, 0) / np.maximum(1 + cosine, _FAR)
        found += kernel.values(x).astype(np.float32)[:, None] * flux
    return found


def blurred_pixels(environment: Environment, kernel: Kernel) -> NDArray[np.float32]:
    """The environment blurred by a kernel, as a latitude-longitude picture; without its lamps, if it is not smooth.

    **Returns:** shape (h, 2 h, 3).
    """
    found = _analysis(environment, kernel.degree)
    degree = min(kernel.degree, len(found) - 1)
    found = found[: degree + 1, : degree + 1]
    if kernel.is_smooth:
        found = found + _lamp_analysis(environment, degree)
    coefficients = found * kernel.coefficients()[: degree + 1, None]
    picture = synthesise(coefficients, _ROWS_STEP * math.ceil(_ROWS_PER_TEXEL * kernel.texels / _ROWS_STEP))
    return np.maximum(picture, 0, out=picture)


def _analysis(environment: Environment, degree: int) -> NDArray[np.complex128]:
    """The coefficients of the environment without its lamps, to this degree or more, or what it has rows for."""
    held = _analyses(environment)
    enough = [one for one in held if one >= degree]
    if not enough:
        limit = find_strong_lamps(environment).limit
        dim = environment.pixels if math.isinf(limit) else np.minimum(environment.pixels, np.float32(limit))
        pixels = _interpolated(dim, _ROWS_PER_DEGREE * degree)
        held[degree] = analyse(pixels, min(degree, len(pixels)))
    return held[min(enough, default=degree)]


@functools.lru_cache(8)
def _analyses(environment: Environment) -> dict[int, NDArray[np.complex128]]:
    """Those that were made of an environment, by the degree that was asked for: each serves lower degrees too."""
    return {}


@functools.lru_cache(8)
def _lamp_analysis(environment: Environment, degree: int) -> NDArray[np.complex128]:
    """The coefficients of its lamps."""
    lamps = find_strong_lamps(environment)
    x, y, z = lamps.directions.astype(np.float64).T
    return analyse_points(np.arctan2(np.hypot(x, z), y), np.arctan2(x, -z) + np.pi, lamps.fluxes, degree)


def _interpolated(pixels: NDArray[np.float32], rows: int) -> NDArray[np.float32]:
    """The picture with this many rows or more, if it may be that wide."""
    height, width = pixels.shape[:2]
    times = min(-(-rows // height), _WIDTH_MAX // width)
    if times <= 1:
        return pixels
    padded = np.pad(pixels, ((1, 1), (0, 0), (0, 0)), mode="edge")
    taller = _between(padded, times)
    return _between(np.pad(taller, ((0, 0), (1, 1), (0, 0)), mode="wrap").swapaxes(0, 1), times).swapaxes(0, 1)


def _between(rows: NDArray[np.float32], times: int) -> NDArray[np.float32]:
    """As many rows in place of each but the first and the last, interpolated linearly as a texture's are."""
    place = (np.arange((len(rows) - 2) * times) + 0.5) / times + 0.5
    before = place.astype(int)
    part = (place - before).astype(np.float32)[:, None, None]
    return ((1 - part) * rows[before] + part * rows[before + 1]).astype(np.float32)


@functools.lru_cache(8)
def _places(texels: int, height: int) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Where a cube's texels lie in a picture of this height, column by column: four texels of it, with weights.

    **Returns:** shapes (4, m) and (4, m, 1), m = 6 texels^2.
    """
    w = texel_directions(texels).reshape(-1, 3)
    x = (0.5 + np.arctan2(w[:, 0], -w[:, 2]) / (2 * np.pi)) * 2 * height - 0.5
    y = np.arctan2(np.hypot(w[:, 0], w[:, 2]), w[:, 1]) / np.pi * height - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    places, weights = [], []
    for row, down in ((top, 1 - (y - top)), (top + 1, y - top)):
        for column, across in ((left, 1 - (x - left)), (left + 1, x - left)):
            places.append(column % (2 * height) * height + np.clip(row, 0, height - 1))
            weights.append(down * across)
    return np.array(places, np.int32), np.array(weights, np.float32)[..., None]

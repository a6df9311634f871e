"""The environment out of focus, as a quiet background: a small picture, smoothed on the sphere.

- Fisher 1953, "Dispersion on a Sphere", Proc. R. Soc. A 217: the kernel exp(k cos(angle)).
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from .environment import Environment

_HEIGHT = 64
# The kernel's concentration: a standard deviation of about 9 degrees.
_CONCENTRATION = 40.0


def blurred(environment: Environment) -> Environment:
    """The environment smoothed with a round kernel, 128 x 64 texels, from at most twice as many."""
    pixels = _reduced(environment.pixels.astype(np.float64))
    height, width = pixels.shape[:2]
    polar_in, polar_out = (np.pi * (np.arange(n) + 0.5) / n for n in (height, _HEIGHT))
    # The kernel depends on azimuths by their difference alone: a circular convolution along the rows.
    turn = 2 * np.pi * np.arange(width) / width
    cosine = (np.sin(polar_out)[:, None] * np.sin(polar_in))[..., None] * np.cos(turn)
    cosine += (np.cos(polar_out)[:, None] * np.cos(polar_in))[..., None]
    kernel = np.exp(_CONCENTRATION * (cosine - 1)) * np.sin(polar_in)[:, None]
    kernel /= kernel.sum(axis=(1, 2), keepdims=True)
    spectrum = np.einsum("oif,ifc->ofc", np.fft.rfft(kernel, axis=2), np.fft.rfft(pixels, axis=1))
    smooth = np.maximum(np.fft.irfft(spectrum, n=width, axis=1), 0.0)
    return dataclasses.replace(environment, pixels=np.ascontiguousarray(smooth, np.float32))


def _reduced(pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean over square blocks, the largest that leave twice the height of the result or more."""
    height, width = pixels.shape[:2]
    block = max(height // (2 * _HEIGHT), 1)
    cropped = np.pad(pixels, ((0, -height % block), (0, -width % block), (0, 0)), mode="edge")
    return cropped.reshape(cropped.shape[0] // block, block, cropped.shape[1] // block, block, 3).mean(axis=(1, 3))

"""Pictures of all directions blurred exactly: a convolution with a round kernel is a product in spherical harmonics.

A picture is a sum over degrees l and orders m; blurring it with a kernel that depends on the angle alone multiplies
degree l by one number (Funk-Hecke). A smooth result needs few degrees, whatever the picture held: no sample is drawn,
and a sun of one texel is spread without noise.

- Ramamoorthi, Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps".
- Holmes, Featherstone 2002, "A unified approach to the Clenshaw summation and the recursive computation of very high
  degree and order normalised associated Legendre functions": the recurrence over l.

Pictures are latitude-longitude ones as `shaders.environment` orients them. Only m >= 0 is kept, since they are real.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

# Orders that are worked on together: their functions stay in the processor's cache.
_ORDERS_AT_ONCE = 24
# Nodes of the midpoint rule for a kernel, theta = u^4 pi: a width of 1e-3 still spans an eighth of them.
_KERNEL_NODES = 4096
_CROWDING = 4


def analyse(pixels: NDArray[np.float32], degree: int) -> NDArray[np.complex128]:
    """The coefficients of a picture up to a degree.

    Every texel counts with its exact solid angle, as a point: the picture's energy is kept.

    **Arguments:** `pixels`: shape (h, w, 3); `degree`: at most h.

    **Returns:** shape (degree + 1, degree + 1, 3), [m, l], zero for l < m.
    """
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:]) * (2 * np.pi / width)
    orders = min(degree, width // 2) + 1
    # A few orders are quicker by a product of matrices than by an FFT of all.
    azimuth = 2 * np.pi * (np.arange(width) + 0.5) / width
    waves = np.exp(-1j * np.outer(azimuth, np.arange(orders)))
    rows = (pixels * solid_angle[:, None, None].astype(np.float32)).transpose(0, 2, 1).reshape(3 * height, width)
    columns = np.concatenate([rows @ part.astype(np.float32) for part in (waves.real, waves.imag)], axis=1)
    columns = columns.reshape(height, 3, 2, orders).transpose(3, 0, 2, 1).reshape(orders, height, 6).astype(np.float64)
    found = np.zeros((degree + 1, degree + 1, 3), np.complex128)
    for start, functions in _legendre(_cosines(height), degree):
        for m, one in enumerate(functions, start):
            if m < orders:
                parts = one[m:] @ columns[m]
                found[m, m:] = parts[:, :3] + 1j * parts[:, 3:]
    return found


def synthesise(coefficients: NDArray[np.complex128], height: int) -> NDArray[np.float32]:
    """The picture of the coefficients, shape (height, 2 height, 3); `height` is to be at least their degree."""
    degree = len(coefficients) - 1
    width = 2 * height
    columns = np.zeros((height, width // 2 + 1, 3), np.complex128)
    for start, functions in _legendre(_cosines(height), degree):
        for m, one in enumerate(functions, start):
            part = coefficients[m, m:]
            columns[:, m] = one[m:].T @ part.real + 1j * (one[m:].T @ part.imag)
    columns *= np.exp(1j * np.pi / width * np.arange(width // 2 + 1))[:, None]
    # Each order stands for its negative twin too, which the inverse FFT adds.
    return np.fft.irfft(columns, width, axis=1).astype(np.float32) * width


def kernel_coefficients(
    kernel: Callable[[NDArray[np.float64]], NDArray[np.float64]], degree: int
) -> NDArray[np.float64]:
    """What a round kernel multiplies each degree by.

    **Arguments:** `kernel`: from tan^2(theta / 2) of the angle from its middle to a density, of any scale.

    **Returns:** shape (degree + 1,); the first is 1, so that a constant picture stays what it is.
    """
    u = (np.arange(_KERNEL_NODES) + 0.5) / _KERNEL_NODES
    theta = np.pi * u**_CROWDING
    weight = kernel(np.tan(0.5 * theta) ** 2) * np.sin(theta) * u ** (_CROWDING - 1)
    cosine = np.cos(theta)
    found = np.empty(degree + 1)
    before, now = np.zeros_like(cosine), np.ones_like(cosine)
    for n in range(degree + 1):
        found[n] = weight @ now
        before, now = now, ((2 * n + 1) * cosine * now - n * before) / (n + 1)
    return found / found[0]


def _cosines(height: int) -> NDArray[np.float64]:
    return np.cos(np.pi * (np.arange(height) + 0.5) / height)


def _legendre(cosine: NDArray[np.float64], degree: int) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """The normalised associated Legendre functions at some cosines, for blocks of orders: the first order of a block,
    and the functions, shape (orders, degree + 1, n), zero for l < m. Their squares integrate to 1 / (2 pi)."""
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    sectoral = np.full_like(cosine, np.sqrt(0.25 / np.pi))
    for start in range(0, degree + 1, _ORDERS_AT_ONCE):
        m = np.arange(start, min(start + _ORDERS_AT_ONCE, degree + 1))[:, None]
        found = np.zeros((len(m), degree + 1, len(cosine)))
        for row, order in enumerate(m[:, 0]):
            if order:
                sectoral = np.sqrt((2 * order + 1) / (2 * order)) * sine * sectoral
            found[row, order] = sectoral
        for n in range(start + 1, degree + 1):
            # Orders below the degree n; the others of the block have not begun.
            live = slice(0, min(n - start, len(m)))
            square = m[live].astype(np.float64) ** 2
            scale = np.sqrt((4.0 * n * n - 1) / (n * n - square))
            back = np.sqrt(((n - 1.0) ** 2 - square) / (4.0 * (n - 1) ** 2 - 1))
            found[live, n] = scale * (cosine * found[live, n - 1] - (back * found[live, n - 2] if n > 1 else 0))
        yield start, found

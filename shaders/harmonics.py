"""Pictures of all directions blurred exactly: a convolution with a round kernel is a product in spherical harmonics.

A picture is a sum over degrees l and orders m; blurring it with a kernel that depends on the angle alone multiplies
degree l by one number (Funk-Hecke). A smooth result needs few degrees, whatever the picture held: no sample is drawn,
and a sun of one texel is spread without noise.

A picture's lower half is taken together with its upper one: functions are even or odd there (l - m even or odd), so
tables of them have half the rows. They are kept, in float32, for the next picture of that size.

- Ramamoorthi, Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps".
- Holmes, Featherstone 2002, "A unified approach to the Clenshaw summation and the recursive computation of very high
  degree and order normalised associated Legendre functions": the recurrence over l.

Pictures are latitude-longitude ones as `shaders.environment` orients them. Only m >= 0 is kept, since they are real.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

# Orders that are worked on together: their functions stay in the processor's cache.
_ORDERS_AT_ONCE = 24
# Of no weight, and multiplied much slower if it is denormal in float32.
_TINY = 1e-30
# A picture's texels may be summed to this many rows and columns per degree, or in all: a function changes little within
# one of them.
_ROWS_PER_DEGREE, _ROWS_MIN = 6, 128
# Nodes of the midpoint rule for a kernel, theta = u^4 pi: a width of 1e-3 still spans an eighth of them.
_KERNEL_NODES = 4096
_CROWDING = 4


def analyse(pixels: NDArray[np.float32], degree: int) -> NDArray[np.complex128]:
    """The coefficients of a picture up to a degree.

    Every texel counts with its exact solid angle, as a point: the picture's energy is kept. Of a picture that has many
    more rows than degrees, some texels are summed first.

    **Arguments:** `pixels`: shape (h, w, 3); `degree`: at most h.

    **Returns:** shape (degree + 1, degree + 1, 3), [m, l], zero for l < m.
    """
    rows = _energies(pixels, degree)
    height, width = rows.shape[:2]
    half, orders = (height + 1) // 2, min(degree, width // 2) + 1
    # An FFT, and no product of matrices: for large ones BLAS starts threads, which wait long where others are at work.
    waves = np.fft.rfft(rows, axis=1)[:, :orders] * _to_middles(width, orders).conj()[:, None]
    columns = np.stack([waves.real, waves.imag], axis=-2).swapaxes(0, 1)  # [m, row, part, channel]
    north, south = columns[:, :half], columns[:, ::-1][:, :half]
    even, odd = (one.reshape(orders, half, 6) for one in (north + south, north - south))
    if height % 2:
        even[:, -1] *= 0.5  # the row in the middle is its own twin
    functions = _row_functions(height, degree)[:orders]
    parts = np.where(_is_odd(degree)[:orders], functions @ odd, functions @ even)
    found = np.zeros((degree + 1, degree + 1, 3), np.complex128)
    found[:orders] = parts[..., :3] + 1j * parts[..., 3:]
    return found


def analyse_points(
    polar: NDArray[np.float64], azimuth: NDArray[np.float64], energies: NDArray[np.float32], degree: int
) -> NDArray[np.complex128]:
    """The coefficients, as `analyse` has them, of lights without size.

    **Arguments:** `polar`: from the zenith, shape (n,); `azimuth`: from a picture's left edge, shape (n,); `energies`:
    radiance times solid angle, shape (n, 3).
    """
    phase = np.outer(np.arange(degree + 1), azimuth)[..., None]
    parts = np.concatenate([np.cos(phase) * energies, -np.sin(phase) * energies], axis=2)
    sums = _legendre(np.cos(polar), degree) @ parts.astype(np.float32)
    return sums[..., :3] + 1j * sums[..., 3:].astype(np.float64)


def synthesise(coefficients: NDArray[np.complex128], height: int) -> NDArray[np.float32]:
    """The picture of the coefficients, shape (height, 2 height, 3); `height` is to be at least their degree."""
    orders = len(coefficients)
    parts = np.concatenate([coefficients.real, coefficients.imag], axis=2).astype(np.float32)
    is_odd = _is_odd(orders - 1)
    functions = _row_functions(height, orders - 1).transpose(0, 2, 1)
    even, odd = functions @ np.where(is_odd, 0, parts), functions @ np.where(is_odd, parts, 0)
    columns = np.concatenate([even + odd, (even - odd)[:, : height // 2][:, ::-1]], axis=1)
    waves = (columns[..., :3] + 1j * columns[..., 3:]) * _to_middles(2 * height, orders)[:, None, None]
    picture = np.fft.irfft(waves, 2 * height, axis=0, norm="forward")
    return picture.astype(np.float32, copy=False).swapaxes(0, 1)


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


def _energies(pixels: NDArray[np.float32], degree: int) -> NDArray[np.float32]:
    """Radiance times solid angle of texels, or of equal blocks of them: shape (rows, columns, 3)."""
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = ((edges[:-1] - edges[1:]) * (2 * np.pi / width)).astype(np.float32)
    rows = max(_ROWS_PER_DEGREE * degree, _ROWS_MIN)
    down, across = _block(height, rows), _block(width, max(rows, 2 * _ROWS_MIN))
    # A product of matrices reads the picture once, and keeps nothing of its size.
    blocks = np.ascontiguousarray(pixels).reshape(height // down, down, width * 3)
    summed = (solid_angle.reshape(-1, 1, down) @ blocks).reshape(height // down, width, 3)
    found = summed[:, ::across]
    for start in range(1, across):
        found = found + summed[:, start::across]
    return found


def _block(texels: int, wanted: int) -> int:
    """Into how many texels a number of them can be parted so that as many parts as are wanted are left."""
    return max((one for one in range(1, texels // wanted + 1) if texels % one == 0), default=1)


def _to_middles(width: int, orders: int) -> NDArray[np.complex64]:
    """What each order is turned by from a picture's left edge to the middle of its first column."""
    return np.exp(1j * np.pi / width * np.arange(orders)).astype(np.complex64)


def _is_odd(degree: int) -> NDArray[np.bool_]:
    """Whether the function changes its sign between the halves of a picture, [m, l, 0]."""
    return (np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) % 2 == 1)[..., None]


@functools.lru_cache(8)
def _row_functions(height: int, degree: int) -> NDArray[np.float32]:
    """Those of `_legendre` at the middles of a picture's upper rows, of which there are (height + 1) // 2."""
    return _legendre(np.cos(np.pi * (np.arange((height + 1) // 2) + 0.5) / height), degree)


def _legendre(cosine: NDArray[np.float64], degree: int) -> NDArray[np.float32]:
    """The normalised associated Legendre functions at some cosines.

    **Returns:** shape (degree + 1, degree + 1, n), [m, l], zero for l < m. Their squares integrate to 1 / (2 pi).
    """
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    found = np.zeros((degree + 1, degree + 1, len(cosine)), np.float32)
    # By l, with a 0 that stands for the degree before the first.
    square = np.concatenate([[0.0], np.arange(degree + 1.0) ** 2])
    sectoral = np.full_like(cosine, np.sqrt(0.25 / np.pi))
    for start in range(0, degree + 1, _ORDERS_AT_ONCE):
        m = np.arange(start, min(start + _ORDERS_AT_ONCE, degree + 1))[:, None]
        before, now = np.zeros((2, len(m), len(cosine)))
        for n in range(start, degree + 1):
            # Orders below the degree n; the others of the block have not begun.
            live = slice(0, min(n - start, len(m)))
            if n > start:
                scale = np.sqrt((4.0 * n * n - 1) / (n * n - square[m[live] + 1]))
                back = np.sqrt((square[n] - square[m[live] + 1]) / (4.0 * square[n] - 1))
                after = scale * (cosine * now[live] - back * before[live])
                before[live], now[live] = now[live], after
            if n - start < len(m):
                if n:
                    sectoral = np.sqrt((2 * n + 1) / (2 * n)) * sine * sectoral
                now[n - start] = sectoral
            found[start : start + len(m), n] = np.where(np.abs(now) > _TINY, now, 0)
    return found

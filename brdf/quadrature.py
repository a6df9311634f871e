"""Quadrature over half vectors: nodes and weights, for models of any kind.

The rule resolves every highlight down to a slope of 1e-4 without being told where it is: in half vectors a lobe has its
peak at the normal, whatever the viewer, and the nodes crowd there.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

# theta_h = u^4 pi/2 at the nodes u: a lobe of slope 1e-4 still spans the first eighth of them.
_CROWDING = 4


@functools.cache
def unit_nodes(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Abscissas and weights of the Gauss-Legendre rule on [0, 1], shape (count,) each."""
    abscissas, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (1 + abscissas), 0.5 * weights


def half_vector_rule(
    theta: float, polar: int = 48, around: int = 64, cos_min: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A quadrature rule for what is reflected between all directions and one, with any highlight in it.

    **Arguments:**

    - `theta`: polar angle of the one direction in radians, in [0, pi/2); its azimuth is 0.
    - `polar`, `around`: nodes along theta_h (Gauss-Legendre, crowded at the normal) and phi_h (equidistant).
    - `cos_min`: cosine that the other directions are to exceed, at least 0 and not above cos(theta).

    **Returns:** the other directions, unit, shape (n, 3) with n = polar x around, and their solid angles in sr, shape
    (n,), which add up to nearly 2 pi (1 - cos_min).
    """
    u, weight = (column[:, None] for column in unit_nodes(polar))
    phi = (np.arange(around) + 0.5) * (2 * np.pi / around)
    sine, cosine = np.sin(theta), np.cos(theta)
    # The other direction's cosine is hypot(aside, cosine) cos(2 theta_h - tilt): it falls to `cos_min` at `end`.
    aside = sine * np.cos(phi)
    tilt = np.arctan2(aside, cosine)
    end = 0.5 * (tilt + np.arccos(np.minimum(cos_min / np.hypot(aside, cosine), 1)))
    theta_h = u**_CROWDING * end
    sin_h, cos_h = np.sin(theta_h), np.cos(theta_h)
    h = np.stack([sin_h * np.cos(phi), sin_h * np.sin(phi), cos_h], axis=-1)
    solid_angle = weight * _CROWDING * u ** (_CROWDING - 1) * end * sin_h * (2 * np.pi / around)
    one = np.array([sine, 0.0, cosine])
    cos_d = h @ one
    # The mirror image moves through 4 cos(theta_d) times the half vector's solid angle.
    return (2 * cos_d[..., None] * h - one).reshape(-1, 3), (4 * cos_d * solid_angle).ravel()

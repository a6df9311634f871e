"""Daylight scattered by a spherical atmosphere: integrals along view rays towards one sun.

- Nishita, Sirai, Tadamura, Nakamae 1993, "Display of the Earth Taking into Account Atmospheric Scattering".
- Bruneton, Neyret 2008, "Precomputed Atmospheric Scattering".
- Hillaire 2020, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique": the coefficients, and light
  scattered more than once as a geometric series of isotropic scattering.

Lengths are in km; the last axis of a colour is red, green, blue, at about 680, 550 and 440 nm.
"""

from __future__ import annotations

import math

import numpy as np

from .grid import Floats

Number = Floats | np.floating

GROUND, TOP = 6360.0, 6460.0
# Per km at sea level (ozone: at its densest), for air, aerosol and ozone; what is not scattered is absorbed.
SCATTERING = np.array([[5.802e-3, 13.558e-3, 33.1e-3], [3.996e-3] * 3, [0, 0, 0]], np.float32)
EXTINCTION = SCATTERING + np.array([[0, 0, 0], [0.44e-3] * 3, [0.650e-3, 1.881e-3, 0.085e-3]], np.float32)
_HEIGHT_AIR, _HEIGHT_AEROSOL = 8.0, 1.2
_OZONE_CENTRE, _OZONE_HALF_WIDTH = 25.0, 15.0
_FORWARD = 0.8  # mean cosine of scattering by aerosol
_VIEW_STEPS = 32
# Gauss and Legendre's points of a way of length 1, squared: the air is densest where the way begins.
_POINTS = [((1 + x) / 2, w / 2) for x, w in zip(*np.polynomial.legendre.leggauss(10), strict=True)]
# Without its phase functions, the sky hardly depends on the azimuth from the sun: a short series of cosines.
_AZIMUTHS = 6


def sky_radiance(eye: float, elevation: Floats, around: Floats, sun_elevation: float, albedo: float) -> Floats:
    """The radiance of the sky for a sun of irradiance 1 above the atmosphere in every channel.

    **Arguments:**

    - `eye`: the viewer's height above the ground.
    - `elevation`: shape (r,), of the view rays, not below the horizon.
    - `around`: shape (c,), the azimuth of the view rays from the sun.
    - `sun_elevation`: in [0.1, pi / 2].
    - `albedo`: of the ground.

    **Returns:** shape (r, c, 3), 1/sr.
    """
    sine, cosine = np.sin(elevation)[:, None], np.cos(elevation)[:, None]
    sun_sine, sun_cosine = np.float32(math.sin(sun_elevation)), np.float32(math.cos(sun_elevation))
    nodes = ((np.arange(_AZIMUTHS) + 0.5) * np.pi / _AZIMUTHS).astype(np.float32)
    found = scattered(eye, sine, sine * sun_sine + cosine * sun_cosine * np.cos(nodes), float(sun_sine), albedo)
    # The cosine series through the nodes.
    order = np.arange(_AZIMUTHS, dtype=np.float32)
    series = np.cos(order * nodes[:, None]) * np.where(order, 2, 1).astype(np.float32) / _AZIMUTHS
    between = series @ np.cos(order[:, None] * around)
    air, aerosol, often = (np.einsum("rnk,nc->rck", one, between, optimize=True) for one in found)
    nu = (sine * sun_sine + cosine * sun_cosine * np.cos(around))[..., None]
    return air * _phase_air(nu) + aerosol * _phase_aerosol(nu) + often


def scattered(eye: float, sine: Floats, nu: Floats, sun_sine: float, albedo: float) -> tuple[Floats, Floats, Floats]:
    """What arrives by one scattering of air and of aerosol, without their phase functions, and by more than one.

    `sine` of the elevations has the shape (r, 1), `nu`, the cosines to the sun, (r, n); the results (r, n, 3).
    """
    radius = np.float32(GROUND + eye)
    length = np.asarray(_to_top(radius, sine))[..., None]
    part, width = _steps(_VIEW_STEPS)
    t = length * part
    r = np.sqrt(radius**2 + t * t + 2 * radius * t * sine[..., None])
    amount = _densities(r - np.float32(GROUND)) * (length * width)[..., None]
    # Up to the middle of a step.
    passed = np.cumsum(amount, axis=-2) - amount / 2
    sun_cosine = (radius * np.float32(sun_sine) + t * nu[..., None]) / r
    lit = np.exp(-(passed + _depth(r, sun_cosine)) @ EXTINCTION)
    often = _multiple(sun_sine, albedo)
    height = r[:, 0] - np.float32(GROUND)
    ambient = np.stack([np.interp(height, _LEVELS, often[:, k]) for k in range(3)], axis=-1).astype(np.float32)
    again = (np.exp(-passed @ EXTINCTION) * (amount @ SCATTERING))[:, 0] * ambient
    air, aerosol = (np.einsum("rnsk,rs->rnk", lit, amount[:, 0, :, k]) * SCATTERING[k] for k in range(2))
    return air, aerosol, np.broadcast_to(again.sum(axis=-2)[:, None], air.shape)


def transmittance(eye: float, sine: float) -> Floats:
    """The part of the light from above the atmosphere that reaches the viewer: shape (3,)."""
    return np.exp(-_depth(np.float32(GROUND + eye), np.float32(sine)) @ EXTINCTION)


def _to_top(radius: Number, cosine: Number) -> Number:
    """The way from a radius to the top of the atmosphere, at a cosine to the zenith."""
    return -radius * cosine + np.sqrt((radius * cosine) ** 2 + np.float32(TOP) ** 2 - radius**2)


def _steps(count: int) -> tuple[Floats, Floats]:
    """Middles and widths of steps that grow along a way of length 1: the air is densest where it begins."""
    edges = np.linspace(0, 1, count + 1, dtype=np.float32) ** 2
    return (edges[1:] + edges[:-1]) / 2, np.diff(edges)


def _densities(height: Number) -> Floats:
    """Of air, aerosol and ozone, relative to their densest: shape (..., 3)."""
    height = height.clip(0, None)
    ozone = (1 - np.abs(height - np.float32(_OZONE_CENTRE)) / np.float32(_OZONE_HALF_WIDTH)).clip(0, None)
    return np.stack([np.exp(-height / _HEIGHT_AIR), np.exp(-height / _HEIGHT_AEROSOL), ozone], axis=-1)


def _depth(radius: Number, cosine: Number) -> Floats:
    """The amounts of air, aerosol and ozone on the way to the top, in km of the densest: shape (..., 3)."""
    length = np.asarray(_to_top(radius, cosine))
    total = np.zeros((*np.shape(length), 3), np.float32)
    for node, weight in _POINTS:
        t = length * np.float32(node * node)
        r = np.sqrt(radius * radius + t * t + 2 * radius * t * cosine)
        total += _densities(r - np.float32(GROUND)) * (length * np.float32(2 * node * weight))[..., None]
    return total


def _phase_air(nu: Floats) -> Floats:
    """Rayleigh's, in 1/sr."""
    return (3 / (16 * np.pi)) * (1 + nu * nu)


def _phase_aerosol(nu: Floats) -> Floats:
    """Cornette and Shanks 1992, in 1/sr."""
    g = _FORWARD
    bracket = (1 + g * g - 2 * g * nu).clip(1e-4, None)
    return (3 / (8 * np.pi)) * (1 - g * g) * (1 + nu * nu) / ((2 + g * g) * bracket**1.5)


# Heights at which light scattered more than once is computed; it varies slowly.
_LEVELS = np.linspace(0, 1, 16, dtype=np.float32) ** 2 * np.float32(TOP - GROUND)


def _multiple(sun_sine: float, albedo: float) -> Floats:
    """What arrives from all around after two scatterings or more, per unit of scattering there: shape (16, 3).

    The mean over directions of the light scattered once, isotropically, or by the ground, times the geometric series
    of what scatters back again (Hillaire 2020).
    """
    nodes, weights = np.polynomial.legendre.leggauss(24)
    cosine = nodes.astype(np.float32)[None, :]
    radius = (np.float32(GROUND) + _LEVELS.clip(1e-3, TOP - GROUND - 1e-2))[:, None]
    discriminant = (radius * cosine) ** 2 + np.float32(GROUND) ** 2 - radius**2
    hits = (cosine < 0) & (discriminant > 0)
    length = np.where(hits, -radius * cosine - np.sqrt(discriminant.clip(0, None)), _to_top(radius, cosine))
    part, width = _steps(_VIEW_STEPS)
    t = length[..., None] * part
    r = np.sqrt(radius[..., None] ** 2 + t * t + 2 * radius[..., None] * t * cosine[..., None])
    amount = _densities(r - np.float32(GROUND)) * (length[..., None] * width)[..., None]
    passed = np.cumsum(amount, axis=-2)
    through = np.exp(-(passed - amount / 2) @ EXTINCTION) * (amount @ SCATTERING)
    sun = np.exp(-_depth(r, np.full_like(r, sun_sine)) @ EXTINCTION)
    back = through.sum(axis=-2)
    ground = np.exp(-passed[..., -1, :] @ EXTINCTION) * transmittance(0.0, sun_sine) * (sun_sine * albedo / np.pi)
    first = (through * sun).sum(axis=-2) / (4 * np.pi) + ground * hits[..., None]
    mean = (weights / 2).astype(np.float32)
    return np.einsum("hdc,d->hc", first, mean) / (1 - np.einsum("hdc,d->hc", back, mean))

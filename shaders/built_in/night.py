"""A street at night: lamps in two rows, shop signs in strong colours, a moon: small bright lights on a dark ground.

Such lights are the hard case for a renderer that samples them, and the best for judging a highlight's shape. Every
light lies in a street whose ground it lights by the inverse square of the distance.
"""

from __future__ import annotations

import math

import numpy as np

from .disc import Triple, add_disc
from .grid import HEIGHT, Floats, directions

# Metres from the eye: lamps 4 m above it, left and right, warm, some of them white.
_LAMPS = tuple(
    ((side, 4.0, float(z)), (1.0, 0.86, 0.66) if (index + (side > 0)) % 3 == 0 else (1.0, 0.60, 0.24))
    for side in (-6.0, 6.5)
    for index, z in enumerate(range(-42, 46, 12))
)
_SIGNS = (
    ((-9.0, 0.4, -7.0), (1.0, 0.06, 0.10)),
    ((-9.0, 1.6, 1.5), (0.05, 0.35, 1.0)),
    ((-9.0, 0.9, 10.0), (0.10, 1.0, 0.35)),
    ((9.5, 0.7, -10.0), (0.05, 0.9, 0.8)),
    ((9.5, 1.5, -2.0), (1.0, 0.12, 0.75)),
    ((9.5, 0.5, 7.0), (1.0, 0.45, 0.05)),
)
# Irradiance times squared distance (m^2), and radius (m), of a lamp and of a sign; no light looks smaller than this.
_LAMP_POWER, _LAMP_RADIUS = 50.0, 0.40
_SIGN_POWER, _SIGN_RADIUS = 40.0, 0.50
_HALF_ANGLE_MIN = math.radians(0.7)
# It fades towards its edge by this power of a cosine, so that its outline is soft however bright its middle.
_FADE = (6.0, 6.0, 6.0)
_MOON: Triple = (0.42, 0.62, -0.66)
_MOON_HALF_ANGLE = math.radians(0.52 / 2)
_MOON_LIGHT = np.array([0.050, 0.055, 0.062])
_EYE = 1.7
_ASPHALT = np.array([0.09, 0.09, 0.10], np.float32)
_ZENITH = np.array([0.0025, 0.0045, 0.0120], np.float32)
_HORIZON = np.array([0.018, 0.022, 0.038], np.float32)
_TOWN = np.array([0.10, 0.055, 0.025], np.float32)


def night(height: int = HEIGHT) -> Floats:
    """The picture: shape (height, 2 height, 3), float32; every light has its whole energy at any resolution."""
    w = directions(height)
    half = height // 2
    picture = np.concatenate([_sky(w[:half]), _street(w[half:])])
    for at, color, power, radius in _lights():
        distance = math.hypot(*at)
        half_angle = max(math.asin(radius / distance), _HALF_ANGLE_MIN)
        add_disc(picture, at, half_angle, np.array(color) * power / distance**2, _FADE)
    add_disc(picture, _MOON, _MOON_HALF_ANGLE, _MOON_LIGHT)
    return picture


def _lights() -> list[tuple[Triple, Triple, float, float]]:
    """Place, colour, power and radius of each."""
    lamps = [(at, color, _LAMP_POWER, _LAMP_RADIUS) for at, color in _LAMPS]
    return lamps + [(at, color, _SIGN_POWER, _SIGN_RADIUS) for at, color in _SIGNS]


def _sky(w: Floats) -> Floats:
    """Dark blue, paler towards the horizon, with the glow of the town ahead."""
    y = w[..., 1:2]
    pale = np.exp(-y / np.float32(0.30))
    glow = np.exp(-y / np.float32(0.10)) * (0.55 - 0.45 * w[..., 2:])
    return _ZENITH * (1 - pale) + _HORIZON * pale + _TOWN * glow


def _street(w: Floats) -> Floats:
    """Asphalt with a pool of light under each lamp, fading into the horizon's glow."""
    distance = _EYE / -w[..., 1]
    x, z = w[..., 0] * distance, w[..., 2] * distance
    received = np.full((*x.shape, 3), 0.02, np.float32)
    for color in sorted({color for _, color, _, _ in _lights()}):
        level = np.zeros_like(x)
        for at, _, power, _ in (light for light in _lights() if light[1] == color):
            drop = np.float32(at[1] + _EYE)
            squared = (x - np.float32(at[0])) ** 2 + (z - np.float32(at[2])) ** 2 + drop * drop
            level += np.float32(power) * drop / (squared * np.sqrt(squared))
        received += level[..., None] * np.array(color, np.float32)
    near = np.exp(-((distance / np.float32(40)) ** 2))[..., None]
    horizon = _sky(w[:1] * np.array([1, 0, 1], np.float32))
    return near * _ASPHALT * received / np.float32(np.pi) + (1 - near) * horizon

"""A clear day: the sun over the left shoulder in a sky computed by `atmosphere`, above a plain that it lights.

- Hestroffer, Magnan 1998, "Wavelength dependency of the Solar limb darkening".

The white balance is a photographer's, who lays a grey card on the ground: there all channels receive pi together from
sun and sky. So the sun is a little warm, and the shadows are blue.
"""

from __future__ import annotations

import math

import numpy as np

from .atmosphere import EXTINCTION, sky_radiance, transmittance
from .disc import add_disc
from .grid import HEIGHT, Floats, azimuths, elevations, sky_irradiance

# The sun 38 degrees above the horizon, 130 degrees to the left of the direction in which the camera looks.
SUN_ELEVATION, SUN_AZIMUTH = math.radians(38), math.radians(-130)
SUN_HALF_ANGLE = math.radians(0.53 / 2)
# Of the cosine on the sun's surface at 680, 550 and 440 nm (Hestroffer, Magnan 1998).
_LIMB = (0.397, 0.503, 0.652)
# The viewer stands on a hill of this height in km: the plain fades into the air before the horizon, which a viewer on
# it would see as a sharp line.
_EYE = 0.5
_GROUND = np.array([0.25, 0.23, 0.20], np.float32)


def clear_sky(height: int = HEIGHT) -> Floats:
    """The picture: shape (height, 2 height, 3), float32; the sun covers one texel or two and has its whole energy."""
    half = height // 2
    around = azimuths(height) - np.float32(SUN_AZIMUTH)
    albedo = float(_GROUND.mean())
    above = np.concatenate([elevations(height)[:half], [np.float32(0)]])
    *_, horizon = sky = sky_radiance(_EYE, above, around, SUN_ELEVATION, albedo)
    upper, sun_sine = sky[:half], math.sin(SUN_ELEVATION)
    beam = transmittance(_EYE, sun_sine).astype(np.float64)
    received = sky_irradiance(upper) + beam * sun_sine
    lower = _plain(elevations(height)[half:, None, None], _GROUND * (received / np.pi).astype(np.float32), horizon)
    balance = np.pi / received
    picture = np.concatenate([upper, lower]) * balance.astype(np.float32)
    add_disc(picture, sun_direction(), SUN_HALF_ANGLE, beam * balance, _LIMB)
    return picture


def sun_direction() -> tuple[float, float, float]:
    """The unit vector towards the middle of the sun."""
    cosine = math.cos(SUN_ELEVATION)
    return cosine * math.sin(SUN_AZIMUTH), math.sin(SUN_ELEVATION), -cosine * math.cos(SUN_AZIMUTH)


def _plain(elevation: Floats, ground: Floats, horizon: Floats) -> Floats:
    """The lit ground through the air between, which takes on the colour of the horizon with the distance."""
    distance = np.float32(_EYE) / np.sin(-elevation)
    clear = np.exp(-distance * (EXTINCTION[0] + EXTINCTION[1]))
    return ground * clear + horizon * (1 - clear)

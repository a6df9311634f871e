"""A day under thick cloud: light from above without a shadow, above ground that it lights.

- CIE S 011/E:2003, "Spatial Distribution of Daylight", the traditional overcast sky (Moon, Spencer 1942): the radiance
  at an elevation is that of the zenith times (1 + 2 sin(elevation)) / 3.

Integrated over the hemisphere onto the ground that is 7 pi / 9 times the zenith's radiance.
"""

from __future__ import annotations

import numpy as np

from .grid import HEIGHT, Floats, directions, smooth

# The ground receives pi.
ZENITH = 9 / 7
_COLOR = np.array([0.97, 1.0, 1.05], np.float32)
_GROUND = np.array([0.22, 0.21, 0.19], np.float32)
# Waves across the cloud's underside (to +x, to +z, strength), in waves times 2 pi per height of the cloud; the share
# of the light that they take or give; and how far they bend each other.
_WAVES = ((0.9, 0.5, 1.0), (-0.8, 1.7, 0.8), (2.6, 1.7, 0.5), (2.2, -3.9, 0.35), (-6.1, 3.7, 0.2), (7.9, 6.1, 0.15))
_VARIATION = 0.20
_BEND = 0.8
# Fog: the ground fades into it over this sine of the angle below the horizon.
_FOG = 0.06


def overcast(height: int = HEIGHT) -> Floats:
    """The picture: shape (height, 2 height, 3), float32."""
    w = directions(height)
    half = height // 2
    upper = np.float32(ZENITH / 3) * (1 + 2 * w[:half, :, 1]) * (1 + _VARIATION * _clouds(w[:half]))
    near = 1 - np.exp(w[half:, :1, 1:2] / np.float32(_FOG))
    lower = near * _GROUND + (1 - near) * np.float32(ZENITH / 3)
    return np.concatenate([upper[..., None] * _COLOR, np.broadcast_to(lower, (height - half, 2 * height, 3)) * _COLOR])


def _clouds(w: Floats) -> Floats:
    """Waves in [-1, 1] that are odd in (x, z) together: opposite directions vary oppositely, so the light on the ground
    stays what the standard says."""
    far = np.maximum(w[..., 1], 0) + 0.15
    x, z = w[..., 0] / far, w[..., 2] / far
    total = np.zeros_like(x)
    strengths = 0.0
    for along_x, along_z, strength in _WAVES:
        total += np.float32(strength) * np.sin(along_x * x + along_z * z + _BEND * total)
        strengths += strength
    return total / np.float32(strengths) * smooth(w[..., 1] / np.float32(0.3))

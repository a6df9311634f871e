"""Half and difference angles, both ways, in float64 numpy.

Use it at the edge of file formats, whose tables are laid out in these angles. The differentiable
twin for models is `brdf/frame.py`.

With `h` the half vector, `(theta_h, phi_h)` are its spherical angles, and `(theta_d, phi_d)` those
of `wi` after the rotation that takes `h` to the normal: about the normal by `-phi_h`, then about
the binormal by `-theta_h`. Exchanging `wi` and `wo` adds pi to `phi_d`.

Rusinkiewicz 1998: S. Rusinkiewicz, "A New Change of Variables for Efficient BRDF Representation",
Eurographics Workshop on Rendering 1998.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

# Sines at or below this are the rounding of two unit vectors' sum or difference: the azimuth that
# they would give is noise, so it is set to zero instead.
POLE_SINE = 1e-15


class HalfDifference(NamedTuple):
    """The four angles of a pair of directions, each (n,), radians.

    `theta_h` in [0, pi/2] for directions above the horizon, `theta_d` in [0, pi/2], `phi_h` and
    `phi_d` in (-pi, pi].
    """

    theta_h: np.ndarray
    phi_h: np.ndarray
    theta_d: np.ndarray
    phi_d: np.ndarray


def half_difference(wi: np.ndarray, wo: np.ndarray) -> HalfDifference:
    """The half and difference angles of pairs of directions (Rusinkiewicz 1998).

    Every angle is the arc tangent of two lengths, never the arc cosine of a rounded cosine: the
    absolute error stays near 1e-16 down to `theta_h = 0` and `theta_d = 0`.

    **Arguments:**

    - `wi`: (n, 3) unit, to the light, local frame with normal +z.
    - `wo`: (n, 3) unit, to the viewer.

    **Returns:** the angles, radians. Where `h` is the normal `phi_h` is 0 and `phi_d` is the
    azimuth of `wi`; where `wi` equals `wo`, `phi_d` is 0.
    """
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    total, apart = wi + wo, wi - wo
    length = np.sqrt(np.einsum("ij,ij->i", total, total))
    sine = np.hypot(total[:, 0], total[:, 1])
    theta_h = np.arctan2(sine, total[:, 2])
    at_pole = sine <= POLE_SINE
    phi_h = np.where(at_pole, 0.0, np.arctan2(total[:, 1], total[:, 0]))
    # |wi + wo| = 2 cos(theta_d) and |wi - wo| = 2 sin(theta_d) for unit vectors.
    theta_d = np.arctan2(np.sqrt(np.einsum("ij,ij->i", apart, apart)), length)
    # Components of wi across h; those of (wi - wo) / 2 are the same and do not cancel.
    cos_h, sin_h = np.cos(theta_h), np.sin(theta_h)
    cos_p, sin_p = np.cos(phi_h), np.sin(phi_h)
    across = cos_h * (cos_p * apart[:, 0] + sin_p * apart[:, 1]) - sin_h * apart[:, 2]
    along = cos_p * apart[:, 1] - sin_p * apart[:, 0]
    at_pole = np.hypot(across, along) <= POLE_SINE
    phi_d = np.where(at_pole, 0.0, np.arctan2(along, across))
    return HalfDifference(theta_h, phi_h, theta_d, phi_d)


def directions(
    theta_h: ArrayLike, theta_d: ArrayLike, phi_d: ArrayLike, phi_h: ArrayLike = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """The pair of directions that has the given half and difference angles (Rusinkiewicz 1998).

    **Arguments:**

    - `theta_h`, `theta_d`, `phi_d`, `phi_h`: radians, of shapes that broadcast to (n,). An
      isotropic table needs no `phi_h`: 0 puts `h` into the x-z plane.

    **Returns:** `wi` and `wo`, each (n, 3) or, for four numbers, (3,); unit. Either may lie below
    the horizon.
    """
    theta_h, theta_d, phi_d, phi_h = np.broadcast_arrays(theta_h, theta_d, phi_d, phi_h)
    cos_h, sin_h = np.cos(theta_h), np.sin(theta_h)
    cos_p, sin_p = np.cos(phi_h), np.sin(phi_h)
    cos_d, sin_d = np.cos(theta_d), np.sin(theta_d)
    across, along = sin_d * np.cos(phi_d), sin_d * np.sin(phi_d)
    wi, wo = np.empty((*theta_h.shape, 3)), np.empty((*theta_h.shape, 3))
    # wi, wo = cos(theta_d) h +- (across t + along b), with t, b the rotated tangent and binormal.
    middle = cos_d * sin_h * cos_p
    aside = across * cos_h * cos_p - along * sin_p
    wi[..., 0], wo[..., 0] = middle + aside, middle - aside
    middle = cos_d * sin_h * sin_p
    aside = across * cos_h * sin_p + along * cos_p
    wi[..., 1], wo[..., 1] = middle + aside, middle - aside
    middle, aside = cos_d * cos_h, across * sin_h
    wi[..., 2], wo[..., 2] = middle - aside, middle + aside
    return wi, wo

"""Whether a fitted model keeps the laws: the same both ways, and no more light out than in.

What a model claims for all of its parameters is `AbstractBRDF.claims`; this looks at the parameters that were found,
whose lobes may together reflect more than all light although each keeps the law.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from brdf.integrate import albedos, evaluate_in_chunks
from brdf.model import AbstractBRDF
from brdf.quadrature import half_vector_rule

# The quadrature is right to this (tests/fitter/test_physics.py): less above 1 is no gain.
ENERGY_TOLERANCE = 1e-3
# Both ways differ by rounding alone in a model that is reciprocal.
RECIPROCITY_TOLERANCE = 1e-6
# Incident angles: near the horizon, where models gain energy, they are dense; the last is the limit of what is seen.
_THETA_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 75.0, 80.0, 83.0, 86.0, 88.0)
# About the normal: a model may be anisotropic.
_PHI_DEG = (0.0, 45.0, 90.0, 135.0)
# At grazing incidence a lobe is cut by the horizon within a few degrees of azimuth.
_POLAR, _AROUND = 40, 128
# Coarser, for the comparison of both ways and of the azimuths.
_PAIRS_POLAR, _PAIRS_AROUND = 16, 20
# In 1/sr: below the darkest measurement, a difference means nothing.
_DARK = 1e-6
# Relative: turning both directions rounds them, which a highlight of slope 1e-4 magnifies.
_SAME = 1e-6

CHANNELS = ("red", "green", "blue")


@dataclasses.dataclass(frozen=True)
class PhysicalCheck:
    """What the laws say of a model with its parameters.

    - `albedo_max`: the largest share of the light from one direction that it reflects, over all channels.
    - `theta_deg`, `channel`: the incident angle of that in degrees, at most 88, and the channel, empty where all three
      are the same.
    - `albedo_max_to_80`: the same over the incident angles up to 80 degrees, what a fit has usually seen.
    - `asymmetry`: the largest difference between a value and that with light and viewer exchanged, relative to the
      larger of the two; 0 for a reciprocal model, at most 1 unless values are negative.
    """

    albedo_max: float
    theta_deg: float
    channel: str
    albedo_max_to_80: float
    asymmetry: float

    @property
    def keeps_energy(self) -> bool:
        """Whether it never reflects more light than arrives, up to the accuracy of the quadrature."""
        return self.albedo_max <= 1 + ENERGY_TOLERANCE

    @property
    def is_reciprocal(self) -> bool:
        """Whether light and viewer may be exchanged, up to rounding."""
        return self.asymmetry <= RECIPROCITY_TOLERANCE

    def sentence(self) -> str:
        """The check in words, for a report."""
        where = f"{self.theta_deg:.0f} degrees" + (f", {self.channel}" if self.channel else "")
        if self.keeps_energy:
            energy = f"reflects at most {min(self.albedo_max, 1):.3g} of the light (at {where})"
        else:
            energy = f"gains energy: {self.albedo_max:.4g} of the light at {where}"
            if self.albedo_max_to_80 <= 1 + ENERGY_TOLERANCE:
                energy += ", though none up to 80 degrees"
        if self.is_reciprocal:
            return f"{energy}; reciprocal"
        return f"{energy}; not reciprocal: exchanging light and viewer changes it by up to {100 * self.asymmetry:.2g} %"

    def to_dict(self) -> dict[str, Any]:
        """The check as a JSON object."""
        return dataclasses.asdict(self) | {"keeps_energy": self.keeps_energy, "is_reciprocal": self.is_reciprocal}


def check(model: AbstractBRDF) -> PhysicalCheck:
    """Checks energy and reciprocity of a model with its parameters; see `PhysicalCheck`.

    The directional albedo is integrated at 11 incident angles from 0 to 88 degrees, and 4 azimuths if the model has a
    direction of its own, by a quadrature that resolves any highlight of a slope from 1e-4 on. Both ways are compared at
    12,800 pairs of directions, near the mirror direction and far from it.

    **Arguments:** `model`: any model or sum with finite parameters.
    """
    asymmetry, is_isotropic = _compare(model)
    azimuths = np.radians(_PHI_DEG[:1] if is_isotropic else _PHI_DEG)
    theta, phi = (angle.ravel() for angle in np.meshgrid(np.radians(_THETA_DEG), azimuths, indexing="ij"))
    albedo = albedos(model, theta, phi, _POLAR, _AROUND)
    # Rounded, so that the first of those that are the same wins.
    row, channel = np.unravel_index(int(np.argmax(albedo.round(6))), albedo.shape)
    seen = np.degrees(theta) <= 80 + 1e-9
    return PhysicalCheck(
        albedo_max=float(albedo[row, channel]),
        theta_deg=round(float(np.degrees(theta[row])), 6),
        channel=CHANNELS[channel] if np.ptp(albedo[row]) > 1e-6 else "",
        albedo_max_to_80=float(albedo[seen].max()),
        asymmetry=asymmetry,
    )


def _compare(model: AbstractBRDF) -> tuple[float, bool]:
    """The largest difference of both ways, and whether all azimuths of a pair give the same value."""
    wi, wo = [], []
    for phi in np.radians(_PHI_DEG):
        c, s = np.cos(phi), np.sin(phi)
        turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        for theta in np.radians(_THETA_DEG[1:]):
            other, _ = half_vector_rule(float(theta), _PAIRS_POLAR, _PAIRS_AROUND)
            wi.append(other @ turn)
            wo.append(np.broadcast_to(np.array([np.sin(theta), 0, np.cos(theta)]) @ turn, other.shape))
    there = np.concatenate(wi), np.concatenate(wo)
    forth, back = evaluate_in_chunks(model, there[0], there[1]), evaluate_in_chunks(model, there[1], there[0])
    asymmetry = (np.abs(forth - back) / np.maximum(np.maximum(np.abs(forth), np.abs(back)), _DARK)).max()
    turned = forth.reshape(len(_PHI_DEG), -1)
    return float(asymmetry), bool(np.allclose(turned, turned[:1], rtol=_SAME, atol=_DARK))

"""What a measurement leaves open: directions and channels that it does not cover."""

from __future__ import annotations

import numpy as np

from ..reflectance import Reflectance
from .finding import Finding, found

# Angles that differ by less are the same; instruments repeat theirs to a tenth of a degree or so.
_SAME_DEG = 0.5
_HIGHLIGHT_DEG = 5.0
_GRAZING_DEG = 45.0
_FIRST = 2000


def gaps(data: Reflectance) -> list[Finding]:
    """Names what data of this coverage cannot determine.

    **Arguments:**

    - `data`: any measurement.

    **Returns:** findings about all samples: `one-dimensional scan`, or else `one incident angle`, `plane of incidence`
    or `one phi_d`; `no highlight`; `no grazing angles`; `one channel`. Nothing for complete data.
    """
    findings = []
    # Almost always the first samples show already that there is more than one angle.
    for rows in (slice(None, None, max(1, len(data) // _FIRST)), slice(None)):
        findings = _angles(data, data.wi[rows], data.wo[rows])
        if not findings:
            break
    value = data.value
    if (value[:_FIRST, 0] == value[:_FIRST, 1]).all() and (value == value[:, :1]).all():
        findings.append(
            found(
                "one channel",
                len(data),
                data,
                "The three channels are the same: there is one measured channel, and no colour can be told from it.",
            )
        )
    return findings


def _angles(data: Reflectance, wi: np.ndarray, wo: np.ndarray) -> list[Finding]:
    total, apart = wi + wo, wi - wo
    theta_i, theta_o, theta_h = (_polar(w) for w in (wi, wo, total))
    theta_d = np.degrees(np.arctan2(np.linalg.norm(apart, axis=1), np.linalg.norm(total, axis=1)))
    # n . (wi x wo), over the sines that it could reach: 0 in the plane of incidence.
    sines = np.hypot(wi[:, 0], wi[:, 1]) * np.hypot(wo[:, 0], wo[:, 1])
    out_of_plane = np.abs(wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0])
    oblique = sines > np.sin(np.radians(_SAME_DEG))
    in_plane = bool(oblique.any() and (out_of_plane <= sines * np.sin(np.radians(_SAME_DEG)))[oblique].all())
    sentences = {}
    angles = {"theta_i": theta_i, "theta_o": theta_o, "theta_h": theta_h, "theta_d": theta_d}
    fixed = [name for name, angle in angles.items() if np.ptp(angle) < _SAME_DEG]
    if in_plane and fixed:
        sentences["one-dimensional scan"] = (
            f"All samples lie in the plane of incidence with {fixed[0]} = {_middle(angles[fixed[0]])} degrees, a scan "
            "in one dimension. It determines the shape of a lobe along it, and neither the Fresnel reflectance, nor "
            "anisotropy, nor two overlapping lobes: fix what else is known."
        )
    elif "theta_i" in fixed:
        sentences["one incident angle"] = (
            f"All samples have theta_i = {_middle(theta_i)} degrees. Such data cannot separate the Fresnel reflectance "
            "(f0, ior) from the strength of a lobe, nor tell how masking acts: fix them, or add an angle near 75."
        )
    elif in_plane:
        sentences["plane of incidence"] = (
            "All samples lie in the plane of incidence. Such data say nothing about anisotropy and little about the "
            "width of a lobe across that plane: fit isotropic models, or add samples beside the plane."
        )
    elif (np.abs(wi[:, 2] - wo[:, 2]) < 1e-6).all():
        sentences["one phi_d"] = (
            "All samples have phi_d = 90 degrees, light and viewer at the same height. Such data say nothing about the "
            "difference between forward and backward scattering: the roughness of a diffuse lobe and asymmetric lobes "
            "are guesses."
        )
    if (nearest := float(theta_h.min())) > _HIGHLIGHT_DEG:
        sentences["no highlight"] = (
            f"No sample is nearer than {nearest:.3g} degrees (theta_h) to the mirror direction. Narrower lobes "
            "are not seen, and a specular lobe's strength and width are guesses: fix one, or measure there."
        )
    if (steepest := float(theta_d.max())) < _GRAZING_DEG:
        sentences["no grazing angles"] = (
            f"Light and viewer are at most {2 * steepest:.3g} degrees apart. Such data cannot separate the Fresnel "
            "reflectance from the strength of a lobe: fix f0 or ior, or measure at theta_i of 60 degrees and more."
        )
    return [found(name, len(data), data, sentence) for name, sentence in sentences.items()]


def _polar(w: np.ndarray) -> np.ndarray:
    return np.degrees(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]))


def _middle(angle: np.ndarray) -> str:
    return f"{np.median(angle):.3g}"

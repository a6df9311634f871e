"""What a tabulated BRDF proposes to sample: the cosine, and visible normals of a GGX as wide as its highlight."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# Far from grazing, where measurements are least sure and the cosines vary least.
_THETA_D_MAX = math.radians(40)
_THETA_H_MAX = math.radians(45)
# GGX falls to half of its top, but for a factor near 1, where tan(theta_h) = alpha sqrt(sqrt(2) - 1).
_HALF_WIDTH = math.sqrt(math.sqrt(2) - 1)
# A highlight that holds less of the light than this needs no samples of its own.
_SHARE_MIN = 1e-3
# The cosine keeps this share of the samples: it reaches what the highlight's GGX does not.
_DIFFUSE_SHARE_MIN = 0.05


class Proposal(NamedTuple):
    """Weights of the cosine and of visible GGX normals, in one unit; 0 where there is no highlight; and the slope."""

    diffuse: float
    specular: float
    alpha: float


def estimate(values: NDArray[np.floating], theta_h: NDArray[np.floating], theta_d: NDArray[np.floating]) -> Proposal:
    """The proposal for a table, from its mean profile along theta_h.

    The least value of the profile is taken for the diffuse base, what is above it for the highlight: its weight is the
    light that it reflects, its slope that of the GGX with the same half width. The estimate decides how noisy a picture
    is, not what it converges to.

    **Arguments:**

    - `values`: (theta_h, theta_d, phi_d, 3), 1/sr.
    - `theta_h`, `theta_d`: radians, one-dimensional.
    """
    rows = max(int(np.searchsorted(theta_h, _THETA_H_MAX)), 1)
    columns = max(int(np.searchsorted(theta_d, _THETA_D_MAX)), 1)
    by_angle = values[:rows, :columns].mean(axis=(2, 3), dtype=np.float64)
    weight = np.sin(theta_d[:columns]) + 1e-6
    profile = by_angle @ (weight / weight.sum())
    angle = theta_h[:rows]
    base = float(profile.min())
    peak = profile - base
    # d(wi) = 4 cos_d d(h)
    cos_d = float(np.cos(theta_d[:columns]) @ (weight / weight.sum()))
    integrand = peak * np.cos(angle) * np.sin(angle)
    specular = 8 * np.pi * cos_d * float(np.sum((integrand[1:] + integrand[:-1]) / 2 * np.diff(angle)))
    diffuse = np.pi * base
    if specular <= _SHARE_MIN * (specular + diffuse):
        return Proposal(max(diffuse, _SHARE_MIN), 0.0, 1.0)
    top = int(np.argmax(peak))
    below = np.flatnonzero(peak[top:] <= 0.5 * peak[top])
    # What does not fall to half within these angles is as wide as a lobe may be.
    alpha = math.tan(float(angle[top + int(below[0])])) / _HALF_WIDTH if below.size else 1.0
    return Proposal(max(diffuse, _DIFFUSE_SHARE_MIN * specular), specular, min(max(alpha, 1e-4), 1.0))

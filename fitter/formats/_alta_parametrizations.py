"""ALTA's parametrizations of two directions: name -> (number of columns, function, what the columns are).

A function takes one (n,) array per column, radians, and returns `wi`, the light, and `wo`, the viewer, (n, 3). Where a
parametrization leaves an angle open, it is the one of ALTA's `params::to_cartesian`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fitter.formats._scattered import spherical
from fitter.rusinkiewicz import directions

Pair = tuple[np.ndarray, np.ndarray]


def _half(
    theta_h: np.ndarray, phi_h: np.ndarray | float, theta_d: np.ndarray | float, phi_d: np.ndarray | float
) -> Pair:
    """ALTA's difference vector is the viewer's, ours the light's."""
    wo, wi = directions(theta_h, theta_d, phi_d, phi_h)
    return wi, wo


def _cartesian(*v_then_l: np.ndarray) -> Pair:
    vectors = np.stack(v_then_l, 1).reshape(-1, 2, 3)
    return vectors[:, 1], vectors[:, 0]


def _projected(theta_l: np.ndarray, x: np.ndarray, y: np.ndarray) -> Pair:
    """The light in the x-z plane; (x, y) is the viewer's polar angle, turned by the difference of the azimuths."""
    zero = np.zeros_like(theta_l)
    return spherical(theta_l, zero), spherical(np.hypot(x, y), np.arctan2(y, x))


def _between(cosine: np.ndarray) -> Pair:
    """The light along the normal; COS_TLV is the angle between the two."""
    zero = np.zeros_like(cosine)
    return spherical(zero, zero), spherical(np.arccos(cosine), zero)


PARAMETRIZATIONS: dict[str, tuple[int, Callable[..., Pair], tuple[str, ...]]] = {
    "RUSIN_TH_PH_TD_PD": (4, _half, ("theta", "phi", "theta", "phi")),
    "RUSIN_TH_PH_TD": (3, lambda th, ph, td: _half(th, ph, td, 0.0), ("theta", "phi", "theta")),
    "RUSIN_TH_TD_PD": (3, lambda th, td, pd: _half(th, 0.0, td, pd), ("theta", "theta", "phi")),
    "RUSIN_TH_TD": (2, lambda th, td: _half(th, 0.0, td, np.pi / 2), ("theta", "theta")),
    "COS_TH_TD": (2, lambda h, d: _half(np.arccos(h), 0.0, np.arccos(d), 0.0), ("cosine", "cosine")),
    "COS_TH": (1, lambda h: _half(np.arccos(h), 0.0, 0.0, 0.0), ("cosine",)),
    "COS_TLV": (1, _between, ("cosine",)),
    "SPHERICAL_TL_PL_TV_PV": (
        4,
        lambda tl, pl, tv, pv: (spherical(tl, pl), spherical(tv, pv)),
        ("theta", "phi", "theta", "phi"),
    ),
    "ISOTROPIC_TV_TL_DPHI": (
        3,
        lambda tv, tl, dphi: (spherical(tl, dphi), spherical(tv, np.zeros_like(tv))),
        ("theta", "theta", "phi"),
    ),
    "ISOTROPIC_TL_TV_PROJ_DPHI": (3, _projected, ("theta", "theta", "theta")),
    "ISOTROPIC_TV_PROJ_DPHI": (2, lambda x, y: _projected(np.zeros_like(x), x, y), ("theta", "theta")),
    "CARTESIAN": (6, _cartesian, ("length",) * 6),
}

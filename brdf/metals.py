"""Measured metals, as the complex index per channel of the exact conductor Fresnel (`fresnel="conductor"`).

Per channel (eta, k) stand for a whole spectrum: their reflectance at normal incidence is that of the metal under D65,
CIE 1931 2 degree observer, in linear Rec. 709, and among all such pairs theirs follows the metal best up to 85
degrees. `brdf metals FILE.yml` makes them from a file of refractiveindex.info (CC0), as `fitter.conductor` says; every
entry names its page, such as `main/Au/Johnson`. They are films and polished crystals, and measurements of one metal
differ: two published reflectances of titanium by 0.18.

Platinum and tungsten are not from Werner et al. 2009, whose energy-loss spectra put their green reflectance at 0.93
and 0.81: optical measurements say 0.64-0.73 and 0.50. Platinum is a model fitted to several measurements.
"""

from __future__ import annotations

import dataclasses
import itertools

from .errors import UserError, nearest

RGB = tuple[float, float, float]

# The reflectance per channel that a conductor can have; a metal's colour may lie outside Rec. 709.
F0_MIN, F0_MAX = 0.0, 0.9999


@dataclasses.dataclass(frozen=True)
class Metal:
    """One measured metal.

    **Arguments:**

    - `symbol`: of the chemical element.
    - `eta`, `k`: real and imaginary part of the effective index of refraction per channel, linear Rec. 709.
    - `color`: the metal's colour at normal incidence, linear Rec. 709, where 1 reflects all light. Channels outside
      [0, 0.9999] are out of the gamut, and clipped in `eta` and `k`.
    - `source`: who measured it.
    - `page`: where refractiveindex.info has the measurement.
    """

    symbol: str
    eta: RGB
    k: RGB
    color: RGB
    source: str
    page: str

    @property
    def f0(self) -> RGB:
        """The reflectance at normal incidence of `eta` and `k`."""
        red, green, blue = (
            ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2) for eta, k in zip(self.eta, self.k, strict=True)
        )
        return red, green, blue


METALS: dict[str, Metal] = {
    "aluminium": Metal(
        symbol="Al",
        eta=(1.5061, 0.9858, 0.60645),
        k=(7.6638, 6.5514, 5.353),
        color=(0.9073, 0.9159, 0.9223),
        source="Rakić 1995, doi:10.1364/AO.34.004755",
        page="main/Al/Rakic",
    ),
    "chromium": Metal(
        symbol="Cr",
        eta=(3.245, 3.1169, 2.2865),
        k=(3.2863, 3.3366, 3.1171),
        color=(0.5496, 0.556, 0.5542),
        source="Johnson and Christy 1974, doi:10.1103/PhysRevB.9.5056",
        page="main/Cr/Johnson",
    ),
    "copper": Metal(
        symbol="Cu",
        eta=(0.23872, 1.0455, 1.2975),
        k=(3.5292, 2.6265, 2.3636),
        color=(0.9317, 0.6227, 0.5223),
        source="Johnson and Christy 1972, doi:10.1103/PhysRevB.6.4370",
        page="main/Cu/Johnson",
    ),
    "gold": Metal(
        symbol="Au",
        eta=(0.010026, 0.49538, 1.4781),
        k=(20.0, 2.2491, 1.7788),
        color=(1.0376, 0.7284, 0.3646),
        source="Johnson and Christy 1972, doi:10.1103/PhysRevB.6.4370",
        page="main/Au/Johnson",
    ),
    "iron": Metal(
        symbol="Fe",
        eta=(2.9225, 2.92, 2.5462),
        k=(3.0773, 2.9374, 2.7499),
        color=(0.5297, 0.5132, 0.4942),
        source="Johnson and Christy 1974, doi:10.1103/PhysRevB.9.5056",
        page="main/Fe/Johnson",
    ),
    "nickel": Metal(
        symbol="Ni",
        eta=(2.0413, 1.9048, 1.7308),
        k=(4.208, 3.5714, 2.8972),
        color=(0.6971, 0.6405, 0.5632),
        source="Johnson and Christy 1974, doi:10.1103/PhysRevB.9.5056",
        page="main/Ni/Johnson",
    ),
    "platinum": Metal(
        symbol="Pt",
        eta=(2.3654, 2.0693, 1.8287),
        k=(4.2594, 3.68, 3.0929),
        color=(0.6789, 0.6395, 0.5836),
        source="Rakić et al. 1998, doi:10.1364/AO.37.005271",
        page="main/Pt/Rakic-BB",
    ),
    "silver": Metal(
        symbol="Ag",
        eta=(0.057027, 0.055158, 0.043278),
        k=(4.5076, 3.5546, 2.5911),
        color=(0.9894, 0.984, 0.9778),
        source="Johnson and Christy 1972, doi:10.1103/PhysRevB.6.4370",
        page="main/Ag/Johnson",
    ),
    "titanium": Metal(
        symbol="Ti",
        eta=(2.7551, 2.5079, 2.2416),
        k=(3.8465, 3.3975, 3.0154),
        color=(0.6186, 0.5794, 0.5425),
        source="Johnson and Christy 1974, doi:10.1103/PhysRevB.9.5056",
        page="main/Ti/Johnson",
    ),
    "tungsten": Metal(
        symbol="W",
        eta=(3.6373, 3.4945, 3.3144),
        k=(2.9238, 2.7475, 2.5056),
        color=(0.5159, 0.4963, 0.4674),
        source="Weaver et al. 1975, doi:10.1103/PhysRevB.12.1293",
        page="main/W/Weaver",
    ),
}

_ALIASES = {"aluminum": "aluminium", **{metal.symbol.lower(): name for name, metal in METALS.items()}}


def metal_name(name: str) -> str:
    """The key in `METALS` of a metal's name or chemical symbol; raises `UserError`, naming the nearest, if unknown."""
    lower = name.strip().lower()
    found = _ALIASES.get(lower, lower)
    if found not in METALS:
        known = itertools.chain(METALS, (metal.symbol for metal in METALS.values()))
        raise UserError(f"`{name}` is not a metal of the table. {nearest(name, known)}")
    return found


def conductor(name: str) -> dict[str, RGB]:
    """The parameters `eta` and `k` of a metal, for a model with `fresnel="conductor"`.

    **Arguments:**

    - `name`: a common name or chemical symbol, `gold` or `Au`.

    **Raises:** `UserError` for an unknown metal.
    """
    metal = METALS[metal_name(name)]
    return {"eta": metal.eta, "k": metal.k}

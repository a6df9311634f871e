"""Spectra of reflectance to colours.

The colour of a reflectance is that of light from a named illuminant after it: CIE 1931 2 degree observer, then adapted
from the illuminant's white to D65 by Bradford's transform, then linear Rec. 709, whose white is D65. A flat spectrum is
grey under every illuminant. The tables of the observer and the illuminants come from the package `colour-science`.

Readers of spectral formats share the options `wavelength` and `illuminant`; see `channel_weights`.
"""

from __future__ import annotations

import difflib
import math

import numpy as np

from brdf.errors import UserError

# Where the observer's table lies, nm.
FIRST_NM, LAST_NM = 360, 830
# Spectra that leave out more of the visible range than this do not define a colour; nm.
NEEDED_NM = (450, 650)
# Nor do those with a wider gap inside it: between laser lines any curve could run. The observer's three curves are
# 50 to 100 nm wide at half their height.
WIDEST_GAP_NM = 50
# The wavelength that stands for all where no colour is defined: near the peak of the eye's sensitivity.
GREY_NM = 550
DEFAULT_ILLUMINANT = "D65"
# A wavelength that was asked for must be one that was measured, to within this; nm.
SAME_NM = 1.0

OPTIONS: dict[str, tuple[str, ...]] = {"wavelength": (), "illuminant": ()}


def channel_weights(
    wavelengths_nm: np.ndarray, wavelength: str | None = None, illuminant: str | None = None
) -> tuple[np.ndarray, str]:
    """How a spectrum becomes three channels, as the options say, or as the wavelengths allow.

    **Arguments:**

    - `wavelengths_nm`: (n,) ascending, nm.
    - `wavelength`: `550`: this one for all three channels; `630,525,465`: these for red, green and blue; none: the
      colour under `illuminant` if the wavelengths define one, otherwise the one nearest 550 nm for all three.
    - `illuminant`: a name that `colour-science` knows, such as D65 (the default), A, E or FL2.

    **Returns:** (n, 3), so that `spectrum @ weights` are the channels, and a phrase that says what was done, for the
    report.

    **Raises:** `UserError` if an option is not one of these or a wavelength was not measured.
    """
    wavelengths_nm = np.asarray(wavelengths_nm, np.float64)
    if wavelength is not None:
        if illuminant is not None:
            raise UserError(
                f"`wavelength = {wavelength}` and `illuminant = {illuminant}` exclude each other. "
                "Leave out `wavelength` for a colour, `illuminant` for single wavelengths."
            )
        places = _chosen(wavelengths_nm, wavelength)
        names = ", ".join(f"{wavelengths_nm[place]:g}" for place in places)
        return _picked(len(wavelengths_nm), places * (3 // len(places))), (
            f"{names} nm as red, green, blue" if len(places) == 3 else f"all channels from {names} nm"
        )
    problem = _no_colour(wavelengths_nm)
    if problem is None:
        name = _illuminant(illuminant or DEFAULT_ILLUMINANT)
        return rgb_weights(wavelengths_nm, name), f"colour of {len(wavelengths_nm)} wavelengths under {name}"
    if illuminant is not None:
        raise UserError(f"`illuminant = {illuminant}` asks for a colour, but {problem}. Pass `wavelength` instead.")
    place = int(np.argmin(np.abs(wavelengths_nm - GREY_NM)))
    return _picked(len(wavelengths_nm), [place] * 3), (
        f"all channels from {wavelengths_nm[place]:g} nm, since {problem}"
        if len(wavelengths_nm) > 1
        else f"all channels from {wavelengths_nm[place]:g} nm"
    )


def rgb_weights(wavelengths_nm: np.ndarray, illuminant: str = DEFAULT_ILLUMINANT) -> np.ndarray:
    """What each wavelength of a reflectance spectrum contributes to red, green and blue.

    **Arguments:**

    - `wavelengths_nm`: (n,) ascending, nm. Between them the spectrum is linear, beyond them constant.
    - `illuminant`: a name that `colour-science` knows.

    **Returns:** (n, 3), so that `spectrum @ rgb_weights(...)` is linear Rec. 709. Each column sums to 1: a flat
    spectrum is grey.

    **Raises:** `ValueError` if the wavelengths do not reach from 450 to 650 nm without a gap of more than 50 nm;
    `UserError` on an unknown illuminant.
    """
    if (problem := _no_colour(wavelengths_nm)) is not None:
        raise ValueError(problem)
    name = _illuminant(illuminant)
    import colour  # slow to import, and only spectral files need it

    grid = colour.SpectralShape(FIRST_NM, LAST_NM, 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(grid)
    light = colour.SDS_ILLUMINANTS[name].copy().align(grid)
    seen = observer.values * light.values[:, None]
    seen /= seen[:, 1].sum()
    shares = np.stack([np.interp(grid.wavelengths, wavelengths_nm, one) for one in np.eye(len(wavelengths_nm))])
    space = colour.RGB_COLOURSPACES["ITU-R BT.709"]
    white = space.matrix_RGB_to_XYZ.sum(1)
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(seen.sum(0), white, transform="Bradford")
    return shares @ seen @ (space.matrix_XYZ_to_RGB @ adapt).T


def xyz_to_rgb(xyz: np.ndarray) -> np.ndarray:
    """CIE XYZ relative to D65, (..., 3), to linear Rec. 709."""
    import colour

    return xyz @ colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB.T


def _no_colour(wavelengths_nm: np.ndarray) -> str | None:
    """Why these wavelengths do not define a colour, or None if they do."""
    low, high = wavelengths_nm[0], wavelengths_nm[-1]
    if not (low <= NEEDED_NM[0] and high >= NEEDED_NM[1]):
        return f"wavelengths of {low:g}-{high:g} nm do not cover {NEEDED_NM[0]}-{NEEDED_NM[1]} nm, which a colour needs"
    start, end = wavelengths_nm[:-1], wavelengths_nm[1:]
    gap = np.where((end > NEEDED_NM[0]) & (start < NEEDED_NM[1]), end - start, 0)
    if gap.max() > WIDEST_GAP_NM:
        place = int(np.argmax(gap))
        return f"the gap of {start[place]:g}-{end[place]:g} nm is too wide for a colour (over {WIDEST_GAP_NM} nm)"
    return None


def _chosen(wavelengths_nm: np.ndarray, wavelength: str) -> list[int]:
    """The columns that the option `wavelength` names."""
    try:
        wanted = [float(part) for part in wavelength.split(",")]
    except ValueError:
        wanted = []
    if len(wanted) not in (1, 3) or not all(map(math.isfinite, wanted)):
        raise UserError(f"`wavelength = {wavelength}` is not one number of nm, or three for red, green and blue.")
    places = [int(np.argmin(np.abs(wavelengths_nm - one))) for one in wanted]
    for one, place in zip(wanted, places, strict=True):
        if abs(wavelengths_nm[place] - one) > SAME_NM:
            shown = ", ".join(f"{nm:g}" for nm in wavelengths_nm[:12])
            raise UserError(
                f"`wavelength = {one:g}` nm was not measured. The nearest is {wavelengths_nm[place]:g} nm; "
                f"there are {shown}{', ...' if len(wavelengths_nm) > 12 else ''}."
            )
    return places


def _picked(count: int, places: list[int]) -> np.ndarray:
    weights = np.zeros((count, 3))
    weights[places, range(3)] = 1
    return weights


def _illuminant(name: str) -> str:
    """The name as `colour-science` writes it."""
    import colour

    known = {one.lower(): one for one in colour.SDS_ILLUMINANTS}
    if name.lower() not in known:
        near = difflib.get_close_matches(name.lower(), known, n=3, cutoff=0.4) or ["d65", "d50", "a", "e", "fl2"]
        raise UserError(
            f"`illuminant = {name}` is not one that colour-science knows. Pass one such as "
            + ", ".join(f"`{known[one]}`" for one in near)
            + "."
        )
    return known[name.lower()]

"""Spectra of reflectance to colours.

The colour of a reflectance is that of light from the illuminant D65 after it: CIE 1931 2 degree
observer, then linear Rec. 709, whose white is D65. The observer's and the illuminant's tables come
from the package `colour-science`.
"""

from __future__ import annotations

import numpy as np

# Where the observer's table lies, nm.
FIRST_NM, LAST_NM = 360, 830
# Spectra that leave out more of the visible range than this do not define a colour; nm.
NEEDED_NM = (450, 650)


def rgb_weights(wavelengths_nm: np.ndarray) -> np.ndarray:
    """What each wavelength of a reflectance spectrum contributes to red, green and blue.

    **Arguments:**

    - `wavelengths_nm`: (n,) ascending, nm. Between them the spectrum is linear, beyond them constant.

    **Returns:** (n, 3), so that `spectrum @ rgb_weights(...)` is linear Rec. 709. Each column sums
    to 1: a flat spectrum is grey.

    **Raises:** `ValueError` if the wavelengths do not reach from 450 to 650 nm, or `colour-science`
    is not installed.
    """
    if not (wavelengths_nm[0] <= NEEDED_NM[0] and wavelengths_nm[-1] >= NEEDED_NM[1]):
        raise ValueError(
            f"wavelengths of {wavelengths_nm[0]:g}-{wavelengths_nm[-1]:g} nm do not cover "
            f"{NEEDED_NM[0]}-{NEEDED_NM[1]} nm, which a colour needs"
        )
    try:
        import colour  # slow to import, and only spectral files need it
    except ImportError as error:
        raise ValueError("colours of spectra need the package: pip install colour-science") from error

    grid = colour.SpectralShape(FIRST_NM, LAST_NM, 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(grid)
    illuminant = colour.SDS_ILLUMINANTS["D65"].copy().align(grid)
    seen = observer.values * illuminant.values[:, None]
    shares = np.stack([np.interp(grid.wavelengths, wavelengths_nm, one) for one in np.eye(len(wavelengths_nm))])
    to_rgb = colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB
    weights = shares @ seen @ to_rgb.T
    return weights / weights.sum(0)

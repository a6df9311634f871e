"""Goniometer `.csv`: scattered samples as NIST publishes them, one row per wavelength and pair of directions.

The header line names the columns, in any order; capitals and underscores do not count.

    lambda                wavelength in micrometres, or nm if above 20
    thetai, phii (phi)    incident direction, degrees
    thetar, phir          reflected direction, degrees
    fr11                  unpolarised BRDF, 1/sr, without the cosine

Further columns, such as the other elements of a Mueller matrix, are not used. Both azimuths are in one frame, and a
negative polar angle is a direction on the other side of the normal: with thetai < 0 and phii = 0 the light comes from
-x, and the mirror direction is at phir = 0, as in the PTFE data.

The options `wavelength` and `illuminant` say how wavelengths become channels. A few laser lines define no colour: then
one wavelength stands for all channels, and the report says which and why.

Germer 2017: T. A. Germer, "Full four-dimensional and reciprocal Mueller matrix bidirectional reflectance distribution
function of sintered polytetrafluoroethylene", Applied Optics 56(33), 2017.
"""

from __future__ import annotations

import os

import numpy as np

from brdf.errors import FileError
from fitter.formats import _spectrum
from fitter.formats._scattered import measurement, spherical
from fitter.formats._text import number_rows, read_text
from fitter.reflectance import Reflectance

NAME = "goniometer CSV"
DESCRIPTION = "scattered samples at several wavelengths: lambda, thetai, phii, thetar, phir, fr11"
SUFFIXES = (".csv",)
OPTIONS = _spectrum.OPTIONS

ANGLES = ("thetai", "phii", "thetar", "phir")
COLUMNS = ("lambda", *ANGLES, "fr11")
ALIASES = {"phi": "phii", "fr": "fr11", "brdf": "fr11"}
# Wavelengths above this are nm, below micrometres.
LONGEST_UM = 20
# More distinct wavelengths than a spectrum has mean that the column is not one of wavelengths.
MOST_WAVELENGTHS = 2000
# Directions that differ by less are one, measured at several wavelengths; degrees.
SAME_DEG = 1e-3


def sniff(head: bytes) -> bool:
    """Whether the first line that is no comment names a wavelength and both polar angles."""
    lines = (line.strip() for line in head.decode("utf-8-sig", "replace").splitlines())
    first = next((line for line in lines if line and not line.startswith("#")), "")
    return {"lambda", "thetai", "thetar"} <= set(_names(first))


def read(path: str | os.PathLike[str], wavelength: str | None = None, illuminant: str | None = None) -> Reflectance:
    """Reads scattered samples; see the module.

    **Arguments:**

    - `path`: the file, UTF-8.
    - `wavelength`, `illuminant`: see `_spectrum.channel_weights`.

    **Returns:** one sample per pair of directions that has every wavelength that is needed, is finite, above the
    horizon and has a positive channel or only zeros. Negative channels beside positive ones are colours out of gamut:
    0, and counted in `clamped`. There is no grid and no interpolation.

    **Raises:** `FileError` that names the line, on missing columns, fields that are no numbers, wavelengths that are
    not positive, or no usable row; `UserError` on an option that does not fit.
    """
    lines = [
        (number, line.strip())
        for number, line in enumerate(read_text(path).splitlines(), 1)
        if line.strip() and not line.strip().startswith("#")
    ]
    if len(lines) < 2:
        raise FileError(path, "has no rows.", f"A header with {', '.join(COLUMNS)}, then numbers.")
    number, header = lines[0]
    names = _names(header)
    for name in COLUMNS:
        if names.count(name) != 1:
            what = f"lacks `{name}`" if name not in names else f"names `{name}` twice"
            raise FileError(path, f"line {number} {what}.", f"Columns are {', '.join(COLUMNS)}.")
    rows, numbers = number_rows(path, lines[1:], names, ",")
    used = rows[:, [names.index(name) for name in COLUMNS]]
    finite = np.isfinite(used).all(1)
    used, numbers = used[finite], numbers[finite]
    dropped = {"not finite": int(np.count_nonzero(~finite))}
    if (bad := used[:, 0] <= 0).any():
        first = int(np.argmax(bad))
        raise FileError(
            path, f"line {numbers[first]}: `lambda = {used[first, 0]:g}` is not positive.", "Give micrometres or nm."
        )
    if not len(used):
        raise FileError(path, f"has no usable row: of {len(rows)} {len(rows)} not finite.", "Export it again.")
    nanometres = np.where(used[:, 0] > LONGEST_UM, used[:, 0], used[:, 0] * 1000).round(3)
    wavelengths = np.unique(nanometres)
    if len(wavelengths) > MOST_WAVELENGTHS:
        raise FileError(
            path,
            f"column `lambda` holds {len(wavelengths)} different wavelengths.",
            f"At most {MOST_WAVELENGTHS} are accepted: check the column.",
        )
    weights, done = _spectrum.channel_weights(wavelengths, wavelength, illuminant)
    degrees, value, reasons = _gather(used, nanometres, wavelengths, weights)
    theta_i, phi_i, theta_r, phi_r = np.radians(degrees).T
    return measurement(
        path,
        spherical(theta_i, phi_i),
        spherical(theta_r, phi_r),
        value,
        format=NAME,
        facts=f"{done}, of wavelengths {_told(wavelengths)} nm",
        clamp=True,
        dropped=dropped | reasons,
        remedy="Angles are in degrees from the normal, values in 1/sr.",
    )


def _gather(
    used: np.ndarray, nanometres: np.ndarray, wavelengths: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray, dict[str, int]]:
    """Brings the wavelengths of a pair of directions together.

    **Returns:** (n, 4) degrees, (n, 3) values, and reason -> count of what was left out.
    """
    needed = np.flatnonzero(weights.any(1))
    use = np.isin(nanometres, wavelengths[needed])
    used, nanometres = used[use], nanometres[use]
    _, first, pair = np.unique(np.rint(used[:, 1:5] / SAME_DEG), axis=0, return_index=True, return_inverse=True)
    pair = pair.ravel()
    value, found = np.zeros((len(first), 3)), np.zeros(len(first), int)
    repeated = 0
    for place in needed:
        rows = np.flatnonzero(nanometres == wavelengths[place])
        pairs, where = np.unique(pair[rows], return_index=True)
        repeated += len(rows) - len(pairs)
        value[pairs] += used[rows[where], 5, None] * weights[place]
        found[pairs] += 1
    whole = found == len(needed)
    order = np.flatnonzero(whole)[np.argsort(first[whole])]  # as in the file
    reasons = {"repeated": repeated, "not at every wavelength": int(np.count_nonzero(~whole))}
    return used[first[order], 1:5], value[order], reasons


def _names(header: str) -> list[str]:
    names = [name.strip().strip('"').lower().replace("_", "").replace(" ", "") for name in header.split(",")]
    return [ALIASES.get(name, name) if ALIASES.get(name, "") not in names else name for name in names]


def _told(wavelengths: np.ndarray) -> str:
    shown = [f"{nm:g}" for nm in wavelengths]
    return ", ".join(shown) if len(shown) <= 6 else f"{shown[0]} to {shown[-1]} ({len(shown)})"

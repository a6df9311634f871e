"""ASTM E1392 `.astm`: scattered samples as text, as the Cornell reflectance data are published.

A header of `KEY value` lines ends with `VARS`, whose comma-separated names are the columns; then follow rows of
comma-separated numbers. Lines that start with `#` are comments.

    theta_i, phi_i, theta_s, phi_s    directions of the light and of scatter; phi_i may be left out: 0
    R, G, B                           linear Rec. 709
    X, Y, Z                           CIE XYZ relative to D65
    500nm, 510nm, ...                 a spectrum; the options `wavelength` and `illuminant` say how it becomes channels
    Integrated ..., or any other      one value for all three channels

Values are 1/sr without the cosine. `NUM_POINTS`, if given, must not exceed the number of rows: a truncated file is
told.

Two things differ between files. Angles are radians in the Cornell data, as their public readers take them, and degrees
elsewhere: the option `angles` says it; `auto`, the default, takes a line `ANGLE_UNITS` of the header, and without it
radians if no polar angle exceeds pi / 2 and no azimuth 2 pi. The mirror direction lies at phi_s - phi_i = 180 degrees
if both are azimuths in one frame, as in the Cornell data (the default of the option `mirror`), and at 0 if phi_s is
counted from the forward direction.
"""

from __future__ import annotations

import os
import re

import numpy as np

from brdf.errors import FileError
from fitter.formats import _spectrum
from fitter.formats._scattered import measurement, spherical
from fitter.formats._text import number_rows, read_text
from fitter.reflectance import Reflectance

NAME = "ASTM E1392"
DESCRIPTION = "scattered samples as text, a header with VARS, one value, colours or spectra"
SUFFIXES = (".astm", ".dat", ".txt")
OPTIONS = {"angles": ("auto", "degrees", "radians"), "mirror": ("180", "0")} | _spectrum.OPTIONS

ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
COLOURS = (("r", "g", "b"), ("x", "y", "z"))
NANOMETRES = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*nm")
# Angles in radians may exceed their range by rounding.
SLACK = 1e-3


def sniff(head: bytes) -> bool:
    """Whether a line of the head starts with VARS."""
    return re.search(rb"^\s*VARS\s", head, re.MULTILINE) is not None


def read(
    path: str | os.PathLike[str],
    angles: str = "auto",
    mirror: str = "180",
    wavelength: str | None = None,
    illuminant: str | None = None,
) -> Reflectance:
    """Reads scattered samples; see the module.

    **Arguments:**

    - `path`: the file, UTF-8.
    - `angles`: `auto`, `degrees` or `radians`.
    - `mirror`: phi_s - phi_i of the mirror direction, degrees.
    - `wavelength`, `illuminant`: for spectra only; see `_spectrum.channel_weights`.

    **Returns:** one sample per row that is finite, has both directions above the horizon and a positive channel or
    only zeros. Negative channels beside positive ones are colours out of gamut: 0, and counted in `clamped`. There is
    no grid and no interpolation.

    **Raises:** `FileError` that names the line, on a missing or contradictory header, fields that are no numbers, fewer
    rows than NUM_POINTS, or no usable row; `UserError` on an option that does not fit.
    """
    header, start, lines = _header(path)
    names = _names(path, start, header["VARS"])
    rows, _ = number_rows(path, lines, names, ",")
    _count(path, header, len(rows))
    column = {name: rows[:, place] for place, name in enumerate(names)}
    unit = _unit(header, column) if angles == "auto" else angles
    radians = {
        name: np.radians(column[name]) if unit == "degrees" else column[name] for name in ANGLES if name in column
    }
    phi_i = radians.get("phi_i", np.zeros(len(rows)))
    phi_s = radians["phi_s"] + (np.pi if mirror == "0" else 0.0)
    with np.errstate(invalid="ignore"):  # rows that are not finite are left out by `measurement`
        wi, wo = spherical(radians["theta_i"], phi_i), spherical(radians["theta_s"], phi_s)
        value, done = _channels(path, start, column, wavelength, illuminant)
    return measurement(
        path,
        wi,
        wo,
        value,
        format=NAME,
        facts=f"angles in {unit}, mirror direction at {mirror} degrees, {done}",
        clamp=True,
        remedy="Check the columns that VARS names and the option `angles`.",
    )


def _header(path: str | os.PathLike[str]) -> tuple[dict[str, str], int, list[tuple[int, str]]]:
    """Keys with their values, the line number of VARS, and the lines behind it."""
    header: dict[str, str] = {}
    lines = [
        (number, line.strip())
        for number, line in enumerate(read_text(path).splitlines(), 1)
        if line.strip() and not line.strip().startswith("#")
    ]
    for place, (number, line) in enumerate(lines):
        key, _, value = line.partition(" ") if "\t" not in line else line.partition("\t")
        header[key.upper()] = value.strip()
        if key.upper() == "VARS":
            if place + 1 == len(lines):
                raise FileError(path, f"ends with VARS in line {number}.", "It is truncated: export it again.")
            return header, number, lines[place + 1 :]
    raise FileError(
        path,
        f"has no line VARS that names the columns ({len(lines)} lines).",
        "Write one before the numbers: VARS theta_i,phi_i,theta_s,phi_s,R,G,B.",
    )


def _names(path: str | os.PathLike[str], line: int, text: str) -> list[str]:
    names = [name.strip().strip('"') for name in text.split(",")]
    names = [name.lower() if name.lower() in (*ANGLES, *COLOURS[0], *COLOURS[1]) else name for name in names]
    for name in names:
        if names.count(name) > 1:
            raise FileError(path, f"line {line} names `{name[:40]}` twice.", "Keep one of them.")
    missing = [name for name in ANGLES if name not in names and name != "phi_i"]
    if missing:
        raise FileError(
            path,
            f"line {line}: VARS lacks {', '.join(f'`{name}`' for name in missing)}.",
            "It names theta_i, phi_i (or none: 0), theta_s, phi_s, then values; in one plane phi_s is 0 or 180.",
        )
    if len(names) == len(set(names) & set(ANGLES)):
        raise FileError(path, f"line {line}: VARS names no value.", "Name R,G,B, X,Y,Z, wavelengths or one value.")
    return names


def _count(path: str | os.PathLike[str], header: dict[str, str], rows: int) -> None:
    if "NUM_POINTS" not in header:
        return
    text = header["NUM_POINTS"]
    if not text.isdecimal():
        raise FileError(path, f"gives `NUM_POINTS {text[:40]}`, which is no count.", "Write the number of rows.")
    if rows < (expected := int(text[:18])):
        raise FileError(
            path,
            f"has {rows} rows, but NUM_POINTS says {expected}.",
            "It is truncated: download it again, or correct NUM_POINTS if no more were measured.",
        )


def _unit(header: dict[str, str], column: dict[str, np.ndarray]) -> str:
    """`degrees` or `radians`, by the header or by the angles themselves."""
    told = header.get("ANGLE_UNITS", "").lower()
    for unit in ("degrees", "radians"):
        if told.startswith(unit[:3]):
            return unit
    for name in ANGLES:
        most = np.pi / 2 if name.startswith("theta") else 2 * np.pi
        with np.errstate(invalid="ignore"):
            if name in column and (np.abs(column[name]) > most + SLACK).any():
                return "degrees"
    return "radians"


def _channels(
    path: str | os.PathLike[str],
    line: int,
    column: dict[str, np.ndarray],
    wavelength: str | None,
    illuminant: str | None,
) -> tuple[np.ndarray, str]:
    """(n, 3) linear Rec. 709 and a phrase that says how it was made."""
    names = [name for name in column if name not in ANGLES]
    values = np.stack([column[name] for name in names], 1)
    found = [NANOMETRES.fullmatch(name) for name in names]
    if any(found):
        if not all(found):
            raise FileError(
                path, f"line {line}: VARS mixes wavelengths with {names[found.index(None)][:40]}.", "Split it."
            )
        nanometres = np.array([float(one[1]) for one in found if one])
        order = np.argsort(nanometres)
        if not (np.diff(nanometres[order]) > 0).all():
            raise FileError(path, f"line {line}: VARS names a wavelength twice.", "Keep one of them.")
        weights, done = _spectrum.channel_weights(nanometres[order], wavelength, illuminant)
        used = weights.any(1)  # a wavelength that is not used may have holes
        return values[:, order][:, used] @ weights[used], done
    if wavelength or illuminant:
        raise FileError(path, f"line {line}: VARS names no wavelengths.", "Leave out `wavelength` and `illuminant`.")
    if set(names) == set(COLOURS[0]):
        return np.stack([column[name] for name in COLOURS[0]], 1), "R, G, B taken as linear Rec. 709"
    if set(names) == set(COLOURS[1]):
        return _spectrum.xyz_to_rgb(np.stack([column[name] for name in COLOURS[1]], 1)), "from X, Y, Z under D65"
    if len(names) == 1:
        return np.repeat(values, 3, axis=1), f"all channels from `{names[0][:40]}`"
    raise FileError(
        path,
        f"line {line}: VARS names the values {', '.join(names)[:60]}.",
        "Supported are R,G,B or X,Y,Z or wavelengths such as 550nm or one value.",
    )

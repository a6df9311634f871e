"""`.csv`: scattered samples as text.

One header line names the columns; lines that start with `#` are comments. Directions are either
angles in degrees

    theta_i, phi_i, theta_o, phi_o      phi_i may be left out: 0

measured from the normal and about it, or unit vectors in the frame whose normal is +z

    wi_x, wi_y, wi_z, wo_x, wo_y, wo_z

`i` is the light, `o` the viewer. Values are 1/sr without the cosine, linear Rec. 709: `r, g, b`, or
one `value` that stands for all three. Optional are `weight`, and the standard error of the value
in 1/sr, by which a fit can weight it: `sigma` for every channel or `sigma_r, sigma_g, sigma_b`.
Columns stand in any order, separated by comma, semicolon or tab.

Samples are scattered: the format defines no value between them.
"""

from __future__ import annotations

import difflib
import os
import pathlib
from collections.abc import Callable

import numpy as np

from brdf.atomic import atomic_path
from brdf.errors import FileError
from fitter.formats._scattered import measurement, spherical
from fitter.formats._text import number_rows, read_text
from fitter.reflectance import UNIT_TOLERANCE, Reflectance

NAME = "CSV"
DESCRIPTION = "scattered samples: angles in degrees or unit vectors, one or three channels"
SUFFIXES = (".csv", ".tsv")
OPTIONS: dict[str, tuple[str, ...]] = {}

ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
VECTORS = ("wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z")
COLOUR = ("r", "g", "b")
SIGMAS = ("sigma_r", "sigma_g", "sigma_b")
KNOWN = (*ANGLES, *VECTORS, *COLOUR, "value", "weight", "sigma", *SIGMAS)
ROWS_AT_ONCE = 65536


def sniff(head: bytes) -> bool:
    """Whether the file starts with text."""
    return b"\0" not in head


def read(path: str | os.PathLike[str]) -> Reflectance:
    """Reads scattered samples; see the module for the columns.

    **Arguments:**

    - `path`: the file, UTF-8, with or without a byte order mark.

    **Returns:** one sample per row that is finite, not negative, and has both directions above the
    horizon. There is no grid and no interpolation.

    **Raises:** `FileError` that names the line, on text that is not UTF-8, columns that are unknown,
    missing, doubled or contradict each other, fields that are no numbers, vectors that are not
    unit, negative weights, standard errors that are not positive, or no usable row.
    """
    names, rows, lines = _parse(path)
    column = {name: rows[:, place] for place, name in enumerate(names)}
    finite = np.asarray(np.isfinite(rows).all(1))
    with np.errstate(invalid="ignore"):  # rows that are not finite are left out below
        wi, wo = _directions(path, column, lines, finite)
        grey = "value" in column
        value = np.stack([column[name] for name in (("value",) * 3 if grey else COLOUR)], 1)
        _refuse_below(path, column, "weight", lines, finite, np.less, "is negative", "Give 0 to what is not to count.")
        remedy = "Give the standard error of the value in 1/sr, or leave out the column or the row."
        for name in ("sigma", *SIGMAS):
            _refuse_below(path, column, name, lines, finite, np.less_equal, "is not positive", remedy)
    sigma = column.get("sigma")
    if sigma is None and SIGMAS[0] in column:
        sigma = np.stack([column[name] for name in SIGMAS], 1)
    return measurement(
        path,
        wi,
        wo,
        value,
        format=NAME,
        facts="one channel for all three" if grey else "",
        clamp=False,
        weight=column.get("weight"),
        sigma=sigma,
        remedy="Angles are in degrees from the normal, values in 1/sr.",
    )


def write(reflectance: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes the samples as unit vectors and colours, with every digit.

    **Arguments:**

    - `reflectance`: what to write; `weight` becomes a column only if it is not 1 everywhere, and
      `sigma` one or three if it is there.
    - `path`: where to.
    - `force`: whether an existing file may be replaced.

    **Raises:** `FileError` if the file cannot be written.
    """
    weight = reflectance.weight
    weighted = bool((weight != 1).any())
    names = [*VECTORS, *COLOUR]
    columns = [reflectance.wi, reflectance.wo, reflectance.value]
    if weighted:
        names.append("weight")
        columns.append(weight[:, None])
    if reflectance.sigma is not None:
        names += ["sigma"] if reflectance.sigma.ndim == 1 else SIGMAS
        columns.append(reflectance.sigma.reshape(len(reflectance), -1))
    separator = "\t" if pathlib.Path(path).suffix.lower() == ".tsv" else ","
    with (
        atomic_path(path, force) as temporary,
        open(temporary, "w", encoding="utf-8", newline="\n") as file,
    ):
        source = " ".join(reflectance.source.split())
        file.write(f"# {source}\n# BRDF in 1/sr without the cosine, linear Rec. 709\n")
        file.write(separator.join(names) + "\n")
        for start in range(0, len(reflectance), ROWS_AT_ONCE):
            rows = np.hstack([part[start : start + ROWS_AT_ONCE] for part in columns])
            file.writelines(separator.join(map(repr, row)) + "\n" for row in rows.tolist())


def _parse(path: str | os.PathLike[str]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Column names, (rows, columns) numbers, and the line of each row."""
    lines = [
        (number, line.strip())
        for number, line in enumerate(read_text(path).splitlines(), 1)
        if line.strip() and not line.strip().startswith("#")
    ]
    if not lines:
        raise FileError(path, "has no header line.", f"The first line names columns: {_forms()}.")
    number, header = lines[0]
    separator = max(",;\t", key=header.count)
    names = _header(path, number, header.split(separator))
    if len(lines) == 1:
        raise FileError(path, "has a header and no rows.", "Export the measurement again.")
    return names, *number_rows(path, lines[1:], names, separator)


def _header(path: str | os.PathLike[str], line: int, fields: list[str]) -> list[str]:
    names = [field.strip().strip('"').strip().lower() for field in fields]
    for name in names:
        if name not in KNOWN:
            near = difflib.get_close_matches(name, KNOWN, n=2, cutoff=0.4)
            hint = f"Did you mean {' or '.join(f'`{n}`' for n in near)}? " if near else ""
            raise FileError(path, f"line {line}: `{name[:40]}` is no known column.", f"{hint}{_forms()}.")
        if names.count(name) > 1:
            raise FileError(path, f"line {line} names `{name}` twice.", "Keep one of them.")
    for either, other in ((ANGLES, VECTORS), (COLOUR, ("value",)), (SIGMAS, ("sigma",))):
        if set(either) & set(names) and set(other) & set(names):
            raise FileError(
                path,
                f"line {line} mixes {', '.join(either)} with {', '.join(other)}.",
                "Keep one of the two.",
            )
    directions = VECTORS if set(VECTORS) & set(names) else ("theta_i", "theta_o", "phi_o")
    values = ("value",) if "value" in names else COLOUR
    sigmas = SIGMAS if set(SIGMAS) & set(names) else ()
    missing = [name for name in (*directions, *values, *sigmas) if name not in names]
    if missing:
        raise FileError(path, f"line {line} lacks {', '.join(f'`{name}`' for name in missing)}.", f"{_forms()}.")
    return names


def _directions(
    path: str | os.PathLike[str],
    column: dict[str, np.ndarray],
    lines: np.ndarray,
    finite: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """wi and wo of every row, (n, 3); vectors are checked and normalised."""
    found = []
    for end in "io":
        if f"theta_{end}" in column:
            degrees = column[f"theta_{end}"]
            bad = finite & (np.abs(degrees) > 180)
            if bad.any():
                first = int(np.argmax(bad))
                raise FileError(
                    path,
                    f"line {lines[first]}: `theta_{end} = {degrees[first]:g}` is no polar angle.",
                    "Give degrees from the normal, in [0, 90).",
                )
            theta = np.radians(degrees)
            phi = np.radians(column.get(f"phi_{end}", np.zeros(len(theta))))
            found.append(spherical(theta, phi))
            continue
        vector = np.stack([column[f"w{end}_{axis}"] for axis in "xyz"], 1)
        length = np.linalg.norm(vector, axis=1)
        bad = finite & ~(np.abs(length - 1) <= UNIT_TOLERANCE)
        if bad.any():
            first = int(np.argmax(bad))
            raise FileError(
                path,
                f"line {lines[first]}: `w{end}` has the length {length[first]:g}.",
                "Directions are unit vectors.",
            )
        found.append(vector)
    return found[0], found[1]


def _refuse_below(
    path: str | os.PathLike[str],
    column: dict[str, np.ndarray],
    name: str,
    lines: np.ndarray,
    finite: np.ndarray,
    is_bad: Callable[[np.ndarray, int], np.ndarray],
    rule: str,
    remedy: str,
) -> None:
    """Raises if a finite number of the column `name`, where there is one, stands in the relation `is_bad` to 0."""
    if name in column and (bad := finite & is_bad(column[name], 0)).any():
        first = int(np.argmax(bad))
        raise FileError(path, f"line {lines[first]}: `{name} = {column[name][first]:g}` {rule}.", remedy)


def _forms() -> str:
    return (
        f"Columns are {', '.join(ANGLES)} in degrees or {', '.join(VECTORS)}, then "
        f"{', '.join(COLOUR)} or value, and optionally weight and sigma (or "
        f"{', '.join(SIGMAS)})"
    )

"""`.csv`: scattered samples as text.

One header line names the columns; lines that start with `#` are comments. Directions are either
angles in degrees

    theta_i, phi_i, theta_o, phi_o      phi_i may be left out: 0

measured from the normal and about it, or unit vectors in the frame whose normal is +z

    wi_x, wi_y, wi_z, wo_x, wo_y, wo_z

`i` is the light, `o` the viewer. Values are 1/sr without the cosine, linear Rec. 709: `r, g, b`, or
one `value` that stands for all three. `weight` is optional. Columns stand in any order, separated
by comma, semicolon or tab.

Samples are scattered: the format defines no value between them.
"""

from __future__ import annotations

import difflib
import os
import pathlib

import numpy as np

from brdf.atomic import atomic_path
from brdf.errors import FileError
from fitter.reflectance import HORIZON_COSINE, UNIT_TOLERANCE, Reflectance

NAME = "CSV"
DESCRIPTION = "scattered samples: angles in degrees or unit vectors, one or three channels"
SUFFIXES = (".csv", ".tsv")
OPTIONS: dict[str, tuple[str, ...]] = {}

ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
VECTORS = ("wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z")
COLOUR = ("r", "g", "b")
KNOWN = (*ANGLES, *VECTORS, *COLOUR, "value", "weight")
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
    unit, negative weights, or no usable row.
    """
    names, rows, lines = _parse(path)
    column = {name: rows[:, place] for place, name in enumerate(names)}
    finite = np.asarray(np.isfinite(rows).all(1))
    with np.errstate(invalid="ignore"):  # rows that are not finite are left out below
        wi, wo = _directions(path, column, lines, finite)
        grey = "value" in column
        value = np.stack([column[name] for name in (("value",) * 3 if grey else COLOUR)], 1)
        weight = column.get("weight", np.ones(len(rows)))
        if (bad := finite & (weight < 0)).any():
            raise FileError(
                path,
                f"line {lines[np.argmax(bad)]}: `weight = {weight[np.argmax(bad)]:g}` is negative.",
                "Give 0 to a sample that is not to count.",
            )
        above = finite & (wi[:, 2] > HORIZON_COSINE) & (wo[:, 2] > HORIZON_COSINE)
        keep = above & (value >= 0).all(1)
    dropped = {
        "not finite": int(np.count_nonzero(~finite)),
        "below horizon": int(np.count_nonzero(finite & ~above)),
        "negative": int(np.count_nonzero(above & ~keep)),
    }
    dropped = {reason: count for reason, count in dropped.items() if count}
    if not keep.any():
        raise FileError(
            path,
            f"has no usable row: of {len(rows)} "
            + ", ".join(f"{count} {reason}" for reason, count in dropped.items())
            + ".",
            "Angles are in degrees from the normal, values in 1/sr.",
        )
    if not weight[keep].any():
        raise FileError(path, "has weight 0 in every row.", "Give one row a positive weight.")
    return Reflectance(
        wi=wi[keep],
        wo=wo[keep],
        value=value[keep],
        weight=weight[keep],
        source=f"{os.path.basename(path)} ({NAME}{', one channel for all three' if grey else ''})",
        format=NAME,
        dropped=dropped,
    )


def write(reflectance: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes the samples as unit vectors and colours, with every digit.

    **Arguments:**

    - `reflectance`: what to write; `weight` becomes a column only if it is not 1 everywhere.
    - `path`: where to.
    - `force`: whether an existing file may be replaced.

    **Raises:** `FileError` if the file cannot be written.
    """
    weight = reflectance.weight
    weighted = bool((weight != 1).any())
    names = (*VECTORS, *COLOUR, *(("weight",) if weighted else ()))
    columns = [reflectance.wi, reflectance.wo, reflectance.value]
    if weighted:
        columns.append(weight[:, None])
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


def _parse(path: str | os.PathLike[str]) -> tuple[list[str], np.ndarray, list[int]]:
    """Column names, (rows, columns) numbers, and the line of each row."""
    data = pathlib.Path(path).read_bytes()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(path, f"byte {error.start} is not UTF-8 text.", "Save it as CSV in UTF-8.") from error
    if (zero := text.find("\0")) >= 0:
        raise FileError(path, f"character {zero} is a zero: this is no text.", "Save it as CSV.")
    names: list[str] = []
    rows: list[list[float]] = []
    lines: list[int] = []
    separator = ","
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        if not names:
            separator = max(",;\t", key=line.count)
            names = _header(path, number, line.split(separator))
            continue
        fields = line.split(separator)
        if len(fields) != len(names):
            raise FileError(
                path,
                f"line {number} has {len(fields)} fields for {len(names)} columns.",
                "Give every column a number, and decimals a point.",
            )
        try:
            rows.append(list(map(float, fields)))
        except ValueError:
            place, field = next((i, f) for i, f in enumerate(fields) if not _is_number(f))
            raise FileError(
                path,
                f"line {number}, column `{names[place]}`: `{field.strip()[:40]}` is no number.",
                "Write decimals with a point, and nan where nothing was measured.",
            ) from None
        lines.append(number)
    if not names:
        raise FileError(path, "has no header line.", f"The first line names columns: {_forms()}.")
    if not rows:
        raise FileError(path, "has a header and no rows.", "Export the measurement again.")
    return names, np.array(rows), lines


def _header(path: str | os.PathLike[str], line: int, fields: list[str]) -> list[str]:
    names = [field.strip().strip('"').strip().lower() for field in fields]
    for name in names:
        if name not in KNOWN:
            near = difflib.get_close_matches(name, KNOWN, n=2, cutoff=0.4)
            hint = f"Did you mean {' or '.join(f'`{n}`' for n in near)}? " if near else ""
            raise FileError(path, f"line {line}: `{name[:40]}` is no known column.", f"{hint}{_forms()}.")
        if names.count(name) > 1:
            raise FileError(path, f"line {line} names `{name}` twice.", "Keep one of them.")
    for either, other in ((ANGLES, VECTORS), (COLOUR, ("value",))):
        if set(either) & set(names) and set(other) & set(names):
            raise FileError(
                path,
                f"line {line} mixes {', '.join(either)} with {', '.join(other)}.",
                "Keep one of the two.",
            )
    directions = VECTORS if set(VECTORS) & set(names) else ("theta_i", "theta_o", "phi_o")
    values = ("value",) if "value" in names else COLOUR
    missing = [name for name in (*directions, *values) if name not in names]
    if missing:
        raise FileError(path, f"line {line} lacks {', '.join(f'`{name}`' for name in missing)}.", f"{_forms()}.")
    return names


def _directions(
    path: str | os.PathLike[str],
    column: dict[str, np.ndarray],
    lines: list[int],
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
            sine = np.sin(theta)
            found.append(np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)], 1))
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


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _forms() -> str:
    return (
        f"Columns are {', '.join(ANGLES)} in degrees or {', '.join(VECTORS)}, then "
        f"{', '.join(COLOUR)} or value, and optionally weight"
    )

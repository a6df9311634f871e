"""ALTA `.alta`: scattered samples in one of many parametrizations, as text or binary.

Lines that start with `#` are the header, `#KEY value`, or comments; numbers follow, separated by blanks.

    #DIM x y         numbers of angles and of values per row
    #PARAM_IN name   what the angles are, radians; see `PARAMETRIZATIONS`
    #PARAM_OUT name  INV_STERADIAN      1/sr
                     RGB_COLOR          1/sr, taken as linear Rec. 709
                     XYZ_COLOR          1/sr, CIE XYZ relative to D65
                     INV_STERADIAN_COSINE_FACTOR  1/sr times a cosine
    #VS n            n more numbers, a confidence interval, which is not used: it is no standard error
    #FORMAT binary   then #SAMPLE_COUNT, #ENDIAN and, behind #BEGIN_STREAM, float64

`V` is the viewer, `L` the light. In half and difference angles ALTA gives those of V to the half vector; that is the
same BRDF by reciprocity, but not the same cosine. Whose cosine INV_STERADIAN_COSINE_FACTOR holds is disputed between
ALTA's manual (the output direction's) and its code (the light's): the option `cosine` says it, and `light` is the
default.

Parametrizations with fewer than three angles leave open where the directions lie; they are put where ALTA puts them.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np

from brdf.errors import FileError
from fitter.formats._alta_parametrizations import PARAMETRIZATIONS
from fitter.formats._scattered import measurement
from fitter.formats._spectrum import xyz_to_rgb
from fitter.formats._text import decode, number_rows, read_bytes
from fitter.reflectance import HORIZON_COSINE, UNIT_TOLERANCE, Reflectance

NAME = "ALTA"
DESCRIPTION = "scattered samples as text or binary; #DIM, #PARAM_IN and #PARAM_OUT say what the columns are"
SUFFIXES = (".alta", ".dat", ".txt")
OPTIONS = {"cosine": ("light", "view")}

# Name -> how many values it has; None where a grey value and a colour are both in use.
OUTPUTS = {"INV_STERADIAN": None, "INV_STERADIAN_COSINE_FACTOR": None, "RGB_COLOR": 3, "XYZ_COLOR": 3}
STREAM = b"#BEGIN_STREAM"
BYTE_ORDER = {"little": "<f8", "big": ">f8"}
MOST_INTERVALS = 2


def sniff(head: bytes) -> bool:
    """Whether the head has one of the keys that every file has."""
    return b"#DIM" in head or b"#PARAM_IN" in head


def read(path: str | os.PathLike[str], cosine: str = "light") -> Reflectance:
    """Reads scattered samples; see the module.

    **Arguments:**

    - `path`: the file.
    - `cosine`: whose cosine INV_STERADIAN_COSINE_FACTOR holds, that of the `light` or the `view` direction.

    **Returns:** one sample per row that is finite, has both directions above the horizon and a positive channel or only
    zeros. Negative channels beside positive ones are colours out of gamut: 0, and counted in `clamped`. There is no
    grid and no interpolation.

    **Raises:** `FileError` that names line or byte, on a missing or unsupported header, fields that are no numbers, a
    truncated stream, angles in degrees, vectors that are not unit, or no usable row.
    """
    data = read_bytes(path)
    header, angles, values, ignored = (_binary if STREAM in data else _text)(path, data)
    name, output = header["PARAM_IN"], header["PARAM_OUT"]
    with np.errstate(invalid="ignore"):  # rows that are not finite are left out by `measurement`
        wi, wo = PARAMETRIZATIONS[name][1](*angles.T)
        if values.shape[1] == 1:
            values = np.repeat(values, 3, axis=1)
        if output == "XYZ_COLOR":
            values = xyz_to_rgb(values)
        facts = f"{name}, {output}"
        if output == "INV_STERADIAN_COSINE_FACTOR":
            taken = (wi if cosine == "light" else wo)[:, 2:]
            # Below the horizon the row is left out, whatever its value.
            values = values / np.where(taken > HORIZON_COSINE, taken, 1.0)
            facts += f", the {cosine} direction's cosine taken out"
    return measurement(
        path,
        wi,
        wo,
        values,
        format=NAME,
        facts=facts + (f", {ignored} more columns not used" if ignored else ""),
        clamp=True,
        remedy=f"Check `#PARAM_IN {name}`: angles are in radians.",
    )


def _text(path: str | os.PathLike[str], data: bytes) -> tuple[dict[str, str], np.ndarray, np.ndarray, int]:
    lines = [(number, line.strip()) for number, line in enumerate(decode(path, data).splitlines(), 1) if line.strip()]
    header, (angles, values) = _header(path, [line for line in lines if line[1].startswith("#")])
    rows = [line for line in lines if not line[1].startswith("#")]
    if not rows:
        raise FileError(path, f"has a header and no rows ({len(lines)} lines).", "Export it again.")
    number, first = rows[0]
    count = len(first.split())
    if count < angles + values:
        raise FileError(
            path,
            f"line {number} has {count} numbers, but `#DIM {angles} {values}` asks for {angles + values}.",
            "Correct #DIM or the rows.",
        )
    names = [f"{place + 1}" for place in range(count)]
    table, numbers = number_rows(path, rows, names, None)
    _refuse_wrong_angles(path, header["PARAM_IN"], table[:, :angles], lambda row: f"line {numbers[row]}")
    return header, table[:, :angles], table[:, angles : angles + values], count - angles - values


def _binary(path: str | os.PathLike[str], data: bytes) -> tuple[dict[str, str], np.ndarray, np.ndarray, int]:
    end = data.index(STREAM)
    start = data.find(b"\n", end) + 1 or len(data)
    text = data[:end].decode("utf-8", "replace")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1) if line.startswith("#")]
    header, (angles, values) = _header(path, lines)
    counts = {}
    for key, default in (("SAMPLE_COUNT", ""), ("VS", "0")):
        found = header.get(key, default)
        if not found.isdecimal() or len(found) > 18:
            raise FileError(path, f"gives `#{key} {found[:40]}`, which is no count.", "Export it again.")
        counts[key] = int(found)
    if counts["VS"] > MOST_INTERVALS:
        raise FileError(path, f"gives `#VS {counts['VS']}`; 0 to {MOST_INTERVALS} are known.", "Export it again.")
    order = header.get("ENDIAN", "little")
    if order not in BYTE_ORDER or header.get("PRECISION", "ieee754-double") != "ieee754-double":
        raise FileError(
            path,
            f"stores `{header.get('PRECISION', '')[:40]}`, `{order[:40]}` endian.",
            "Only ieee754-double, little or big endian, is known: export it as text.",
        )
    ignored = counts["VS"] * values
    columns = angles + values + ignored
    expected = 8 * counts["SAMPLE_COUNT"] * columns
    if not counts["SAMPLE_COUNT"] or start + expected > len(data):
        raise FileError(
            path,
            f"ends at byte {len(data)}, but {counts['SAMPLE_COUNT']} samples of {columns} numbers start at byte "
            f"{start} and take {expected} bytes.",
            "It is damaged or truncated: download it again.",
        )
    stream = np.frombuffer(data, BYTE_ORDER[order], expected // 8, start)
    table = stream.reshape(-1, columns).astype(np.float64)
    _refuse_wrong_angles(path, header["PARAM_IN"], table[:, :angles], lambda row: f"byte {start + 8 * columns * row}")
    return header, table[:, :angles], table[:, angles : angles + values], ignored


def _header(path: str | os.PathLike[str], lines: list[tuple[int, str]]) -> tuple[dict[str, str], tuple[int, int]]:
    """Keys with their values, and the two numbers of DIM, after they were checked against each other."""
    header: dict[str, str] = {}
    places: dict[str, int] = {}
    for number, line in lines:
        key, *value = line[1:].split(None, 1) or [""]
        header.setdefault(key, value[0].strip() if value else "")
        places.setdefault(key, number)
    for key, known in (("DIM", ()), ("PARAM_IN", PARAMETRIZATIONS), ("PARAM_OUT", OUTPUTS)):
        if key not in header:
            raise FileError(path, f"has no line `#{key}`.", "ALTA files start with #DIM, #PARAM_IN and #PARAM_OUT.")
        if known and header[key] not in known:
            raise FileError(
                path,
                f"line {places[key]}: `#{key} {header[key][:40]}` is not supported.",
                f"Supported are {', '.join(known)}: convert it with ALTA's data2data.",
            )
    sizes = header["DIM"].split()
    angles, values = PARAMETRIZATIONS[header["PARAM_IN"]][0], OUTPUTS[header["PARAM_OUT"]]
    allowed = [str(values)] if values else ["1", "3"]
    if len(sizes) != 2 or sizes[0] != str(angles) or sizes[1] not in allowed:
        raise FileError(
            path,
            f"line {places['DIM']}: `#DIM {header['DIM'][:40]}` does not fit {header['PARAM_IN']} and "
            f"{header['PARAM_OUT']}.",
            f"It must be `#DIM {angles} {' or '.join(allowed)}`.",
        )
    return header, (angles, int(sizes[1]))


def _refuse_wrong_angles(
    path: str | os.PathLike[str], name: str, angles: np.ndarray, where: Callable[[int], str]
) -> None:
    """Raises if a polar angle is larger than half a turn, which only degrees are, or a vector is not unit."""
    polar = [place for place, part in enumerate(PARAMETRIZATIONS[name][2]) if part == "theta"]
    with np.errstate(invalid="ignore"):
        bad = np.abs(angles[:, polar]) > np.pi
        if name == "CARTESIAN":
            lengths = np.linalg.norm(angles.reshape(-1, 2, 3), axis=2)
            wrong = np.abs(lengths - 1) > UNIT_TOLERANCE
        else:
            lengths, wrong = angles, np.zeros((len(angles), 1), bool)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise FileError(
            path,
            f"{where(row)}: `{angles[row, polar[column]]:g}` is no polar angle in radians.",
            "ALTA's angles are radians: convert degrees.",
        )
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise FileError(
            path,
            f"{where(row)}: the {('view', 'light')[column]} vector has the length {lengths[row, column]:g}.",
            "Directions are unit vectors, the viewer's first.",
        )

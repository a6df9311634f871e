"""Rows of numbers in text files, with errors that name the line."""

from __future__ import annotations

import array
import os
import pathlib
from collections.abc import Iterable, Sequence

import numpy as np

from brdf.errors import FileError

SHOWN_CHARACTERS = 40
# Text takes a few times its length in memory; no goniometer fills this.
MOST_BYTES = 1 << 30


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """The whole file.

    **Raises:** `FileError` if it is larger than any measurement in text.
    """
    length = pathlib.Path(path).stat().st_size
    if length > MOST_BYTES:
        raise FileError(
            path,
            f"is {length} bytes long; text is read up to {MOST_BYTES}.",
            "Split it, or convert it to a MERL table.",
        )
    return pathlib.Path(path).read_bytes()


def read_text(path: str | os.PathLike[str]) -> str:
    """The text of a UTF-8 file, with or without a byte order mark; raises as `read_bytes` and `decode` do."""
    return decode(path, read_bytes(path))


def decode(path: str | os.PathLike[str], data: bytes) -> str:
    """UTF-8 text, with or without a byte order mark.

    **Raises:** `FileError` that names the byte, if it is not UTF-8 or holds a zero.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(path, f"byte {error.start} is not UTF-8 text.", "Save it as text in UTF-8.") from error
    if (zero := text.find("\0")) >= 0:
        raise FileError(path, f"character {zero} is a zero: this is no text.", "Save it as text.")
    return text


def number_rows(
    path: str | os.PathLike[str], lines: Iterable[tuple[int, str]], names: Sequence[str], separator: str | None
) -> tuple[np.ndarray, np.ndarray]:
    """Parses lines of as many numbers as there are columns.

    **Arguments:**

    - `path`: what errors name.
    - `lines`: (line number, text), neither empty nor comments.
    - `names`: of the columns.
    - `separator`: between fields; None for any blanks.

    **Returns:** (rows, columns) numbers, possibly not finite, and (rows,) line numbers.

    **Raises:** `FileError` that names line and column, if a line has another number of fields or one is no number.
    """
    values, numbers = array.array("d"), array.array("q")
    for number, line in lines:
        fields = line.split(separator)
        if len(fields) != len(names):
            raise FileError(
                path,
                f"line {number} has {len(fields)} fields for {len(names)} columns.",
                "Give every column a number, and decimals a point.",
            )
        try:
            values.extend(map(float, fields))
        except ValueError:
            place, field = next((i, f) for i, f in enumerate(fields) if not _is_number(f))
            raise FileError(
                path,
                f"line {number}, column `{names[place]}`: `{field.strip()[:SHOWN_CHARACTERS]}` is no number.",
                "Write decimals with a point, and nan where nothing was measured.",
            ) from None
        numbers.append(number)
    return np.array(values).reshape(-1, len(names)), np.array(numbers)


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True

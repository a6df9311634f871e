"""The `tensor_file` container: named arrays, little-endian, as in the EPFL RGL material database.

    12 bytes  "tensor_file" and a zero
     2 bytes  version, major and minor
     4 bytes  uint32: number of fields
    then for each field
     2 bytes  uint16: length of the name, and the name
     2 bytes  uint16: rank
     1 byte   type of the elements
     8 bytes  uint64: where the data start, from the beginning of the file
     8 bytes  uint64: size, for each axis

Dupuy and Jakob 2018: J. Dupuy, W. Jakob, "An Adaptive Parameterization for Efficient Material
Acquisition and Rendering", ACM TOG 37(6), 2018.
"""

from __future__ import annotations

import math
import os
import struct

import numpy as np

from brdf.errors import FileError

MAGIC = b"tensor_file\0"
MAJOR_VERSION = 1
TYPES = {
    1: "<u1",
    2: "<i1",
    3: "<u2",
    4: "<i2",
    5: "<u4",
    6: "<i4",
    7: "<u8",
    8: "<i8",
    9: "<f2",
    10: "<f4",
    11: "<f8",
}
# More than any known file has, few enough that a damaged count is noticed at once.
MOST_FIELDS = 1000
MOST_AXES = 16

DAMAGED = "The file is damaged or truncated: download it again."


def read_tensor_file(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Reads every field. Sizes are held to the length of the file before anything is allocated.

    **Arguments:**

    - `path`: the file.

    **Returns:** name -> array, of the shape and type that the file declares, read-only.

    **Raises:** `FileError` that names the field and the byte, if the magic, the version or a type
    is unknown or the file ends too early.
    """
    with open(path, "rb") as file:
        data = file.read()
    if not data.startswith(MAGIC):
        if MAGIC.startswith(data):
            raise FileError(path, f"ends at byte {len(data)}, inside the magic word.", DAMAGED)
        raise FileError(
            path,
            f"starts with {data[:12]!r}, not with {MAGIC!r}.",
            "It is no tensor file: check where it comes from.",
        )
    (major, minor), place = _unpack(path, data, len(MAGIC), "<BB", "the version")
    if major != MAJOR_VERSION:
        raise FileError(
            path,
            f"is a tensor file of version {major}.{minor} (byte {len(MAGIC)}).",
            f"Only version {MAJOR_VERSION} is known: export it as that.",
        )
    (count,), place = _unpack(path, data, place, "<I", "the number of fields")
    if count > MOST_FIELDS:
        raise FileError(path, f"claims to hold {count} fields (byte {place - 4}).", DAMAGED)
    fields = {}
    for number in range(count):
        where = f"the header of field {number + 1} of {count}"
        (length,), place = _unpack(path, data, place, "<H", where)
        (name,), place = _unpack(path, data, place, f"<{length}s", where)
        # A damaged name must not reach a terminal as it is.
        name = name.decode("utf-8", "replace")
        name = name if name.isprintable() else repr(name)[:40]
        where = f"the header of field `{name}`"
        (rank, code, offset), place = _unpack(path, data, place, "<HBQ", where)
        if code not in TYPES or rank > MOST_AXES:
            raise FileError(
                path,
                f"gives field `{name}` the type {code} and {rank} axes (byte {place - 11}).",
                DAMAGED,
            )
        shape, place = _unpack(path, data, place, f"<{rank}Q", where)
        dtype = np.dtype(TYPES[code])
        size = math.prod(shape)
        if offset + size * dtype.itemsize > len(data):
            raise FileError(
                path,
                f"ends at byte {len(data)}, inside field `{name}`, whose {size} elements start at "
                f"byte {offset} and take {size * dtype.itemsize} bytes.",
                DAMAGED,
            )
        fields[name] = np.frombuffer(data, dtype, size, offset).reshape(shape)
    return fields


def _unpack(path: str | os.PathLike[str], data: bytes, place: int, layout: str, what: str) -> tuple[tuple, int]:
    """Reads numbers at a byte, and the byte behind them."""
    end = place + struct.calcsize(layout)
    if end > len(data):
        raise FileError(path, f"ends at byte {len(data)}, inside {what}.", DAMAGED)
    return struct.unpack_from(layout, data, place), end

"""Reads Radiance pictures (.hdr, .pic): RGBE with new and old run lengths or none, in any of the eight orientations.

- Ward 1991, "Real Pixels", Graphics Gems II.
- The Radiance reference manual, "File Formats": header, resolution string, scan lines.

A component is `mantissa 2^(exponent - 136)`, as most readers have it; Radiance itself adds half a step.
"""

from __future__ import annotations

import dataclasses
import os
import pathlib
import re

import numpy as np
from numpy.typing import NDArray

from brdf.errors import FileError

_RESOLUTION = re.compile(rb"([+-])([XY]) (\d{1,9}) ([+-])([XY]) (\d{1,9})\s*$")
# Headers are a few lines; a longer one is another kind of file.
_HEADER_MAX = 1 << 16
# No camera or renderer is outside; float32 ends soon after.
_EXPOSURE_MIN = 1e-30
# New run lengths exist for these line lengths (Radiance color.c: MINELEN, MAXELEN).
_NEW_MIN, _NEW_MAX = 8, 32767
# By the exponent's byte; 0 is black.
_SCALES = np.where(np.arange(256) > 0, np.ldexp(np.float32(1), np.arange(256) - 136), np.float32(0))
_EXPORT_AGAIN = "Export it again, or use an .exr."


@dataclasses.dataclass(frozen=True)
class _Header:
    """What the header says: where the pixels begin, the resolution string, the product of EXPOSURE lines."""

    end: int
    lines: int
    length: int
    first_sign: str
    by_column: bool
    second_sign: str
    exposure: float


def read_hdr(path: str | os.PathLike[str], width_max: int) -> NDArray[np.float32]:
    """The pixels of a Radiance picture.

    **Arguments:**

    - `path`: the file.
    - `width_max`: the largest accepted width and height in pixels.

    **Returns:** shape (h, w, 3), float32, row 0 at the top, the header's exposure taken out.

    Raises `FileError` when the file is not such a picture, too large, or damaged, naming the byte.
    """
    data = pathlib.Path(path).read_bytes()
    header = _read_header(path, data)
    if max(header.lines, header.length) > width_max or min(header.lines, header.length) < 1:
        problem = f"Its resolution `{header.lines} x {header.length}` is outside 1 to {width_max} pixels a side."
        raise FileError(path, problem, "Resize it.")
    if len(data) - header.end < 4 * header.lines:  # every scan line takes four bytes or more
        raise _truncated(path, len(data))
    scan_lines = []
    position = header.end
    for _ in range(header.lines):
        line, position = _read_line(path, data, position, header.length)
        scan_lines.append(line)
    with np.errstate(over="ignore"):  # to infinity, which the caller clamps and counts
        return _decode(_orient(np.stack(scan_lines), header)) / np.float32(header.exposure)


def _read_header(path: str | os.PathLike[str], data: bytes) -> _Header:
    if not data.startswith((b"#?RADIANCE", b"#?RGBE")):
        problem = f"It begins with `{data[:10]!r}`, not with `#?RADIANCE` (byte 0)."
        raise FileError(path, problem, "Is it really a Radiance picture?")
    end = data.find(b"\n\n", 0, _HEADER_MAX)
    if end < 0:
        raise FileError(path, f"No empty line ends its header (first {_HEADER_MAX} bytes).", _EXPORT_AGAIN)
    exposure = 1.0
    for line in data[:end].split(b"\n"):
        name, _, value = line.partition(b"=")
        if name.strip() == b"FORMAT" and value.strip() != b"32-bit_rle_rgbe":
            problem = f"Its header says `FORMAT={value.decode(errors='replace').strip()}`; `32-bit_rle_rgbe` is read."
            raise FileError(path, problem, _EXPORT_AGAIN)
        if name.strip() == b"EXPOSURE":
            exposure *= _exposure(path, value)
    if not _EXPOSURE_MIN <= exposure <= 1 / _EXPOSURE_MIN:
        problem = f"The product of its EXPOSURE lines, `{exposure:g}`, is outside {_EXPOSURE_MIN:g} to its inverse."
        raise FileError(path, problem, "Correct or remove those lines.")
    line_end = data.find(b"\n", end + 2, end + 2 + 256)
    found = _RESOLUTION.match(data[end + 2 : max(line_end, end + 2)])
    if found is None or found.group(2) == found.group(5):
        shown = data[end + 2 : end + 34].split(b"\n")[0]
        problem = f"Its resolution line `{shown!r}` (byte {end + 2}) is not like `-Y 512 +X 1024`."
        raise FileError(path, problem, _EXPORT_AGAIN)
    sign, axis, lines, other_sign, _, length = (group.decode() for group in found.groups())
    return _Header(line_end + 1, int(lines), int(length), sign, axis == "X", other_sign, exposure)


def _exposure(path: str | os.PathLike[str], value: bytes) -> float:
    try:
        exposure = float(value)
    except ValueError:
        exposure = 0.0
    if not (np.isfinite(exposure) and exposure > 0):
        problem = f"Its header says `EXPOSURE={value.decode(errors='replace').strip()}`, not a positive number."
        raise FileError(path, problem, "Correct or remove that line.")
    return exposure


def _read_line(path: str | os.PathLike[str], data: bytes, start: int, length: int) -> tuple[NDArray[np.uint8], int]:
    """One scan line as (length, 4) RGBE, and where the next begins."""
    mark = data[start : start + 4]
    if len(mark) < 4:
        raise _truncated(path, len(data))
    if _NEW_MIN <= length <= _NEW_MAX and mark[:2] == b"\x02\x02" and mark[2] < 128:
        if (mark[2] << 8) + mark[3] != length:
            problem = f"A scan line of `{(mark[2] << 8) + mark[3]}` pixels (byte {start}) should have {length}."
            raise FileError(path, problem, _EXPORT_AGAIN)
        return _read_new_line(path, data, start + 4, length)
    return _read_old_line(path, data, start, length)


def _read_new_line(path: str | os.PathLike[str], data: bytes, start: int, length: int) -> tuple[NDArray[np.uint8], int]:
    """Four components one after the other; a count above 128 is a run, else that many bytes follow."""
    line = bytearray()
    try:
        for _ in range(4):
            left = length
            while left > 0:
                count = data[start]
                if count > 128:
                    count -= 128
                    line += data[start + 1 : start + 2] * count
                    start += 2
                elif count:
                    line += data[start + 1 : start + 1 + count]
                    start += 1 + count
                else:
                    raise _damaged(path, start)
                left -= count
            if left < 0:
                raise _damaged(path, start)
    except IndexError:
        raise _truncated(path, len(data)) from None
    if start > len(data):
        raise _truncated(path, len(data))
    return np.frombuffer(bytes(line), np.uint8).reshape(4, length).T, start


def _read_old_line(path: str | os.PathLike[str], data: bytes, start: int, length: int) -> tuple[NDArray[np.uint8], int]:
    """Whole pixels; (1, 1, 1, n) repeats the one before n times, and the next such one 256 n times, and so on."""
    line = bytearray()
    shift = 0
    while len(line) < 4 * length:
        pixel = data[start : start + 4]
        if len(pixel) < 4:
            raise _truncated(path, len(data))
        if pixel[:3] == b"\x01\x01\x01":
            count = pixel[3] << shift
            if not line or len(line) + 4 * count > 4 * length:
                raise _damaged(path, start)
            line += line[-4:] * count
            shift += 8
        else:
            line += pixel
            shift = 0
        start += 4
    return np.frombuffer(bytes(line), np.uint8).reshape(length, 4), start


def _truncated(path: str | os.PathLike[str], size: int) -> FileError:
    return FileError(path, f"It ends inside the pixels (byte {size}).", "Download or export it again.")


def _damaged(path: str | os.PathLike[str], position: int) -> FileError:
    return FileError(path, f"The run lengths of a scan line do not add up (byte {position}).", _EXPORT_AGAIN)


def _orient(rgbe: NDArray[np.uint8], header: _Header) -> NDArray[np.uint8]:
    """From the order of the file to rows from the top, columns from the left: X increases to the right, Y upwards."""
    first_is_natural = header.first_sign == ("+" if header.by_column else "-")
    second_is_natural = header.second_sign == ("-" if header.by_column else "+")
    rgbe = rgbe if first_is_natural else rgbe[::-1]
    rgbe = rgbe if second_is_natural else rgbe[:, ::-1]
    return rgbe.transpose(1, 0, 2) if header.by_column else rgbe


def _decode(rgbe: NDArray[np.uint8]) -> NDArray[np.float32]:
    scale = np.take(_SCALES, rgbe[..., 3])
    pixels = np.empty((*scale.shape, 3), np.float32)
    # Channel by channel: several times as quick as a product along an axis of three.
    for channel in range(3):
        np.multiply(rgbe[..., channel], scale, out=pixels[..., channel])
    return pixels

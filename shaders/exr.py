"""OpenEXR pictures in and out.

OpenEXR's own Python module writes an array that is not contiguous as garbage without a word, so every array passes
through `np.ascontiguousarray` here.
"""

from __future__ import annotations

import os
import pathlib
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import ArrayLike, NDArray

from brdf.errors import FileError, UserError
from brdf.silence import silence

_MAGIC = b"\x76\x2f\x31\x01"


def read_exr(path: str | os.PathLike[str], width_max: int) -> NDArray[np.float32]:
    """The colour of an OpenEXR picture: its channels R, G, B, or Y for grey; half, float or unsigned.

    **Arguments:**

    - `path`: the file; its first part is read.
    - `width_max`: the largest accepted width and height in pixels.

    **Returns:** shape (h, w, 3), float32, row 0 at the top, values as in the file.

    Raises `FileError` when the file is not such a picture, too large, damaged, or without those channels.
    """
    with pathlib.Path(path).open("rb") as file:
        magic = file.read(4)
    if magic != _MAGIC:
        raise FileError(
            path, f"It begins with `{magic!r}`, not with OpenEXR's `{_MAGIC!r}` (byte 0).", "Is it an .exr?"
        )
    low, high = _first_part(path, header_only=True).header["dataWindow"]
    width, height = int(high[0] - low[0] + 1), int(high[1] - low[1] + 1)
    if not (1 <= width <= width_max and 1 <= height <= width_max):
        problem = f"Its data window is `{width} x {height}` pixels, outside 1 to {width_max} a side."
        raise FileError(path, problem, "Resize or crop it.")
    channels = _first_part(path, header_only=False).channels
    names = ("R", "G", "B") if {"R", "G", "B"} <= set(channels) else ("Y", "Y", "Y")
    if not set(names) <= set(channels):
        problem = f"It has the channels `{', '.join(sorted(channels))}`; R, G, B or Y is needed."
        raise FileError(path, problem, "Rename the channels of the wanted layer.")
    planes = [np.asarray(channels[name].pixels, np.float32) for name in names]
    if any(plane.shape != (height, width) for plane in planes):
        problem = f"A channel has the shape `{planes[0].shape}` in a picture of `{(height, width)}`."
        raise FileError(path, problem, "Save it without chroma subsampling.")
    return np.ascontiguousarray(np.stack(planes, axis=-1))


def _first_part(path: str | os.PathLike[str], *, header_only: bool) -> Any:
    """The first part; OpenEXR raises for a damaged header, and leaves out a part whose pixels are damaged."""
    try:
        with silence():
            parts = OpenEXR.File(os.fspath(path), separate_channels=True, header_only=header_only).parts
        problem = "Its pixels are damaged or cut off."
    except Exception as error:  # OpenEXR raises bare RuntimeError and ValueError
        parts, problem = [], f"OpenEXR cannot read it: {' '.join(str(error).split())}."
    if not parts:
        raise FileError(path, problem, "Download or export it again.")
    return parts[0]


def write_exr(path: str | os.PathLike[str], pixels: ArrayLike) -> None:
    """Writes linear pixels as float32.

    **Arguments:**

    - `path`: the file, replaced if it exists.
    - `pixels`: shape (h, w, 3) or (h, w, 4) with coverage, row 0 at the top, colour premultiplied by the coverage.

    Raises `UserError` for another shape, `OSError` when the file cannot be written.
    """
    values = np.ascontiguousarray(pixels, np.float32)
    if values.ndim != 3 or values.shape[2] not in (3, 4) or values.size == 0:
        raise UserError(f"`{values.shape}` is not the shape of a picture. Pass (h, w, 3) or (h, w, 4).")
    name = "RGB" if values.shape[2] == 3 else "RGBA"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    try:
        OpenEXR.File(header, {name: values}).write(os.fspath(path))
    except RuntimeError as error:
        raise OSError(f"OpenEXR cannot write {os.fspath(path)}: {' '.join(str(error).split())}") from None

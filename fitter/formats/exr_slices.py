"""EXR slices: pictures over half and difference angle at phi_d = 90 degrees, as BRDF Explorer's image slices.

Columns are theta_h, 0 to 90 degrees from left to right, rows are theta_d. Channels R, G, B are linear Rec. 709 in 1/sr,
without the cosine; a picture with Y alone is grey. Files differ, and options say how:

- `theta_h`: `linear`, as BRDF Explorer draws by default and ALTA reads, or `quadratic`, as MERL's cells lie;
- `theta_d`: `down`, from 0 in the first row of the file to 90 degrees in the last, as ALTA reads, or `up`, as BRDF
  Explorer draws on the screen;
- `cells`: a value belongs to the `centre` of its pixel, or to its lower `edge` as in the npz slices.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from brdf.errors import FileError
from brdf.silence import silence
from fitter.formats._slice import slice_measurement
from fitter.reflectance import Reflectance

NAME = "EXR slice"
DESCRIPTION = "phi_d = 90 degree slice as a picture, columns theta_h, rows theta_d"
SUFFIXES = (".exr",)
OPTIONS = {"theta_h": ("linear", "quadratic"), "theta_d": ("down", "up"), "cells": ("centre", "edge")}

MAGIC = b"\x76\x2f\x31\x01"
# A picture of more pixels is no slice; the header is held to this before anything is allocated.
MOST_PIXELS = 1 << 22


def sniff(head: bytes) -> bool:
    """Whether the file starts with OpenEXR's magic number."""
    return head.startswith(MAGIC)


def read(
    path: str | os.PathLike[str], theta_h: str = "linear", theta_d: str = "down", cells: str = "centre"
) -> Reflectance:
    """Reads a slice; half, float or unsigned channels.

    **Arguments:**

    - `path`: the file; its first part is read.
    - `theta_h`, `theta_d`, `cells`: see the module.

    **Returns:** as `_slice.slice_measurement` says.

    **Raises:** `FileError` if the file is no such picture, damaged or too large, or no cell is valid.
    """
    values = _pixels(path)
    if theta_d == "up":
        values = values[::-1].copy()
    return slice_measurement(
        path,
        values,
        what="",
        source=f"{os.path.basename(path)} ({NAME}, phi_d = 90 degrees, theta_h {theta_h}, theta_d {theta_d}, values at "
        f"the cells' {cells})",
        format=NAME,
        theta_h=theta_h,
        cells=cells,
    )


def _pixels(path: str | os.PathLike[str]) -> np.ndarray:
    """(rows, columns, 3) float64, the first row of the file first."""
    with open(path, "rb") as file:
        magic = file.read(len(MAGIC))
    if magic != MAGIC:
        raise FileError(path, f"starts with {magic!r}, not with {MAGIC!r} (byte 0).", "It is no OpenEXR file.")
    low, high = _first_part(path, header_only=True).header["dataWindow"]
    width, height = int(high[0]) - int(low[0]) + 1, int(high[1]) - int(low[1]) + 1
    if width < 1 or height < 1 or width * height > MOST_PIXELS:
        raise FileError(
            path,
            f"has a data window of {width} x {height} pixels; a slice has at most {MOST_PIXELS}.",
            "It is damaged or no slice: resize or export it again.",
        )
    channels = _first_part(path, header_only=False).channels
    names = ("R", "G", "B") if {"R", "G", "B"} <= set(channels) else ("Y", "Y", "Y")
    if not set(names) <= set(channels):
        raise FileError(
            path,
            f"has the channels {', '.join(f'`{name}`' for name in sorted(channels)) or 'none'}.",
            "A slice has R, G, B, or Y alone: rename those of the wanted layer.",
        )
    planes = [np.asarray(channels[name].pixels, np.float64) for name in names]
    if any(plane.shape != (height, width) for plane in planes):
        raise FileError(
            path,
            f"has a channel of {planes[0].shape} in a data window of {(height, width)}.",
            "Save it without chroma subsampling.",
        )
    return np.stack(planes, axis=-1)


def _first_part(path: str | os.PathLike[str], *, header_only: bool) -> Any:
    """The first part; OpenEXR raises for a damaged header, and leaves out a part whose pixels are damaged."""
    import OpenEXR

    try:
        with silence():
            parts = OpenEXR.File(os.fspath(path), separate_channels=True, header_only=header_only).parts
        problem = "has pixels that are damaged or cut off."
    except Exception as error:  # OpenEXR raises bare RuntimeError and ValueError
        parts, problem = [], f"cannot be read by OpenEXR: {' '.join(str(error).split())}."
    if not parts:
        raise FileError(path, problem, "It is damaged or truncated: export it again.")
    return parts[0]

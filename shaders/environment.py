"""Light from all around: a picture by direction. This file fixes the orientation; everything else follows it.

**Orientation.** y is up. Row 0 of the picture is the zenith (+y), the last row the nadir. The direction (x, y, z) is
found at

    u = 0.5 + atan2(x, -z) / (2 pi)      v = acos(y) / pi

so a camera that looks along -z sees the picture's centre, upright and not mirrored, with +x (u = 0.75) on its right.
Texels have their centres at half integers; between them radiance is interpolated linearly, around in u and not beyond
the poles in v. A scene's `rotation` turns the environment about +y, counter-clockwise seen from above.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import os
import pathlib

import numpy as np
from numpy.typing import NDArray

from brdf.errors import FileError, UserError, nearest

# The largest picture that is read: 16384 x 8192 texels, 1.6 GB in float32. The common 8k is a quarter of it.
_WIDTH_MAX = 16384
# float16's largest value stands in for infinity.
_INFINITE = 65504.0
# Larger values are clamped. The sun in cd/m^2, 1.6e9, is below; and times the sharpest lobe's 3e7 and 2^20 samples it
# is far from the end of float32, where sums would become infinite.
_RADIANCE_MAX = 1e10


# Two are equal if they are the same object, so that what is made of one can be kept with it (lighting.py).
@dataclasses.dataclass(frozen=True, eq=False)
class Environment:
    """Radiance by direction.

    - `pixels`: shape (h, w, 3), float32, linear Rec. 709, finite and not negative; oriented as this file says. Not
      to be changed once it has been rendered: make another `Environment`.
    - `name`: the built-in name or the file.
    - `clamped`: how many values of the file were negative, NaN, infinite or above 1e10 and have been clamped.
    """

    pixels: NDArray[np.float32]
    name: str
    clamped: int = 0

    @functools.cached_property
    def digest(self) -> str:
        """A hash of the shape and the values of `pixels`: what is made of equal pixels may be kept under it."""
        content = hashlib.blake2b(repr(self.pixels.shape).encode(), digest_size=16)
        content.update(np.ascontiguousarray(self.pixels, np.float32).data)
        return content.hexdigest()


def load_environment(name: str | os.PathLike[str]) -> Environment:
    """The environment of a name: a built-in one or a `.hdr` or `.exr` file.

    **Arguments:**

    - `name`: a key of `built_in.BUILT_IN`, or the path of a latitude-longitude picture, twice as wide as high.

    **Returns:** the `Environment`, with negative and NaN values set to 0, infinite ones to 65504, those above 1e10 to
    1e10, and all of them counted. A built-in one is made once: asked for again, it is the same object.

    Raises `UserError` for a name that is neither, `brdf.errors.FileError` for a file that cannot be used.
    """
    text = os.fspath(name)
    try:
        pixels = _read(text)
    except OSError as error:
        raise FileError(text, f"It cannot be read: {error.strerror}.", "Check the path and its permissions.") from None
    if pixels is None:
        return _built_in(text)
    height, width = pixels.shape[:2]
    if abs(width - 2 * height) > 1:
        raise FileError(
            text,
            f"It has `{width} x {height}` texels; a latitude-longitude picture is twice as wide as high.",
            "Convert it to that projection.",
        )
    cleaned, clamped = _clean(pixels)
    return Environment(cleaned, text, clamped)


def _read(path: str) -> NDArray[np.float32] | None:
    """The pixels of a file, or None if its name is not that of one."""
    match pathlib.Path(path).suffix.lower():
        case ".exr":
            from .exr import read_exr

            return read_exr(path, _WIDTH_MAX)
        case ".hdr":
            from .radiance_hdr import read_hdr

            return read_hdr(path, _WIDTH_MAX)
    return None


@functools.cache
def _built_in(name: str) -> Environment:
    from .built_in import BUILT_IN

    if name not in BUILT_IN:
        raise UserError(
            f"`{name}` is neither a .hdr or .exr file nor a built-in environment. {nearest(name, BUILT_IN)}"
        )
    pixels = np.asarray(BUILT_IN[name](), np.float32)
    pixels.flags.writeable = False  # all who ask for it share it
    return Environment(pixels, name)


def _clean(pixels: NDArray[np.float32]) -> tuple[NDArray[np.float32], int]:
    """Finite, non-negative radiance, and how many values were not, or too large."""
    bad = ~((pixels >= 0) & (pixels <= _RADIANCE_MAX))  # NaN too
    if not bad.any():
        return np.ascontiguousarray(pixels, np.float32), 0
    cleaned = np.clip(np.nan_to_num(pixels, nan=0.0, posinf=_INFINITE, neginf=0.0), 0.0, _RADIANCE_MAX)
    return np.ascontiguousarray(cleaned, np.float32), int(bad.sum())

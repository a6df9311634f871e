"""A rendered picture and how it is stored."""

from __future__ import annotations

import dataclasses
import os
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image as PillowImage

from brdf.errors import UserError

from .plan import FramePlan

# Together just below 1, so that what eight bits hold exactly is not rounded up; the second one covers the rounding of
# float32, so that it is not rounded down either.
_DITHER, _ROUNDING = 0.999, 5e-4


@dataclasses.dataclass(frozen=True)
class Image:
    """What `shaders.render` returns.

    - `pixels`: shape (h, w, 3), float32, linear Rec. 709 after exposure, row 0 at the top; without a sky (h, w, 4), the
      fourth channel being the coverage, by which colour is premultiplied.
    - `display`: the same picture for displays in [0, 1], tone-mapped and sRGB-encoded, colour not premultiplied; `None`
      if the scene asks for none.
    - `renderer`: the OpenGL device that made it.
    - `counts`: what was done: `tier`; `passes` that ran, `reused` ones, and `dropped` ones with the reason; `draws`,
      `culled_parts`, `bytes_uploaded`, `programs_compiled`, `milliseconds` by pass and `seconds`; of the picture, drawn
      now or kept, the `frames`, `samples` per pixel, estimated `error` (see `Accumulation`) and why it `stopped`.
    - `plan`: the passes as they were declared, and what became of each.
    """

    pixels: NDArray[np.float32]
    display: NDArray[np.float32] | None
    renderer: str
    counts: dict[str, Any]
    plan: FramePlan


def write_png(path: str | os.PathLike[str], display: ArrayLike) -> None:
    """Writes a picture for displays with eight bits per channel.

    **Arguments:**

    - `path`: the file, replaced if it exists.
    - `display`: shape (h, w, 3) or (h, w, 4), encoded for display, clipped to [0, 1], row 0 at the top.

    Raises `UserError` for another shape or NaN, `OSError` when the file cannot be written.
    """
    values = np.asarray(display, np.float32)
    if values.ndim != 3 or values.shape[2] not in (3, 4) or values.size == 0:
        raise UserError(f"`{values.shape}` is not the shape of a picture. Pass (h, w, 3) or (h, w, 4).")
    is_missing = np.isnan(values)
    if is_missing.any():
        row, column, _ = np.argwhere(is_missing)[0].tolist()
        raise UserError(
            f"`row {row}, column {column}` of the picture is NaN, which a PNG cannot hold. Write an .exr, which can, "
            "to look at it, or replace it with `numpy.nan_to_num`."
        )
    # Rounded up or down at random, in proportion, so that eight bits draw no bands in a slow gradient. Values that
    # eight bits hold exactly stay, and the seed makes the same picture the same file.
    dither = np.random.default_rng(0).random((*values.shape[:2], 1), np.float32)
    levels = np.floor(np.minimum(np.clip(values, 0, 1) * 255 + (dither * _DITHER + _ROUNDING), 255)).astype(np.uint8)
    # Dithered rows repeat nothing but flat runs: a search for more takes longer, and the file is no smaller.
    PillowImage.fromarray(np.ascontiguousarray(levels)).save(os.fspath(path), format="PNG", compress_type=zlib.Z_RLE)

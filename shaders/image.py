"""A rendered picture and how it is stored."""

from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image as PillowImage

from brdf.errors import UserError


@dataclasses.dataclass(frozen=True)
class Image:
    """What `shaders.render` returns.

    - `pixels`: shape (h, w, 3), float32, linear Rec. 709 after exposure, row 0 at the top; without a sky (h, w, 4), the
      fourth channel being the coverage, by which colour is premultiplied.
    - `display`: the same picture for displays in [0, 1], tone-mapped and sRGB-encoded, colour not premultiplied; `None`
      if the scene asks for none.
    - `renderer`: the OpenGL device that made it.
    - `counts`: what was done: passes run and dropped, frames, samples, draws, programs compiled, seconds.
    """

    pixels: NDArray[np.float32]
    display: NDArray[np.float32] | None
    renderer: str
    counts: dict[str, Any]


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
    if np.isnan(values).any():
        raise UserError("`NaN` is in the picture. A PNG cannot hold it; write an .exr to look for it.")
    levels = np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8)
    PillowImage.fromarray(np.ascontiguousarray(levels)).save(os.fspath(path), format="PNG")

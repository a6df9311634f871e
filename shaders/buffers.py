"""Buffers and pictures that stay on the device: a new content uploads only what differs."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray


class KeptBuffer:
    """A buffer and the content that it holds."""

    def __init__(self, ctx: moderngl.Context):
        self._ctx = ctx
        self._data = b""
        self._buffer: moderngl.Buffer | None = None

    @property
    def buffer(self) -> moderngl.Buffer:
        """The buffer; `update` comes first."""
        assert self._buffer is not None
        return self._buffer

    def update(self, data: bytes) -> int:
        """Makes `data`, not empty, the content; returns how many bytes were uploaded.

        From the first byte that differs to the last one, in one piece; all of them for another length.
        """
        if data == self._data:
            return 0
        if self._buffer is None or len(data) != len(self._data):
            self._data, self._buffer = data, self._ctx.buffer(data)
            return len(data)
        differs = np.flatnonzero(np.frombuffer(data, np.uint8) != np.frombuffer(self._data, np.uint8))
        first, end = int(differs[0]), int(differs[-1]) + 1
        self._buffer.write(data[first:end], offset=first)
        self._data = data
        return end - first


class KeptPixels:
    """A picture of four numbers per texel, none between its texels, and the content that it holds."""

    def __init__(self, ctx: moderngl.Context):
        self._ctx = ctx
        self._pixels: NDArray[np.float32] | None = None
        self._texture: moderngl.Texture | None = None

    @property
    def texture(self) -> moderngl.Texture:
        """The texture; `update` comes first."""
        assert self._texture is not None
        return self._texture

    def update(self, pixels: NDArray[np.float32]) -> int:
        """Makes `pixels`, shape (h, w, 4), the content; returns how many bytes were uploaded.

        From the first row that differs to the last one; all of them for another shape.
        """
        height, width, _ = pixels.shape
        if self._pixels is None or self._texture is None or pixels.shape != self._pixels.shape:
            self._pixels, self._texture = pixels, self._ctx.texture((width, height), 4, pixels.tobytes(), dtype="f4")
            self._texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._texture.repeat_x = self._texture.repeat_y = False
            return pixels.nbytes
        differs = np.flatnonzero((pixels != self._pixels).any(axis=(1, 2)))
        self._pixels = pixels
        if not len(differs):
            return 0
        first, end = int(differs[0]), int(differs[-1]) + 1
        self._texture.write(pixels[first:end].tobytes(), viewport=(0, first, width, end - first))
        return pixels[first:end].nbytes

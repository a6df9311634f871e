"""Buffers that stay on the device: a new content uploads only the bytes that differ."""

from __future__ import annotations

import moderngl
import numpy as np


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

"""Twins kept on disk by the file they were made of: a material that was seen before needs no JAX to be drawn."""

from __future__ import annotations

import functools
import hashlib
import pathlib
from collections.abc import Callable

import numpy as np

import brdf

from .kept_tables import kept
from .source import GLSL
from .twin import Twin

_KIND = "twin-1"


def kept_twin(content: bytes, make: Callable[[], Twin]) -> Twin:
    """The twin that `make` returns, from disk if it was made before.

    **Arguments:** `content`: of the file that decides it.
    """

    def arrays() -> dict[str, np.ndarray]:
        made = make()
        facts = np.array([made.proposals, made.is_anisotropic], np.int64)
        parts = (made.text.encode(), made.block, *made.buffers)
        return {"facts": facts} | {f"part_{i:03d}": np.frombuffer(part, np.uint8) for i, part in enumerate(parts)}

    found = kept(_KIND, (content, _program()), arrays)
    text, block, *buffers = (found[name].tobytes() for name in sorted(found) if name != "facts")
    proposals, is_anisotropic = (int(fact) for fact in found["facts"])
    return Twin(text.decode(), block, proposals, tuple(buffers), bool(is_anisotropic))


@functools.cache
def _program() -> bytes:
    """A digest of what makes twins, the models and their GLSL, by the files' sizes and times."""
    digest = hashlib.blake2b(digest_size=16)
    models = pathlib.Path(brdf.__file__).parent
    for folder, pattern in ((models, "*.py"), (GLSL, "*.glsl"), (pathlib.Path(__file__).parent, "*.py")):
        for file in sorted(folder.rglob(pattern)):
            facts = file.stat()
            digest.update(f"{file.name} {facts.st_size} {facts.st_mtime_ns}\n".encode())
    return digest.digest()

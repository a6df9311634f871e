"""Arrays that are dear to make, kept on disk by their content: by a hash of everything that they are made of.

A file that cannot be read or written is no error: its table is made anew.
"""

from __future__ import annotations

import hashlib
import os
import pathlib
import zipfile
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from brdf.atomic import atomic_path
from brdf.cache import cache_folder

# When the folder grows beyond it, the files that were not used for longest go, down to half of it.
_BYTES_MAX = 256 << 20

Arrays = dict[str, NDArray[np.generic]]


def kept(kind: str, ingredients: tuple[bytes, ...], make: Callable[[], Mapping[str, NDArray[np.generic]]]) -> Arrays:
    """The arrays that `make` returns, from disk if they were made before.

    **Arguments:**

    - `kind`: what they are, with the version of how they are made: another one makes them anew.
    - `ingredients`: all that they depend on.
    """
    digest = hashlib.blake2b(kind.encode(), digest_size=16)
    for one in ingredients:
        digest.update(len(one).to_bytes(8, "little") + one)
    folder = cache_folder("tables")
    path = None if folder is None else folder / f"{kind}-{digest.hexdigest()}.npz"
    found = None if path is None else _read(path)
    if found is not None:
        return found
    made = dict(make())
    if path is not None:
        _write(path, made)
    return made


def _read(path: pathlib.Path) -> Arrays | None:
    try:
        with np.load(path) as archive:
            found = {name: archive[name] for name in archive.files}
        os.utime(path)
        return found
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None


def _write(path: pathlib.Path, arrays: Arrays) -> None:
    try:
        with atomic_path(path, force=True) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)  # pyright: ignore[reportArgumentType]
        _prune(path.parent)
    except OSError:
        return


def _prune(folder: pathlib.Path) -> None:
    files = [(one.stat().st_mtime, one.stat().st_size, one) for one in folder.glob("*.npz")]
    total = sum(size for _, size, _ in files)
    if total <= _BYTES_MAX:
        return
    for _, size, one in sorted(files):
        if total <= _BYTES_MAX // 2:
            break
        one.unlink(missing_ok=True)
        total -= size

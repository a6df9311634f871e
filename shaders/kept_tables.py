"""Arrays that are dear to make, kept on disk by their content: by a hash of everything that they are made of.

A file that cannot be read or written is no error: its table is made anew.
"""

from __future__ import annotations

import hashlib
import io
import os
import pathlib
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from brdf.atomic import atomic_path
from brdf.cache import cache_folder
from brdf.errors import FileError

# When the folder grows beyond it, the files that were not used for longest go, down to half of it.
_BYTES_MAX = 256 << 20
# A file is a checksum, then an archive of NumPy's.
_CHECKSUM_BYTES = 16
_SUFFIX = ".table"

Arrays = dict[str, NDArray[np.generic]]


def kept(
    kind: str,
    ingredients: tuple[bytes, ...],
    make: Callable[[], Mapping[str, NDArray[np.generic]]],
    folder_name: str = "tables",
) -> Arrays:
    """The arrays that `make` returns, from disk if they were made before.

    **Arguments:**

    - `kind`: what they are, with the version of how they are made: another one makes them anew.
    - `ingredients`: all that they depend on.
    - `folder_name`: of the cache's folder that they are kept in.
    """
    digest = hashlib.blake2b(kind.encode(), digest_size=16)
    for one in ingredients:
        digest.update(len(one).to_bytes(8, "little") + one)
    folder = cache_folder(folder_name)
    path = None if folder is None else folder / f"{kind}-{digest.hexdigest()}{_SUFFIX}"
    found = None if path is None else _read(path)
    if found is not None:
        return found
    made = dict(make())
    if path is not None:
        _write(path, made)
    return made


def _read(path: pathlib.Path) -> Arrays | None:
    try:
        content = path.read_bytes()
        os.utime(path)
    except OSError:
        return None
    # Not every damage of an archive is an error when it is read.
    if _checksum(content[_CHECKSUM_BYTES:]) != content[:_CHECKSUM_BYTES]:
        return None
    with np.load(io.BytesIO(content[_CHECKSUM_BYTES:])) as archive:
        return {name: archive[name] for name in archive.files}


def _write(path: pathlib.Path, arrays: Arrays) -> None:
    archive = io.BytesIO()
    np.savez(archive, **arrays)  # pyright: ignore[reportArgumentType]
    content = archive.getvalue()
    try:
        with atomic_path(path, force=True) as temporary:
            temporary.write_bytes(_checksum(content) + content)
        _prune(path.parent)
    except (OSError, FileError):
        return


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKSUM_BYTES).digest()


def _prune(folder: pathlib.Path) -> None:
    files = [(one.stat().st_mtime, one.stat().st_size, one) for one in folder.glob(f"*{_SUFFIX}")]
    total = sum(size for _, size, _ in files)
    if total <= _BYTES_MAX:
        return
    for _, size, one in sorted(files):
        if total <= _BYTES_MAX // 2:
            break
        one.unlink(missing_ok=True)
        total -= size

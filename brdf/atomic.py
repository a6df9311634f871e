"""Whole files or none: write to a temporary file beside the target, then rename it into place."""

from __future__ import annotations

import contextlib
import os
import pathlib
from collections.abc import Iterator

from brdf.errors import FileError


def refuse_to_overwrite(path: str | os.PathLike[str], force: bool) -> None:
    """Says no before any work is done, if `path` exists and `force` is not given.

    **Arguments:**

    - `path`: the file that is going to be written.
    - `force`: whether an existing file may be replaced. A folder never may.

    **Raises:** `FileError` if `path` is a folder, its folder is missing, or it exists without
    `force`.
    """
    target = pathlib.Path(path)
    if target.is_dir():
        raise FileError(path, "is a folder, and a file is to be written.", "Name a file inside it.")
    if not target.parent.is_dir():
        raise FileError(
            path,
            f"cannot be written: the folder `{target.parent}` does not exist.",
            "Create the folder first or name another.",
        )
    if target.exists() and not force:
        raise FileError(path, "exists already.", "Pass `--force` (in Python `force=True`) to replace it.")


@contextlib.contextmanager
def atomic_path(path: str | os.PathLike[str], force: bool = False) -> Iterator[pathlib.Path]:
    """Gives a temporary path to write to and renames it to `path` when the block ends well.

    Use it for every file that the project writes, so that a killed or failed run never leaves half
    a file and never destroys the one before. The temporary file stands in the same folder (a rename
    across file systems is not atomic), hidden, and keeps the suffix, since some writers choose
    their format by it. The permissions are those that a newly created file gets.

    **Arguments:**

    - `path`: the file to write.
    - `force`: whether an existing file may be replaced.

    **Returns:** a context manager whose value is the temporary path. If the block raises, the
    temporary file is removed and `path` is left as it was.

    **Raises:** `FileError` as `refuse_to_overwrite` does, or if the folder cannot be written to.
    """
    refuse_to_overwrite(path, force)
    target = pathlib.Path(path)
    temporary = target.with_name(f".{target.stem}.{os.urandom(6).hex()}{target.suffix}")
    try:
        # Created here, exclusively, so that a folder without write permission is told at once.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as error:
        raise FileError(
            path,
            f"cannot be written ({error.strerror}).",
            "Check the permissions of the folder or name another.",
        ) from error
    try:
        yield temporary
        if target.exists() and not force:  # it may have appeared in the meantime
            refuse_to_overwrite(path, force)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)

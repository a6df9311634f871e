"""Measurement files, one module per format, found by suffix.

A format is one module of this folder that declares

- `NAME`: what reports and errors call it;
- `DESCRIPTION`: one line;
- `SUFFIXES`: lower case, with the dot;
- `OPTIONS`: option name -> the values allowed, or `()` for free text;
- `sniff(head)`: whether the first bytes of a file look like it;
- `read(path, **its options by name) -> Reflectance`;
- `write(reflectance, path, force)`, if the project writes it.

Nothing else has to be edited: `formats()` finds the module. What several formats share, or one is long for, stands in a
module whose name begins with an underscore. Modules import nothing heavy at the
top.
"""

from __future__ import annotations

import difflib
import functools
import importlib
import os
import pathlib
import pkgutil
from collections.abc import Callable, Mapping
from typing import Protocol, cast, runtime_checkable

from brdf.errors import FileError, UserError
from fitter.reflectance import Reflectance

# Text headers, such as ASTM's, run to some hundred bytes before the line that tells them apart.
SNIFFED_BYTES = 4096


@runtime_checkable
class Format(Protocol):
    """What a module of this folder declares."""

    NAME: str
    DESCRIPTION: str
    SUFFIXES: tuple[str, ...]
    OPTIONS: Mapping[str, tuple[str, ...]]
    sniff: Callable[[bytes], bool]
    read: Callable[..., Reflectance]


@runtime_checkable
class Writable(Protocol):
    """What a module declares besides if the project writes its format."""

    write: Callable[[Reflectance, pathlib.Path, bool], None]


@functools.cache
def formats() -> tuple[Format, ...]:
    """Every format of this folder, in alphabetical order of its module."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return tuple(
        cast(Format, importlib.import_module(f"{__name__}.{name}")) for name in names if not name.startswith("_")
    )


def supported() -> str:
    """One line that names every format and its suffixes, for help and errors."""
    return ", ".join(f"{' '.join(format.SUFFIXES)} ({format.NAME})" for format in formats())


def split_member(path: str | os.PathLike[str]) -> tuple[pathlib.Path, str | None]:
    """Splits `slices.npz:brass` into the file and the member of it.

    **Arguments:**

    - `path`: a file name, with `:member` behind it for formats that hold several measurements.

    **Returns:** the file, and the member or `None`. A file whose own name holds the colon wins, and
    the colon of a drive letter is none.
    """
    text = os.fspath(path)
    head, colon, member = text.rpartition(":")
    if not colon or os.path.exists(text):
        return pathlib.Path(text), None
    suffix = pathlib.Path(head).suffix.lower()
    if any(suffix in format.SUFFIXES and "member" in format.OPTIONS for format in formats()):
        return pathlib.Path(head), member
    return pathlib.Path(text), None


def read(path: str | os.PathLike[str], options: Mapping[str, str] | None = None) -> Reflectance:
    """Reads a measurement of any supported format.

    **Arguments:**

    - `path`: the file; `slices.npz:brass` for one member of an npz.
    - `options`: the format's own options by name, such as `{"cells": "centre"}` for MERL.

    **Returns:** the measurement; what was left out is counted in its `dropped`.

    **Raises:** `FileError` if the file is missing, empty, unreadable, of an unknown suffix or
    damaged; `UserError` on an unknown option.
    """
    file, member = split_member(path)
    format = _format_of(file, _head(file))
    chosen = dict(options or {})
    if member is not None:
        chosen["member"] = member
    for name, value in chosen.items():
        if name not in format.OPTIONS:
            known = ", ".join(f"`{option}`" for option in format.OPTIONS) or "none"
            raise UserError(f"`{name}` is not an option of the {format.NAME} reader. It knows: {known}.")
        allowed = format.OPTIONS[name]
        if allowed and value not in allowed:
            raise UserError(
                f"`{name} = {value}` is not allowed by the {format.NAME} reader. Pass one of "
                + ", ".join(f"`{choice}`" for choice in allowed)
                + "."
            )
    try:
        return format.read(file, **chosen)
    except OSError as error:
        raise _unreadable(file, error) from error


def write(reflectance: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes the samples of a measurement in the format that the suffix of `path` names.

    **Arguments:**

    - `reflectance`: what to write.
    - `path`: where to.
    - `force`: whether an existing file may be replaced.

    **Raises:** `FileError` if the suffix belongs to no format that can be written, or the file
    cannot be; `UserError` if the format cannot hold this measurement.
    """
    file = pathlib.Path(path)
    writers = {
        suffix: cast(Writable, format).write
        for format in formats()
        if hasattr(format, "write")
        for suffix in format.SUFFIXES
    }
    if file.suffix.lower() not in writers:
        raise FileError(
            path,
            f"`{file.suffix}` is no format that can be written.",
            f"End the name in one of {', '.join(sorted(writers))}.",
        )
    writers[file.suffix.lower()](reflectance, file, force)


def _head(path: pathlib.Path) -> bytes:
    """The first bytes of a file that exists, is a file, can be read and is not empty."""
    if path.is_dir():
        raise FileError(path, "is a folder.", "Name one measurement file inside it.")
    try:
        with open(path, "rb") as file:
            head = file.read(SNIFFED_BYTES)
    except OSError as error:
        raise _unreadable(path, error) from error
    if not head:
        raise FileError(path, "is empty (0 bytes).", "Download or export it again.")
    return head


def _unreadable(path: pathlib.Path, error: OSError) -> FileError:
    if isinstance(error, FileNotFoundError):
        folder = path.parent
        siblings = [entry.name for entry in folder.iterdir()] if folder.is_dir() else []
        near = difflib.get_close_matches(path.name, siblings, n=1)
        remedy = f"Did you mean `{folder / near[0]}`?" if near else "Check the name."
        return FileError(path, "does not exist.", remedy)
    return FileError(path, f"cannot be read ({error.strerror or error}).", "Check its permissions.")


def _format_of(path: pathlib.Path, head: bytes) -> Format:
    """The format by suffix; by content where two share the suffix."""
    suffix = path.suffix.lower()
    candidates = [format for format in formats() if suffix in format.SUFFIXES]
    fitting = [format for format in candidates if format.sniff(head)]
    if fitting or candidates:
        return (fitting or candidates)[0]
    alike = [format for format in formats() if format.sniff(head)]
    hint = f" Its content looks like {alike[0].NAME}: rename it to end in {alike[0].SUFFIXES[0]}." if alike else ""
    shown = f"the suffix `{suffix}`" if suffix else "a name without a suffix"
    raise FileError(path, f"has {shown}, which no reader knows.", f"Supported are {supported()}.{hint}")

"""Public measurements, downloaded from their homes: MERL and RGL.

The catalogue is `datasets.toml`. A file is checked before it gets its name: its length, its first bytes and, where the
catalogue has one, its checksum. Beside each file its SHA-256 is kept as `NAME.sha256`, in the form of `sha256sum`, and
a file that is here already is held to it: where no checksum was published, the first download is trusted.
"""

from __future__ import annotations

import hashlib
import pathlib
import re
import time
import zipfile
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, cast, runtime_checkable

from brdf.atomic import atomic_path
from brdf.errors import FileError

from .catalogue import DataSet, catalogue

if TYPE_CHECKING:
    import requests

MIRROR_VARIABLE = "BRDF_DATA_URL"
# A transfer that breaks off is begun anew; a server that says no is believed at once.
ATTEMPTS = 3
CHUNK_BYTES = 1 << 16
CONNECT_READ_SECONDS = (10, 60)


@runtime_checkable
class Bar(Protocol):
    """What pooch wants of a progress bar, counted in bytes."""

    total: int

    def update(self, count: int) -> None: ...
    def reset(self) -> None: ...
    def close(self) -> None: ...


def fetch(
    entry: DataSet,
    folder: pathlib.Path,
    mirror: str | None = None,
    force: bool = False,
    bar: Bar | None = None,
    say: Callable[[str], None] = lambda sentence: None,
    wait: float = 1.0,
) -> list[pathlib.Path]:
    """Makes sure that a data set is here and whole.

    **Arguments:**

    - `entry`: from `find`.
    - `folder`: see `data_folder`; files go to a subfolder for each group.
    - `mirror`: download `mirror/FILE` instead of the home's address.
    - `force`: download again even what is here.
    - `bar`: shows the transfer.
    - `say`: called with a sentence before each transfer.
    - `wait`: seconds before the second attempt, twice that before the third.

    **Returns:** the file, or the files of an archive.

    **Raises:** `FileError` if the server cannot be reached or refuses, if what came is not the file, if a file that is
    here has changed, or if it cannot be written. Nothing half-written is left.
    """
    paths = entry.paths(folder)
    if not force and all(path.exists() for path in paths):
        for part, path in zip(entry.members or (entry,), paths, strict=True):
            _check_kept(part, path)
        return paths
    url = f"{mirror.rstrip('/')}/{entry.file}" if mirror else entry.url
    try:
        (folder / entry.group).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be made a folder ({error.strerror}).", "Name another with `-o`.") from error
    target = folder / entry.group / entry.file
    if force or not target.exists():
        _transfer(entry, url, target, bar, say, wait)
    if entry.members:
        _unpack(entry, target, folder, say)
        target.unlink()
        _record_of(target).unlink()
    return paths


def _transfer(
    entry: DataSet, url: str, target: pathlib.Path, bar: Bar | None, say: Callable[[str], None], wait: float
) -> None:
    """Downloads to a temporary file, checks it and gives it its name; begins anew where that may help."""
    import pooch
    import requests

    download = pooch.HTTPDownloader(
        progressbar=cast(bool, bar or False),  # pooch takes any object that can do what a bar does
        chunk_size=CHUNK_BYTES,
        timeout=CONNECT_READ_SECONDS,
        headers=_PLAIN,
    )
    for attempt in range(1, ATTEMPTS + 1):
        say(f"downloading {url}" if attempt == 1 else f"downloading {url} again, attempt {attempt} of {ATTEMPTS}")
        try:
            with atomic_path(target, force=True) as temporary:
                download(url, str(temporary), None)
                digest = _check_new(entry, url, temporary)
            _record(target, digest)
            return
        except requests.HTTPError as error:
            failure, final = _refused(entry, url, cast(requests.Response, error.response))
        except (requests.exceptions.InvalidURL, requests.exceptions.MissingSchema, requests.exceptions.InvalidSchema):
            failure, final = FileError(url, "is not a web address.", f"Mend `--base-url` or {MIRROR_VARIABLE}."), True
        except requests.ConnectionError as error:
            failure, final = _unreachable(url, target, error), False
        except requests.RequestException:
            failure = FileError(url, "broke off in the middle of the transfer.", "Try again; nothing was kept.")
            final = False
        except _Incomplete as error:
            failure, final = error.failure, False
        if final or attempt == ATTEMPTS:
            raise failure from None
        time.sleep(wait * attempt)


# Content-Length then counts the file's own bytes, which a broken transfer is told by.
_PLAIN = {"Accept-Encoding": "identity"}


class _Incomplete(Exception):
    """What came is not the file; another attempt may bring it."""

    def __init__(self, failure: FileError):
        self.failure = failure
        super().__init__(str(failure))


def _check_new(entry: DataSet, url: str, path: pathlib.Path) -> str:
    """The SHA-256 of a downloaded file, if it is what the catalogue says."""
    size = path.stat().st_size
    with open(path, "rb") as file:
        head = file.read(len(entry.magic))
    if head != entry.magic:
        raise _Incomplete(
            FileError(url, f"gave something else than {entry.file} ({size} bytes).", f"Look there: {entry.home}")
        )
    if entry.size is not None and size != entry.size:
        raise _Incomplete(
            FileError(
                url, f"gave {size} bytes of {entry.file}, which has {entry.size}.", "Try again; nothing was kept."
            )
        )
    if entry.checksum:
        kind, _, expected = entry.checksum.partition(":")
        if (found := _digest(path, kind)) != expected:
            raise _Incomplete(
                FileError(
                    url,
                    f"gave a file with the {kind} {found}; the catalogue says {expected}.",
                    f"Try again; nothing was kept. If it stays so, it was replaced at its home, {entry.home}.",
                )
            )
    return _digest(path, "sha256")


def _check_kept(entry: DataSet, path: pathlib.Path) -> None:
    """Raises if a file that is here is not the one that was downloaded; records the SHA-256 of one without a record."""
    recorded = _record_of(path)
    if not recorded.exists():
        try:
            _record(path, _check_new(entry, str(path), path))
        except _Incomplete as error:
            raise FileError(path, error.failure.problem, "Delete it, or pass `--force` to download it.") from None
        return
    digest, expected = _digest(path, "sha256"), recorded.read_text(encoding="utf-8").partition(" ")[0]
    if digest != expected:
        raise FileError(
            path,
            f"has changed: its sha256 is {digest}, and {recorded.name} says {expected}.",
            "Pass `--force` to download it again.",
        )


def _unpack(archive: DataSet, path: pathlib.Path, folder: pathlib.Path, say: Callable[[str], None]) -> None:
    """Takes the members out of a checked archive; zipfile holds each to its CRC-32."""
    say(f"unpacking {len(archive.members)} files")
    try:
        with zipfile.ZipFile(path) as zipped:
            places = {pathlib.PurePosixPath(name).name: name for name in zipped.namelist()}
            for entry, target in zip(archive.members, archive.paths(folder), strict=True):
                with zipped.open(places[entry.file]) as source, atomic_path(target, force=True) as temporary:
                    with open(temporary, "wb") as file:
                        while block := source.read(1 << 20):
                            file.write(block)
                    digest = _check_new(entry, archive.url, temporary)
                _record(target, digest)
    except (zipfile.BadZipFile, KeyError, EOFError) as error:
        raise FileError(path, f"is not the archive it should be ({error}).", "Delete it and try again.") from error
    except _Incomplete as error:
        raise error.failure from None


def _refused(entry: DataSet, url: str, response: requests.Response) -> tuple[FileError, bool]:
    """The failure, and whether another attempt is useless."""
    status = f"HTTP {response.status_code} {response.reason}"
    if response.status_code not in (404, 410):
        final = 400 <= response.status_code < 500 and response.status_code != 429
        return FileError(url, f"was refused by the server ({status}).", "Try again later."), final
    remedy = f"It may have moved: look at {entry.home}"
    if entry.group in catalogue() and not entry.members:
        remedy += f" or get the whole set with `brdf data get {entry.group}`"
    return FileError(url, f"is not there ({status}).", f"{remedy}."), True


def _unreachable(url: str, target: pathlib.Path, error: Exception) -> FileError:
    # The operating system's own words stand somewhere in a chain of wrapped errors.
    words = re.search(r"\[Errno -?\d+\] ([^)\]'\"]+)", str(error))
    cause = words[1] if words else "no answer"
    return FileError(
        url,
        f"cannot be reached ({cause}): this machine may be offline.",
        f"Check the network, or download it elsewhere and put it to `{target}`.",
    )


def _digest(path: pathlib.Path, kind: str) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, kind).hexdigest()


def _record_of(path: pathlib.Path) -> pathlib.Path:
    return path.with_name(path.name + ".sha256")


def _record(path: pathlib.Path, digest: str) -> None:
    with atomic_path(_record_of(path), force=True) as temporary:
        temporary.write_text(f"{digest}  {path.name}\n", encoding="utf-8")

"""The catalogue of public measurements: what `brdf data` knows, from `datasets.toml`."""

from __future__ import annotations

import dataclasses
import difflib
import fnmatch
import functools
import os
import pathlib
import tomllib
from collections.abc import Mapping
from typing import Any

from brdf.errors import UserError

FOLDER_VARIABLE = "BRDF_DATA"


@dataclasses.dataclass(frozen=True)
class DataSet:
    """One entry of the catalogue.

    - `name`: what `brdf data get` takes, such as `chrome` or `chm_mint_rgb`.
    - `group`: `merl` or `rgl`; `licence`, `notice`, `home`: of that group.
    - `file`: the name it gets here; `url`: where it is.
    - `size`: bytes, or None if not known; `magic`: its first bytes; `checksum`: such as `md5:...`, or None.
    - `members`: of an archive, the files that are taken out of it.
    """

    name: str
    group: str
    licence: str
    notice: str
    home: str
    file: str
    url: str
    size: int | None = None
    magic: bytes = b""
    checksum: str | None = None
    members: tuple[DataSet, ...] = ()

    def paths(self, folder: pathlib.Path) -> list[pathlib.Path]:
        """Where the file, or what an archive holds, lies under the folder of all data."""
        return [folder / self.group / entry.file for entry in self.members or (self,)]


@functools.cache
def catalogue() -> dict[str, DataSet]:
    """Every data set by name, in the order of the catalogue."""
    groups = tomllib.loads((pathlib.Path(__file__).parent / "datasets.toml").read_text(encoding="utf-8"))
    found: dict[str, DataSet] = {}
    for group, facts in groups.items():
        shared = {"group": group, **{key: facts[key].strip() for key in ("licence", "notice", "home")}}
        members = []
        for name in facts["names"].split():
            for pattern, source in facts["files"].items():
                file = pattern.format(name=name)
                checksum = facts.get("checksums", {}).get(file)
                entry = _entry(source, shared, pathlib.Path(file).stem, file, name, checksum and f"sha256:{checksum}")
                members.append(entry)
        found |= {entry.name: entry for entry in members}
        if "archive" in facts:
            archive = facts["archive"]
            whole = _entry(archive, shared, group, archive["file"], group, archive["checksum"])
            found[group] = dataclasses.replace(whole, members=tuple(members))
    return found


def _entry(
    source: Mapping[str, Any], shared: Mapping[str, str], name: str, file: str, material: str, checksum: str | None
) -> DataSet:
    return DataSet(
        name=name,
        file=file,
        url=source["url"].format(name=material, file=file),
        size=source.get("size"),
        magic=bytes.fromhex(source["magic"]),
        checksum=checksum,
        group=shared["group"],
        licence=shared["licence"],
        notice=shared["notice"],
        home=shared["home"],
    )


def find(name: str) -> DataSet:
    """The data set of a name; a file name will do, and an RGL material without `_rgb` or `_spec` means the RGB file.

    **Raises:** `UserError`, naming the nearest ones, for an unknown name.
    """
    known = catalogue()
    wanted = name.strip().lower().rpartition("/")[2]
    wanted = wanted.removesuffix(".binary").removesuffix(".bsdf")
    for candidate in (wanted, wanted.replace("_", "-"), wanted.replace("-", "_")):
        for full in (candidate, f"{candidate}_rgb"):
            if full in known:
                return known[full]
    # Nearest by the words in it too: `gold` is far from `gold-metallic-paint` by its letters.
    near = difflib.get_close_matches(wanted, known, n=3, cutoff=0.6) or [key for key in known if wanted in key][:3]
    hint = f"Did you mean {' or '.join(f'`{key}`' for key in near)}? " if wanted and near else ""
    raise UserError(f"`{name}` is not a data set. {hint}`brdf data list` shows all {len(known)}.")


def matching(pattern: str) -> list[DataSet]:
    """The data sets whose name or group contains the text, or matches it as a shell pattern; all for an empty text."""
    text = pattern.strip().lower()
    if not any(character in text for character in "*?["):
        text = f"*{text}*"
    return [
        entry
        for entry in catalogue().values()
        if fnmatch.fnmatchcase(entry.name, text) or fnmatch.fnmatchcase(entry.group, text)
    ]


def data_folder(chosen: str | None = None) -> pathlib.Path:
    """The folder of all data: the chosen one, else that of `BRDF_DATA`, else the user's cache folder."""
    if chosen or (chosen := os.environ.get(FOLDER_VARIABLE)):
        return pathlib.Path(chosen).expanduser()
    import pooch

    return pathlib.Path(pooch.os_cache("brdf-fitter")) / "data"

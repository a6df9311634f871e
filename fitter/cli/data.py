"""`brdf data`: public measurements, listed and downloaded."""

from __future__ import annotations

import os
import pathlib
import sys
from typing import Any

import click

from . import options

_folder = click.option(
    "--output", "-o", metavar="FOLDER", help="Where data are kept.  [default: $BRDF_DATA or the cache]"
)


@click.group(name="data")
def command() -> None:
    """Lists public measurements and downloads them from their homes: MERL and RGL.

    \b
    Example:
      brdf fit $(brdf data get chrome) --model lambert+ggx -o chrome.json
    """


@command.command(name="list")
@click.argument("pattern", default="")
@_folder
@options.as_json
def list_(pattern: str, output: str | None, as_json: bool) -> None:
    """Lists the data sets whose name or set contains PATTERN, such as gold, rgl or `*_spec`.

    \b
    Example:
      brdf data list metallic
    """
    import json

    from brdf.errors import UserError

    from ..datasets.catalogue import catalogue, data_folder, matching

    folder = data_folder(output)
    facts = [_facts(entry, folder) for entry in matching(pattern)]
    if not facts:
        raise UserError(f"No data set matches `{pattern}`. `brdf data list` shows all {len(catalogue())}.")
    if as_json:
        click.echo(json.dumps(facts, indent=2))
        return
    rows = [("name", "set", "size", "licence", "here")]
    rows += [
        (fact["name"], fact["set"], _size(fact["bytes"]), fact["licence"], "yes" if fact["here"] else "")
        for fact in facts
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    for row in rows:
        click.echo("  ".join(f"{text:{width}}" for text, width in zip(row, widths, strict=True)).rstrip())
    here = sum(fact["here"] for fact in facts)
    click.echo(f"\n{len(facts)} data sets, {here} of them in {folder}. Get one: brdf data get NAME", err=True)


@command.command(name="get")
@click.argument("names", metavar="NAME...", nargs=-1, required=True)
@_folder
@click.option("--base-url", hidden=True, help="Download BASE-URL/FILE instead; the default is $BRDF_DATA_URL.")
@click.option("--force", is_flag=True, help="Download again what is here.")
@options.quiet
def get(names: tuple[str, ...], output: str | None, base_url: str | None, force: bool, quiet: bool) -> None:
    """Downloads the data sets NAME..., unless they are here, and prints their paths.

    The licence is shown first. `merl` stands for all 100 materials of that set, in one archive of 1.25 GB with a
    published checksum. Elsewhere, where none was published, the first download is trusted and its SHA-256 kept beside
    the file, to which it is held from then on.

    \b
    Example:
      brdf data get chrome chm_mint
    """
    from ..datasets.catalogue import data_folder, find
    from ..datasets.download import MIRROR_VARIABLE, fetch

    folder = data_folder(output)
    mirror = base_url or os.environ.get(MIRROR_VARIABLE)
    noticed: set[str] = set()
    for entry in [find(name) for name in names]:
        here = all(path.exists() for path in entry.paths(folder))
        if entry.group not in noticed and (force or not here):
            click.echo(entry.notice, err=True)
            noticed.add(entry.group)
        with _Bar(entry.file, quiet) as bar:
            paths = fetch(entry, folder, mirror, force, bar, bar.say)
        for path in paths:
            click.echo(path)


def _facts(entry: Any, folder: pathlib.Path) -> dict[str, Any]:
    paths = entry.paths(folder)
    here = all(path.exists() for path in paths)
    return {
        "name": entry.name,
        "set": entry.group,
        "bytes": entry.size or (sum(path.stat().st_size for path in paths) if here else None),
        "licence": entry.licence,
        "url": entry.url,
        "checksum": entry.checksum,
        "here": here,
        "path": str(paths[0] if len(paths) == 1 else paths[0].parent),
    }


def _size(count: int | None) -> str:
    return "" if count is None else f"{count / 1e6:.3g} MB" if count < 1e9 else f"{count / 1e9:.3g} GB"


class _Bar:
    """A progress bar on stderr with the interface that pooch wants; lines instead where that is no terminal."""

    def __init__(self, file: str, quiet: bool):
        self.file, self.quiet = file, quiet
        self.total = 0
        self._progress: Any = None
        self._task: Any = None

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def say(self, sentence: str) -> None:
        self.close()
        if not self.quiet:
            click.echo(sentence, err=True)

    def update(self, count: int) -> None:
        if self.quiet or not sys.stderr.isatty():
            return
        if self._progress is None:
            from rich.console import Console
            from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TransferSpeedColumn

            columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TransferSpeedColumn())
            self._progress = Progress(*columns, console=Console(stderr=True), transient=True)
            self._progress.start()
            self._task = self._progress.add_task(self.file, total=self.total or None)
        self._progress.update(self._task, advance=count)

    def reset(self) -> None:
        if self._progress is not None:
            self._progress.reset(self._task)

    def close(self) -> None:
        if self._progress is not None:
            self._progress.stop()
            self._progress = None

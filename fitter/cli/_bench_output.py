"""How `brdf bench` tells what it found: a plot, and text, the page of the docs or JSON."""

from __future__ import annotations

import dataclasses
import json
import pathlib
from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import click

from brdf.errors import UserError

from . import options


@runtime_checkable
class Report(Protocol):
    """A module that words what was found."""

    def data(self, found: Any) -> Any: ...
    def markdown(self, found: Any, plot: str | None) -> str: ...
    def text(self, found: Any) -> str: ...


@dataclasses.dataclass(frozen=True)
class Output:
    """The options of one run; raises `UserError` for those that exclude each other and for a file that exists."""

    plot: str | None
    markdown: bool
    as_json: bool
    force: bool

    def __post_init__(self) -> None:
        if self.markdown and self.as_json:
            raise UserError("`--markdown` and `--json` exclude each other. Leave one out.")
        options.check_output(self.plot, (".png", ".pdf", ".svg"), self.force)

    def tell(self, found: Any, report: Report, draw: Callable[[str], None]) -> None:
        """Draws the plot, if one is wanted, by its path, and prints the report."""
        if self.plot:
            draw(self.plot)
            click.echo(f"wrote {self.plot}", err=True)
        if self.as_json:
            click.echo(json.dumps(report.data(found), indent=2, allow_nan=False))
        elif self.markdown:
            click.echo(report.markdown(found, pathlib.Path(self.plot).name if self.plot else None).rstrip("\n"))
        else:
            click.echo(report.text(found))

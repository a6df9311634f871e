"""`brdf info`: what a file holds."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from . import options


@click.command(name="info")
@click.argument("file")
@click.option("--read", "read_options", multiple=True, metavar="NAME=VALUE", help="Option of the reader: cells=centre")
@click.option(
    "--channels", default="rgb", show_default=True, metavar="ORDER", help="Order of FILE's channels: bgr, ..."
)
@options.as_json
def command(file: str, read_options: tuple[str, ...], channels: str, as_json: bool) -> None:
    """Says what FILE holds: a measurement (samples, angles, values, what was left out) or a material.

    For a measurement it ends in what was found to be wrong or missing. A wrong order of channels cannot be seen in the
    numbers: if the colour looks wrong, try `--channels bgr`.

    \b
    Example:
      brdf info gold.binary
    """
    import json

    if pathlib.Path(file).suffix.lower() == ".json":
        from brdf.material import load_material

        facts: dict[str, Any] = load_material(file).to_dict()
    else:
        from ..formats import read
        from ..quality import reorder_channels
        from ..summary import summarise

        facts = summarise(reorder_channels(read(file, options.pairs(read_options, "--read")), channels))
    if as_json:
        click.echo(json.dumps(facts, indent=2))
        return
    findings = facts.pop("findings", [])
    click.echo("\n".join(_lines(facts, "")))
    for finding in findings:
        click.echo(f"{finding['name']}: {finding['sentence']}")


def _lines(value: Any, indent: str) -> list[str]:
    """A nested object as indented lines, one per entry; short lists on one line."""
    lines = []
    width = max((len(str(key)) for key in value), default=0)
    for key, entry in value.items():
        if isinstance(entry, dict) and entry:
            flat = all(not isinstance(part, dict | list) for part in entry.values())
            if flat and len(entry) <= 5:
                text = "  ".join(f"{name} {_text(part)}" for name, part in entry.items())
                lines.append(f"{indent}{key:{width}}  {text}")
            else:
                lines += [f"{indent}{key}", *_lines(entry, indent + "    ")]
        else:
            lines.append(f"{indent}{key:{width}}  {_text(entry)}")
    return lines


def _text(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(_text(part) for part in value)
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None or value == {} else str(value)

"""`brdf formats`: what can be read and written."""

from __future__ import annotations

import click


@click.command(name="formats")
def command() -> None:
    """Lists the measurement formats, their suffixes and the options of their readers (`--read NAME=VALUE`).

    \b
    Example:
      brdf formats
    """
    from ..formats import formats

    for one in formats():
        written = ", also written" if hasattr(one, "write") else ""
        click.echo(f"{' '.join(one.SUFFIXES):18} {one.NAME}: {one.DESCRIPTION}{written}")
        for name, allowed in one.OPTIONS.items():
            click.echo(f"{'':18}   --read {name}={'|'.join(allowed) if allowed else name.upper()}")

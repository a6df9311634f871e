"""`brdf models`: what can be fitted, from the models' declarations."""

from __future__ import annotations

import click

from . import options


@click.command(name="models")
@click.argument("name", required=False)
@click.option("--markdown", is_flag=True, help="Print the table of all models as Markdown, as in the README.")
@options.as_json
def command(name: str | None, markdown: bool, as_json: bool) -> None:
    """Lists the models, or shows the parameters, choices and sources of the model NAME.

    \b
    Example:
      brdf models ggx
    """
    import json

    from ..catalogue import describe, markdown_table, overview, page

    if as_json:
        click.echo(json.dumps(describe(name), indent=2))
    elif markdown:
        click.echo(markdown_table())
    else:
        click.echo(page(name) if name else overview())

"""`brdf models`: what can be fitted, from the models' declarations."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from . import options


@click.command(name="models")
@click.argument("name", required=False)
@click.option("--markdown", is_flag=True, help="Print the table of all models as Markdown, as in the README.")
@click.option("--pages", metavar="FOLDER", help="Write the pages of the docs: text and picture of every model.")
@options.as_json
@options.quiet
@options.force
def command(name: str | None, markdown: bool, pages: str | None, as_json: bool, quiet: bool, force: bool) -> None:
    """Lists the models, or shows the parameters, choices, claims and sources of the model NAME.

    \b
    Example:
      brdf models ggx
    """
    import json

    from brdf.errors import UserError

    if sum((markdown, as_json, pages is not None)) > 1:
        raise UserError("`--markdown`, `--json` and `--pages` exclude each other. Give one of them.")
    if name and (markdown or pages):
        raise UserError(f"`--{'markdown' if markdown else 'pages'}` is about all models. Leave `{name}` out.")

    from ..catalogue import describe, markdown_table, overview, page

    if as_json:
        click.echo(json.dumps(describe(name), indent=2))
    elif markdown:
        click.echo(markdown_table())
    elif pages:
        _write_pages(pathlib.Path(pages), quiet, force)
    else:
        click.echo(page(name) if name else overview())


def _write_pages(folder: pathlib.Path, quiet: bool, force: bool) -> None:
    from brdf.atomic import atomic_path, refuse_to_overwrite
    from brdf.registry import MODELS

    from ..pages import texts
    from ..portrait import draw, shown

    folder.mkdir(parents=True, exist_ok=True)
    found = texts()
    for file in (*found, *(f"{model}.png" for model in MODELS)):
        refuse_to_overwrite(folder / file, force)
    sphere = _sphere()
    options.cache_compilations()
    with options.progress(quiet) as say:
        for file, text in found.items():
            with atomic_path(folder / file, force) as temporary:
                temporary.write_text(text, encoding="utf-8")
        for name, model in MODELS.items():
            say(f"drawing {name}")
            draw(shown(name, model)[0], folder / f"{name}.png", sphere, force)
    click.echo(f"{folder}: {len(found)} pages and {len(MODELS)} pictures")


def _sphere() -> Any:
    """Renders a model on a sphere, or None, saying why, where there is no OpenGL 4.3."""
    import shaders

    found = shaders.describe()
    if not found["available"]:
        click.echo(f"brdf: spheres are left out: {found['problem']} `brdf doctor` says more.", err=True)
        return None
    studio = shaders.load_environment("studio")

    def sphere(model: Any, size: int) -> Any:
        scene = shaders.Scene((shaders.Part(model),), studio, width=size, height=size, samples=1056)
        return shaders.render(scene).display

    return sphere

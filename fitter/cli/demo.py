"""`brdf demo`: the whole road on an embedded sample."""

from __future__ import annotations

import pathlib

import click

from . import options

SAMPLE = pathlib.Path(__file__).parent.parent / "samples" / "copper_paint.csv"
MODEL = "lambert+ggx"


@click.command(name="demo")
@click.option("--output", "-o", default="demo", show_default=True, help="The folder to write to; it is created.")
@options.quiet
@options.force
@click.pass_context
def command(ctx: click.Context, output: str, quiet: bool, force: bool) -> None:
    """Fits the embedded sample and writes its material, report, plot and preview picture.

    The sample is synthetic: known parameters with 3 % noise, so that the report can be checked against the truth, which
    stands at the head of the file.

    \b
    Example:
      brdf demo -o demo
    """
    from brdf.atomic import atomic_path
    from brdf.errors import FileError

    from .fit import command as fit
    from .preview import command as preview

    folder = pathlib.Path(output)
    if folder.exists() and not folder.is_dir():
        raise FileError(output, "is a file.", "Name a folder.")
    names = {name: str(folder / name) for name in ("copper.json", "report.txt", "fit.png", "preview.png")}
    folder.mkdir(parents=True, exist_ok=True)
    for path in names.values():
        options.check_output(path, (".json", ".txt", ".png"), force)
    shared = {"quiet": quiet, "force": force}
    result = ctx.invoke(
        fit, data=(str(SAMPLE),), model=MODEL, output=names["copper.json"], plot=names["fit.png"], **shared
    )
    with atomic_path(names["report.txt"], force) as temporary:
        temporary.write_text(result.report() + "\n", encoding="utf-8")
    ctx.invoke(preview, material=names["copper.json"], output=names["preview.png"], **shared)
    click.echo(f"wrote {', '.join(names.values())}", err=True)

"""`brdf bench`: how fast is it, against named peers?"""

from __future__ import annotations

import os

import click

from . import options


@click.group(name="bench")
def command() -> None:
    """Measures speed on this machine against named peers.

    \b
    Example:
      brdf bench models ggx
    """


@command.command(name="models")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--dtype", type=click.Choice(["float64", "float32"]), default="float64", show_default=True)
@click.option(
    "--points", default=65536, show_default=True, type=click.IntRange(min=1), help="Pairs of directions per call."
)
@click.option("--rounds", default=7, show_default=True, type=click.IntRange(min=1), help="Their median counts.")
@click.option("--markdown", is_flag=True, help="Print the page of the docs.")
@options.as_json
@options.quiet
def models(
    names: tuple[str, ...], dtype: str, points: int, rounds: int, markdown: bool, as_json: bool, quiet: bool
) -> None:
    """Evaluations per second of models, with and without the gradient, on one core.

    Compares each NAME (a model or a sum), or all models, with the same formula in NumPy, and with Mitsuba 3 where it is
    installed and has the model.

    \b
    Example:
      brdf bench models ggx disney
    """
    import json

    from brdf.errors import UserError

    if markdown and as_json:
        raise UserError("`--markdown` and `--json` exclude each other. Leave one out.")
    one_core = _bind_to_one_core()

    from ..bench.report import data, text
    from ..bench.report import markdown as page
    from ..bench.run import bench

    options.cache_compilations()
    with options.progress(quiet) as say:
        found = bench(names, points, dtype, rounds, one_core, say)
    if as_json:
        click.echo(json.dumps(data(found), indent=2))
    else:
        click.echo(page(found).rstrip("\n") if markdown else text(found))


def _bind_to_one_core() -> bool:
    """Binds this process to one of its cores, before JAX starts a thread for each; False where that is not possible."""
    if not hasattr(os, "sched_setaffinity"):
        return False
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    return True

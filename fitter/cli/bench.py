"""`brdf bench`: how fast is it, against named peers?"""

from __future__ import annotations

import os

import click

from . import options
from ._bench_preview import preview

_SECTIONS = ("table", "slice", "scaling", "memory", "process", "many")


@click.group(name="bench")
def command() -> None:
    """Measures speed on this machine against named peers.

    \b
    Example:
      brdf bench fit --quick
    """


command.add_command(preview)


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


@command.command(name="fit")
@click.argument("data", required=False)
@click.option("--model", "-m", "names", multiple=True, help="Model to fit; the first one races against every peer.")
@click.option("--samples", type=click.IntRange(min=100), help="Of the synthetic table, about; MERL's size by default.")
@click.option("--rounds", default=3, show_default=True, type=click.IntRange(min=1), help="Their median counts.")
@click.option("--limit", default=180.0, show_default=True, help="CPU seconds after which a peer's run is stopped.")
@click.option("--materials", default=16, show_default=True, type=click.IntRange(min=1), help="Of the many fits.")
@click.option("--only", multiple=True, type=click.Choice(_SECTIONS), help="Measure only this; may be given again.")
@click.option("--quick", is_flag=True, help="One round on a table of 30,000 samples, 4 materials, 30 s per run.")
@click.option("--plot", help="Where to draw the cost over time (.png, .pdf or .svg).")
@click.option("--markdown", is_flag=True, help="Print the page of the docs.")
@options.as_json
@options.quiet
@options.force
def fit(
    data: str | None,
    names: tuple[str, ...],
    samples: int | None,
    rounds: int,
    limit: float,
    materials: int,
    only: tuple[str, ...],
    quick: bool,
    plot: str | None,
    markdown: bool,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Our fit against Optimistix, lmfit, scipy, Ceres and torch: same data, same loss, same final cost.

    Fits a full MERL table and a slice of it, and measures memory, the whole process, growth with the samples and many
    fits. DATA is a MERL .binary; without it the table is a synthetic material. Peers that are not installed are left
    out: pip install --group bench. A full run takes about an hour.

    \b
    Example:
      brdf bench fit --quick --only table --only slice
    """
    from brdf.errors import UserError

    from ._bench_output import Output

    output = Output(plot, markdown, as_json, force)
    if data is not None and samples is not None:
        raise UserError(f"`--samples {samples}` is the size of a synthetic table. Leave it or `{data}` out.")

    from ..bench import fit_report
    from ..bench.fit_run import MODELS, SECTIONS, Settings, bench

    if quick:
        samples, rounds, limit, materials = samples or (30_000 if data is None else None), 1, min(limit, 30.0), 4
    settings = Settings(data, names or MODELS, samples, rounds, limit, materials, only or SECTIONS)
    options.cache_compilations()
    with options.progress(quiet) as say:
        found = bench(settings, say)

    def draw(path: str) -> None:
        from ..bench.fit_plot import plot

        plot(found.races, path, force)

    output.tell(found, fit_report, draw)


def _bind_to_one_core() -> bool:
    """Binds this process to one of its cores, before JAX starts a thread for each; False where that is not possible."""
    if not hasattr(os, "sched_setaffinity"):
        return False
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    return True

"""`brdf bench preview`: the preview's run time against its error."""

from __future__ import annotations

import click

from . import options

SECTIONS = ("tier", "truth", "furnace", "tables", "start")
_MATERIALS = ("metal", "dielectric")
# Frames are short: more of them are timed.
_FRAMES_PER_ROUND = 3


@click.command(name="preview")
@click.option(
    "--environment",
    "-e",
    "environments",
    multiple=True,
    help="Light: built-in or a file; may be given again.  [clear_sky, studio]",
)
@click.option("--material", "materials", multiple=True, type=click.Choice(_MATERIALS), help="[both]")
@click.option("--roughness", multiple=True, type=click.FloatRange(0.02, 1), help="May be given again.  [.1, .3, .6, 1]")
@click.option("--size", default=128, show_default=True, type=click.IntRange(16), help="Pixels a side, compared.")
@click.option("--timed-size", default=512, show_default=True, type=click.IntRange(16), help="Pixels a side, timed.")
@click.option("--rounds", default=5, show_default=True, type=click.IntRange(1), help="Their median counts.")
@click.option("--error", default=0.002, show_default=True, help="At which the truth itself stops.")
@click.option("--seconds", default=20.0, show_default=True, help="After which it stops, converged or not.")
@click.option("--samples-max", default=2048, show_default=True, type=click.IntRange(32), help="Of the truth's curve.")
@click.option("--only", multiple=True, type=click.Choice(SECTIONS), help="Measure only this; may be given again.")
@click.option("--plot", help="Where to draw run time against error (.png, .pdf or .svg).")
@click.option("--markdown", is_flag=True, help="Print the page of the docs.")
@options.as_json
@options.quiet
@options.force
def preview(
    environments: tuple[str, ...],
    materials: tuple[str, ...],
    roughness: tuple[float, ...],
    size: int,
    timed_size: int,
    rounds: int,
    error: float,
    seconds: float,
    samples_max: int,
    only: tuple[str, ...],
    plot: str | None,
    markdown: bool,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Run time against error of the preview's tiers, by model, roughness and environment.

    Races the interactive tier with the split sum of the textbooks, and the blurred environments with filtered
    importance sampling; shows how the truth converges, the furnace, and the time from a cold start. Needs OpenGL 4.3
    and, for tier and truth, pip install flip-evaluator. A full run takes about a quarter of an hour.

    \b
    Example:
      brdf bench preview --only tier --environment studio --roughness 0.3
    """
    from brdf.errors import UserError

    from ._bench_output import Output

    output = Output(plot, markdown, as_json, force)
    sections = only or SECTIONS
    if plot is not None and not {"tier", "truth"} & set(sections):
        raise UserError(f"`--plot {plot}` draws the tiers, which `--only {sections[0]}` leaves out. Leave one out.")

    from shaders.bench.case import ROUGHNESS
    from shaders.bench.pictures import PictureSettings

    from . import _bench_preview_report as report
    from ._bench_preview_run import measure

    samples = (
        tuple(2 * 4**power for power in range(2, 10) if 2 * 4**power <= samples_max) if "truth" in sections else ()
    )
    names, steps = environments or ("clear_sky", "studio"), roughness or ROUGHNESS
    settings = PictureSettings(
        names, materials or _MATERIALS, steps, size, timed_size, _FRAMES_PER_ROUND * rounds, samples, error, seconds
    )
    with options.progress(quiet) as say:
        found = measure(settings, rounds, sections, say)

    def draw(path: str) -> None:
        from ._bench_preview_plot import plot

        plot(found.pictures, path, force)

    output.tell(found, report, draw)

"""`brdf preview`: a material on a lit sphere."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING, Any

import click

from . import options

if TYPE_CHECKING:
    from shaders import Image, Scene

_TIERS = ("interactive", "still", "truth")


@click.command(name="preview")
@click.argument("material")
@click.option("--output", "-o", required=True, help="The picture: .png for displays, .exr for linear values.")
@click.option(
    "--environment",
    "-e",
    default="studio",
    show_default=True,
    help="studio, clear_sky, overcast, night, furnace, or an .hdr/.exr file.",
)
@click.option(
    "--rotate-deg", default=0.0, show_default=True, help="Turns the environment about +y, counter-clockwise from above."
)
@click.option("--exposure", default=0.0, show_default=True, help="In stops: +1 is twice as bright.")
@click.option("--size", default="512x512", show_default=True, metavar="WxH", help="Size in pixels.")
@click.option(
    "--tier",
    type=click.Choice(_TIERS),
    default="interactive",
    show_default=True,
    help="How light is gathered: interactive looks it up at once, still is a few samples, truth converges.",
)
@click.option(
    "--error", default=None, type=float, help="truth: stops at this RMS error of the picture, white being 1.  [0.005]"
)
@click.option("--seconds", default=None, type=float, help="truth: stops after this time, converged or not.")
@click.option(
    "--samples",
    default=None,
    type=int,
    help="Directions of light per pixel; with --error or --seconds, the most, else as many, and no error is told.",
)
@click.option(
    "--sky",
    type=click.Choice(["sharp", "blurred", "none"]),
    default="sharp",
    show_default=True,
    help="How the environment is seen behind; none leaves it transparent.",
)
@click.option("--stats", is_flag=True, help="Prints what was done: passes, draws, uploads, times.")
@click.option("--graph", default=None, metavar="FILE.svg", help="Draws the passes and what became of each.")
@click.option("--read", "read_options", multiple=True, metavar="NAME=VALUE", help="Option of the reader: cells=centre")
@options.as_json
@options.quiet
@options.force
def command(
    material: str,
    output: str,
    environment: str,
    rotate_deg: float,
    exposure: float,
    size: str,
    tier: Any,
    error: float | None,
    seconds: float | None,
    samples: int | None,
    sky: Any,
    stats: bool,
    graph: str | None,
    read_options: tuple[str, ...],
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Renders a sphere of MATERIAL, lit by an environment, through OpenGL.

    MATERIAL is a material (.json), or a measurement itself: MERL, RGL, or another format that defines values between
    its samples, if it is isotropic.

    The camera looks along -z, with +y up; it sees the centre of the environment's picture behind the sphere. A PNG is
    tone-mapped (Khronos PBR Neutral) and sRGB-encoded, an EXR is linear Rec. 709.

    \b
    Example:
      brdf preview gold.json --environment studio.hdr -o gold.png
      brdf preview gold.json --tier truth --error 0.001 --seconds 60 --stats -o gold.png
    """
    import json
    import math
    import os

    # The matrices of a material's fit are small: more threads for them wait long where others are at work. Read when
    # NumPy is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

    from brdf.errors import UserError

    options.check_output(output, (".png", ".exr"), force)
    options.check_output(graph, (".svg",), force)
    if stats and as_json:
        raise click.UsageError("--json holds the statistics already. Leave --stats out.")
    for name, value in (("--error", error), ("--seconds", seconds)):
        if value is not None and tier != "truth":
            raise click.UsageError(
                f"{name} {value:g} needs --tier truth, the only one that goes on until it is reached; "
                f"this is --tier {tier}. Leave {name} out or change the tier."
            )
    width, height = _size(size)
    if not math.isfinite(rotate_deg):
        raise UserError(f"`--rotate-deg {rotate_deg}` is not an angle. Give degrees, such as 90.")
    # Until there is a picture to write, nothing needs to be cleaned up.
    with options.progress(quiet) as say, options.leaving_at_once():
        say(f"rendering {material}")

        import shaders

        from ._measured import material_of

        scene = shaders.Scene(
            parts=(shaders.Part(material_of(material, options.pairs(read_options, "--read"))),),
            environment=shaders.load_environment(environment),
            rotation=math.radians(rotate_deg),
            exposure=exposure,
            width=width,
            height=height,
            tier=tier,
            error=error,
            seconds=seconds,
            samples=samples,
            sky=sky,
            tone_map="none" if pathlib.Path(output).suffix.lower() == ".exr" else "neutral",
        )
        image = shaders.render(scene)
    _write(image, output, graph, force)
    facts = _facts(scene, image, output)
    if as_json:
        click.echo(json.dumps(facts, indent=2))
        return
    if facts["clamped"]:
        click.echo(f"brdf: {environment}: {facts['clamped']} values were negative or not finite: clamped.", err=True)
    click.echo(
        f"{output}: {width}x{height}, environment {facts['environment']}, rotation {rotate_deg:g} deg, exposure "
        f"{exposure:+g}, tone map {facts['tone_map']}, {facts['renderer']}, {_quality(image.counts)}"
    )
    if stats:
        from ._preview_stats import stats_text

        click.echo(stats_text(image.counts))


def _size(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) > 2 or not all(part.isdigit() and 0 < len(part) < 6 for part in parts):
        raise click.BadParameter(f"`{text}` is not a size. Write 512x512, or 512 for a square.", param_hint="--size")
    return int(parts[0]), int(parts[-1])


def _write(image: Image, output: str, graph: str | None, force: bool) -> None:
    import shaders
    from brdf.atomic import atomic_path

    with atomic_path(output, force) as temporary:
        if image.display is None:
            shaders.write_exr(temporary, image.pixels)
        else:
            shaders.write_png(temporary, image.display)
    if graph is not None:
        with atomic_path(graph, force) as temporary:
            temporary.write_text(shaders.plan_svg(image.plan, image.counts["milliseconds"]), encoding="utf-8")


def _facts(scene: Scene, image: Image, output: str) -> dict[str, Any]:
    return {
        "picture": output,
        "environment": scene.environment.name,
        "clamped": scene.environment.clamped,
        "tone_map": scene.tone_map,
        "renderer": image.renderer,
        "counts": image.counts,
    }


def _quality(counts: dict[str, Any]) -> str:
    """How good the picture is, and how long it took."""
    error = "" if counts["error"] is None else f", error {counts['error']:.2g}"
    return f"{counts['samples']} samples{error}, {counts['seconds']:.2f} s"

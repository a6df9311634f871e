"""`brdf preview`: a material on a lit sphere."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from . import options


@click.command(name="preview")
@click.argument("material")
@click.option("--output", "-o", required=True, help="The picture: .png for displays, .exr for linear values.")
@click.option("--environment", "-e", default="studio", show_default=True, help="studio, furnace, or an .hdr/.exr file.")
@click.option(
    "--rotate-deg", default=0.0, show_default=True, help="Turns the environment about +y, counter-clockwise from above."
)
@click.option("--exposure", default=0.0, show_default=True, help="In stops: +1 is twice as bright.")
@click.option("--size", default="512x512", show_default=True, metavar="WxH", help="Size in pixels.")
@click.option("--samples", default=None, type=int, help="Directions of light per pixel; more is smoother and slower.")
@click.option("--sky/--no-sky", default=True, show_default=True, help="Whether the environment is seen behind.")
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
    samples: int | None,
    sky: bool,
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
    """
    import json

    options.check_output(output, (".png", ".exr"), force)
    width, height = _size(size)
    with options.progress(quiet) as say:
        say(f"rendering {material}")
        chosen = options.pairs(read_options, "--read")
        facts = _render(material, chosen, output, environment, rotate_deg, exposure, width, height, samples, sky, force)
    if as_json:
        click.echo(json.dumps(facts, indent=2))
    else:
        if facts["clamped"]:
            click.echo(
                f"brdf: {environment}: {facts['clamped']} values were negative or not finite: clamped.", err=True
            )
        click.echo(
            f"{output}: {width}x{height}, environment {facts['environment']}, rotation {rotate_deg:g} deg, exposure "
            f"{exposure:+g}, tone map {facts['tone_map']}, {facts['renderer']}, {facts['counts']['seconds']:.2f} s"
        )


def _size(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) > 2 or not all(part.isdigit() and 0 < len(part) < 6 for part in parts):
        raise click.BadParameter(f"`{text}` is not a size. Write 512x512, or 512 for a square.", param_hint="--size")
    return int(parts[0]), int(parts[-1])


def _render(
    material: str,
    read_options: dict[str, str],
    output: str,
    environment: str,
    rotate_deg: float,
    exposure: float,
    width: int,
    height: int,
    samples: int | None,
    sky: bool,
    force: bool,
) -> dict[str, Any]:
    import dataclasses
    import math

    from brdf.errors import UserError

    if not math.isfinite(rotate_deg):
        raise UserError(f"`--rotate-deg {rotate_deg}` is not an angle. Give degrees, such as 90.")

    import shaders
    from brdf.atomic import atomic_path

    from ._measured import material_of

    is_linear = pathlib.Path(output).suffix.lower() == ".exr"
    part = shaders.Part(material_of(material, read_options))
    light = shaders.load_environment(environment)
    scene = shaders.Scene(
        parts=(part,),
        environment=light,
        rotation=math.radians(rotate_deg),
        exposure=exposure,
        width=width,
        height=height,
        sky=sky,
        tone_map="none" if is_linear else "neutral",
    )
    if samples is not None:
        scene = dataclasses.replace(scene, samples=samples)
    image = shaders.render(scene)
    with atomic_path(output, force) as temporary:
        if image.display is None:
            shaders.write_exr(temporary, image.pixels)
        else:
            shaders.write_png(temporary, image.display)
    return {
        "picture": output,
        "environment": light.name,
        "clamped": light.clamped,
        "tone_map": scene.tone_map,
        "renderer": image.renderer,
        "counts": image.counts,
    }

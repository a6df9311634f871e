"""`brdf sheet`: contact sheets of rendered models and fits."""

from __future__ import annotations

import pathlib
import tempfile
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from . import options

if TYPE_CHECKING:
    import numpy as np

    from brdf.model import AbstractBRDF
    from shaders.twin import Twin

    from ..contact_sheet import Row, Tile

    # A material -> linear picture with coverage, and the same for displays.
    Render = Callable[[AbstractBRDF | Twin], tuple[np.ndarray, np.ndarray]]

_ROUGHNESS = ("alpha", "roughness", "specular_roughness", "exponent", "sigma")
_SLOPES = (0.03, 0.1, 0.2, 0.35, 0.6, 1.0)
# What lies around the sphere, encoded.
_GROUND = 0.42
# Delta E ITP that is drawn in the brightest colour; a difference of 1 is just noticeable.
_WORST = 100.0

_size = click.option(
    "--tile", default=160, show_default=True, type=click.IntRange(32, 512), help="Pixels a side of one picture."
)
_tier = click.option(
    "--tier",
    type=click.Choice(["interactive", "still", "truth"]),
    default="interactive",
    show_default=True,
    help="How light is gathered, as in `brdf preview`.",
)
_environment = click.option(
    "--environment",
    "-e",
    default="studio",
    show_default=True,
    help="The light: a built-in environment or an .hdr/.exr file.",
)
_output = click.option("--output", "-o", required=True, help="The picture (.png).")


@click.group(name="sheet")
def command() -> None:
    """Draws contact sheets: many small spheres on one picture, under the same light and exposure.

    \b
    Example:
      brdf sheet models -o models.png
    """


@command.command(name="models")
@_output
@_environment
@_size
@_tier
@options.quiet
@options.force
def models(output: str, environment: str, tile: int, tier: Any, quiet: bool, force: bool) -> None:
    """Every model that has a roughness, from sharp to rough.

    Each column stands for a slope, which each model's own parameter is set to; it is named on the left, its value below
    each sphere.

    \b
    Example:
      brdf sheet models -o models.png
    """
    import dataclasses

    from brdf.parameter import parameters
    from brdf.registry import MODELS

    from ..contact_sheet import Row, Tile
    from ..portrait import shown

    options.check_output(output, (".png",), force)
    render = _renderer(environment, tile, tier)
    rows = []
    with options.progress(quiet) as say:
        for name, model in MODELS.items():
            found = {one.name: one for one in parameters(model)}
            rough = next((one for one in _ROUGHNESS if one in found), None)
            if rough is None:
                continue
            say(f"rendering {name}")
            base, _ = shown(name, model)
            tiles = []
            for slope in _SLOPES:
                value = min(max(_from_slope(rough, slope), found[rough].lower), found[rough].upper)
                _, display = render(dataclasses.replace(base, **{rough: value}))
                tiles.append(Tile(display, (f"{value:.3g}" if value < 1000 else f"{value:.0f}",)))
            rows.append(Row((name, rough), tuple(tiles)))
        slopes = ", ".join(f"{slope:g}" for slope in _SLOPES)
        _save(f"Slopes {slopes}, lit by `{environment}`", rows, tile, output, force)


@command.command(name="fits")
@click.argument("data", nargs=-1, required=True)
@_output
@click.option("--model", "-m", "names", multiple=True, help="A model or sum; all registered models by default.")
@click.option("--keep", help="A folder for the fitted materials: what it holds already is not fitted again.")
@click.option("--columns", default=6, show_default=True, type=click.IntRange(min=1), help="Fits side by side.")
@_environment
@_size
@_tier
@options.quiet
@options.force
def fits(
    data: tuple[str, ...],
    output: str,
    names: tuple[str, ...],
    keep: str | None,
    columns: int,
    environment: str,
    tile: int,
    tier: Any,
    quiet: bool,
    force: bool,
) -> None:
    """Measurements beside the models fitted to them, and below each fit where it looks different.

    On the left of every row the measurement DATA itself; below each fit its colour difference (Delta E ITP).

    \b
    Example:
      brdf sheet fits gold.binary -m ggx -m lambert+ggx -o fits.png
    """
    from brdf.registry import MODELS

    from ..formats import read
    from ._measured import tabulated
    from ._sheet_fits import fits as made

    options.check_output(output, (".png",), force)
    render = _renderer(environment, tile, tier)
    options.cache_compilations()
    rows: list[Row] = []
    with options.progress(quiet) as say, tempfile.TemporaryDirectory() as temporary:
        for path in data:
            measured = read(path)
            label = pathlib.Path(path).stem
            truth = render(tabulated(measured).twin)
            pairs = []
            for one in made(measured, names or tuple(MODELS), pathlib.Path(keep or temporary) / label, say):
                say(f"rendering {one.model}")
                pairs.append(_compared(f"{one.model}", f"log error {one.log_mae:.4f}", truth[0], *render(one.brdf)))
            rows += _rows(measured.source, truth[1], pairs, columns)
        title = f"Fits, lit by `{environment}`, and their colour difference (Delta E ITP, black 0 to light {_WORST:g})"
        _save(title, rows, tile, output, force)


def _from_slope(name: str, slope: float) -> float:
    """A model's own measure of a slope: Disney's roughness is its root, Blinn's exponent 2 / alpha^2 - 2."""
    if name.endswith("roughness"):
        return slope**0.5
    return 2 / slope**2 - 2 if name == "exponent" else slope


def _renderer(environment: str, size: int, tier: Any) -> Render:
    import shaders

    light = shaders.load_environment(environment)

    def render(material: AbstractBRDF | Twin) -> tuple[np.ndarray, np.ndarray]:
        image = shaders.render(
            shaders.Scene((shaders.Part(material),), light, width=size, height=size, sky="none", tier=tier)
        )
        assert image.display is not None
        coverage = image.display[..., 3:]
        return image.pixels, image.display[..., :3] * coverage + _GROUND * (1 - coverage)

    return render


def _compared(model: str, error: str, truth: np.ndarray, linear: np.ndarray, display: np.ndarray) -> tuple[Tile, Tile]:
    """The picture of a fit, and where it differs from the measurement's."""
    import matplotlib
    import numpy as np

    from ..contact_sheet import Tile
    from ..judge import WHITE, delta_e_itp

    inside = truth[..., 3] > 0
    # The preview shows 1 as the display's white.
    a, b = (np.clip(WHITE * one[..., :3], 0, 10 * WHITE) for one in (truth, linear))
    difference = delta_e_itp(a.astype(np.float64), b.astype(np.float64))
    colours = matplotlib.colormaps["magma"](np.clip(difference / _WORST, 0, 1))[..., :3]
    colours[~inside] = _GROUND
    mean = f"Delta E {difference[inside].mean():.1f}"
    return Tile(display, (model, error)), Tile(colours, (mean,))


def _rows(source: str, truth: np.ndarray, pairs: list[tuple[Tile, Tile]], columns: int) -> list[Row]:
    from ..contact_sheet import Row, Tile

    rows = []
    for start in range(0, len(pairs), columns):
        part = pairs[start : start + columns]
        heading = source if start == 0 else ""
        rows.append(Row((), (Tile(truth, ("measured",)), *(one[0] for one in part)), heading))
        rows.append(Row((), (Tile(None), *(one[1] for one in part))))
    return rows


def _save(title: str, rows: list[Any], tile: int, output: str, force: bool) -> None:
    from brdf.atomic import atomic_path

    from ..contact_sheet import contact_sheet

    with atomic_path(output, force) as temporary:
        contact_sheet(title, rows, tile).save(temporary, format="PNG", optimize=True)
    click.echo(f"wrote {output}", err=True)

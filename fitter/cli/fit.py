"""`brdf fit`: measurements in, materials out."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from . import options
from ._fit_each import fit_each

if TYPE_CHECKING:
    from ..reflectance import Reflectance
    from ..result import FitResult


@click.command(name="fit")
@click.argument("data", nargs=-1, required=True)
@click.option("--model", "-m", help="The model, such as lambert+ggx, or auto; `brdf models` lists them.")
@click.option("--models", metavar="A,B,C", help="Compare these on held-out angles and take the best.")
@click.option("--output", "-o", help="Where to write the material (.json); a folder for several DATA.")
@click.option(
    "--fix", multiple=True, metavar="NAME=VALUE", help="Hold a parameter or choice: alpha=0.2, ggx.f0=1,.9,.8"
)
@click.option("--tie", multiple=True, metavar="NAME=NAME", help="Keep two parameters equal: alpha_x=alpha_y")
@click.option("--bound", multiple=True, metavar="NAME=LOW:HIGH", help="Narrow a parameter's range: alpha=0.01:0.3")
@click.option("--free", multiple=True, metavar="NAME", help="Fit a parameter that is held by default: metallic")
@click.option("--start", multiple=True, metavar="MATERIAL|NAME=VALUE", help="Start from a material, or from values.")
@click.option("--search", metavar="CHOICE,...", help="Try all options of static choices: masking,fresnel")
@click.option("--loss", default="log", show_default=True, help="What is minimised; adaptive tries several.")
@click.option(
    "--weights", default="samples", show_default=True, help="What samples count: samples, grid, solid_angle or sigma."
)
@click.option("--max-theta-deg", default=80.0, show_default=True, help="Leave out samples from this polar angle on.")
@click.option("--advise", is_flag=True, help="Say which further scans would help most.")
@click.option("--read", "read_options", multiple=True, metavar="NAME=VALUE", help="Option of the reader: cells=centre")
@click.option(
    "--channels", default="rgb", show_default=True, metavar="ORDER", help="Order of DATA's channels: bgr, ..."
)
@click.option("--plot", help="Where to draw measured, fitted and residual slices and lobes (.png, .pdf or .svg).")
@click.option("--workers", type=click.IntRange(min=1), help="Processes for several DATA; one per core by default.")
@options.as_json
@options.quiet
@options.force
@click.pass_context
def command(
    ctx: click.Context,
    data: tuple[str, ...],
    model: str | None,
    models: str | None,
    output: str | None,
    fix: tuple[str, ...],
    tie: tuple[str, ...],
    bound: tuple[str, ...],
    free: tuple[str, ...],
    start: tuple[str, ...],
    search: str | None,
    loss: str,
    weights: str,
    max_theta_deg: float,
    advise: bool,
    read_options: tuple[str, ...],
    channels: str,
    plot: str | None,
    workers: int | None,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> FitResult | None:
    """Fits a model to the measurement DATA and prints parameters with standard errors.

    DATA is a measurement of any supported format (`brdf formats` lists them); `slices.npz:brass` is one member of an
    npz, `slices.npz:*` all of them. Several DATA are fitted side by side into the folder that -o names; what is there
    already is kept, so that an interrupted run continues.

    \b
    Example:
      brdf fit gold.binary --model lambert+ggx -o gold.json --plot gold-fit.png
      brdf fit *.binary --model auto -o fits/
    """
    from brdf.errors import UserError

    wanted = _model(model, models)
    shared: dict[str, Any] = {
        "fixed": {name: options.value(text) for name, text in options.pairs(fix, "--fix").items()},
        "loss": loss,
        "weights": weights,
        "max_theta_deg": max_theta_deg,
    }
    compared = wanted == "auto" or "," in wanted or search is not None
    alone = {
        "tied": options.pairs(tie, "--tie"),
        "bounds": _bounds(bound),
        "free": free,
        "start": _start(start),
        "advice": advise,
    }
    given = [
        f"--{name}"
        for name, value in zip(("tie", "bound", "free", "start", "advise"), alone.values(), strict=True)
        if value
    ]
    if compared and given:
        raise UserError(f"{given[0]} is for one model. Leave it out, or name one model with --model.")
    if not compared:
        shared |= alone
    chosen = options.pairs(read_options, "--read")
    first = next(iter(data))
    if len(data) > 1 or first.endswith(":*") or (output is not None and os.path.isdir(output)):
        if plot or search or channels != "rgb":
            raise UserError("--plot, --search and --channels are for one DATA. Leave them out, or fit one by one.")
        fit_each(ctx, data, wanted, output, chosen, workers, force, shared, as_json, quiet)
        return None
    options.check_output(output, (".json",), force)
    options.check_output(plot, (".png", ".pdf", ".svg"), force)
    with options.progress(quiet) as say:
        say(f"reading {first}")
        from ..formats import read

        measured = read(first, chosen)
        if channels != "rgb":
            from ..quality import reorder_channels

            measured = reorder_channels(measured, channels)
        say("loading JAX")
        options.cache_compilations()
        result, table = _fit(measured, wanted, search, compared, shared, say)
        if output:
            from brdf.material import save_material

            save_material(result.material, output, force=force)
        if plot:
            say(f"drawing {plot}")
            from ..plot import plot_fit

            plot_fit(result, plot, force=force)
        say("judging the picture")
        text = _json(result, table) if as_json else "\n".join(filter(None, (table and table.report(), result.report())))
    click.echo(text)
    if not as_json:
        for path in filter(None, (output, plot)):
            click.echo(f"wrote {path}", err=True)
    if not result.converged:
        ctx.exit(1)
    return result


def _model(model: str | None, models: str | None) -> str:
    from brdf.errors import UserError

    if (model is None) == (models is None):
        raise UserError(
            "Name a model with --model, such as `--model lambert+ggx` or `--model auto`; or several with "
            "--models, but not both."
        )
    if model is not None and "," in model:
        raise UserError(f"`--model {model}` names several. Write `--models {model}`.")
    return model or str(models)


def _bounds(texts: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    from brdf.errors import UserError

    found = {}
    for name, span in options.pairs(texts, "--bound").items():
        low, _, high = span.partition(":")
        try:
            found[name] = (float(low), float(high))
        except ValueError:
            raise UserError(f"`--bound {name}={span}` is no range. Write `--bound {name}=LOW:HIGH`.") from None
    return found


def _start(texts: tuple[str, ...]) -> Any:
    from brdf.errors import UserError

    materials = [text for text in texts if "=" not in text]
    if materials and len(texts) > 1:
        raise UserError("A material gives every start: leave the other `--start` out.")
    if materials:
        return materials[0]
    return {name: options.value(text) for name, text in options.pairs(texts, "--start").items()}


def _fit(
    measured: Reflectance, wanted: str, search: str | None, compared: bool, shared: dict[str, Any], say: Any
) -> tuple[FitResult, Any]:
    """The fit, and the table of models if there were several."""
    if not compared:
        from ..fitting import fit

        return fit(wanted, measured, progress=say, **shared), None
    from ..select import AUTO, select

    models: Any = AUTO if wanted == AUTO else wanted.split(",")
    if search is not None:
        from brdf.errors import UserError

        from ..search import searched

        if models == AUTO:
            raise UserError("--search needs a model: it tries the options of its static choices.")
        models = [variant for one in models for variant in searched(one, search.split(","))]
    table = select(measured, models, progress=say, **shared)
    return table.result, table


def _json(result: FitResult, table: Any) -> str:
    import json

    found = result.to_dict()
    if table is not None:
        found["selection"] = table.to_dict()
    return json.dumps(found, indent=2, allow_nan=False)

"""`brdf fit`: a measurement in, a material out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from . import options

if TYPE_CHECKING:
    from ..result import FitResult


@click.command(name="fit")
@click.argument("data")
@click.option("--model", "-m", required=True, help="The model, such as lambert+ggx; `brdf models` lists them.")
@click.option("--output", "-o", help="Where to write the material (.json).")
@click.option(
    "--fix", multiple=True, metavar="NAME=VALUE", help="Hold a parameter or choice: alpha=0.2, ggx.f0=1,.9,.8"
)
@click.option("--loss", default="log", show_default=True, help="What is minimised: log or log_squares.")
@click.option("--max-theta-deg", default=80.0, show_default=True, help="Leave out samples from this polar angle on.")
@click.option("--read", "read_options", multiple=True, metavar="NAME=VALUE", help="Option of the reader: cells=centre")
@click.option("--plot", help="Where to draw measured, fitted and residual slices and lobes (.png, .pdf or .svg).")
@options.as_json
@options.quiet
@options.force
@click.pass_context
def command(
    ctx: click.Context,
    data: str,
    model: str,
    output: str | None,
    fix: tuple[str, ...],
    loss: str,
    max_theta_deg: float,
    read_options: tuple[str, ...],
    plot: str | None,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> FitResult:
    """Fits a model to the measurement DATA and prints parameters with standard errors.

    DATA is a MERL .binary, RGL .bsdf, .csv or .npz file; `slices.npz:brass` is one member of an npz.

    \b
    Example:
      brdf fit gold.binary --model lambert+ggx -o gold.json --plot gold-fit.png
    """
    options.check_output(output, (".json",), force)
    options.check_output(plot, (".png", ".pdf", ".svg"), force)
    fixed = {name: _value(text) for name, text in options.pairs(fix, "--fix").items()}
    chosen = options.pairs(read_options, "--read")
    with options.progress(quiet) as say:
        say(f"reading {data}")
        from ..formats import read

        measured = read(data, chosen)
        say("loading JAX")
        options.cache_compilations()
        from ..fitting import fit

        result = fit(model, measured, fixed=fixed, loss=loss, max_theta_deg=max_theta_deg, progress=say)
        if output:
            from brdf.material import save_material

            save_material(result.material, output, force=force)
        if plot:
            say(f"drawing {plot}")
            from ..plot import plot_fit

            plot_fit(result, plot, force=force)
    if as_json:
        import json

        click.echo(json.dumps(result.to_dict(), indent=2, allow_nan=False))
    else:
        click.echo(result.report())
        for path in filter(None, (output, plot)):
            click.echo(f"wrote {path}", err=True)
    if not result.converged:
        ctx.exit(1)
    return result


def _value(text: str) -> Any:
    """A number, a list of numbers, or the text itself."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers

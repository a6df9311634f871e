"""`brdf evaluate`: a material or a measurement at given directions."""

from __future__ import annotations

import pathlib

import click

from . import options


@click.command(name="evaluate")
@click.argument("source")
@click.option("--directions", "-d", required=True, help="An .npz with `wi` and `wo`, (n, 3), unit, normal +z.")
@click.option("--output", "-o", required=True, help="Where to write `wi`, `wo` and `value` (.npz).")
@click.option("--gpu", is_flag=True, help="Evaluate a material in GLSL, float32, instead of JAX, float64.")
@click.option("--read", "read_options", multiple=True, metavar="NAME=VALUE", help="Option of the reader: cells=centre")
@options.quiet
@options.force
def command(
    source: str, directions: str, output: str, gpu: bool, read_options: tuple[str, ...], quiet: bool, force: bool
) -> None:
    """Evaluates SOURCE at pairs of directions: 1/sr, without the cosine.

    SOURCE is a material (.json), or a measurement, which is interpolated as its format defines; `wi` is to the light.

    \b
    Example:
      brdf evaluate gold.json --directions dirs.npz -o values.npz
    """
    import numpy as np

    from brdf.errors import UserError

    from ..directions import load_directions, save_values

    options.check_output(output, (".npz",), force)
    is_material = pathlib.Path(source).suffix.lower() == ".json"
    if gpu and not is_material:
        raise UserError(f"`--gpu` evaluates a material, and `{source}` is a measurement. Leave `--gpu` out.")
    if read_options and is_material:
        raise UserError(f"`--read` is for measurements, and `{source}` is a material. Leave `--read` out.")
    with options.progress(quiet) as say:
        wi, wo = load_directions(directions)
        say(f"evaluating {len(wi)} pairs of directions")
        if not is_material:
            from ..formats import read

            value = read(source, options.pairs(read_options, "--read")).evaluate(wi, wo)
        elif gpu:
            from brdf.material import load_material
            from shaders.evaluation import evaluate as evaluate_glsl

            value = evaluate_glsl(load_material(source).brdf, wi, wo)
        else:
            options.cache_compilations()
            import jax

            from brdf.material import load_material
            from brdf.model import evaluate

            with jax.enable_x64(True):
                value = np.asarray(evaluate(load_material(source).brdf, wi, wo))
        save_values(output, wi, wo, value, force)
    holes = int(np.isnan(value).any(axis=1).sum())
    if holes:
        click.echo(f"brdf: {holes} of {len(value)} values are NaN: the file has no valid cell around them.", err=True)
    click.echo(f"wrote {output}", err=True)

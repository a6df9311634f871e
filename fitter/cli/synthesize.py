"""`brdf synthesize`: a known material in, a measurement out."""

from __future__ import annotations

import pathlib

import click

from . import options

# The only layout that such a file can hold; text holds any.
_LAYOUT = {".binary": "merl", ".npz": "slice"}
_TEXT = (".csv", ".tsv")


@click.command(name="synthesize")
@click.argument("model")
@click.option("--output", "-o", required=True, help="The measurement: .csv for any layout, .binary for merl.")
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="A parameter or choice: alpha=0.2, ggx.f0=1,.9,.8"
)
@click.option("--layout", help="Where to measure: random, merl, slice, plane or goniometer.  [default: by the output]")
@click.option("--samples", type=int, help="How many.  [default: 20000 for random, all for the others]")
@click.option("--noise", default=0.0, show_default=True, help="Standard deviation of the noise: 0.05 is 5 %.")
@click.option("--noise-kind", default="multiplicative", show_default=True, help="multiplicative, or additive in 1/sr.")
@click.option("--seed", default=0, show_default=True, help="The same seed gives the same measurement.")
@click.option("--truth", help="Where to write the material itself (.json), to compare a fit with.")
@options.as_json
@options.quiet
@options.force
def command(
    model: str,
    output: str,
    settings: tuple[str, ...],
    layout: str | None,
    samples: int | None,
    noise: float,
    noise_kind: str,
    seed: int,
    truth: str | None,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Measures MODEL as an instrument would, with noise, and writes the measurement.

    MODEL is an expression such as lambert+ggx, or a material (.json). A .csv tells the truth in its first line.

    \b
    Example:
      brdf synthesize lambert+ggx --set ggx.alpha=0.2 --noise 0.05 -o samples.csv
    """
    import json

    from brdf.errors import UserError

    from ..formats import Writable, formats

    writers = [format for format in formats() if isinstance(format, Writable)]
    writable = {suffix for format in writers for suffix in format.SUFFIXES}
    suffixes = tuple(suffix for suffix in (*_TEXT, *_LAYOUT) if suffix in writable)
    options.check_output(output, suffixes, force)
    options.check_output(truth, (".json",), force)
    needed = _LAYOUT.get(pathlib.Path(output).suffix.lower(), layout or "random")
    if layout not in (None, needed):
        raise UserError(f"`{output}` can only hold the layout {needed}. Leave out `--layout {layout}` or write a .csv.")
    parameters = {name: options.value(text) for name, text in options.pairs(settings, "--set").items()}
    with options.progress(quiet) as say:
        say(f"measuring {model}")
        options.cache_compilations()
        from brdf.material import load_material, save_material

        from ..formats import write
        from ..synthetic import synthesize, truth_of

        known = truth_of(load_material(model) if model.lower().endswith(".json") else model, parameters)
        measured = synthesize(
            known,
            layout=needed,
            samples=samples,
            noise=noise,
            noise_kind=noise_kind,
            seed=seed,
        )
        write(measured, output, force)
        if truth:
            save_material(known, truth, force)
    if as_json:
        facts = {"source": measured.source, "samples": len(measured), "clamped": measured.clamped, "output": output}
        click.echo(json.dumps(facts | {"truth": known.to_dict()}, indent=2))
    else:
        click.echo(f"{output}: {len(measured)} samples of {known.model}, layout {needed}, {noise:g} {noise_kind} noise")
        if measured.clamped:
            click.echo(f"brdf: {measured.clamped} channel values fell below 0 by noise and were set to 0.", err=True)

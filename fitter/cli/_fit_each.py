"""`brdf fit` for several measurements: a line for each as it ends."""

from __future__ import annotations

from typing import Any

import click

from . import options


def fit_each(
    ctx: click.Context,
    data: tuple[str, ...],
    model: str,
    output: str | None,
    read_options: dict[str, str],
    workers: int | None,
    force: bool,
    shared: dict[str, Any],
    as_json: bool,
    quiet: bool,
) -> None:
    """Fits several measurements, a line for each as it ends; exit status 1 if one failed."""
    import dataclasses
    import json

    from brdf.errors import UserError

    from ..many import fit_many

    if output is None:
        raise UserError("Several DATA need a folder for their materials. Name one with -o.")
    if output.endswith(".json"):
        raise UserError(f"`-o {output}` is one file for several DATA. Name a folder.")
    cache = options.cache_folder()
    outcomes = []
    for outcome in fit_many(
        data, model, output=output, read_options=read_options, workers=workers, force=force, cache=cache, **shared
    ):
        outcomes.append(outcome)
        if not (as_json or quiet):
            error = f"{outcome.errors['log_mae']:.5f}" if "log_mae" in outcome.errors else "-"
            click.echo(f"{outcome.kind:13}  {error:>8}  {outcome.seconds:6.1f} s  {outcome.name}: {outcome.sentence}")
    good = sum(outcome.is_good for outcome in outcomes)
    if as_json:
        click.echo(json.dumps([dataclasses.asdict(outcome) for outcome in outcomes], indent=2))
    else:
        click.echo(f"{good} of {len(outcomes)} materials are in {output}", err=True)
    if good < len(outcomes):
        ctx.exit(1)

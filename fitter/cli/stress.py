"""`brdf stress`: does a number anywhere in a model break, and how far is it from the exact one?"""

from __future__ import annotations

import json
import sys
from typing import Any

import click

from . import options


@click.command(name="stress")
@click.argument("model", required=False)
@click.option("--points", default=10_000_000, show_default=True, type=click.IntRange(min=1), help="Points per model.")
@click.option(
    "--exact-points",
    default=2000,
    show_default=True,
    type=click.IntRange(min=0),
    help="Points per model that are compared with 50 digits; 0 for none.",
)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(min=0), help="Other points for another seed.")
@click.option("--no-gpu", is_flag=True, help="Leave GLSL out.")
@click.option("--markdown", is_flag=True, help="Print the page of the docs.")
@options.as_json
@options.quiet
def command(
    model: str | None,
    points: int,
    exact_points: int,
    seed: int,
    no_gpu: bool,
    markdown: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Tries MODEL, or every model, where formulas break; exit status 1 if one does.

    Random and adversarial directions, parameters at, next to and between their bounds, all static choices, in float32
    and float64, in JAX with all derivatives and in GLSL: counts NaN, Inf and negative numbers, and measures the error
    against 50-digit arithmetic. MODEL may be a sum.

    \b
    Example:
      brdf stress lambert+ggx --points 1000000
    """
    from brdf.errors import UserError

    if markdown and as_json:
        raise UserError("`--markdown` and `--json` exclude each other. Leave one out.")
    from brdf.registry import MODELS, build

    chosen = [build(name) for name in ([model] if model else MODELS)]
    evaluate = None if no_gpu else _glsl()
    options.cache_compilations()
    from ..stress.report import data, text
    from ..stress.report import markdown as page
    from ..stress.run import stress

    found = []
    with options.progress(quiet) as say:
        for one in chosen:
            found.append(stress(one, points, exact_points, seed, evaluate, say))
            if not (as_json or markdown):
                click.echo(text(found[-1]))
            elif not found[-1].passed:
                click.echo(text(found[-1]), err=True)
    if as_json:
        click.echo(json.dumps(data(found), indent=2))
    elif markdown:
        click.echo(page(found, seed))
    if not all(one.passed for one in found):
        sys.exit(1)


def _glsl() -> Any:
    """The GLSL evaluation, or None, saying why, where there is no OpenGL 4.3."""
    from shaders.context import describe
    from shaders.evaluation import evaluate

    found = describe()
    if found["available"]:
        return evaluate
    click.echo(f"brdf: GLSL is left out: {found['problem']} `brdf doctor` says more.", err=True)
    return None

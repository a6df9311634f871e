"""The pages of the models in docs/models: Markdown made from the declarations and the leading comments alone."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from brdf.material import Material
from brdf.parameter import choices, parameters
from brdf.registry import MODELS

from . import portrait
from .catalogue import check_name, claims, either, sentence, span, theory

_MADE_BY = "<!-- Made by `brdf models --pages`; edit the model's file instead. -->"
INDEX = "README.md"


def texts() -> dict[str, str]:
    """File name -> Markdown of every page and of their index."""
    return {INDEX: index()} | {f"{name}.md": page(name) for name in MODELS}


def index() -> str:
    """The list of models, each with a link to its page and its picture."""
    lines = [_MADE_BY, "", "# Models", "", "Sums are written `lambert+ggx`; a model may occur twice.", ""]
    for name in MODELS:
        lines += [
            f"## [{name}]({name}.md)",
            "",
            _escaped(sentence(name)),
            "",
            f"[![{name}]({name}.png)]({name}.md)",
            "",
        ]
    return "\n".join(lines)


def page(name: str) -> str:
    """A model's page; raises `UserError` if the name is unknown."""
    check_name(name)
    return "\n\n".join(
        [
            _MADE_BY,
            f"# {name}",
            f"![Lobes, a slice and a lit sphere of {name}]({name}.png)",
            _caption(name),
            _prose(theory(name)),
            "## Parameters",
            _parameters(name),
            *(("## Choices", _choices(name)) if choices(MODELS[name]) else ()),
            "## Claims",
            "The tests hold the model to them.",
            "\n".join(f"- {_escaped(claim)}" for claim in claims(name)),
            "## As a material file",
            f"```json\n{_compact(json.dumps(Material(MODELS[name]()).to_dict(), indent=2))}\n```\n",
        ]
    )


def _caption(name: str) -> str:
    _, words = portrait.shown(name, MODELS[name])
    angles = ", ".join(map(str, portrait.INCIDENT_DEG))
    return (
        f"Drawn with {words}. Left: the value times the cosine of the light, mean of the channels, for light from the "
        f"left at {angles} degrees; the distance from the centre is its root. Middle: the value at phi_d = "
        f"{portrait.PHI_D_DEG} degrees, the mirror direction at the left edge, grazing angles above; x = pi f is shown "
        "as x / (1 + max x), sRGB. Right: the GLSL twin, rendered by `brdf preview` under the environment `studio`."
    )


def _prose(text: str) -> str:
    """A leading comment as Markdown: outside of formulas, nothing in it is HTML or emphasis."""
    return "\n".join(line if line.startswith("    ") else _escaped(line) for line in text.splitlines())


def _escaped(text: str) -> str:
    # Splitting at code in backticks leaves the plain text at even places.
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if place % 2 else re.sub(r"([<*\\])", r"\\\1", part) for place, part in enumerate(parts))


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def _parameters(name: str) -> str:
    head, rows = ["parameter", "range", "default", "meaning"], []
    for p in parameters(MODELS[name]):
        unit = "" if p.unit == "1" else f" {p.unit}"
        rows.append([f"`{p.name}`", span(p) + unit, f"{p.default:g}", _escaped(p.doc)])
    if any(p.when for p in parameters(MODELS[name])):
        head.append("has an effect with")
        for row, p in zip(rows, parameters(MODELS[name]), strict=True):
            row.append(", ".join(f"`{choice}` = {either([f'`{o}`' for o in options])}" for choice, options in p.when))
    return _table(head, rows)


def _choices(name: str) -> str:
    rows = [
        (f"`{c.name}`", ", ".join(f"`{option}`" for option in c.options), _escaped(c.doc))
        for c in choices(MODELS[name])
    ]
    return _table(("choice", "options, the default first", "meaning"), rows)


def _compact(text: str) -> str:
    """JSON with its lists of numbers in one line each."""
    return re.sub(
        r"\[[^\[\]]*\]", lambda found: re.sub(r"\s+", " ", found[0]).replace("[ ", "[").replace(" ]", "]"), text
    )

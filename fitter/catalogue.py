"""What can be fitted, in words: tables and pages made from the models' declarations."""

from __future__ import annotations

import sys
from typing import Any

from brdf.errors import UserError
from brdf.parameter import Parameter, choices, parameters
from brdf.registry import MODELS, nearest


def _check(name: str) -> None:
    if name not in MODELS:
        hint = " A sum such as lambert+ggx has the parameters of its lobes." if "+" in name else ""
        raise UserError(f"`{name}` is not a model.{hint} {nearest(name, MODELS)}")


def describe(name: str | None = None) -> dict[str, Any]:
    """Model name -> sentence, parameters and choices as plain data; raises `UserError` for an unknown name."""
    if name is not None:
        _check(name)
    return {
        model: {
            "doc": (MODELS[model].__doc__ or "").strip(),
            "parameters": {
                p.name: {
                    "kind": p.kind,
                    "lower": p.lower,
                    "upper": p.upper,
                    "default": p.default,
                    "unit": p.unit,
                    "doc": p.doc,
                }
                for p in parameters(MODELS[model])
            },
            "choices": {
                c.name: {"options": list(c.options), "default": c.default, "doc": c.doc} for c in choices(MODELS[model])
            },
        }
        for model in ([name] if name else MODELS)
    }


def overview() -> str:
    """Every model with its sentence and its parameters, two lines each."""
    width = max(map(len, MODELS))
    lines = []
    for name, model in MODELS.items():
        fields = ", ".join(field.name for field in (*parameters(model), *choices(model)))
        lines += [f"{name:{width}}  {(model.__doc__ or '').strip()}", f"{'':{width}}  {fields}"]
    lines += ["", "Sums are written lambert+ggx; a model may occur twice (ggx, ggx_2).", "Details: brdf models NAME"]
    return "\n".join(lines)


def page(name: str) -> str:
    """One model: the leading comment of its file, its parameters and its choices; raises `UserError` if unknown."""
    _check(name)
    model = MODELS[name]
    rows = [("parameter", "range", "default", "unit", "meaning")]
    rows += [(p.name, _range(p), f"{p.default:g}", p.unit, p.doc) for p in parameters(model)]
    rows += [(c.name, " | ".join(c.options), c.default, "choice", c.doc) for c in choices(model)]
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    table = ["  ".join(f"{row[c]:{widths[c]}}" for c in range(4)) + "  " + row[4] for row in rows]
    table.insert(1, "-" * max(map(len, table)))
    text = (sys.modules[model.__module__].__doc__ or "").strip()
    return "\n".join([name, "=" * len(name), "", text, "", *table])


def markdown_table() -> str:
    """All models as a Markdown table."""
    lines = ["| model | what it is | parameters |", "|---|---|---|"]
    for name, model in MODELS.items():
        fields = [f"`{p.name}` {_range(p)}{'' if p.unit == '1' else ' ' + p.unit}" for p in parameters(model)]
        fields += [f"`{c.name}` " + " / ".join(c.options) for c in choices(model)]
        lines.append(f"| `{name}` | {(model.__doc__ or '').strip()} | {', '.join(fields)} |")
    return "\n".join(lines)


def _range(parameter: Parameter) -> str:
    span = f"[{parameter.lower:g}, {parameter.upper:.4g}]"
    return f"rgb {span}" if parameter.kind == "color" else span

"""What can be fitted, in words: tables and pages made from the models' declarations."""

from __future__ import annotations

import itertools
import math
import shutil
import sys
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

from brdf.errors import UserError, nearest
from brdf.model import Claims
from brdf.parameter import Parameter, choices, parameters
from brdf.registry import MODELS

# Columns of a page where no terminal says otherwise, and the least and most that it takes: the names need some, and
# the formulas in the models' files are no wider.
_WIDTH, _WIDTH_MIN, _WIDTH_MAX = 100, 80, 120


def check_name(name: str) -> None:
    """Raises `UserError`, naming the nearest model, if there is none of this name."""
    if name not in MODELS:
        hint = " A sum such as lambert+ggx has the parameters of its lobes." if "+" in name else ""
        raise UserError(f"`{name}` is not a model.{hint} {nearest(name, MODELS)}")


def describe(name: str | None = None) -> dict[str, Any]:
    """Model name -> sentence, parameters, choices and claims as plain data; raises `UserError` for an unknown name."""
    if name is not None:
        check_name(name)
    return {
        model: {
            "doc": sentence(model),
            "parameters": {
                p.name: {
                    "kind": p.kind,
                    "lower": p.lower,
                    "upper": p.upper,
                    "default": p.default,
                    "unit": p.unit,
                    "doc": p.doc,
                    "when": {choice: list(options) for choice, options in p.when},
                }
                for p in parameters(MODELS[model])
            },
            "choices": {
                c.name: {"options": list(c.options), "default": c.default, "doc": c.doc} for c in choices(MODELS[model])
            },
            "claims": claims(model),
        }
        for model in ([name] if name else MODELS)
    }


def sentence(name: str) -> str:
    """What a model is, in one sentence."""
    return (MODELS[name].__doc__ or "").strip()


def theory(name: str) -> str:
    """The leading comment of a model's file: its formula, remarks and references."""
    return (sys.modules[MODELS[name].__module__].__doc__ or "").strip()


def overview() -> str:
    """Every model with its sentence, its parameters at the default choices, and its choices."""
    indent = " " * (max(map(len, MODELS)) + 2)
    lines = []
    for name, model in MODELS.items():
        fields = ", ".join(field.name for field in (*parameters(model()), *choices(model)))
        lines += _wrapped(sentence(name), f"{name:{len(indent)}}", indent) + _wrapped(fields, indent, indent)
    lines += ["", "Sums are written lambert+ggx; a model may occur twice (ggx, ggx_2).", "Details: brdf models NAME"]
    return "\n".join(lines)


def page(name: str) -> str:
    """One model: the leading comment of its file, its parameters, choices and claims; raises `UserError` if unknown."""
    check_name(name)
    model = MODELS[name]
    rows = [("parameter", "range", "default", "unit", "meaning")]
    rows += [(p.name, span(p), f"{p.default:g}", p.unit, p.doc + _condition(p)) for p in parameters(model)]
    lines = [name, "=" * len(name), "", theory(name), "", *_table(rows)]
    if choices(model):
        rows = [("choice", "default", "meaning")]
        rows += [(c.name, c.default, f"{c.doc}: {', '.join(c.options)}") for c in choices(model)]
        lines += ["", *_table(rows)]
    lines += ["", "Claims, to which the tests hold it:"]
    lines += [line for claim in claims(name) for line in _wrapped(claim, "- ", "  ")]
    return "\n".join(lines)


def _width() -> int:
    return min(max(shutil.get_terminal_size((_WIDTH, 24)).columns, _WIDTH_MIN), _WIDTH_MAX)


def _wrapped(text: str, first: str, indent: str) -> list[str]:
    return textwrap.wrap(
        text, _width(), initial_indent=first, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Columns under their heads, the last one wrapped into what is left of the line."""
    widths = [max(map(len, column)) for column in list(zip(*rows, strict=True))[:-1]]
    indent = " " * sum(width + 2 for width in widths)
    lines = []
    for row in rows:
        head = "".join(f"{cell:{width}}  " for cell, width in zip(row, widths, strict=False))
        lines += _wrapped(row[-1], head, indent)
    lines.insert(1, "-" * max(map(len, lines)))
    return lines


def _condition(parameter: Parameter) -> str:
    """Which options make the parameter live, as a note behind its sentence."""
    parts = [f"{choice} = {either(options)}" for choice, options in parameter.when]
    return f" (with {', '.join(parts)})" if parts else ""


def either(options: Sequence[str]) -> str:
    """`a, b or c`."""
    return " or ".join([", ".join(options[:-1]), options[-1]] if len(options) > 1 else options)


def claims(name: str) -> list[str]:
    """What a model claims (see `brdf.model.Claims`), a sentence each for reciprocity and energy."""
    return [_claim(name, _reciprocity), _claim(name, _energy)]


def _reciprocity(claimed: Claims) -> str:
    return "Reciprocal: wi and wo may be exchanged" if claimed.reciprocal else "Not reciprocal"


def _energy(claimed: Claims) -> str:
    if claimed.albedo_max == 1:
        return "No more light leaves than arrives"
    if math.isinf(claimed.albedo_max):
        return "No bound on the light that leaves"
    return f"At most {claimed.albedo_max:g} times the light that arrives leaves"


def _claim(name: str, say: Callable[[Claims], str]) -> str:
    found = cases(name, say)
    # Said once for all that is left: what holds in the most cases.
    rest = max((said for _, said in found), key=[said for _, said in found].count)
    parts = []
    for options, said in found:
        if said != rest:
            parts.append(f"{said} with {', '.join(f'{choice} = {either(names)}' for choice, names in options.items())}")
    parts.append(f"otherwise {_lowered(rest)}" if parts else rest)
    return "; ".join([parts[0], *map(_lowered, parts[1:])]) + "."


def _lowered(text: str) -> str:
    return text[0].lower() + text[1:]


def cases(name: str, say: Callable[[Claims], str]) -> list[tuple[dict[str, list[str]], str]]:
    """What a model claims under which options, in as few cases as can be; they exclude each other and leave none out.

    **Arguments:** `say`: claims -> what is said of them.

    **Returns:** pairs of (choice -> its options) and what is said.
    """
    declared = choices(MODELS[name])
    names = [choice.name for choice in declared]
    said = {
        options: say(MODELS[name](**dict(zip(names, options, strict=True))).claims())
        for options in itertools.product(*(choice.options for choice in declared))
    }
    return _cases(said, tuple(names))


def _cases(said: dict[tuple[str, ...], str], names: tuple[str, ...]) -> list[tuple[dict[str, list[str]], str]]:
    if len(set(said.values())) == 1:
        return [({}, next(iter(said.values())))]
    best = None
    for place, name in enumerate(names):
        # Options that lead to the same sayings are one case; a choice with one case alone decides nothing.
        groups: list[tuple[list[str], dict[tuple[str, ...], str]]] = []
        for option in dict.fromkeys(options[place] for options in said):
            rest = {o[:place] + o[place + 1 :]: text for o, text in said.items() if o[place] == option}
            same = next((group for group in groups if group[1] == rest), None)
            if same:
                same[0].append(option)
            else:
                groups.append(([option], rest))
        if len(groups) == 1:
            continue
        others = names[:place] + names[place + 1 :]
        found = [({name: options} | case, text) for options, rest in groups for case, text in _cases(rest, others)]
        if best is None or len(found) < len(best):
            best = found
    assert best is not None, "different sayings differ by some choice"
    return best


def markdown_table() -> str:
    """All models as a Markdown table: their parameters at the default choices, and their choices, the default first."""
    lines = ["| model | what it is | parameters | choices |", "|---|---|---|---|"]
    for name, model in MODELS.items():
        fields = [f"`{p.name}` {span(p)}{'' if p.unit == '1' else ' ' + p.unit}" for p in parameters(model())]
        options = [f"`{c.name}` {' / '.join(c.options)}" for c in choices(model)]
        lines.append(f"| `{name}` | {sentence(name)} | {', '.join(fields)} | {'; '.join(options)} |")
    return "\n".join(lines)


def span(parameter: Parameter) -> str:
    """The bounds of a parameter, and whether they hold for three channels."""
    bounds = f"[{parameter.lower:.4g}, {parameter.upper:.4g}]"
    return f"rgb {bounds}" if parameter.kind == "color" else bounds

"""`brdf metals`: measured metals for the exact conductor Fresnel, from the table or from a file."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from . import options

_FILES = (".yml", ".yaml", ".csv")
_ILLUMINANT = "D65"


@click.command(name="metals")
@click.argument("metal", required=False)
@click.option(
    "--illuminant", help=f"Light under which a FILE's colour is taken: D50, A, E, ... (CIE).  [default: {_ILLUMINANT}]"
)
@options.as_json
def command(metal: str | None, illuminant: str | None, as_json: bool) -> None:
    """Lists measured metals, or shows how a material uses METAL.

    METAL is a name or chemical symbol of the list, or a file with a measured complex index of refraction: .yml of
    refractiveindex.info, or .csv with the columns wavelength_um, n and k.

    \b
    Example:
      brdf metals gold
    """
    import json

    from brdf.errors import UserError
    from brdf.metals import METALS, metal_name

    is_file = metal is not None and pathlib.Path(metal).suffix.lower() in _FILES
    if illuminant and not is_file:
        raise UserError(f"`--illuminant` is for files; the list is for {_ILLUMINANT}. Leave it out or give a file.")
    if metal is None:
        facts = {name: _facts(name) for name in METALS}
    elif is_file:
        facts = {pathlib.Path(metal).stem: _derived(metal, illuminant or _ILLUMINANT)}
    else:
        name = metal_name(metal)
        facts = {name: _facts(name)}
    if as_json:
        click.echo(json.dumps(facts, indent=2, ensure_ascii=False, allow_nan=False))
    elif metal is None:
        click.echo(_table(facts))
    else:
        name, fact = next(iter(facts.items()))
        click.echo(_page(name, fact))


def _facts(name: str) -> dict[str, Any]:
    from brdf.metals import METALS

    metal = METALS[name]
    facts: dict[str, Any] = {"symbol": metal.symbol, "f0": _rounded(metal.f0, 4)}
    facts |= {key: list(getattr(metal, key)) for key in ("color", "eta", "k")}
    return facts | {"illuminant": _ILLUMINANT, "source": metal.source, "page": metal.page}


def _derived(path: str, illuminant: str) -> dict[str, Any]:
    from brdf.metals import F0_MAX, F0_MIN

    options.cache_compilations()
    from ..conductor import effective_index, read_spectrum

    found = effective_index(read_spectrum(path), illuminant)
    return {
        "f0": _rounded(found.color.clip(F0_MIN, F0_MAX), 4),
        "color": _rounded(found.color, 4),
        "eta": [float(f"{eta:.5g}") for eta in found.eta],
        "k": [float(f"{k:.5g}") for k in found.k],
        "rms": _rounded(found.rms, 5),
        "worst": _rounded(found.worst, 5),
        "illuminant": illuminant,
        "source": found.source,
    }


def _rounded(values: Any, digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]


def _numbers(values: list[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _clipped(name: str, fact: dict[str, Any]) -> list[str]:
    """A sentence for every channel whose colour no conductor has."""
    from brdf.metals import F0_MAX, F0_MIN

    return [
        f"{name}: {channel} is {value:g}, outside Rec. 709; eta and k stand for {min(max(value, F0_MIN), F0_MAX):g}."
        for channel, value in zip(("red", "green", "blue"), fact["color"], strict=True)
        if not F0_MIN <= value <= F0_MAX
    ]


def _table(facts: dict[str, dict[str, Any]]) -> str:
    rows = [("metal", "", "f0", "eta", "k", "source")]
    rows += [
        (
            name,
            fact["symbol"],
            *(" ".join(f"{v:<7.4g}" for v in fact[key]) for key in ("f0", "eta", "k")),
            fact["source"],
        )
        for name, fact in facts.items()
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    lines = ["  ".join(f"{row[c]:{widths[c]}}" for c in range(5)) + "  " + row[5] for row in rows]
    lines += [
        "",
        f"Red, green, blue of linear Rec. 709 under {_ILLUMINANT}; f0 is the reflectance at normal incidence.",
    ]
    lines += [sentence for name, fact in facts.items() for sentence in _clipped(name, fact)]
    return "\n".join([*lines, "Details: brdf metals METAL"])


def _page(name: str, fact: dict[str, Any]) -> str:
    lines = [f"{name}: {fact['source']}"]
    if "page" in fact:
        lines.append(f"refractiveindex.info: {fact['page']}")
    lines.append(f"f0 {_numbers(fact['f0'])} (linear Rec. 709, {fact['illuminant']})")
    if "rms" in fact:
        lines.append(f"difference from the spectrum's reflectance over 0-85 degrees: rms {_numbers(fact['rms'])}, ")
        lines[-1] += f"at most {_numbers(fact['worst'])}"
    lines += _clipped(name, fact)
    eta, k = (",".join(f"{value:g}" for value in fact[key]) for key in ("eta", "k"))
    lines += ["", "To hold it in a fit:", f"  --fix fresnel=conductor --fix eta={eta} --fix k={k}"]
    snippet = f'"fresnel": "conductor", "eta": {fact["eta"]}, "k": {fact["k"]}'
    return "\n".join(
        [*lines, "", "In a material file, among the parameters of a microfacet lobe such as `ggx`:", f"  {snippet}"]
    )

"""What a user asks of the parameters of a fit, and the unknowns that follow."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from brdf.errors import UserError, nearest
from brdf.material import check_choice, check_live, check_parameter
from brdf.model import AbstractBRDF, specialized
from brdf.parameter import Parameter, choices, parameters
from brdf.registry import combine, split

from .unknowns import Place, Unknown, Unknowns


@dataclasses.dataclass(frozen=True)
class Wishes:
    """What a user asks of the parameters of a fit; names are `"alpha"`, or `"ggx.alpha"` where lobes share it.

    - `fixed`: parameters and static choices that are held, and their values.
    - `tied`: pairs of parameters that are to be equal.
    - `bounds`: parameter -> (lower, upper), inside its declared bounds.
    - `freed`: parameters that a fit holds by default and that are to be free.
    """

    fixed: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    tied: Mapping[str, str] = dataclasses.field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = dataclasses.field(default_factory=dict)
    freed: Sequence[str] = ()


def choose(model: AbstractBRDF, wishes: Wishes, azimuths: bool = True) -> Unknowns:
    """The unknowns of a model after the user's wishes.

    **Arguments:**

    - `model`: any model; its own values stand where nothing else is said.
    - `wishes`: see `Wishes`.
    - `azimuths`: whether the data turn the sample about its normal.

    Raises `UserError` for an unknown or ambiguous name, a value out of bounds, or wishes that contradict each other.
    """
    lobes = split(model)
    held: dict[Place, tuple[float, ...]] = {}
    named = {_find(lobes, key): value for key, value in wishes.fixed.items()}
    # Choices first: they decide which parameters there are.
    for (lobe, name), value in named.items():
        chosen = next((c for c in choices(lobes[lobe]) if c.name == name), None)
        if chosen is not None:
            lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: check_choice(value, chosen, lobe)})
    fixed: set[Place] = set()
    for (lobe, name), value in named.items():
        declared = next((p for p in parameters(type(lobes[lobe])) if p.name == name), None)
        if declared is not None:
            check_live(declared, lobes[lobe], lobe)
            lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: check_parameter(value, declared, lobe)})
            fixed.add((lobe, name))
    freed = {_live(lobes, key) for key in wishes.freed}
    tied = [tuple(_live(lobes, key) for key in pair) for pair in wishes.tied.items()]
    touched = {place for pair in tied for place in pair} | {_live(lobes, key) for key in wishes.bounds}
    _refuse_both(fixed, freed | touched)
    for lobe, part in lobes.items():
        for parameter in parameters(part):
            place = (lobe, parameter.name)
            values = parameter.held or ((parameter.default,) if parameter.azimuthal and not azimuths else ())
            if values and place not in fixed | freed | touched:
                held[place] = values
                lobes[lobe] = dataclasses.replace(lobes[lobe], **{parameter.name: values[0]})
    bounds = {_live(lobes, key): span for key, span in wishes.bounds.items()}
    free, offset = [], 0
    for group in _groups(lobes, fixed | set(held), tied):
        parameter = _bounded(lobes, group, bounds)
        free.append(Unknown(parameter, offset, group))
        offset += parameter.size
    return Unknowns(specialized(combine(lobes)), tuple(free), tuple(held.items()))


def _find(lobes: Mapping[str, AbstractBRDF], key: str) -> Place:
    known = [(lobe, field.name) for lobe, part in lobes.items() for field in (*parameters(type(part)), *choices(part))]
    found = [(lobe, name) for lobe, name in known if key in (name, f"{lobe}.{name}")]
    if len(found) == 1:
        return found[0]
    if found:
        options = " or ".join(f"`{lobe}.{name}`" for lobe, name in found)
        raise UserError(f"`{key}` is a parameter of several lobes. Write {options}.")
    raise UserError(f"`{key}` is not a parameter here. {nearest(key, [f'{lobe}.{name}' for lobe, name in known])}")


def _declared(lobes: Mapping[str, AbstractBRDF], place: Place) -> Parameter | None:
    return next((p for p in parameters(type(lobes[place[0]])) if p.name == place[1]), None)


def _live(lobes: Mapping[str, AbstractBRDF], key: str) -> Place:
    """The place of a continuous parameter that the model's choices leave in use."""
    place = _find(lobes, key)
    declared = _declared(lobes, place)
    if declared is None:
        raise UserError(f"`{key}` is a static choice, not a number. Set it with `--fix {key}=OPTION`.")
    check_live(declared, lobes[place[0]], place[0])
    return place


def _refuse_both(fixed: set[Place], other: set[Place]) -> None:
    for lobe, name in sorted(fixed & other):
        raise UserError(f"`{lobe}.{name}` is fixed, and also tied, bounded or freed. Leave one of them out.")


def _groups(
    lobes: Mapping[str, AbstractBRDF], taken: set[Place], tied: Sequence[tuple[Place, ...]]
) -> list[tuple[Place, ...]]:
    """The free places, those that are tied together as one group, in the order of their first."""
    places = [(lobe, p.name) for lobe, part in lobes.items() for p in parameters(part)]
    groups = {place: (place,) for place in places if place not in taken}
    for a, b in tied:
        joined = tuple(place for place in places if place in (*groups[a], *groups[b]))
        kinds = {(p.kind, p.fit_square) for p in (_declared(lobes, place) for place in joined) if p is not None}
        if len(kinds) > 1:
            raise UserError(f"`{'.'.join(a)}` and `{'.'.join(b)}` are not of one kind and cannot be tied.")
        groups |= dict.fromkeys(joined, joined)
    return list(dict.fromkeys(groups.values()))


def _bounded(
    lobes: Mapping[str, AbstractBRDF], group: tuple[Place, ...], bounds: Mapping[Place, tuple[float, float]]
) -> Parameter:
    """The declaration of a group: the bounds that all its members and the user allow."""
    members = [p for p in (_declared(lobes, place) for place in group) if p is not None]
    lower, upper = max(p.lower for p in members), min(p.upper for p in members)
    for place in group:
        if place in bounds:
            label, span = ".".join(place), tuple(bounds[place])
            if len(span) != 2:
                raise UserError(f"The bounds of `{label}` are {len(span)} numbers. Give the lower and the upper one.")
            low, high = span
            if not low < high:
                raise UserError(f"`{label} = {low:g}:{high:g}` is no range. Give the smaller number first.")
            if not lower <= low or not high <= upper:
                raise UserError(f"`{label} = {low:g}:{high:g}` leaves the declared bounds [{lower:g}, {upper:g}].")
            lower, upper = max(lower, low), min(upper, high)
    if not lower < upper:
        raise UserError(f"No value of `{'.'.join(group[0])}` lies in the bounds of all that it is tied to.")
    first = members[0]
    starts = tuple(start for start in first.starts if lower <= start <= upper) or (0.5 * (lower + upper),)
    return dataclasses.replace(first, lower=lower, upper=upper, starts=starts if first.kind == "scalar" else ())

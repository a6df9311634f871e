"""Every combination of options of a model's static choices."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

from brdf.errors import UserError, nearest
from brdf.model import AbstractBRDF
from brdf.parameter import choices
from brdf.registry import build, combine, split

_VARIANTS_MAX = 64


def searched(expression: str, names: Sequence[str]) -> list[AbstractBRDF]:
    """The model with every combination of the options of some choices; lobes that share a choice have it in common.

    **Arguments:**

    - `expression`: such as `"lambert+ggx"`.
    - `names`: of static choices, such as `("masking", "fresnel")`.

    **Raises:** `UserError` for a choice that no lobe has, or more than 64 combinations.
    """
    lobes = split(build(expression))
    # Of lobes that share a choice some may know more options of it than others.
    known: dict[str, dict[str, None]] = {}
    for lobe in lobes.values():
        for choice in choices(lobe):
            known.setdefault(choice.name, {}).update(dict.fromkeys(choice.options))
    names = list(dict.fromkeys(name.strip() for name in names))
    for name in names:
        if name not in known:
            raise UserError(f"`{name}` is not a static choice of `{expression}`. {nearest(name, known)}")
    count = math.prod(len(known[name]) for name in names)
    if count > _VARIANTS_MAX:
        raise UserError(f"{', '.join(names)} have {count} combinations, more than {_VARIANTS_MAX}. Search fewer.")
    variants = []
    for options in itertools.product(*(known[name] for name in names)):
        chosen = dict(zip(names, options, strict=True))
        variants.append(combine({name: _with(lobe, chosen) for name, lobe in lobes.items()}))
    return variants


def _with(lobe: AbstractBRDF, chosen: dict[str, str]) -> AbstractBRDF:
    own = {c.name: chosen[c.name] for c in choices(lobe) if c.name in chosen and chosen[c.name] in c.options}
    return dataclasses.replace(lobe, **own)

"""The fits that a contact sheet shows: made once, kept as materials in a folder."""

from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from brdf.model import AbstractBRDF

    from ..reflectance import Reflectance


@dataclasses.dataclass(frozen=True)
class Fitted:
    """One model fitted to one measurement.

    - `model`: its name or expression.
    - `brdf`: the fitted model.
    - `log_mae`: the mean of |log(1 + f cos_i) - log(1 + y cos_i)| over the samples.
    """

    model: str
    brdf: AbstractBRDF
    log_mae: float


def fits(
    measured: Reflectance, models: tuple[str, ...], folder: pathlib.Path, say: Callable[[str], None]
) -> Iterator[Fitted]:
    """Fits of models to a measurement; one that the folder holds from an earlier call is not made again.

    Raises `UserError` for an unknown model, or when a fit is impossible.
    """
    from brdf.material import load_material, save_material

    from ..fitting import fit

    folder.mkdir(parents=True, exist_ok=True)
    for model in models:
        path = folder / f"{model}.json"
        if not path.exists():
            say(f"fitting {model} to {measured.source}")
            save_material(fit(model, measured).material, path)
        material = load_material(path)
        yield Fitted(model, material.brdf, float(material.provenance["errors"]["log_mae"]))

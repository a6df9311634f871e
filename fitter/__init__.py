"""From measured reflectance to a fitted material.

import fitter
result = fitter.fit("lambert+ggx", "gold.binary")
print(result.report())
brdf.save_material(result.material, "gold.json")
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .fitting import fit as fit
    from .formats import read as read
    from .formats import write as write
    from .many import fit_many as fit_many
    from .reflectance import Reflectance as Reflectance
    from .result import FitResult as FitResult
    from .synthetic import synthesize as synthesize

# Public name -> module, imported on first use: the readers need no JAX, the fit does.
_PUBLIC = {
    "FitResult": "result",
    "Reflectance": "reflectance",
    "fit": "fitting",
    "fit_many": "many",
    "read": "formats",
    "synthesize": "synthetic",
    "write": "formats",
}
__all__ = sorted(_PUBLIC)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module `fitter` has no attribute `{name}`")
    return getattr(importlib.import_module(f".{_PUBLIC[name]}", __name__), name)


def __dir__() -> list[str]:
    return list(__all__)

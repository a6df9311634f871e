"""Reflectance models as differentiable JAX pytrees: declared once, evaluated for one pair of directions, summed.

import brdf
model = brdf.build("lambert+ggx")          # an AbstractBRDF at its defaults
value = model(wi, wo)                      # 1/sr, without the cosine
material = brdf.load_material("gold.json") # a named model with provenance
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import FileError as FileError
    from .errors import UserError as UserError
    from .material import Material as Material
    from .material import load_material as load_material
    from .material import save_material as save_material
    from .model import AbstractBRDF as AbstractBRDF
    from .model import Sum as Sum
    from .model import evaluate as evaluate
    from .parameter import Choice as Choice
    from .parameter import Parameter as Parameter
    from .parameter import choices as choices
    from .parameter import parameters as parameters
    from .registry import MODELS as MODELS
    from .registry import build as build

# Public name -> module. Imported on first use: JAX takes most of a second, and `brdf --help` does not need it.
_PUBLIC = {
    "AbstractBRDF": "model",
    "Choice": "parameter",
    "FileError": "errors",
    "MODELS": "registry",
    "Material": "material",
    "Parameter": "parameter",
    "Sum": "model",
    "UserError": "errors",
    "build": "registry",
    "choices": "parameter",
    "evaluate": "model",
    "load_material": "material",
    "parameters": "parameter",
    "save_material": "material",
}
__all__ = sorted(_PUBLIC)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module `brdf` has no attribute `{name}`")
    return getattr(importlib.import_module(f".{_PUBLIC[name]}", __name__), name)


def __dir__() -> list[str]:
    return list(__all__)

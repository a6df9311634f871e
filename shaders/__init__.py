"""The GLSL twins of the models, and the preview that runs them.

import brdf, shaders
scene = shaders.Scene((shaders.Part(brdf.build("lambert+ggx")),), shaders.load_environment("studio"))
image = shaders.render(scene)
shaders.write_png("preview.png", image.display)
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .context import describe as describe
    from .environment import Environment as Environment
    from .environment import load_environment as load_environment
    from .evaluation import evaluate as evaluate
    from .evaluation import pdf as pdf
    from .evaluation import sample as sample
    from .exr import write_exr as write_exr
    from .image import Image as Image
    from .image import write_png as write_png
    from .mesh import Mesh as Mesh
    from .mesh import sphere as sphere
    from .plan_picture import plan_svg as plan_svg
    from .renderer import Renderer as Renderer
    from .renderer import render as render
    from .scene import Camera as Camera
    from .scene import Part as Part
    from .scene import Scene as Scene
    from .tabulated import Tabulated as Tabulated

# Public name -> module. Imported on first use: `brdf --help` needs neither moderngl nor OpenEXR.
_PUBLIC = {
    "Camera": "scene",
    "Environment": "environment",
    "Image": "image",
    "Mesh": "mesh",
    "Part": "scene",
    "Renderer": "renderer",
    "Scene": "scene",
    "Tabulated": "tabulated",
    "describe": "context",
    "evaluate": "evaluation",
    "load_environment": "environment",
    "pdf": "evaluation",
    "plan_svg": "plan_picture",
    "render": "renderer",
    "sample": "evaluation",
    "sphere": "mesh",
    "write_exr": "exr",
    "write_png": "image",
}
__all__ = sorted(_PUBLIC)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module `shaders` has no attribute `{name}`")
    return getattr(importlib.import_module(f".{_PUBLIC[name]}", __name__), name)


def __dir__() -> list[str]:
    return list(__all__)

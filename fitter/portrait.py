"""The picture of a model in the docs: lobes in the plane of incidence, a slice of its values, and a lit sphere."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable

import jax
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Wedge
from numpy.typing import NDArray
from PIL import Image

from brdf.atomic import atomic_path
from brdf.model import AbstractBRDF, evaluate
from brdf.parameter import parameters

from .rusinkiewicz import directions

# (model, pixels) -> a square picture for displays in [0, 1], (pixels, pixels, 3).
Sphere = Callable[[AbstractBRDF, int], NDArray[np.float32]]

# The colour that makes a model visible: brighter than most f0, and not grey.
COLOUR = (0.9, 0.6, 0.3)
INCIDENT_DEG = (10, 30, 50, 70)
PHI_D_DEG = 90
# Pixels: of the picture, and the place of each panel from the left and from below.
_WIDTH, _HEIGHT, _DPI = 900, 310, 100
_LOBES, _SLICE, _SPHERE = (2, 30, 356, 244), (408, 60, 206, 206), (640, 26, 250, 250)
_LIGHTS = ("#35256f", "#a0308a", "#e4664b", "#dfa02c")
_INK, _FAINT = "#222222", "#c9c9c9"
# Beyond this angle, where some models grow without bound, nothing decides the scale of the lobes.
_SCALE_DEG = 80
_STYLE = {"fontsize": 8, "color": _INK}


def shown(name: str, model: type[AbstractBRDF]) -> tuple[AbstractBRDF, str]:
    """The model as it is drawn, and in words: its first colour is `COLOUR`, all else has its default."""
    default = model()
    first = next((p.name for p in parameters(default) if p.kind == "color"), None)
    if first is None:
        return default, f"`{name}` with every parameter at its default"
    colour = ", ".join(f"{value:g}" for value in COLOUR)
    return dataclasses.replace(default, **{first: COLOUR}), f"`{first}` = ({colour}), all else at its default"


def draw(model: AbstractBRDF, path: str | os.PathLike[str], sphere: Sphere | None, force: bool = False) -> None:
    """Draws a model.

    **Arguments:**

    - `model`: see `shown`.
    - `path`: `.png`.
    - `sphere`: renders the model; without it the panel says that there is no OpenGL.
    - `force`: whether an existing file may be replaced.

    Raises `FileError` if the file exists without `force` or cannot be written.
    """
    figure = Figure(figsize=(_WIDTH / _DPI, _HEIGHT / _DPI), dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    _draw_lobes(model, _panel(figure, _LOBES, "f cos $\\theta_i$ in the plane of incidence (1/sr, root scale)"))
    _draw_slice(model, _panel(figure, _SLICE, f"f at $\\phi_d$ = {PHI_D_DEG}°"))
    _draw_sphere(model, _panel(figure, _SPHERE, "lit by the studio"), sphere)
    canvas.draw()
    with atomic_path(path, force) as temporary:
        # Without an alpha channel, which Matplotlib would write, the file is a fifth smaller.
        Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3]).save(temporary, optimize=True)


def _panel(figure: Figure, place: tuple[int, int, int, int], title: str) -> Axes:
    left, bottom, width, height = place
    axis = figure.add_axes((left / _WIDTH, bottom / _HEIGHT, width / _WIDTH, height / _HEIGHT))
    figure.text((left + width / 2) / _WIDTH, 1 - 16 / _HEIGHT, title, ha="center", va="center", fontsize=9, color=_INK)
    return axis


def _values(model: AbstractBRDF, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    with jax.enable_x64(True):
        return np.asarray(evaluate(model, wi, wo))


def _draw_lobes(model: AbstractBRDF, axis: Axes) -> None:
    degrees = np.linspace(-89.95, 89.95, 1440)
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    wo = np.stack([sine, np.zeros_like(sine), cosine], axis=-1)
    lobes = []
    for angle in np.radians(INCIDENT_DEG):
        # The light stands on the left, the mirror direction is on the right.
        wi = np.broadcast_to([-np.sin(angle), 0, np.cos(angle)], wo.shape)
        lobes.append(_values(model, wi, wo).mean(axis=1) * np.cos(angle))
    inside = np.abs(degrees) <= _SCALE_DEG
    top = 1.08 * max(lobe[inside].max() for lobe in lobes)

    axis.set_xlim(-1.24, 1.24)
    axis.set_ylim(-0.46, 1.24)
    axis.set_aspect("equal")
    axis.axis("off")
    _draw_grid(axis, top)
    rim = axis.add_patch(Wedge((0, 0), 1, 0, 180, facecolor="none", edgecolor="none"))
    for number, (angle, lobe, colour) in enumerate(zip(INCIDENT_DEG, lobes, _LIGHTS, strict=True)):
        # The root shows a diffuse base beside a highlight.
        radius = np.minimum(np.sqrt(lobe / top), 2)
        for patch in axis.fill(radius * sine, radius * cosine, color=colour, alpha=0.12, linewidth=0):
            patch.set_clip_path(rim)
        (line,) = axis.plot(radius * sine, radius * cosine, color=colour, linewidth=1.5)
        line.set_clip_path(rim)
        x, y = -np.sin(np.radians(angle)), np.cos(np.radians(angle))
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
        axis.annotate("", (1.01 * x, 1.01 * y), (1.2 * x, 1.2 * y), arrowprops=arrow)
        axis.text(-0.45 + 0.45 * number, -0.34, f"{angle}°", ha="center", va="center", fontsize=8, color=colour)
    axis.text(-0.85, -0.34, "light at", ha="center", va="center", **_STYLE)


def _draw_grid(axis: Axes, top: float) -> None:
    round_rim = np.radians(np.linspace(-90, 90, 181))
    ticks = [float(f"{share * top:.0e}") for share in (0.1, 0.45)]
    for radius in [*(math.sqrt(tick / top) for tick in ticks), 1.0]:
        axis.plot(radius * np.sin(round_rim), radius * np.cos(round_rim), color=_FAINT, linewidth=0.7, zorder=0)
    for angle in np.radians([-60, -30, 0, 30, 60]):
        axis.plot([0, np.sin(angle)], [0, np.cos(angle)], color=_FAINT, linewidth=0.5, zorder=0)
    axis.plot([-1.1, 1.1], [0, 0], color=_INK, linewidth=0.9, zorder=0)
    for angle in (30, 60):
        x, y = np.sin(np.radians(angle)), np.cos(np.radians(angle))
        axis.text(1.07 * x, 1.07 * y, f"{angle}°", ha="left", va="center", **_STYLE)
    for tick in (0, *ticks):
        axis.text(math.sqrt(tick / top), -0.04, f"{tick:g}", ha="center", va="top", **_STYLE)


def _draw_slice(model: AbstractBRDF, axis: Axes) -> None:
    count = _SLICE[2]
    fraction = (np.arange(count) + 0.5) / count
    # The quadratic theta_h axis of the MERL tables: half of the picture is within 22.5 degrees of the mirror direction.
    theta_h, theta_d = np.meshgrid(fraction**2 * np.pi / 2, fraction * np.pi / 2)
    wi, wo = directions(theta_h.ravel(), theta_d.ravel(), np.radians(PHI_D_DEG))
    axis.imshow(_display(_values(model, wi, wo)).reshape(count, count, 3), origin="lower", extent=(0, 1, 0, 1))
    ticks = (0, 5, 20, 45, 90)
    axis.set_xticks(np.sqrt(np.array(ticks) / 90), [f"{tick}°" for tick in ticks], **_STYLE)
    ticks = (0, 30, 60, 90)
    axis.set_yticks(np.array(ticks) / 90, [f"{tick}°" for tick in ticks], **_STYLE)
    axis.tick_params(length=3, color=_INK)
    axis.set_xlabel("$\\theta_h$", labelpad=3, fontsize=9, color=_INK)
    axis.set_ylabel("$\\theta_d$", labelpad=3, fontsize=9, color=_INK)
    for side in axis.spines.values():
        side.set_linewidth(0.6)


def _display(value: np.ndarray) -> np.ndarray:
    """sRGB of pi f, compressed by its largest channel: x / (1 + max x). A white diffuse surface is half as bright as
    the brightest highlight, and the hue stays."""
    x = np.pi * value
    x = x / (1 + x.max(axis=-1, keepdims=True))
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def _draw_sphere(model: AbstractBRDF, axis: Axes, sphere: Sphere | None) -> None:
    axis.axis("off")
    if sphere is None:
        axis.text(0.5, 0.5, "no OpenGL 4.3 here:\nnot rendered", ha="center", va="center", **_STYLE)
    else:
        axis.imshow(sphere(model, _SPHERE[2]), interpolation="none")

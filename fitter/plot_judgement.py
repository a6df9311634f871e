"""What a judgement looks at: the sphere as measured, as fitted, and their difference."""

from __future__ import annotations

import os

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from brdf.atomic import atomic_path
from brdf.errors import UserError
from brdf.model import AbstractBRDF

from .judge import WHITE, Pictures, judge, render
from .reflectance import Reflectance

# Of the picture on paper: several pixels for each pixel of the sphere.
_SIZE = 300
# A difference of this is drawn as the worst of the scale; beyond it numbers do not mean more.
_WORST = 100.0


def plot_judgement(model: AbstractBRDF, data: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Draws the sphere as measured and as fitted, and Delta E ITP between them.

    **Arguments:**

    - `model`: any model or sum.
    - `data`: a measurement that defines values between its samples.
    - `path`: `.png`, `.pdf` or `.svg`.
    - `force`: whether an existing file may be replaced.

    **Raises:** `UserError` if the measurement defines too few values for a sphere; `FileError` if the file exists
    without `force` or cannot be written.
    """
    pictures = render(model, data)
    if pictures is None:
        raise UserError(
            f"`{data.source}` defines too few values between its samples to light a sphere with them. "
            "Draw the samples instead: `fitter.plot.plot_fit`."
        )
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    draw_judgement(pictures, figure)
    figure.suptitle(judge(model, data).sentence(), fontsize=10)
    with atomic_path(path, force) as temporary:
        figure.savefig(temporary, dpi=110)


def draw_judgement(pictures: Pictures, figure) -> None:
    """The three spheres side by side in a figure or subfigure."""
    axes = figure.subplots(1, 3)
    for axis, picture, title in ((axes[0], pictures.measured, "measured"), (axes[1], pictures.fitted, "fitted")):
        axis.imshow(_encoded(_upright(pictures, picture)), interpolation="bilinear")
        axis.set_title(title)
    difference = np.where(pictures.counts, pictures.difference, np.nan)
    bound = min(max(float(np.nanmax(difference)), 1.0), _WORST)
    shown = axes[2].imshow(_upright(pictures, difference[..., None])[..., 0], vmin=0, vmax=bound, cmap="magma")
    axes[2].set_title("Delta E ITP (1 is just noticeable)")
    figure.colorbar(shown, ax=axes[2])
    for axis in axes:
        axis.set_axis_off()


def _upright(pictures: Pictures, values: np.ndarray) -> np.ndarray:
    """(rings, sectors, channels) as a square picture, the top row first; NaN outside of the sphere."""
    rings, sectors = values.shape[:2]
    at = (np.arange(_SIZE) + 0.5) / (_SIZE / 2) - 1
    x, y = np.meshgrid(at, -at)
    radius = np.hypot(x, y)
    # Rings have equal areas: half a ring inside the edge is the last one's middle.
    edge = pictures.radius[-1] / np.sqrt((rings - 0.5) / rings)
    ring = (radius / edge) ** 2 * rings - 0.5
    # Inside the first ring's middle everything tends to its mean in the centre.
    values = np.concatenate([np.broadcast_to(values[:1].mean(axis=1, keepdims=True), values[:1].shape), values])
    ring = np.clip(np.where(ring < 0, 2 * ring + 1, ring + 1), 0, rings)
    sector = np.arctan2(y, x) / (2 * np.pi) * sectors - 0.5
    low = np.minimum(ring.astype(int), rings - 1)
    left = np.floor(sector).astype(int)
    part, along = (ring - low)[..., None], (sector - left)[..., None]
    left, right = left % sectors, (left + 1) % sectors
    picture = (1 - part) * ((1 - along) * values[low, left] + along * values[low, right])
    picture += part * ((1 - along) * values[low + 1, left] + along * values[low + 1, right])
    picture[radius > edge] = np.nan
    return picture


def _encoded(luminance: np.ndarray) -> np.ndarray:
    """cd/m2 as sRGB, for paper: what is brighter than the reference white is rolled off."""
    x = luminance / WHITE
    # Linear in the lower half, then towards 1 with the same slope at the joint.
    x = np.where(x < 0.5, x, 1 - 0.25 / np.maximum(x, 0.5))
    # What is no pixel is as white as the paper.
    return np.nan_to_num(np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055), nan=1.0)

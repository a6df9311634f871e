"""Pictures of a fit: measured, fitted and residual slices side by side, and lobes at a few incident angles."""

from __future__ import annotations

import os

import jax
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from brdf.atomic import atomic_path
from brdf.model import AbstractBRDF, evaluate

from .judge import render
from .plot_judgement import draw_judgement
from .result import FitResult
from .rusinkiewicz import half_difference

# Bins along theta_h (quadratic, dense at the highlight) and theta_d: enough to see a lobe, few enough to be filled.
_BINS = 45
_INCIDENT_DEG = (10, 30, 50, 70)
# Samples this close to the plane of incidence and to an incident angle are drawn as points.
_NEAR_DEG = 2.5
_POINTS_MAX = 400
# Rec. 709 luminance.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def plot_fit(result: FitResult, path: str | os.PathLike[str], force: bool = False) -> None:
    """Draws a fit beside its measurement.

    Above: the luminance of the samples, of the model at the same directions, and the difference of log(1 + f cos_i),
    averaged over cells of theta_h and theta_d. Below: the plane of incidence at a few incident angles; points or thin
    lines are measured, thick lines fitted. At the bottom, where the measurement defines its values everywhere: a lit
    sphere of both, and how different they look (see `fitter.judge`).

    **Arguments:**

    - `result`: of `fitter.fit`.
    - `path`: `.png`, `.pdf` or `.svg`.
    - `force`: whether an existing file may be replaced.

    Raises `FileError` if the file exists without `force` or cannot be written.
    """
    pictures = render(result.brdf, result.data)
    heights = (1.0, 1.0) if pictures is None else (1.0, 1.0, 0.9)
    figure = Figure(figsize=(14, 4.1 * sum(heights)), layout="constrained")
    FigureCanvasAgg(figure)
    rows = np.asarray(figure.subfigures(len(heights), 1, height_ratios=heights))
    _draw_slices(result, rows[0])
    _draw_lobes(result, rows[1])
    if pictures is not None:
        draw_judgement(pictures, rows[2])
    # A file name need not be text that a font can draw; a dollar would start a formula.
    source = result.data.source.encode(errors="replace").decode().replace("$", r"\$")
    figure.suptitle(f"{result.material.model} fitted to {source}, mean log error {result.errors['log_mae']:.4f}")
    with atomic_path(path, force) as temporary:
        figure.savefig(temporary, dpi=110)


def _values(model: AbstractBRDF, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    with jax.enable_x64(True):
        return np.asarray(evaluate(model, wi, wo))


def _draw_slices(result: FitResult, figure) -> None:
    data = result.data
    angles = half_difference(data.wi, data.wo)
    column = np.minimum((np.sqrt(angles.theta_h / (np.pi / 2)) * _BINS).astype(int), _BINS - 1)
    row = np.minimum((angles.theta_d / (np.pi / 2) * _BINS).astype(int), _BINS - 1)
    cell = row * _BINS + column
    count = np.bincount(cell, minlength=_BINS * _BINS)

    def mean(values: np.ndarray) -> np.ndarray:
        sums = np.bincount(cell, values, minlength=_BINS * _BINS)
        return np.where(count > 0, sums / np.maximum(count, 1), np.nan).reshape(_BINS, _BINS)

    model = _values(result.brdf, data.wi, data.wo)
    cos_i = data.wi[:, 2:3]
    difference = (np.log1p(model * cos_i) - np.log1p(data.value * cos_i)).mean(axis=1)
    measured, fitted, residual = mean(data.value @ _LUMINANCE), mean(model @ _LUMINANCE), mean(difference)
    positive = measured[np.isfinite(measured) & (measured > 0)]
    low, high = (np.percentile(positive, 1), positive.max()) if positive.size else (1e-3, 1.0)
    norm = LogNorm(max(low, high * 1e-7) * 0.8, high * 1.25)
    bound = max(float(np.nanpercentile(np.abs(residual), 99)), 1e-6)
    axes = figure.subplots(1, 3, sharey=True)
    edges_h = (np.arange(_BINS + 1) / _BINS) ** 2 * 90
    edges_d = np.arange(_BINS + 1) / _BINS * 90
    for axis, image, title in ((axes[0], measured, "measured"), (axes[1], fitted, "fitted")):
        shown = axis.pcolormesh(edges_h, edges_d, np.maximum(image, norm.vmin or 0), norm=norm, cmap="magma")
        axis.set_title(title)
    figure.colorbar(shown, ax=list(axes[:2]), label="luminance of f (1/sr)")
    shown = axes[2].pcolormesh(edges_h, edges_d, residual, vmin=-bound, vmax=bound, cmap="RdBu_r")
    axes[2].set_title("fitted - measured, log(1 + f cos)")
    figure.colorbar(shown, ax=axes[2])
    for axis in axes:
        axis.set_xscale("function", functions=(lambda x: np.sqrt(np.maximum(x, 0)), np.square))
        axis.set_xticks([0, 1, 5, 15, 30, 50, 90])
        axis.set_xlabel("theta_h (deg)")
        axis.set_facecolor("0.85")
    axes[0].set_ylabel("theta_d (deg)")


def _draw_lobes(result: FitResult, figure) -> None:
    data = result.data
    theta_o = np.radians(np.linspace(-89, 89, 713))
    axes = figure.subplots(1, len(_INCIDENT_DEG), sharey=True)
    tops, bottoms = [], []
    for axis, degrees in zip(axes, _INCIDENT_DEG, strict=True):
        # The light stands on the left, the mirror direction is on the right.
        wi = np.broadcast_to([-np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))], (theta_o.size, 3))
        wo = np.stack([np.sin(theta_o), np.zeros_like(theta_o), np.cos(theta_o)], axis=-1)
        fitted = _values(result.brdf, wi, wo)
        if data.interpolant is not None:
            x, measured = np.degrees(theta_o), data.evaluate(wi, wo)
            style = {"linestyle": "-", "linewidth": 0.9, "alpha": 0.9}
        else:
            x, measured = _near_plane(result, degrees)
            style = {"linestyle": "none", "marker": ".", "markersize": 3, "alpha": 0.6}
        for channel, colour in enumerate(("#c1272d", "#2e8b57", "#2f5fb3")):
            axis.plot(np.degrees(theta_o), fitted[:, channel], color=colour, linewidth=2.4, alpha=0.45)
            axis.plot(x, measured[:, channel], color=colour, **style)
        axis.axvline(result.max_theta_deg, color="0.6", linewidth=0.8, linestyle=":")
        axis.axvline(-result.max_theta_deg, color="0.6", linewidth=0.8, linestyle=":")
        axis.set_title(f"theta_i = {degrees} deg")
        axis.set_xlabel("theta_o (deg), light at the left")
        axis.set_xticks([-90, -60, -30, 0, 30, 60, 90])
        inside = np.abs(np.degrees(theta_o)) < result.max_theta_deg
        tops.append(fitted[inside].max())
        bottoms.append(fitted[inside].min())
        seen = measured[np.isfinite(measured) & (measured > 0)]
        if seen.size:
            tops.append(np.percentile(seen, 99.9))
            bottoms.append(np.percentile(seen, 2))
    bottom = max(min(bottoms), max(tops) * 1e-6)
    axes[0].set_yscale("log")
    axes[0].set_ylim(bottom / 1.5, max(tops) * 2)
    axes[0].set_ylabel("f (1/sr): thin or dots measured, thick fitted")


def _near_plane(result: FitResult, degrees: float) -> tuple[np.ndarray, np.ndarray]:
    """Signed outgoing angles in degrees and values of scattered samples near the plane of incidence."""
    wi, wo = result.data.wi, result.data.wo
    theta_i = np.degrees(np.arctan2(np.hypot(wi[:, 0], wi[:, 1]), wi[:, 2]))
    theta_o = np.degrees(np.arctan2(np.hypot(wo[:, 0], wo[:, 1]), wo[:, 2]))
    forward = -(wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])
    across = np.abs(wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]) / np.maximum(np.hypot(wi[:, 0], wi[:, 1]), 1e-9)
    near = (np.abs(theta_i - degrees) < _NEAR_DEG) & (across < np.sin(np.radians(2 * _NEAR_DEG)))
    rows = np.flatnonzero(near)[:_POINTS_MAX]
    return np.copysign(theta_o[rows], forward[rows]), result.data.value[rows]

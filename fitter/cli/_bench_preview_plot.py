"""The picture of `brdf bench preview`: run time against error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shaders.bench.pictures import CaseRow

_FLIP_WANTED = 0.08
_COLOURS = {"metal": "#c98a00", "dielectric": "#b03a2e"}
# Of a number of samples beside its point, in points: the materials' do not cover each other.
_LABELS = {"metal": (4, 5), "dielectric": (-9, -12)}
_MARKERS = {"textbook": "s", "interactive": "*", "still": "D", "truth": "o"}


def plot(rows: Sequence[CaseRow], path: str, force: bool) -> None:
    """Draws a panel per environment (down) and roughness (across), both axes logarithmic.

    Raises `FileError` if the file exists without `force` or cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from brdf.atomic import atomic_path

    lights, steps = list(dict.fromkeys(r.environment for r in rows)), list(dict.fromkeys(r.roughness for r in rows))
    figure = Figure(figsize=(3.5 * len(steps) + 0.8, 3.1 * len(lights) + 1.0), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(len(lights), len(steps), squeeze=False, sharex=True, sharey=True)
    for i, light in enumerate(lights):
        for j, roughness in enumerate(steps):
            shown = [row for row in rows if row.environment == light and row.roughness == roughness]
            _draw(grid[i][j], shown)
            grid[i][j].set_title(f"{light}, roughness {roughness:g}", fontsize=11)
        grid[i][0].set_ylabel("mean FLIP over the sphere")
    for axes in grid[-1]:
        axes.set_xlabel("milliseconds of a picture")
    handles = [Line2D([], [], color="0.3", linestyle="", marker=m, label=name) for name, m in _MARKERS.items()]
    handles += [Line2D([], [], color=colour, linewidth=3, label=name) for name, colour in _COLOURS.items()]
    handles.append(Line2D([], [], color="0.5", linestyle=":", label=f"bar: FLIP {_FLIP_WANTED:g}"))
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(len(handles), 2 * len(steps)), fontsize=10, frameon=False
    )
    with atomic_path(path, force) as temporary:
        figure.savefig(temporary, dpi=110)


def _draw(axes: Axes, rows: Sequence[CaseRow]) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 3)))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for row in rows:
        for method, marker in _MARKERS.items():
            points = [(one.milliseconds, one.difference.flip_inside, one.samples) for one in row.of(method)]
            if not points:
                continue
            x, y, samples = zip(*points, strict=True)
            axes.plot(x, y, marker=marker, markersize=13 if marker == "*" else 6, color=_COLOURS[row.material])
            for at in {0, len(points) - 1} if method == "truth" else ():
                where = _LABELS[row.material]
                axes.annotate(f"{samples[at]}", (x[at], y[at]), where, textcoords="offset points", fontsize=7)
    axes.axhline(_FLIP_WANTED, color="0.5", linestyle=":", linewidth=1.2)
    axes.grid(True, which="major", alpha=0.3)

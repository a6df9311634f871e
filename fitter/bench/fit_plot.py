"""The picture of `brdf bench fit`: the cost above the best one over CPU time."""

from __future__ import annotations

import os
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from brdf.atomic import atomic_path

from .peers import OURS
from .race import SAME, Race

# Below this the difference of two costs is rounding; curves end there.
_FLOOR = 1e-12
# The axis begins so many times before the end of the fastest.
_BEFORE = 30
_COLOURS = ("#d62728", "#1f77b4", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b")


def plot(races: Sequence[Race], path: str | os.PathLike[str], force: bool = False) -> None:
    """Draws the races that several peers run, side by side, both axes logarithmic.

    **Arguments:**

    - `races`: of `fitter.bench.race`.
    - `path`: `.png`, `.pdf` or `.svg`.
    - `force`: whether an existing file may be replaced.

    Raises `FileError` if the file exists without `force` or cannot be written.
    """
    shown = [race for race in races if sum(not row.absent for row in race.rows.values()) > 2] or races[:1]
    figure = Figure(figsize=(7.5 * len(shown), 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, race in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True):
        _draw(axes, race)
    with atomic_path(path, force) as temporary:
        figure.savefig(temporary, dpi=110)


def _draw(axes: Axes, race: Race) -> None:
    axes.set(xscale="log", yscale="log")
    for (name, row), colour in zip(race.rows.items(), _COLOURS, strict=False):
        if row.absent:
            continue
        end = row.curve[-1][0]
        # The curve's own run took about the median; its axis is stretched to it.
        stretch = row.cpu / end if end else 1.0
        label = f"{name}  {'stopped after ' if row.stopped else ''}{row.cpu:.2g} s"
        if name == OURS:
            # The public fit tells its end only.
            axes.plot(row.cpu, max(row.excess, _FLOOR), "*", color=colour, markersize=17, label=label, zorder=3)
            axes.axvline(row.cpu, color=colour, linewidth=1, alpha=0.5)
            continue
        points = [(seconds * stretch, max(excess, _FLOOR)) for seconds, excess in row.curve if seconds > 0]
        axes.step(*zip(*points, strict=True), where="post", color=colour, marker="o", markersize=4, label=label)
    axes.axhline(SAME, color="0.5", linestyle=":", linewidth=1)
    axes.text(0.99, SAME * 1.3, "same final cost", color="0.4", ha="right", transform=axes.get_yaxis_transform())
    axes.set_title(f"{race.title}: {race.samples} samples", fontsize=12)
    axes.set_xlabel("CPU seconds")
    axes.set_ylabel("cost above the best, relative")
    axes.grid(True, which="major", alpha=0.3)
    # What happens before the first contestant has moved is not of interest.
    axes.set_xlim(left=min(row.cpu for row in race.rows.values() if not row.absent) / _BEFORE)
    axes.legend(fontsize=9, loc="lower left")

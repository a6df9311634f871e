"""The bars of the preview: what was wanted, what was found, and whether that is enough."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from shaders.bench.pictures import RMSE_WANTED

from ..bench.start import IMPORT_JAX, SEEN
from ._bench_preview_run import PreviewBench

_FLIP, _COST = 0.08, 1.2
_GAIN, _FRAMES = 2.0, 20.0
_FURNACE = 0.01
_TABLE_TIME, _TABLE_ERROR = 0.5, 50.0
_COLD, _WARM = 1.5, 0.9


@dataclasses.dataclass(frozen=True)
class Bar:
    """One demand on the preview; `found` is the worst case."""

    what: str
    wanted: str
    found: str
    is_met: bool

    @property
    def verdict(self) -> str:
        return "yes" if self.is_met else "NO"


def bars(found: PreviewBench) -> list[Bar]:
    """Those that were measured."""
    return [*_tier(found), *_truth(found), *_furnace(found), *_tables(found), *_start(found)]


def _tier(found: PreviewBench) -> Iterable[Bar]:
    timed = [(row.frame_ratio, row.surface_ratio, row) for row in found.pictures]
    timed = [(frame, surface, row) for frame, surface, row in timed if frame is not None and surface is not None]
    if not timed:
        return
    flips = [(row.of("interactive")[0].difference.flip_inside, row) for _, _, row in timed]
    worst, row = max(flips, key=lambda one: one[0])
    enough = sum(flip <= _FLIP for flip, _ in flips)
    where = f"{row.material} {row.roughness:g}, {row.environment}"
    yield Bar(
        "FLIP of the interactive tier over the sphere",
        f"<= {_FLIP:g}",
        f"{worst:.3f} ({where}); {enough} of {len(flips)} met",
        worst <= _FLIP,
    )
    whole = max(row.of("interactive")[0].difference.flip for _, _, row in timed)
    yield Bar("the same, over the picture", f"<= {_FLIP:g}", f"{whole:.3f}", whole <= _FLIP)
    for what, ratios in (("frame", [one[0] for one in timed]), ("surface pass", [one[1] for one in timed])):
        text = f"{max(ratios):.2f} x; {sum(ratio <= _COST for ratio in ratios)} of {len(ratios)} met"
        yield Bar(f"time of its {what} over the textbooks'", f"<= {_COST:g} x", text, max(ratios) <= _COST)


def _truth(found: PreviewBench) -> Iterable[Bar]:
    rows = [row for row in found.pictures if row.gain is not None and row.cost is not None]
    if not rows:
        return
    gains, costs = [row.gain or 0.0 for row in rows], [row.cost or 0.0 for row in rows]
    text = f"{min(gains):.2f} x; {sum(gain >= _GAIN for gain in gains)} of {len(gains)} met"
    yield Bar("4 x the samples divide the truth's error by", f">= {_GAIN:g} x", text, min(gains) >= _GAIN)
    text = f"{min(costs):.0f} to {max(costs):.0f}; {sum(cost <= _FRAMES for cost in costs)} of {len(costs)} met"
    what = f"its cost at RMSE {RMSE_WANTED:g}, in interactive frames"
    yield Bar(what, f"<= {_FRAMES:g}", text, max(costs) <= _FRAMES)


def _furnace(found: PreviewBench) -> Iterable[Bar]:
    rows = () if found.furnace is None else found.furnace.rows
    for tier in rows[0].largest if rows else ():
        for what, values in (
            ("largest of a pixel", [row.largest[tier] for row in rows]),
            ("of a ring's mean", [row.ring[tier] for row in rows]),
        ):
            worst = max(values)
            row = rows[values.index(worst)]
            met = sum(value <= _FURNACE for value in values)
            text = f"{100 * worst:.2f} % ({row.model} {row.setting}); {met} of {len(rows)} met"
            yield Bar(f"furnace, {tier}, {what}", f"<= {100 * _FURNACE:g} %", text, worst <= _FURNACE)


def _tables(found: PreviewBench) -> Iterable[Bar]:
    for one in found.tables:
        yield Bar(
            f"time of all blurs over samples', {one.environment}",
            f"<= {_TABLE_TIME:g} x",
            f"{one.ratio:.2f} x",
            one.ratio <= _TABLE_TIME,
        )
        less = [row.theirs_error / row.ours_error for row in one.rows]
        text = f"{min(less):.0f} x; {sum(times >= _TABLE_ERROR for times in less)} of {len(less)} met"
        yield Bar(
            f"their error below samples', {one.environment}", f">= {_TABLE_ERROR:g} x", text, min(less) >= _TABLE_ERROR
        )


def _start(found: PreviewBench) -> Iterable[Bar]:
    jax = next((one.wall for one in found.start if one.name == IMPORT_JAX), None)
    for one in found.start:
        most = _WARM if one.name == SEEN else _COLD
        if not one.name.startswith("import"):
            ratio = "" if jax is None else f", {one.wall / jax:.2f} x {IMPORT_JAX}"
            text = f"{one.wall:.2f} s ({one.cpu:.2f} s of CPU{ratio})"
            yield Bar(f"start, {one.name}", f"<= {most:g} s", text, one.wall <= most)

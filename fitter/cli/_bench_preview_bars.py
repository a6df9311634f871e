"""The bars of the preview: what was wanted, what was found, and whether that is enough."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from ._bench_preview_run import PreviewBench

_FLIP, _COST = 0.08, 1.2
_GAIN = 2.0
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
    gains = [row.gain for row in found.pictures if row.gain is not None]
    if gains:
        text = f"{min(gains):.2f} x; {sum(gain >= _GAIN for gain in gains)} of {len(gains)} met"
        yield Bar("4 x the samples divide the truth's error by", f">= {_GAIN:g}", text, min(gains) >= _GAIN)


def _furnace(found: PreviewBench) -> Iterable[Bar]:
    rows = () if found.furnace is None else found.furnace.rows
    for tier in rows[0].largest if rows else ():
        worst = max(rows, key=lambda row: row.largest[tier])
        text = f"{100 * worst.largest[tier]:.2f} % ({worst.model} {worst.setting})"
        yield Bar(f"furnace, {tier}", f"within {100 * _FURNACE:g} %", text, worst.largest[tier] <= _FURNACE)


def _tables(found: PreviewBench) -> Iterable[Bar]:
    for name in dict.fromkeys(one.environment for one in found.tables):
        rows = [one for one in found.tables if one.environment == name]
        time = sum(one.ours_ms for one in rows) / sum(one.theirs_ms for one in rows)
        yield Bar(
            f"time of all blurs, {name}, over samples'", f"<= {_TABLE_TIME:g} x", f"{time:.2f} x", time <= _TABLE_TIME
        )
        less = min(one.theirs_error / one.ours_error for one in rows)
        yield Bar(
            f"their error below samples', {name}", f">= {_TABLE_ERROR:g} x", f"{less:.0f} x", less >= _TABLE_ERROR
        )


def _start(found: PreviewBench) -> Iterable[Bar]:
    for name, seconds in found.start.items():
        most = _WARM if name == "tables warm" else _COLD
        if not name.startswith("import"):
            yield Bar(f"start, {name}", f"<= {most:g} s", f"{seconds:.2f} s", seconds <= most)

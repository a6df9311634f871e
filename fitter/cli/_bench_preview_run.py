"""Runs the parts of `brdf bench preview` that are asked for."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shaders.bench.furnace import Furnace
    from shaders.bench.pictures import CaseRow, PictureSettings
    from shaders.bench.tables import TableRow

# The furnace: noise of the truth falls with the root of the samples, so pictures are small and samples many.
_FURNACE_SIZE, _FURNACE_SAMPLES = 48, 4096


@dataclasses.dataclass(frozen=True)
class PreviewBench:
    """Everything that was measured; empty or None where it was not.

    - `start`: name -> seconds of a process.
    - `renderer`, `load`: of OpenGL, and of this machine (runnable processes, mean of a minute) before and after; None
      where the system does not say.
    """

    pictures: list[CaseRow]
    furnace: Furnace | None
    tables: list[TableRow]
    start: dict[str, float]
    settings: PictureSettings
    renderer: str
    load: tuple[float, float] | None


def measure(settings: PictureSettings, sections: Collection[str], say: Callable[[str], None]) -> PreviewBench:
    """Measures one part after the other.

    Raises `UserError` without OpenGL 4.3 or FLIP, or for an environment that cannot be used.
    """
    from shaders.bench.furnace import measure_furnace
    from shaders.bench.pictures import measure_pictures
    from shaders.bench.tables import measure_tables
    from shaders.context import device

    from ..bench.start import measure_start

    before = _load()
    start = measure_start(settings.frames, say) if "start" in sections else {}
    tables = measure_tables(settings.environments, settings.frames, say) if "tables" in sections else []
    furnace = None
    if "furnace" in sections:
        samples = min(_FURNACE_SAMPLES, 4 * max(settings.samples, default=_FURNACE_SAMPLES))
        furnace = measure_furnace(min(settings.size, _FURNACE_SIZE), samples, settings.roughness, say)
    pictures = []
    if {"tier", "truth"} & set(sections):
        pictures = measure_pictures(settings, "tier" in sections, say)
    after = _load()
    load = None if before is None or after is None else (before, after)
    return PreviewBench(pictures, furnace, tables, start, settings, device().renderer, load)


def _load() -> float | None:
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None

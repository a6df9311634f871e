"""Runs the parts of `brdf bench preview` that are asked for."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shaders.bench.furnace import Furnace
    from shaders.bench.pictures import CaseRow, PictureSettings
    from shaders.bench.tables import Tables

    from ..bench.start import Start

# The furnace: many samples until the worst pixel shows the model and not noise, so pictures are small. Some models are
# harder to draw than others: all are asked for the same error.
_FURNACE_SIZE, FURNACE_ERROR = 48, 0.00025


@dataclasses.dataclass(frozen=True)
class PreviewBench:
    """Everything that was measured; empty or None where it was not.

    - `renderer`, `load`: of OpenGL, and of this machine (runnable processes, mean of a minute) before and after; None
      where the system does not say.
    """

    pictures: list[CaseRow]
    furnace: Furnace | None
    tables: list[Tables]
    start: list[Start]
    settings: PictureSettings
    renderer: str
    load: tuple[float, float] | None


def measure(
    settings: PictureSettings, rounds: int, sections: Collection[str], say: Callable[[str], None]
) -> PreviewBench:
    """Measures one part after the other; of tables and processes so many rounds.

    Raises `UserError` without OpenGL 4.3 or FLIP, or for an environment that cannot be used.
    """
    from brdf.registry import MODELS
    from shaders.bench.furnace import measure_furnace
    from shaders.bench.pictures import measure_pictures
    from shaders.bench.tables import measure_tables
    from shaders.context import device

    from ..bench.start import measure_start

    before = _load()
    start = measure_start(rounds, say) if "start" in sections else []
    tables = measure_tables(settings.environments, rounds, say) if "tables" in sections else []
    furnace = None
    if "furnace" in sections:
        furnace = measure_furnace(list(MODELS), _FURNACE_SIZE, FURNACE_ERROR, settings.roughness, say)
    pictures = []
    if {"tier", "truth"} & set(sections):
        pictures = measure_pictures(settings, "tier" in sections, say)
    after = _load()
    load = None if before is None or after is None else (before, after)
    return PreviewBench(pictures, furnace, tables, start, settings, device().renderer, load)


def _load() -> float | None:
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None

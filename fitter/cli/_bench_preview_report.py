"""The figures of `brdf bench preview`: as text, as the page of the docs, and as plain data."""

from __future__ import annotations

import dataclasses
import math
import os
import statistics
from collections.abc import Iterable
from typing import Any

from shaders.bench.pictures import RMSE_WANTED, CaseRow

from ..bench.tables import Table, aligned, filled, piped
from ._bench_preview_bars import bars
from ._bench_preview_run import FURNACE_ERROR, PreviewBench

# A title, sentences, and a table, each of which may be empty.
Part = tuple[str, list[str], Table]
_MITSUBA = (
    "The comparison of the truth with Mitsuba 3 is a program of its own: `python tests/benchmarks/mitsuba_preview.py`. "
    "Bad pixels are looked for by `pytest -m 'heavy or not heavy' tests/shaders/test_no_bad_pixel.py`."
)


def data(found: PreviewBench) -> dict[str, Any]:
    """JSON-serialisable."""
    return dataclasses.asdict(found) | {"bars": [dataclasses.asdict(bar) for bar in bars(found)]}


def text(found: PreviewBench) -> str:
    """Tables of aligned columns."""
    blocks: list[str] = [filled(_how(found))]
    for title, sentences, table in _parts(found):
        blocks += [title.upper(), *(filled(one) for one in sentences), *([aligned(table)] if table else [])]
    return "\n\n".join(blocks)


def markdown(found: PreviewBench, plot: str | None) -> str:
    """The page of the docs, with the picture `plot` (a path beside the page) if there is one."""
    blocks = ["<!-- Made by `brdf bench preview --markdown`. -->", "# Speed and error of the preview", _how(found)]
    if plot:
        blocks.append(f"![Run time against error]({plot})")
    for title, sentences, table in _parts(found):
        blocks += [f"## {title}", *sentences, *([piped(table)] if table else [])]
    return "\n\n".join(blocks) + "\n"


def _parts(found: PreviewBench) -> Iterable[Part]:
    yield "Bars", [], [("", "wanted", "found", "met"), *((b.what, b.wanted, b.found, b.verdict) for b in bars(found))]
    if found.pictures:
        if any(row.frame_ratio is not None for row in found.pictures):
            yield "The interactive tier", [_TIER.format(found.settings.timed_size)], _tier(found)
        if found.settings.samples:
            yield "The truth and stills", [_TRUTH.format(RMSE_WANTED), _MITSUBA], _truth(found)
    if found.furnace is not None:
        reasons = "; ".join(f"`{name}` {why}" for name, why in found.furnace.left_out.items())
        yield "Furnace", [_FURNACE.format(FURNACE_ERROR), f"Left out: {reasons}."], _furnace(found)
    if found.tables:
        cubes = ", ".join(f"{one.cube_ms:.0f} ({one.environment})" for one in found.tables)
        yield "Blurred environments", [_TABLES.format(cubes)], _tables(found)
    if found.start:
        yield "Cold start", [_START], _start(found)


def _look_ups(row: CaseRow) -> str:
    return f"{row.look_ups}, sun" if row.has_sun else f"{row.look_ups}"


def _how(found: PreviewBench) -> str:
    load = "" if found.load is None else " The load was {:.1f} before, {:.1f} after.".format(*found.load)
    size = found.settings.size
    return (
        f"Renderer: {found.renderer}, {os.cpu_count()} cores.{load} Differences are those of pictures of {size} x "
        f"{size} pixels for displays (Khronos PBR Neutral, sRGB) from the truth, on grey; FLIP at 67 pixels per "
        "degree. Seconds differ between machines; compare the ratios."
    )


_TIER = (
    "A sphere of gold-like GGX (metal) or of Lambert + GGX with f0 0.04 (dielectric), alpha = roughness squared. FLIP "
    "is the mean over the sphere, in brackets over the picture. Time is in units of the textbooks' split sum "
    "(irradiance of 32 texels a side, five levels from 128, 1024 filtered samples; same mesh, targets and samples per "
    "pixel), frames drawn by turns, median of the ratios at {0} x {0} pixels: surface pass, and all passes. Look-ups "
    "are of cube maps, in a pixel, beside the sun where the material is lit by it apart; the textbooks' has two, one "
    "of them in two levels, and one of a table. Error is what the truth says of its own RMSE."
)
_TRUTH = (
    "RMSE (sRGB, over the sphere) by light samples per pixel, and by how much four times as many divide it, the "
    "truth's own error taken off; the truth to compare with has other random points. Cost: all passes of a picture "
    "with RMSE {:g} in frames of the interactive tier of the same size, by the line through the two largest numbers of "
    "samples."
)
_FURNACE = (
    "Light that is 1 everywhere: the largest deviation of a pixel of the sphere from 1 in percent, noise and bias, and "
    "in brackets that of the means over eight rings with as many pixels each, nearly without noise; the outermost is "
    "the rim. The truth stops where it estimates its RMS error as {:g} in sRGB. All models whose claims keep the "
    "energy and that are white with all colours at 1."
)
_TABLES = (
    "Irradiance and the blurs of GGX of roughness 0.5 and more (power 2, by width), built without the cache of tables, "
    "by turns with 64-sample filtered importance sampling of the same cubes from the environment's own, the level by "
    "the density of the sample; relative RMS error at 50 random directions, from direct summation in float64. The "
    "first blur of ours holds what is found out for all; the environment's digest, tables by size alone, which all "
    "environments share, and programs are made before. Milliseconds of the environment's own cube, which only the "
    "samples need, are in none: {}."
)
_START = (
    "Seconds of whole processes, by turns: `brdf preview gold.json -e 1k.hdr --tier interactive`, 512 x 512 pixels. "
    "Nothing kept: no table, no program of Mesa's, and nothing of what models declare, so that JAX is loaded. New "
    "material, new light: one of the same model and choices was drawn before, so that what the model declares and "
    "Mesa's programs are kept, but no table of this material or light. Of the wall's seconds: Python, imports, files "
    "and the picture's encoding (before), the context, programs and the material's fit by round lobes (plan), the "
    "blurs, and all other passes (drawing). Beside them what an import takes."
)


def _tier(found: PreviewBench) -> Table:
    head = (
        "",
        "roughness",
        "light",
        "FLIP",
        "RMSE",
        "FLIP, textbook",
        "RMSE, textbook",
        "surface",
        "frame",
        "look-ups",
        "error",
    )
    rows: Table = [head]
    for row in found.pictures:
        cells = [row.material, f"{row.roughness:g}", row.environment]
        for name in ("interactive", "textbook"):
            one = row.of(name)[0].difference
            cells += [f"{one.flip_inside:.3f} ({one.flip:.3f})", f"{one.rmse:.4f}"]
        rows.append(
            [*cells, _times(row.surface_ratio), _times(row.frame_ratio), _look_ups(row), f"{row.truth_error:.4f}"]
        )
    return rows


def _truth(found: PreviewBench) -> Table:
    counts = found.settings.samples
    head = ("", "roughness", "light", "still", *(f"{count}" for count in counts), "gain of 4 x", "cost", "error")
    rows: Table = [head]
    for row in found.pictures:
        errors = [f"{point.difference.rmse:.4f}" for point in (*row.of("still"), *row.of("truth"))]
        ends = [_times(row.gain), "n/a" if row.cost is None else f"{row.cost:.0f}", f"{row.truth_error:.4f}"]
        rows.append([row.material, f"{row.roughness:g}", row.environment, *errors, *ends])
    return rows


def _furnace(found: PreviewBench) -> Table:
    assert found.furnace is not None
    tiers = list(found.furnace.rows[0].largest) if found.furnace.rows else []
    rows: Table = [("", "", *tiers)]
    for row in found.furnace.rows:
        cells = [f"{100 * row.largest[tier]:.2f} ({100 * row.ring[tier]:.2f})" for tier in tiers]
        rows.append([row.model, row.setting, *cells])
    return rows


def _tables(found: PreviewBench) -> Table:
    rows: Table = [("", "kernel", "texels", "ms", "ms, samples", "time", "error", "error, samples", "less error")]
    for light in found.tables:
        for one in light.rows:
            sizes = [light.environment, one.kernel, f"{one.texels}", f"{one.ours_ms:.1f}", f"{one.theirs_ms:.1f}"]
            errors = [f"{one.ours_error:.2g}", f"{one.theirs_error:.2g}", _times(one.theirs_error / one.ours_error)]
            rows.append([*sizes, _times(one.ours_ms / one.theirs_ms), *errors])
        less = math.exp(statistics.fmean(math.log(one.theirs_error / one.ours_error) for one in light.rows))
        sums = [f"{light.ours_ms:.0f}", f"{light.theirs_ms:.0f}", _times(light.ratio)]
        rows.append([light.environment, "all", "", *sums, "", "", _times(less)])
    return rows


def _start(found: PreviewBench) -> Table:
    rows: Table = [("", "wall", "CPU", "before", "plan", "blurs", "drawing")]
    for one in found.start:
        parts = (one.wall, one.cpu, one.before, one.plan, one.blurs, one.drawing)
        rows.append([one.name, *("" if part is None else f"{part:.2f}" for part in parts)])
    return rows


def _times(ratio: float | None) -> str:
    return "n/a" if ratio is None else f"{ratio:.3g} x"

"""How long a cold process takes from the command to the picture, beside what Python and JAX take to start."""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from brdf.material import Material, save_material
from brdf.registry import MODELS

_GOLD, _ALPHA = (1.0, 0.78, 0.34), 0.09
_WIDTH, _SIZE, _SEED = 1024, 512, 6
# Of the run lengths of a Radiance picture.
_RUN_MIN, _RUN_MAX = 4, 127
_MAIN = "from fitter.cli.main import main; main()"
NOTHING_KEPT, NEW, SEEN = "nothing kept", "new material, new light", "both seen before"
# What each finds on disk: folders of our cache, and Mesa's programs.
_PROGRAMS = "programs"
_CASES = {NOTHING_KEPT: (), NEW: ("models", _PROGRAMS), SEEN: ("models", "tables", _PROGRAMS)}
IMPORT_JAX = "import jax"
_IMPORTS = (IMPORT_JAX, "import numpy")


@dataclasses.dataclass(frozen=True)
class Start:
    """A process, medians of all rounds in seconds.

    - `wall`, `cpu`: of the whole process, user and system.
    - `before`: of the wall's, those outside the renderer: Python, imports, files, writing the picture.
    - `plan`: those in it and not in a pass: the context, the material's fit by round lobes, compilation.
    - `blurs`, `drawing`: of the pass that blurs the environment, and of all others.
    """

    name: str
    wall: float
    cpu: float
    before: float | None = None
    plan: float | None = None
    blurs: float | None = None
    drawing: float | None = None


def measure_start(rounds: int, say: Callable[[str], None]) -> list[Start]:
    """Whole processes, run by turns.

    Three are `brdf preview` of a gold-like material, a 1024 x 512 environment and a picture of 512 x 512, the
    interactive tier:

    - nothing is kept: neither what models declare (`shaders.kept_models`), nor tables, nor Mesa's programs;
    - the material and the light are new, but one of the same model and choices was drawn: what the model declares and
      Mesa's programs are kept, but no table, each of which is of one material or light;
    - both were seen before: all is kept.

    The others only import. Python's own cache is warm in all, as an installation leaves it.

    Raises `RuntimeError` with a process's last words if it fails.
    """
    found: dict[str, list[Start]] = {name: [] for name in (*_CASES, *_IMPORTS)}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        material, light = folder / "gold.json", folder / "1k.hdr"
        save_material(Material(MODELS["ggx"](f0=_GOLD, alpha=_ALPHA)), material)
        write_hdr(light, _light())
        arguments = ["preview", str(material), "-e", str(light), "--size", str(_SIZE), "--tier", "interactive"]
        command = [_MAIN, *arguments, "-o", str(folder / "x.png"), "--force", "--json"]
        kept = folder / "kept"
        _run("", command, _caches(kept))  # fills it, and Python's own cache
        for number in range(rounds):
            for case, parts in _CASES.items():
                say(f"start: {case}, round {number + 1}")
                with tempfile.TemporaryDirectory() as own:
                    for part in parts:
                        shutil.copytree(kept / part, pathlib.Path(own) / part)
                    found[case].append(_run(case, command, _caches(pathlib.Path(own))))
            for case in _IMPORTS:
                found[case].append(_run(case, [case], {}))
    return [_median(runs) for runs in found.values()]


def _caches(folder: pathlib.Path) -> dict[str, str]:
    return {"BRDF_CACHE_DIR": str(folder), "MESA_SHADER_CACHE_DIR": str(folder / _PROGRAMS)}


def _run(name: str, command: Sequence[str], variables: Mapping[str, str]) -> Start:
    """Python with a program and its arguments; one that prints JSON has the counts of a picture in it."""
    environment = {**os.environ, **variables}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    began, before = time.perf_counter(), _cpu_of_children()
    done = subprocess.run([sys.executable, "-c", *command], capture_output=True, text=True, env=environment)
    wall, cpu = time.perf_counter() - began, _cpu_of_children() - before
    if done.returncode != 0:
        raise RuntimeError(f"`{name}` ended with {done.returncode}: {done.stderr[-500:]}")
    if not done.stdout:
        return Start(name, wall, cpu)
    counts: dict[str, Any] = json.loads(done.stdout)["counts"]
    passes = {key: 1e-3 * value for key, value in counts["milliseconds"].items()}
    blurs, total = passes.pop("blurs", 0.0), sum(passes.values())
    return Start(name, wall, cpu, wall - counts["seconds"], counts["seconds"] - total - blurs, blurs, total)


def _cpu_of_children() -> float:
    used = os.times()
    return used.children_user + used.children_system


def _median(runs: Sequence[Start]) -> Start:
    medians = {}
    for field in dataclasses.fields(Start)[1:]:
        values = [getattr(run, field.name) for run in runs]
        medians[field.name] = None if None in values else statistics.median(values)
    return Start(runs[0].name, **medians)


def _light() -> np.ndarray:
    """A bright sky above a dim ground, grainy as a photograph, and a sun: linear, shape (512, 1024, 3)."""
    v = (np.arange(_WIDTH // 2) + 0.5) / (_WIDTH // 2)
    rows = np.where(v[:, None] < 0.5, 1.5 - v[:, None], 0.2) * np.array([0.6, 0.8, 1.0])
    pixels = rows[:, None] * np.random.default_rng(_SEED).uniform(0.9, 1.1, (len(v), _WIDTH, 1))
    pixels[140:144, 300:304] = 2e4
    return pixels


def write_hdr(path: pathlib.Path, pixels: np.ndarray) -> None:
    """Writes a Radiance picture with run lengths, as cameras' are: positive values, shape (h, w, 3), w from 8 on."""
    mantissa, exponent = np.frexp(pixels.max(axis=-1))
    values = np.floor(pixels * (mantissa * 256 / pixels.max(axis=-1))[..., None])
    rgbe = np.concatenate([values, exponent[..., None] + 128], axis=-1).astype(np.uint8)
    height, width = rgbe.shape[:2]
    content = bytearray(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
    for line in rgbe:
        content += bytes([2, 2, width >> 8, width & 255])
        for channel in line.T:
            content += _encoded(channel)
    path.write_bytes(content)


def _encoded(channel: np.ndarray) -> bytes:
    """Runs of equal bytes by their length plus 128, others by their number."""
    found = bytearray()
    ends = np.append(np.flatnonzero(np.diff(channel)) + 1, len(channel))
    literal = bytearray()
    for start, end in zip(np.append(0, ends[:-1]), ends, strict=True):
        if end - start < _RUN_MIN:
            literal += channel[start:end].tobytes()
            continue
        found += _literal(literal)
        literal.clear()
        for at in range(start, end, _RUN_MAX):
            found += bytes([128 + min(end - at, _RUN_MAX), channel[start]])
    return bytes(found + _literal(literal))


def _literal(content: bytes | bytearray) -> bytes:
    return b"".join(
        bytes([len(part)]) + part for part in (content[at : at + 128] for at in range(0, len(content), 128))
    )

"""How long a cold process takes from the command to the picture, beside what Python and JAX take to start."""

from __future__ import annotations

import contextlib
import os
import pathlib
import statistics
import sys
import tempfile
from collections.abc import Callable, Sequence

import numpy as np

from brdf.material import Material, save_material
from brdf.registry import MODELS

from .resources import wall

_GOLD, _ALPHA = (1.0, 0.78, 0.34), 0.09
_WIDTH, _SIZE = 1024, 512
# Name -> which of the two caches, of our tables and of Mesa's programs, are warm.
_CASES = {"both caches empty": (False, False), "tables empty": (False, True), "tables warm": (True, True)}
_IMPORTS = {"import jax": "import jax", "import numpy": "import numpy"}


def measure_start(rounds: int, say: Callable[[str], None]) -> dict[str, float]:
    """Name -> median wall seconds of whole processes, run by turns.

    Three are `brdf preview` of a gold-like material, a 1024 x 512 environment and a picture of 512 x 512, the
    interactive tier: with the caches of tables and of Mesa's programs empty, with that of tables empty, and with both
    warm. The others only import.
    """
    seconds: dict[str, list[float]] = {name: [] for name in (*_CASES, *_IMPORTS)}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        material, light = folder / "gold.json", folder / "1k.hdr"
        save_material(Material(MODELS["ggx"](f0=_GOLD, alpha=_ALPHA)), material)
        write_hdr(light, _light())
        command = [
            sys.executable,
            "-c",
            "from fitter.cli.main import main; main()",
            "preview",
            str(material),
            "-e",
            str(light),
        ]
        command += ["--size", str(_SIZE), "--tier", "interactive", "-o", str(folder / "x.png"), "--force", "-q"]
        _preview(command, folder / "tables", folder / "mesa")  # fills both, and Python's own cache
        for number in range(rounds):
            for case, (has_tables, has_programs) in _CASES.items():
                say(f"start: {case}, round {number + 1}")
                with contextlib.ExitStack() as stack:
                    caches = [
                        folder / kind if warm else pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
                        for kind, warm in (("tables", has_tables), ("mesa", has_programs))
                    ]
                    seconds[case].append(_preview(command, *caches))
            for case, code in _IMPORTS.items():
                seconds[case].append(wall([sys.executable, "-c", code], dict(os.environ)))
    return {case: statistics.median(found) for case, found in seconds.items()}


def _preview(command: Sequence[str], tables: pathlib.Path, programs: pathlib.Path) -> float:
    caches = {"BRDF_CACHE_DIR": str(tables), "MESA_SHADER_CACHE_DIR": str(programs)}
    return wall(command, os.environ | caches)


def _light() -> np.ndarray:
    """A bright sky above a dim ground, and a sun: linear, shape (512, 1024, 3)."""
    v = (np.arange(_WIDTH // 2) + 0.5) / (_WIDTH // 2)
    rows = np.where(v[:, None] < 0.5, 1.5 - v[:, None], 0.2) * np.array([0.6, 0.8, 1.0])
    pixels = np.repeat(rows[:, None], _WIDTH, axis=1)
    pixels[140:144, 300:304] = 2e4
    return pixels


def write_hdr(path: pathlib.Path, pixels: np.ndarray) -> None:
    """Writes a Radiance picture without run lengths: positive values, shape (h, w, 3)."""
    mantissa, exponent = np.frexp(pixels.max(axis=-1))
    values = np.floor(pixels * (mantissa * 256 / pixels.max(axis=-1))[..., None])
    rgbe = np.concatenate([values, exponent[..., None] + 128], axis=-1).astype(np.uint8)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {pixels.shape[0]} +X {pixels.shape[1]}\n"
    path.write_bytes(head.encode() + rgbe.tobytes())

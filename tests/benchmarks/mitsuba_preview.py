"""Tier 3 beside Mitsuba 3: error against time under one camera and environment.

    python tests/benchmarks/mitsuba_preview.py sky.hdr --references folder

Mitsuba's rows are spread from pole to pole, texel centres on the poles (`v = acos(y) / pi (H - 1)`), and its column 0
looks along -z. The picture it gets has 2 H + 1 rows, at which ours is interpolated exactly, and is turned by half:
both see the same light. Errors are those of the sRGB-encoded picture, clipped to [0, 1], inside the ball; the
reference's own noise is estimated from two halves of its samples. Costs
are compared with a frame of tier 1 of the same size, by turns with it. Needs `mitsuba` and `flip-evaluator`, and ends
with a sentence when one is missing.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import math
import pathlib
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import brdf
from brdf.model import AbstractBRDF
from shaders import Environment, Part, Renderer, Scene, load_environment, render
from shaders.context import device
from shaders.scene import Tier

_SIZE = 128
# Samples of the reference in one go, for the memory of Mitsuba's vectorised variants.
_PASS = 1024
_COUNTS = (32, 64, 128, 256, 512, 1024)
# The truth draws whole frames of 16 samples.
_STEP = 16
# The cost of a frame is measured at these sizes, that of a sample by the difference of two truths.
_SIZES = (128, 512)
_TRUTHS: tuple[tuple[Tier, int], ...] = (("truth", 32), ("truth", 128))
_REPEATS = 5
_ETA, _K = (0.3, 0.9, 1.1), (3.9, 2.4, 2.2)
_ALBEDO = (0.9, 0.6, 0.3)

Picture = NDArray[np.float32]


def cases() -> dict[str, tuple[AbstractBRDF, dict[str, Any]]]:
    """Ours and Mitsuba's by name: the models that are the same formula."""
    found: dict[str, tuple[AbstractBRDF, dict[str, Any]]] = {
        "lambert": (brdf.MODELS["lambert"](albedo=_ALBEDO), {"type": "diffuse", "reflectance": _rgb(_ALBEDO)})
    }
    for name, alpha in (("ggx", 0.1), ("ggx", 0.3), ("ggx", 0.6), ("beckmann", 0.3)):
        ours = brdf.MODELS[name](
            alpha=alpha, eta=_ETA, k=_K, masking="smith_separable", fresnel="conductor", energy="single"
        )
        theirs = {"type": "roughconductor", "distribution": name, "alpha": alpha, "eta": _rgb(_ETA), "k": _rgb(_K)}
        found[f"{name} {alpha}"] = (ours, theirs)
    return found


def _rgb(values: tuple[float, float, float]) -> dict[str, Any]:
    return {"type": "rgb", "value": list(values)}


def for_mitsuba(pixels: Picture) -> Picture:
    """Our picture, shape (h, w, 3), as Mitsuba's environment map, shape (2 h + 1, w, 3)."""
    padded = np.pad(pixels, ((1, 1), (0, 0), (0, 0)), mode="edge")
    rows = np.repeat(padded[1:-1], 2, axis=0)
    # Even rows lie midway between two of ours, odd ones on them.
    rows = np.concatenate([rows, rows[-1:]])
    rows[0::2] = 0.5 * (padded[:-1] + padded[1:])
    return np.ascontiguousarray(np.roll(rows, pixels.shape[1] // 2, axis=1))


def halves(mi: Any, bsdf: dict[str, Any], sky: Picture, samples: int, kept: pathlib.Path | None) -> Picture:
    """Two pictures of half of the samples each, shape (2, h, w, 3), from the file if it is there."""
    if kept is not None and kept.exists():
        return np.load(kept)
    passes = max(samples // (2 * _PASS), 1)
    found = np.zeros((2, _SIZE, _SIZE, 3))
    for number in range(2 * passes):
        found[number % 2] += reference(mi, bsdf, sky, min(samples // 2, _PASS), number) / passes
    found = found.astype(np.float32)
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.save(kept, found)
    return found


def reference(mi: Any, bsdf: dict[str, Any], sky: Picture, samples: int, seed: int) -> Picture:
    """Mitsuba's picture of a ball under a sky, shape (h, w, 3)."""
    camera = mi.ScalarTransform4f().look_at(origin=[0, 0, 4.77], target=[0, 0, 0], up=[0, 1, 0])
    film = {
        "type": "hdrfilm",
        "width": _SIZE,
        "height": _SIZE,
        "pixel_format": "rgb",
        "rfilter": {"type": "box"},
    }
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "sensor": {
                "type": "perspective",
                "fov": 30,
                "fov_axis": "y",
                "to_world": camera,
                "film": film,
                "sampler": {"type": "multijitter", "sample_count": samples},
            },
            "ball": {"type": "sphere", "bsdf": bsdf},
            "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky)},
        }
    )
    return np.array(mi.render(scene, seed=seed), np.float32)


def scene_of(
    model: AbstractBRDF, environment: Environment, tier: Tier, samples: int | None, size: int, turn: float
) -> Scene:
    """A ball without a sky behind it; `turn` is the environment's rotation."""
    return Scene(
        (Part(model),),
        environment,
        turn,
        width=size,
        height=size,
        tier=tier,
        samples=samples,
        sky="none",
        tone_map="none",
    )


def ours(model: AbstractBRDF, environment: Environment, samples: int) -> tuple[Picture, Picture]:
    """Our picture and its coverage."""
    pixels = render(scene_of(model, environment, "truth", samples, _SIZE, 0.0)).pixels
    return pixels[..., :3], pixels[..., 3]


def frame_cost(model: AbstractBRDF, environment: Environment, size: int) -> tuple[float, float, float]:
    """Seconds of a frame of tier 1, of a truth without samples, and of each of its samples."""
    keys: tuple[tuple[Tier, int | None], ...] = (("interactive", None), *_TRUTHS)
    renderers = {key: Renderer() for key in keys}
    seconds: dict[tuple[Tier, int | None], list[float]] = {key: [] for key in renderers}
    # The first frames compile; a sky that turns leaves nothing but the drawing to do.
    for turn in range(_REPEATS + 1):
        for (tier, samples), renderer in renderers.items():
            scene = scene_of(model, environment, tier, samples, size, 1e-2 * turn)
            started = _now()
            renderer.render(scene)
            seconds[tier, samples].append(_now() - started)
    tier_1, few, many = (min(one[1:]) for one in seconds.values())
    per_sample = (many - few) / (_TRUTHS[1][1] - _TRUTHS[0][1])
    return tier_1, few - _TRUTHS[0][1] * per_sample, per_sample


def _now() -> float:
    """A software renderer's threads are this process's own, and their clock does not count what others do meanwhile."""
    return time.process_time() if device().is_software else time.perf_counter()


def srgb(linear: Picture) -> Picture:
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055).astype(np.float32)


def _rms(difference: Picture) -> float:
    return float(np.sqrt(np.mean(np.square(difference, dtype=np.float64))))


def errors(flip: Any, found: Picture, truth: Picture, inside: NDArray[np.bool_]) -> tuple[float, float]:
    """sRGB RMSE and mean FLIP inside the ball, of encoded pictures."""
    masked = [np.where(inside[..., None], picture, 0).astype(np.float32) for picture in (truth, found)]
    seen = flip.evaluate(*masked, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False)[0]
    return _rms((found - truth)[inside]), float(np.squeeze(seen)[inside].mean())


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("environment", help="a built-in name or a .hdr or .exr file")
    arguments.add_argument("--reference-samples", type=int, default=4096)
    arguments.add_argument("--references", type=pathlib.Path, help="a folder that keeps Mitsuba's pictures")
    arguments.add_argument("--variant", default="scalar_rgb", help="of Mitsuba; llvm_ad_rgb is quicker")
    given = arguments.parse_args()
    missing = [name for name in ("mitsuba", "flip_evaluator") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"skipped: {' and '.join(missing)} missing")
        return 0
    # Optional packages, which the type checker need not find.
    mi: Any = importlib.import_module("mitsuba")
    flip: Any = importlib.import_module("flip_evaluator")
    mi.set_variant(given.variant)
    environment = load_environment(given.environment)
    sky = for_mitsuba(environment.pixels)
    print(f"Mitsuba {mi.__version__} {given.variant}, {given.reference_samples} samples, {_SIZE} x {_SIZE}")
    for name, (model, bsdf) in cases().items():
        kept = None
        if given.references is not None:
            stem = pathlib.Path(given.environment).stem
            kept = given.references / f"{stem} {name} {given.reference_samples}.npy"
        pair = halves(mi, bsdf, sky, given.reference_samples, kept)
        truth = srgb(pair.mean(axis=0))
        # Of one frame alone, pixels on the outline are covered or not; Mitsuba has its sky behind them.
        inside = ours(model, environment, _COUNTS[-1])[1] == 1
        found = [errors(flip, srgb(ours(model, environment, n)[0]), truth, inside) for n in _COUNTS]
        noise = _rms((srgb(pair[0]) - srgb(pair[1]))[inside]) / 2
        slope = np.polyfit(np.log2(_COUNTS), np.log2([error for error, _ in found]), 1)[0]
        print(f"{name}: the reference's noise {noise:.4f}; error x {2 ** (2 * slope):.2f} for 4 x samples")
        for samples, (error, seen) in zip(_COUNTS, found, strict=True):
            print(f"  {samples:5d} samples  sRGB RMSE {error:.4f}  FLIP {seen:.4f}")
        for size in _SIZES:
            tier_1, fixed, per_sample = frame_cost(model, environment, size)
            affordable = max(int((20 * tier_1 - fixed) / per_sample) // _STEP, 1) * _STEP
            error, seen = errors(flip, srgb(ours(model, environment, affordable)[0]), truth, inside)
            print(
                f"  {size} x {size}: a frame of tier 1 {1e3 * tier_1:.1f} ms, a sample {1e3 * per_sample:.3f} ms; "
                f"20 frames: {affordable} samples, sRGB RMSE {error:.4f}  FLIP {seen:.4f}",
                flush=True,
            )
        if not math.isfinite(found[-1][0]):
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

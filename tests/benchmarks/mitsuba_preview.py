"""Tier 3 beside Mitsuba 3: error against time under one camera and environment.

    python tests/benchmarks/mitsuba_preview.py sky.hdr --reference-samples 1024

Mitsuba's rows are spread from pole to pole, texel centres on the poles (`v = acos(y) / pi (H - 1)`), and its column 0
looks along -z. The picture it gets has 2 H + 1 rows, at which ours is interpolated exactly, and is turned by half:
both see the same light. Errors are those of the sRGB-encoded picture, clipped to [0, 1], inside the ball; the
reference's own noise is estimated from two halves of its samples. Needs `mitsuba` and `flip-evaluator`, and ends with a
sentence when one is missing.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import math
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import brdf
from brdf.model import AbstractBRDF
from shaders import Environment, Part, Scene, load_environment, render

_SIZE = 128
_COUNTS = (16, 32, 64, 128, 256, 512)
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
                "sampler": {"type": "independent", "sample_count": samples},
            },
            "ball": {"type": "sphere", "bsdf": bsdf},
            "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky)},
        }
    )
    return np.array(mi.render(scene, seed=seed), np.float32)


def ours(model: AbstractBRDF, environment: Environment, samples: int) -> tuple[Picture, Picture, float]:
    """Our picture, its coverage, and the seconds that it took."""
    scene = Scene((Part(model),), environment, width=_SIZE, height=_SIZE, samples=samples, sky="none", tone_map="none")
    render(scene)
    image = min((render(scene) for _ in range(3)), key=lambda one: one.counts["seconds"])
    return image.pixels[..., :3], image.pixels[..., 3], float(image.counts["seconds"])


def srgb(linear: Picture) -> Picture:
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055).astype(np.float32)


def _rms(difference: Picture) -> float:
    return float(np.sqrt(np.mean(np.square(difference, dtype=np.float64))))


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("environment", help="a built-in name or a .hdr or .exr file")
    arguments.add_argument("--reference-samples", type=int, default=1024)
    arguments.add_argument("--variant", default="scalar_rgb")
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
        started = time.perf_counter()
        halves = [reference(mi, bsdf, sky, given.reference_samples // 2, seed) for seed in (1, 2)]
        seconds = time.perf_counter() - started
        truth = srgb(0.5 * (halves[0] + halves[1]))
        # Of one frame alone, pixels on the outline are covered or not; Mitsuba has its sky behind them.
        inside = ours(model, environment, _COUNTS[-1])[1] == 1
        rows, errors = [], []
        for samples in _COUNTS:
            linear, _, cost = ours(model, environment, samples)
            found = srgb(linear)
            errors.append(_rms((found - truth)[inside]))
            masked = [np.where(inside[..., None], picture, 0).astype(np.float32) for picture in (truth, found)]
            errors_seen = flip.evaluate(*masked, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False)[0]
            rows.append((samples, cost, errors[-1], float(np.squeeze(errors_seen)[inside].mean())))
        noise = _rms((srgb(halves[0]) - srgb(halves[1]))[inside]) / 2
        slope = np.polyfit(np.log2(_COUNTS), np.log2(errors), 1)[0]
        print(
            f"{name}: reference {seconds:.0f} s, its noise {noise:.4f}; error x {2 ** (2 * slope):.2f} for 4 x samples"
        )
        for samples, cost, error, seen in rows:
            print(f"  {samples:5d} samples {cost:7.3f} s  sRGB RMSE {error:.4f}  FLIP {seen:.4f}", flush=True)
        if not math.isfinite(errors[-1]):
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

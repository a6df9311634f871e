"""Writes a synthetic measurement: a known material, the angles of a goniometer, multiplicative noise.

    python examples/synthesize.py copper_paint.csv

This is how the sample of `brdf demo` was made.
"""

import pathlib
import sys

import jax
import numpy as np

import brdf
from brdf.material import from_dict

TRUTH = {
    "model": "lambert+ggx",
    "parameters": {
        "lambert": {"albedo": [0.12, 0.045, 0.02]},
        "ggx": {"f0": [0.62, 0.33, 0.19], "alpha": 0.18},
    },
}
NOISE = 0.03
THETA_I = (10, 30, 50, 70)


def goniometer() -> np.ndarray:
    """Columns theta_i, theta_o, phi_o in degrees: 2.5-degree steps in the plane of incidence, 5 x 15 beside it."""
    plane = [(i, o, p) for i in THETA_I for p in (0, 180) for o in np.arange(0, 78, 2.5)]
    beside = [(i, o, p) for i in THETA_I for p in range(15, 180, 15) for o in np.arange(5, 76, 5)]
    return np.array(plane + beside)


def unit(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def main(path: str) -> None:
    degrees = goniometer()
    theta_i, theta_o, phi_o = np.radians(degrees).T
    with jax.enable_x64(True):
        value = np.asarray(brdf.evaluate(from_dict(TRUTH).brdf, unit(theta_i, 0 * theta_i), unit(theta_o, phi_o)))
    value = value * (1 + NOISE * np.random.default_rng(7).normal(size=value.shape))
    header = f"# synthetic: {TRUTH}, {NOISE:.0%} noise, made by examples/synthesize.py\ntheta_i,theta_o,phi_o,r,g,b\n"
    rows = (",".join(f"{x:.6g}" for x in row) for row in np.hstack([degrees, value]))
    pathlib.Path(path).write_text(header + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])

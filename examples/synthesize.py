"""Writes a synthetic measurement: a known material, the angles of a goniometer, multiplicative noise.

    python examples/synthesize.py copper_paint.csv

This is how the sample of `brdf demo` was made. `brdf synthesize` does the same for any model, with unit vectors.
"""

import pathlib
import sys

import numpy as np

import fitter
from brdf.material import from_dict

TRUTH = {
    "model": "lambert+ggx",
    "parameters": {
        "lambert": {"albedo": [0.12, 0.045, 0.02]},
        "ggx": {"f0": [0.62, 0.33, 0.19], "alpha": 0.18},
    },
}
NOISE = 0.03


def polar_deg(w: np.ndarray) -> np.ndarray:
    return np.degrees(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]))


def main(path: str) -> None:
    data = fitter.synthesize(from_dict(TRUTH), layout="goniometer", noise=NOISE, seed=7)
    phi_o = np.degrees(np.arctan2(data.wo[:, 1], data.wo[:, 0]))
    columns = np.column_stack([polar_deg(data.wi), polar_deg(data.wo), phi_o, data.value])
    header = f"# synthetic: {TRUTH}, {NOISE:.0%} noise, made by examples/synthesize.py\ntheta_i,theta_o,phi_o,r,g,b\n"
    rows = (",".join(f"{x:.6g}" for x in row) for row in columns)
    pathlib.Path(path).write_text(header + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])

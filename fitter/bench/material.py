"""Synthetic tables that anybody can make again: a known material that no model of one lobe follows, and noise."""

from __future__ import annotations

import functools
import os
import pathlib

import jax
import numpy as np

from brdf.material import from_dict
from brdf.model import AbstractBRDF, evaluate

from ..formats import merl, read
from ..reflectance import Reflectance
from ..rusinkiewicz import half_difference

# Standard deviation of the noise and amplitude of the ripple, relative to the value.
NOISE, RIPPLE = 0.05, 0.1
# The share of a table's cells that lie above the horizon.
_ABOVE = 0.76
_FULL = merl.SIZE[0] * merl.SIZE[1] * merl.SIZE[2]
# Evaluations are padded to this many, so that they share one program: the cells of one theta_h.
_BLOCK = 90 * 180
_TRUTHS = {
    "paint": {
        "model": "lambert+ggx+ggx",
        "parameters": {
            "lambert": {"albedo": [0.25, 0.12, 0.05]},
            "ggx": {"f0": [0.35, 0.27, 0.2], "alpha": 0.12},
            "ggx_2": {"f0": [0.15, 0.13, 0.11], "alpha": 0.4},
        },
    },
    "disney": {
        "model": "disney",
        "parameters": {
            "disney": {
                "base_color": [0.5, 0.3, 0.1],
                "subsurface": 0.4,
                "specular": 0.6,
                "specular_tint": 0.4,
                "roughness": 0.45,
                "sheen": 0.5,
                "sheen_tint": 0.5,
                "clearcoat": 0.6,
                "clearcoat_gloss": 0.6,
            }
        },
    },
}


def described() -> str:
    """What the tables hold, for the docs."""
    return (
        "lambert + two GGX lobes (alpha 0.12 and 0.4), so that one lobe misses it as it misses real paints; for "
        f"Disney, Disney's model itself; both with a ripple of {100 * RIPPLE:.0f} % over the angles, which no model "
        f"follows, and {100 * NOISE:.0f} % noise"
    )


def table_size(samples: int | None) -> tuple[int, int, int]:
    """The size of a table with about so many cells above the horizon; MERL's own if None or more than it has."""
    share = 1.0 if samples is None else min(1.0, (samples / (_ABOVE * _FULL)) ** (1 / 3))
    theta_h, theta_d, phi_d = (max(4, round(share * size)) for size in merl.SIZE)
    return theta_h, theta_d, phi_d


def table(model: str, size: tuple[int, int, int], folder: str | os.PathLike[str], seed: int = 0) -> pathlib.Path:
    """Writes the table that stands for a material to fit `model` to, unless it is there.

    **Arguments:**

    - `model`: the expression that will be fitted.
    - `size`: cells along theta_h, theta_d and phi_d.
    - `folder`: where to.
    - `seed`: of the noise; above 0 also of the roughness, which makes it another material.

    **Returns:** the path of a MERL `.binary`.
    """
    kind = "disney" if "disney" in model else "paint"
    path = pathlib.Path(folder) / f"{kind}_{'x'.join(map(str, size))}_{seed}.binary"
    if not path.exists():
        merl.write_function(_Material(kind, seed), path, size)
    return path


def slice_values(table: Reflectance) -> np.ndarray:
    """[theta_d][theta_h][3] of the slice at phi_d = 90 degrees, NaN where there is none: a member of an `.npz`."""
    assert table.grid is not None
    full = table.grid.scatter(table.value)
    return full[:, :, full.shape[2] // 2].swapaxes(0, 1)


def slices_path(count: int, folder: str | os.PathLike[str]) -> pathlib.Path:
    """Where `slices` keeps its materials."""
    return pathlib.Path(folder) / f"slices_{count}.npz"


def slices(count: int, folder: str | os.PathLike[str]) -> list[Reflectance]:
    """Slices of 90 x 90 cells of `count` different materials, read back from one `.npz`."""
    path = slices_path(count, folder)
    size = (merl.SIZE[0], merl.SIZE[1], 2)
    members = {f"m{i}": slice_values(read(table("paint", size, folder, i + 1))) for i in range(count)}
    np.savez(path, allow_pickle=False, **members)
    return [read(f"{path}:{name}") for name in members]


class _Material:
    """(wi, wo) to the value, with ripple and noise; the noise depends on the order of the calls."""

    def __init__(self, kind: str, seed: int):
        self.rng = np.random.default_rng(seed)
        self.model = from_dict(_TRUTHS[kind] if seed == 0 else _other(self.rng)).brdf

    def __call__(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        value = _value(self.model, wi, wo)
        angles = half_difference(wi, wo)
        ripple = RIPPLE * np.sin(5 * angles.theta_h) * np.cos(3 * angles.theta_d)
        noise = NOISE * self.rng.normal(size=value.shape)
        return np.maximum(value * (1 + ripple[:, None]) * (1 + noise), 0)


def _other(rng: np.random.Generator) -> dict:
    """Another paint: other colours and other roughnesses."""
    f0, haze = (rng.uniform(0.05, 0.5) * rng.uniform(0.7, 1, 3) for _ in range(2))
    return {
        "model": _TRUTHS["paint"]["model"],
        "parameters": {
            "lambert": {"albedo": rng.uniform(0.02, 0.6, 3).tolist()},
            "ggx": {"f0": f0.tolist(), "alpha": float(np.exp(rng.uniform(np.log(0.05), np.log(0.3))))},
            "ggx_2": {"f0": (0.3 * haze).tolist(), "alpha": float(rng.uniform(0.4, 0.7))},
        },
    }


def _value(model: AbstractBRDF, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    return np.concatenate([_block(model, wi[i : i + _BLOCK], wo[i : i + _BLOCK]) for i in range(0, len(wi), _BLOCK)])


def _block(model: AbstractBRDF, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    pad = lambda rows: np.concatenate([rows, np.tile([0.0, 0.0, 1.0], (_BLOCK - len(rows), 1))])  # noqa: E731
    with jax.enable_x64(True):
        return np.asarray(evaluate(model, pad(wi), pad(wo)))[: len(wi)]


@functools.cache
def load(path: pathlib.Path) -> Reflectance:
    """Reads a table once."""
    return read(path)

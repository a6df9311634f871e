"""Small RGL files with smooth made-up tensors, for tests; run as a program it recomputes the oracle.

python tests/fitter/synthetic_rgl.py     # needs mitsuba; writes data/rgl_anisotropic.npz
"""

from __future__ import annotations

import pathlib
import struct
import sys

import numpy as np

ORACLE = pathlib.Path(__file__).parent / "data" / "rgl_anisotropic.npz"
TYPE_CODES = {"|u1": 1, "<f4": 10, "<f8": 11}
# phi_i that are measured, and whether M still needs the factor D / (4 sigma).
VARIANTS = {
    "whole": (np.linspace(-np.pi, np.pi, 9), 1),
    "half": (np.linspace(-np.pi, 0, 5), 1),
    "quarter": (np.linspace(-np.pi, -np.pi / 2, 4), 1),
    "factored": (np.linspace(-np.pi, np.pi, 9), 0),
}


def fields(phi_i: np.ndarray, jacobian: int) -> dict[str, np.ndarray]:
    """The fields of a made-up material with negative channels and no symmetry."""
    theta_i = np.array([0.0, 0.4, 0.8, 1.2, 1.5707])

    def waves(low: float, high: float, *shape: int) -> np.ndarray:
        """Incommensurate waves: no two entries alike, none rounded differently by another numpy."""
        phase = sum(
            np.reshape(np.arange(size), (-1,) + (1,) * (len(shape) - 1 - axis)) * (0.7 + 0.37 * axis)
            for axis, size in enumerate(shape)
        )
        return (low + (high - low) * (0.5 + 0.5 * np.sin(phase))).astype("<f4")

    directions = (len(phi_i), len(theta_i))
    return {
        "description": np.frombuffer(b"made up", "u1"),
        "phi_i": np.asarray(phi_i, "<f4"),
        "theta_i": theta_i.astype("<f4"),
        "sigma": waves(0.5, 1.0, 8, 16),
        "ndf": waves(0.1, 1.0, 8, 16),
        "vndf": waves(0.2, 1.0, *directions, 16, 16),
        "luminance": waves(0.1, 1.0, *directions, 8, 8),
        "rgb": waves(-0.1, 1.0, *directions, 3, 8, 8),
        "jacobian": np.array([jacobian], "u1"),
    }


def write_tensor_file(path: pathlib.Path, contents: dict[str, np.ndarray]) -> None:
    """Writes a tensor file of version 1.0."""
    sizes = [15 + 8 * array.ndim + len(name) - 2 for name, array in contents.items()]
    start = 18 + sum(sizes)
    head, body = b"tensor_file\0\1\0" + struct.pack("<I", len(contents)), b""
    for name, array in contents.items():
        body += b"\0" * (-(start + len(body)) % 8)
        head += struct.pack("<H", len(name)) + name.encode()
        head += struct.pack("<HBQ", array.ndim, TYPE_CODES[array.dtype.str], start + len(body))
        head += struct.pack(f"<{array.ndim}Q", *array.shape)
        body += array.tobytes()
    assert len(head) == start
    path.write_bytes(head + body)


def directions(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Seeded pairs above the horizon, exact in float32."""
    pairs = np.random.default_rng(5).normal(size=(2, count, 3))
    pairs[..., 2] = np.abs(pairs[..., 2]) + 0.05
    pairs /= np.linalg.norm(pairs, axis=-1, keepdims=True)
    pairs = pairs.astype("f4").astype("f8")
    return pairs[0], pairs[1]


def main() -> None:
    import mitsuba  # pyright: ignore[reportMissingImports]

    mitsuba.set_variant("scalar_rgb")
    wi, wo = directions(100)
    table = {"wi": wi, "wo": wo}
    for name, (phi_i, jacobian) in VARIANTS.items():
        path = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".") / f"{name}.bsdf"
        write_tensor_file(path, fields(phi_i, jacobian))
        bsdf = mitsuba.load_dict({"type": "measured", "filename": str(path)})
        values = []
        for incident, outgoing in zip(wi.tolist(), wo.tolist(), strict=True):
            point = mitsuba.SurfaceInteraction3f()
            point.wi = mitsuba.Vector3f(*incident)
            values.append(np.array(bsdf.eval(mitsuba.BSDFContext(), point, mitsuba.Vector3f(*outgoing))))
        table[name] = (np.array(values) / wo[:, 2:]).astype("f4")
        path.unlink()
    np.savez_compressed(ORACLE, **table)  # pyright: ignore[reportArgumentType]


if __name__ == "__main__":
    main()

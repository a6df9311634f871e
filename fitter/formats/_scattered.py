"""What the formats of scattered samples share: angles to directions, and what becomes of dirty rows."""

from __future__ import annotations

import os

import numpy as np

from brdf.errors import FileError
from fitter.reflectance import HORIZON_COSINE, Reflectance


def spherical(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Polar angle and azimuth, radians, to unit vectors (..., 3). A negative `theta` is a turn of `phi` by pi."""
    sine = np.sin(theta)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)], axis=-1)


def measurement(
    path: str | os.PathLike[str],
    wi: np.ndarray,
    wo: np.ndarray,
    value: np.ndarray,
    *,
    format: str,
    facts: str,
    clamp: bool,
    weight: np.ndarray | None = None,
    sigma: np.ndarray | None = None,
    dropped: dict[str, int] | None = None,
    remedy: str,
) -> Reflectance:
    """Leaves out, clamps and counts what is dirty, and makes the measurement of the rest.

    **Arguments:**

    - `path`: the file.
    - `wi`, `wo`: (n, 3) unit, or not finite.
    - `value`: (n, 3) 1/sr.
    - `format`, `facts`: for `Reflectance.format` and, in brackets behind the file name, `Reflectance.source`.
    - `clamp`: whether a negative channel beside a positive one is a colour out of gamut, to be set to 0 and counted;
      otherwise, and where no channel is positive, it makes the row invalid.
    - `weight`, `sigma`: as in `Reflectance`.
    - `dropped`: what the reader left out before.
    - `remedy`: what to do if nothing is left.

    **Raises:** `FileError` if nothing is left.
    """
    rows = [wi, wo, value]
    rows += [extra.reshape(len(wi), -1) for extra in (weight, sigma) if extra is not None]
    finite = np.logical_and.reduce([np.isfinite(part).all(1) for part in rows])
    with np.errstate(invalid="ignore"):  # rows that are not finite are left out below
        above = finite & (wi[:, 2] > HORIZON_COSINE) & (wo[:, 2] > HORIZON_COSINE)
        negative = (value < 0).any(1) & ~(clamp & (value > 0).any(1))
    keep = above & ~negative
    reasons = dict(dropped or {})
    for reason, left_out in (
        ("not finite", ~finite),
        ("below horizon", finite & ~above),
        ("negative", above & negative),
    ):
        reasons[reason] = reasons.get(reason, 0) + int(np.count_nonzero(left_out))
    reasons = {reason: count for reason, count in reasons.items() if count}
    if not keep.any():
        told = ", ".join(f"{count} {reason}" for reason, count in reasons.items())
        raise FileError(path, f"has no usable row: of {len(wi)} {told}.", remedy)
    if weight is not None and not weight[keep].any():
        raise FileError(path, "has weight 0 in every row.", "Give one row a positive weight.")
    kept = value[keep]
    return Reflectance(
        wi=wi[keep],
        wo=wo[keep],
        value=np.maximum(kept, 0.0),
        source=f"{os.path.basename(path)} ({', '.join(part for part in (format, facts) if part)})",
        weight=np.ones(1) if weight is None else weight[keep],
        sigma=None if sigma is None else sigma[keep],
        format=format,
        dropped=reasons,
        clamped=int(np.count_nonzero(kept < 0)),
    )

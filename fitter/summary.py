"""What a measurement holds, in a few numbers: the contents of `brdf info FILE`."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from fitter.quality import inspect
from fitter.reflectance import Reflectance
from fitter.rusinkiewicz import half_difference

PERCENTILES = (0, 5, 50, 95, 100)


def summarise(reflectance: Reflectance) -> dict[str, Any]:
    """Describes a measurement with plain numbers that can be written as JSON.

    **Arguments:**

    - `reflectance`: any measurement.

    **Returns:** a dictionary with the keys

    - `source`, `format`: as the reader tells them;
    - `samples`, `dropped` (reason -> count), `clamped` (channel values), `weighted`, `standard_errors`,
      `interpolates`;
    - `angles_deg`: name -> [lowest, highest] over the samples;
    - `value`: channel -> percentile -> 1/sr, without the cosine;
    - `grid`: axis -> `size`, `first_deg`, `last_deg`, in C order; `None` for scattered samples;
    - `findings`: what spoils a fit or limits it, a list of `name`, `count`, `share`, `sentence`.
    """
    wi, wo = reflectance.wi, reflectance.wo
    half = half_difference(wi, wo)
    angles = {
        "theta_i": np.arctan2(np.hypot(wi[:, 0], wi[:, 1]), wi[:, 2]),
        "phi_i": np.arctan2(wi[:, 1], wi[:, 0]),
        "theta_o": np.arctan2(np.hypot(wo[:, 0], wo[:, 1]), wo[:, 2]),
        "phi_o": np.arctan2(wo[:, 1], wo[:, 0]),
        "theta_h": half.theta_h,
        "theta_d": half.theta_d,
        "phi_d": half.phi_d,
    }
    percentiles = np.percentile(reflectance.value, PERCENTILES, axis=0)
    grid = reflectance.grid
    return {
        "source": reflectance.source,
        "format": reflectance.format,
        "samples": len(reflectance),
        "dropped": dict(reflectance.dropped),
        "clamped": reflectance.clamped,
        "weighted": bool((reflectance.weight != 1).any()),
        "standard_errors": reflectance.sigma is not None,
        "interpolates": reflectance.interpolant is not None,
        "angles_deg": {
            name: [float(np.degrees(angle.min())), float(np.degrees(angle.max()))] for name, angle in angles.items()
        },
        "value": {
            channel: {
                f"{percentile}%": float(number)
                for percentile, number in zip(PERCENTILES, percentiles[:, place], strict=True)
            }
            for place, channel in enumerate("rgb")
        },
        "grid": grid
        and {
            name: {
                "size": len(axis),
                "first_deg": float(np.degrees(axis[0])),
                "last_deg": float(np.degrees(axis[-1])),
            }
            for name, axis in grid.axes.items()
        },
        "findings": [dataclasses.asdict(finding) for finding in inspect(reflectance)],
    }

"""What measured data suffer from, found before a fit: one sentence each, with a count and what to do.

Every rule has to stay silent on clean data. They were held against 70 measured MERL slices and 12 RGL materials; what
they say there is in `tests/fitter/test_quality.py`. What no rule can tell is the order of the channels: a red paint
with red and blue exchanged is a blue paint. See `reorder_channels`.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from brdf.errors import UserError

from ..reflectance import Reflectance
from .coverage import gaps
from .finding import Finding, found
from .pairs import not_reciprocal, repeated
from .scatter import scatter

# Statistics are taken of about this many samples, evenly spaced: more would not change the sentence.
_LOOKED_AT = 40_000
# As many geometries as this at a channel's maximum are no coincidence; measured slices have up to 7.
_PLATEAU_MIN = 10
_PLATEAU_RTOL = 1e-6
# A smooth peak is that flat over 0.04 degrees at most, even if it is the same along a whole ridge.
_PLATEAU_DEG = 0.1
# A plateau is a highlight only if it stands out: a white diffuse surface is as bright everywhere.
_PLATEAU_OVER_MEDIAN = 3.0
_GRAZING_DEG = 75.0
_SCATTER_MIN = 0.05
_RADIANS_DEG = 1.6
# A white diffuse surface has f pi = 1; measured ones reach 0.95 away from the highlight.
_BRIGHT_MAX = 1.5
_DARK_MAX = 1e-5
# Slope of log f over log cos and its correlation: measured surfaces reach 0.54 at 0.70 and 0.50 at 0.92.
_COSINE_SLOPE = 0.8
_COSINE_CORRELATION = 0.9


def inspect(data: Reflectance) -> list[Finding]:
    """Looks for what spoils a fit, or limits what it can tell.

    **Arguments:**

    - `data`: any measurement, as read: before grazing angles are cut off.

    **Returns:** what was found, the gravest first; nothing for clean and complete data. Names: `radians`, `scale`,
    `cosine`, `saturated`, `not reciprocal`, `grazing`, `clamped`, `repeated`, and those of
    `fitter.quality.coverage.gaps`.
    """
    if (radians := _radians(data)) is not None:
        return [radians, *(finding for finding in (_clamped(data),) if finding)]  # no direction means anything
    rules = (_scale, _cosine, _saturated, not_reciprocal, _grazing, _clamped, repeated)
    return [finding for rule in rules if (finding := rule(data))] + gaps(data)


def reorder_channels(data: Reflectance, order: str) -> Reflectance:
    """The same measurement with its channels in another order, for a file that has them wrong.

    **Arguments:**

    - `order`: what the file holds, such as `"bgr"`: each of r, g and b once.

    **Returns:** red, green, blue; `evaluate` follows.

    **Raises:** `UserError` for another order.
    """
    if sorted(order.lower()) != ["b", "g", "r"]:
        raise UserError(f"`{order}` is no order of channels. Write each of r, g and b once, such as `bgr`.")
    place = [order.lower().index(channel) for channel in "rgb"]
    if place == [0, 1, 2]:
        return data
    values = data.interpolant
    return dataclasses.replace(
        data,
        value=data.value[:, place],
        source=f"{data.source}, channels {order.lower()}",
        interpolant=values and (lambda wi, wo: values(wi, wo)[:, place]),
    )


def _radians(data: Reflectance) -> Finding | None:
    lowest = min(data.wi[:, 2].min(), data.wo[:, 2].min())
    largest = float(np.degrees(np.arccos(min(lowest, 1.0))))
    if largest >= _RADIANS_DEG or len(data) < 3:
        return None
    return found(
        "radians",
        len(data),
        data,
        f"All polar angles are below {_RADIANS_DEG} degrees (the largest is {largest:.3g}): most likely they were "
        "given in radians. Write degrees.",
    )


def _scale(data: Reflectance) -> Finding | None:
    some = _some(data)
    wi, wo, brightest = data.wi[some], data.wo[some], data.value[some].max(axis=1)
    if (largest := float(data.value.max())) < _DARK_MAX:
        return found(
            "scale",
            len(data),
            data,
            f"No value is above {largest:.2g} 1/sr, less than soot: the values are most likely not in 1/sr.",
        )
    cos_h = _cos_h(wi, wo)
    away = brightest[
        (cos_h < np.cos(np.radians(30))) & (np.minimum(wi[:, 2], wo[:, 2]) > np.cos(np.radians(_GRAZING_DEG)))
    ]
    if len(away) < 20 or (typical := float(np.median(away)) * np.pi) < _BRIGHT_MAX:
        return None
    return found(
        "scale",
        len(data),
        data,
        f"Away from the highlight the values are {typical:.3g} times those of a perfectly white surface: they are most "
        "likely not in 1/sr. A BRDF is in 1/sr (white: 0.318), neither in percent nor divided by a white standard.",
    )


def _cosine(data: Reflectance) -> Finding | None:
    some = _some(data)
    wi, wo, value = data.wi[some], data.wo[some], data.value[some].mean(axis=1)
    lowest = np.minimum(wi[:, 2], wo[:, 2])
    use = (_cos_h(wi, wo) < np.cos(np.radians(35))) & (lowest > 0.2) & (value > 0)
    for name, cosine in (("cos(theta_o)", wo[use, 2]), ("cos(theta_i)", wi[use, 2])):
        x, y = np.log(cosine), np.log(value[use])
        if len(x) < 100 or x.std() < 0.2 or not y.std():
            continue
        slope, correlation = np.polyfit(x, y, 1)[0], np.corrcoef(x, y)[0, 1]
        if slope > _COSINE_SLOPE and correlation > _COSINE_CORRELATION:
            return found(
                "cosine",
                len(data),
                data,
                f"Away from the highlight the values fall like {name}^{slope:.2f}, which no common material does: they "
                f"most likely contain the cosine. Divide them by {name}.",
            )
    return None


def _saturated(data: Reflectance) -> Finding | None:
    # Column by column: numpy reduces a short last axis ten times as slowly.
    top = [float(column.max()) for column in data.value.T]
    medians = np.median(data.value[_some(data)], axis=0)
    parts, rows = [], np.zeros(len(data), bool)
    for channel, name in enumerate(("red", "green", "blue")):
        if top[channel] <= _PLATEAU_OVER_MEDIAN * medians[channel]:
            continue
        here = np.flatnonzero(data.value[:, channel] >= top[channel] * (1 - _PLATEAU_RTOL))
        if len(here) < _PLATEAU_MIN:
            continue
        # An isotropic table holds the same geometry many times over, turned about the normal.
        wi, wo = data.wi[here], data.wo[here]
        dot = np.einsum("ij,ij->i", wi, wo)
        geometry = np.round(np.column_stack([wi[:, 2], wo[:, 2], dot]), 6)
        # From the normal to the half vector, and from the mirrored light to the viewer.
        cosines = _cos_h(wi, wo), 2 * wi[:, 2] * wo[:, 2] - dot
        width = min(np.degrees(np.ptp(np.arccos(np.clip(cosine, -1, 1)))) for cosine in cosines)
        if width > _PLATEAU_DEG and len(np.unique(geometry, axis=0)) >= _PLATEAU_MIN:
            parts.append(f"{name} {top[channel]:.4g}")
            rows[here] = True
    if not parts:
        return None
    return found(
        "saturated",
        int(rows.sum()),
        data,
        f"{{count}} have exactly the highest value of a channel ({', '.join(parts)} 1/sr): the detector was saturated, "
        "and the highlight is brighter and narrower than it looks. Measure it with a shorter exposure, or leave these "
        "samples out (weight 0 in a .csv).",
    )


def _grazing(data: Reflectance) -> Finding | None:
    beyond = np.minimum(data.wi[:, 2], data.wo[:, 2]) < np.cos(np.radians(_GRAZING_DEG))
    count = int(np.count_nonzero(beyond))
    if not 0 < count < len(data):
        return None
    outside, inside = scatter(data, beyond), scatter(data, ~beyond)
    if outside is None or inside is None or outside < max(_SCATTER_MIN, 2 * inside):
        return None
    return found(
        "grazing",
        count,
        data,
        f"{{count}} lie beyond {_GRAZING_DEG:g} degrees and scatter by {100 * outside:.0f} % from one to the next, the "
        f"others by {100 * inside:.1f} %. `--max-theta-deg {_GRAZING_DEG:g}` leaves them out.",
    )


def _clamped(data: Reflectance) -> Finding | None:
    if not data.clamped:
        return None
    share = data.clamped / data.value.size
    return Finding(
        "clamped",
        data.clamped,
        share,
        f"{data.clamped} channel values ({100 * share:.2g} %) were negative, by noise or as a colour outside Rec. 709, "
        "and count as 0: dark colours come out a little too bright.",
    )


def _some(data: Reflectance) -> slice:
    return slice(None, None, max(1, len(data) // _LOOKED_AT))


def _cos_h(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    total = wi + wo
    return total[:, 2] / np.maximum(np.sqrt(np.einsum("ij,ij->i", total, total)), 1e-12)

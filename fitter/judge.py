"""How different a fit looks: Delta E ITP between pictures of a sphere, one made of the measurement, one of the model.

Both pictures share everything but the reflectance: a soft key light from the upper left, a broad rim light from behind
on the right, and a sky that is brighter above. All light is white, the sphere is seen from afar, and nothing is left to
chance. Light and viewer beyond 80 degrees are left out of both, since measurements know little there.

The exposure is fixed: the brightest pixel of a white matte sphere shows 203 cd/m2, the reference white of Rec. ITU-R
BT.2408, and the display reaches from 0.005 to 1000 cd/m2, as Rec. ITU-R BT.2100 asks of it. A difference of 1 is just
noticeable under the best conditions (Rec. ITU-R BT.2124).

The formula is our own: to import colour-science takes longer than a whole fit. The tests hold it to colour-science.
"""

from __future__ import annotations

import dataclasses
import functools
import weakref
from typing import Any

import numpy as np
from jaxtyping import Float

from brdf.errors import UserError
from brdf.integrate import Light, Sphere, sphere
from brdf.model import AbstractBRDF

from .evaluation import values
from .reflectance import Reflectance

# Means of Delta E ITP from where a fit looks different, and looks like another material: luminances that differ by 15 %
# and by a factor of 1.7. Chosen by eye on MERL's slices, where `lambert+ggx` reaches 13 on fabric and 84 on aluminium.
VISIBLE, WRONG = 10.0, 40.0
THETA_MAX_DEG = 80.0
WHITE, _PEAK, _BLACK = 203.0, 1000.0, 0.005
# A pixel counts while the measurement knows at least this share of the light that a white surface would send there.
_KNOWN_MIN = 0.9
# Fewer pixels than this do not make a sphere.
_PIXELS_MIN = 0.5
# Scattered samples are compared at no more than this many, evenly spread over the list.
_SAMPLES_MAX = 1 << 15

# Radiance of the sky above and below; that of the lamps is in the same unit, see `_lights`.
_ABOVE, _BELOW = 0.6, 0.15


@dataclasses.dataclass(frozen=True)
class Judgement:
    """How different a fit looks.

    - `kind`: `sphere`, or `samples` where the measurement defines no values in between: then each sample is a patch
      under one light that makes a white matte patch show 203 cd/m2 when it falls in vertically.
    - `mean`, `percentile_95`, `maximum`: Delta E ITP over the pixels or samples, at least 0; 1 is just noticeable.
    - `judged`, `left_out`: how many pixels or samples count, and how many do not because the measurement has no valid
      value for their light.
    """

    kind: str
    mean: float
    percentile_95: float
    maximum: float
    judged: int
    left_out: int

    @property
    def verdict(self) -> str:
        """`close`, `visible` or `wrong`: a mean below 10, up to 40, and above."""
        return "close" if self.mean < VISIBLE else "visible" if self.mean < WRONG else "wrong"

    def sentence(self) -> str:
        """The judgement in words, for a report."""
        what = "a lit sphere" if self.kind == "sphere" else "single patches, for want of values between the samples"
        text = (
            f"Delta E ITP {self.mean:.3g} on {what} (95 % below {self.percentile_95:.3g}, at most {self.maximum:.3g}; "
            "1 is just noticeable)"
        )
        if self.left_out:
            text += f"; {self.left_out} of {self.judged + self.left_out} left out, not measured"
        return text

    def to_dict(self) -> dict[str, Any]:
        """The judgement as a JSON object."""
        return dataclasses.asdict(self)


@dataclasses.dataclass(frozen=True, eq=False)
class Pictures:
    """Both pictures of a sphere and their difference, on rings about the centre; see `brdf.integrate.Sphere`.

    - `measured`, `fitted`: (rings, sectors, 3), cd/m2, linear Rec. 709, within the range of the display.
    - `difference`: (rings, sectors), Delta E ITP.
    - `counts`: (rings, sectors) bool, whether the measurement knows enough there.
    - `radius`: (rings,); `azimuth`: (sectors,) radians.
    """

    measured: np.ndarray
    fitted: np.ndarray
    difference: np.ndarray
    counts: np.ndarray
    radius: np.ndarray
    azimuth: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class _Measured:
    """A measurement under the light: its picture, the rows of pairs that it does not know, and which pixels count."""

    picture: np.ndarray
    unknown: np.ndarray
    counts: np.ndarray


def judge(model: AbstractBRDF, data: Reflectance) -> Judgement:
    """How different a model looks from a measurement; see the module's docstring.

    A measurement's own picture is kept for as long as the measurement lives, so that many models are judged quickly.
    Where a format defines its values between the samples, all of them count, also those that were not fitted. Slices at
    phi_d = 90 degrees answer for every phi_d with the same value: they make a sphere of a material that does not depend
    on phi_d.

    **Arguments:**

    - `model`: any model or sum.
    - `data`: any measurement.

    **Raises:** `UserError` if the model is not finite somewhere.
    """
    pictures = render(model, data)
    if pictures is None:
        return _judge_samples(model, data)
    return _summary("sphere", pictures.difference[pictures.counts], int(np.count_nonzero(~pictures.counts)))


def render(model: AbstractBRDF, data: Reflectance) -> Pictures | None:
    """The pictures that are compared, or None if the measurement defines too few values for them; see `judge`."""
    measured = None if data.interpolant is None else _measure(data)
    if measured is None:
        return None
    scene, exposure = _scene()
    value = _values(model, scene.wi, scene.wo)
    value[measured.unknown] = 0
    fitted = _shown(exposure * scene.picture(value))
    difference = delta_e_itp(measured.picture, fitted)
    return Pictures(measured.picture, fitted, difference, measured.counts, scene.radius, scene.azimuth)


def _values(model: AbstractBRDF, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    value = values(model, wi, wo)
    if not np.isfinite(value).all():
        raise UserError(
            f"The model is not finite at {np.count_nonzero(~np.isfinite(value).all(axis=1))} of {len(value)} pairs of "
            "directions. Check its parameters for numbers that are not finite or out of range."
        )
    return value


def _judge_samples(model: AbstractBRDF, data: Reflectance) -> Judgement:
    counting = np.flatnonzero(data.weight)
    chosen = counting[:: -(-len(counting) // _SAMPLES_MAX)]
    wi, wo = data.wi[chosen], data.wo[chosen]
    scale = WHITE * np.pi * wi[:, 2:3]
    measured, fitted = _shown(scale * data.value[chosen]), _shown(scale * _values(model, wi, wo))
    return _summary("samples", delta_e_itp(measured, fitted), 0)


def _summary(kind: str, difference: np.ndarray, left_out: int) -> Judgement:
    mean, high = float(difference.mean()), float(np.percentile(difference, 95))
    return Judgement(kind, mean, high, float(difference.max()), difference.size, left_out)


def _lamp(toward: tuple[float, float, float], radius_deg: float, radiance: float) -> Light:
    """A round light that fades smoothly from the radiance in its middle to 0 at its edge."""
    scale = 1 / (1 - np.cos(np.radians(radius_deg)))
    top = radiance ** (1 / 3)

    def at(cosine: np.ndarray) -> np.ndarray:
        cosine *= np.float32(top * scale)
        cosine += np.float32(top * (1 - scale))
        np.maximum(cosine, 0, out=cosine)
        return cosine * cosine * cosine

    length = float(np.linalg.norm(toward))
    x, y, z = toward
    return (x / length, y / length, z / length), at


def _sky(cosine: np.ndarray) -> np.ndarray:
    cosine *= np.float32(_ABOVE - _BELOW) / 2
    cosine += np.float32(_ABOVE + _BELOW) / 2
    return cosine


def _lights() -> tuple[Light, ...]:
    """A key light from the upper left, a rim light from behind on the right, and the sky; before the exposure."""
    return _lamp((-0.55, 0.60, 0.58), 15, 40.0), _lamp((0.83, 0.25, -0.50), 40, 2.5), ((0.0, 1.0, 0.0), _sky)


@functools.cache
def _scene() -> tuple[Sphere, float]:
    """The sphere under the light, and the exposure that takes a white matte one to 203 cd/m2."""
    scene = sphere(_lights(), np.radians(THETA_MAX_DEG))
    return scene, WHITE / float(scene.picture(_white(scene)).max())


def _white(scene: Sphere) -> np.ndarray:
    return np.full((len(scene.wi), 1), 1 / np.pi)


# Identity of an interpolant -> picture, for as long as it lives: a selection of a measurement's samples shares it.
_pictures: dict[int, _Measured | None] = {}


def _measure(data: Reflectance) -> _Measured | None:
    """The measurement's own picture; None if it knows too little for one."""
    key = id(data.interpolant)
    if key not in _pictures:
        _pictures[key] = _measure_anew(data)
        weakref.finalize(data.interpolant, _pictures.pop, key, None)
    return _pictures[key]


def _measure_anew(data: Reflectance) -> _Measured | None:
    scene, exposure = _scene()
    value = data.evaluate(scene.wi, scene.wo)
    unknown = np.flatnonzero(~np.isfinite(value).all(axis=1))
    value[unknown] = 0
    white = _white(scene)
    whole = scene.picture(white)
    white[unknown] = 0
    counts = (scene.picture(white) >= _KNOWN_MIN * whole)[..., 0]
    if counts.mean() < _PIXELS_MIN:
        return None
    return _Measured(_shown(exposure * scene.picture(value)), unknown, counts)


def _shown(luminance: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """What the display shows of it, per channel."""
    return np.clip(luminance, _BLACK, _PEAK)


# Rec. 709 to Rec. 2020 primaries (Rec. ITU-R BT.2087), then to LMS and from there to I, T, P (BT.2100, BT.2124).
_REC2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
_LMS = np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096
_ITP = np.array([[2048, 2048, 0], [6610 / 2, -13613 / 2, 7003 / 2], [17933, -17390, -543]]) / 4096


def delta_e_itp(a: Float[np.ndarray, "... 3"], b: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "..."]:
    """The colour difference of Rec. ITU-R BT.2124.

    **Arguments:** `a`, `b`: in cd/m2, linear Rec. 709, in [0, 10000].

    **Returns:** at least 0; 1 is just noticeable.
    """
    difference = (_perceptual(a) - _perceptual(b)) @ _ITP.T
    return np.asarray(720 * np.sqrt((difference * difference).sum(axis=-1)))


def _perceptual(rgb: np.ndarray) -> np.ndarray:
    """LMS after the perceptual quantizer of SMPTE ST 2084."""
    y = (rgb @ (_LMS @ _REC2020).T / 10000) ** (2610 / 16384)
    return ((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32)

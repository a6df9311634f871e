"""A photographer's studio made of formulas: soft boxes in a dim room, so that the preview needs no file.

A large key light over the left shoulder, a tall strip on the right that draws the edge of a metal, a broad weak fill,
a rim light behind, and a room that darkens towards the floor: bright shapes on a dark ground are what a shiny surface
has to show.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

_WIDTH = 1024


@dataclasses.dataclass(frozen=True)
class _SoftBox:
    """A rectangle of light that faces the origin from distance 1.

    - `towards`: the direction of its centre, not normalised.
    - `half_width`, `half_height`: as tangents of angles.
    - `radiance`: linear Rec. 709, at its centre.
    """

    towards: tuple[float, float, float]
    half_width: float
    half_height: float
    radiance: tuple[float, float, float]


_BOXES = (
    _SoftBox((-0.75, 0.75, 0.75), 0.50, 0.38, (7.5, 7.2, 6.8)),  # key
    _SoftBox((1.0, 0.12, 0.25), 0.14, 0.80, (3.6, 3.7, 3.9)),  # strip
    _SoftBox((-1.0, 0.05, -0.30), 0.22, 0.70, (1.2, 1.25, 1.35)),  # fill
    _SoftBox((0.55, 0.60, -0.90), 0.45, 0.22, (3.4, 3.3, 3.1)),  # rim
    _SoftBox((0.0, 1.0, -0.10), 0.55, 0.30, (1.6, 1.6, 1.6)),  # top
)
# The cloth of a soft box fades over this part of its half size, and is dimmer away from the lamp by this much.
_EDGE = 0.12
_FALLOFF = 0.35


def studio() -> NDArray[np.float32]:
    """The studio as a latitude-longitude picture: shape (512, 1024, 3), float32, oriented as `shaders.environment`."""
    height = _WIDTH // 2
    azimuth = ((np.arange(_WIDTH) + 0.5) / _WIDTH - 0.5) * 2 * np.pi
    polar = (np.arange(height)[:, None] + 0.5) / height * np.pi
    w = np.stack(
        [np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -np.sin(polar) * np.cos(azimuth)], axis=-1
    )
    picture = _room(w)
    for box in _BOXES:
        picture += _box(w, box)
    return picture.astype(np.float32)


def _smooth(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """0 below 0, 1 above 1, smooth between."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def _room(w: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dim walls with a lit backdrop behind the object, a warm floor that brightens underneath it, a dark horizon."""
    y = w[..., 1]
    behind = 0.55 - 0.45 * w[..., 2]
    wall = 0.07 + 0.17 * np.exp(-(((y - 0.05) / 0.45) ** 2)) * behind
    floor = 0.04 + 0.14 * _smooth((-y - 0.25) / 0.75)
    above = _smooth((y + 0.32) / 0.22)[..., None]
    return floor[..., None] * np.array([1.05, 1.0, 0.93]) * (1 - above) + wall[..., None] * above


def _box(w: NDArray[np.float64], box: _SoftBox) -> NDArray[np.float64]:
    """The light of one soft box: its rectangle projected from the origin."""
    centre = np.array(box.towards) / np.linalg.norm(box.towards)
    # A box straight above has no upward direction of its own; one that is nearly so takes -z.
    right = np.cross(centre, [0.0, 1.0, 0.0]) if abs(centre[1]) < 0.95 else np.array([1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, centre)
    ahead = w @ centre
    in_front = ahead > 0.05
    distance = np.where(in_front, ahead, 1.0)
    x = (w @ right) / distance / box.half_width
    y = (w @ up) / distance / box.half_height
    inside = _smooth((1 - np.abs(x)) / _EDGE) * _smooth((1 - np.abs(y)) / _EDGE) * in_front
    lamp = 1 - _FALLOFF * np.clip((x * x + y * y) / 2, 0, 1)
    return (inside * lamp)[..., None] * np.array(box.radiance)

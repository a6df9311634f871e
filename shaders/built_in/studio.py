"""A photographer's studio made of formulas: soft boxes in a dim room, so that the preview needs no file.

A large key light over the left shoulder, a tall strip on the right that draws the edge of a metal, a broad weak fill,
a rim light behind, and a room that darkens towards the floor: bright shapes on a dark ground are what a shiny surface
has to show.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from .grid import HEIGHT, Floats, directions, smooth


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


def studio(height: int = HEIGHT) -> Floats:
    """The studio as a latitude-longitude picture: shape (height, 2 height, 3), float32."""
    w = directions(height)
    picture = _room(w)
    for box in _BOXES:
        _add_box(picture, w, box)
    return picture


def _room(w: Floats) -> Floats:
    """Dim walls with a lit backdrop behind the object, a warm floor that brightens underneath it, a dark horizon."""
    y = w[..., 1]
    behind = 0.55 - 0.45 * w[..., 2]
    wall = 0.07 + 0.17 * np.exp(-(((y - 0.05) / 0.45) ** 2)) * behind
    floor = 0.04 + 0.14 * smooth((-y - 0.25) / 0.75)
    above = smooth((y + 0.32) / 0.22)[..., None]
    return floor[..., None] * np.array([1.05, 1.0, 0.93], np.float32) * (1 - above) + wall[..., None] * above


def _add_box(picture: Floats, w: Floats, box: _SoftBox) -> None:
    """Adds the light of one soft box: its rectangle projected from the origin."""
    centre = np.array(box.towards, np.float32)
    centre /= np.linalg.norm(centre)
    # A box straight above has no upward direction of its own; one that is nearly so takes -z.
    pole = np.array([0.0, 1.0, 0.0] if abs(centre[1]) < 0.95 else [0.0, 0.0, 1.0], np.float32)
    right = np.cross(centre, pole)
    right /= np.linalg.norm(right)
    up = np.cross(right, centre)
    # No texel farther from its centre than a corner is lit.
    lit = w @ centre > 1 / math.sqrt(1 + box.half_width**2 + box.half_height**2)
    near = w[lit]
    distance = near @ centre
    x = (near @ right) / distance / box.half_width
    y = (near @ up) / distance / box.half_height
    inside = smooth((1 - np.abs(x)) / _EDGE) * smooth((1 - np.abs(y)) / _EDGE)
    lamp = 1 - _FALLOFF * np.clip((x * x + y * y) / 2, 0, 1)
    picture[lit] += (inside * lamp)[:, None] * np.array(box.radiance, np.float32)

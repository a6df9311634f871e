"""A BRDF given as a table over half and difference angles: how the preview renders a measurement itself.

The angles are those of Rusinkiewicz 1998: theta_h of the half vector; theta_d and phi_d of `wi` about it. The table
is isotropic: it does not depend on phi_h. theta_h runs with the square of its axis, which gives half of the nodes to
the 22.5 degrees around the mirror direction; theta_d and phi_d are linear.

- Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF Representation", Eurographics Workshop on Rendering.
"""

from __future__ import annotations

import dataclasses
import functools
import struct
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

from .tabulated_proposals import estimate
from .twin import Twin

Cells = Literal["edge", "centre", "nodes"]
Holds = Literal["f", "f cos_o"]

_OFFSET: dict[str, float] = {"edge": 0.0, "centre": 0.5, "nodes": 0.0}


@dataclasses.dataclass(frozen=True, eq=False)
class Tabulated:
    """A table of an isotropic BRDF, trilinear between its nodes, constant beyond the first and last of theta_h and
    theta_d, periodic in phi_d.

    - `values`: (theta_h, theta_d, phi_d, 3) float32, in 1/sr without the cosine, linear Rec. 709, finite and not
      negative. Nodes below the horizon count as neighbours of those above it: give them their neighbours' values. A
      table is one storage buffer: OpenGL 4.3 promises 16 MB, desktop drivers give 128 MB or more.
    - `cells`: where the values stand. `edge`: at the lower edges of as many equal cells, as MERL is read; `centre`: in
      their middles; `nodes`: theta_h and theta_d have nodes at both ends, phi_d as for `edge`.
    - `is_reciprocal`: whether phi_d covers [0, pi) only, since its other half is the same with `wi` and `wo` exchanged;
      else it covers [0, 2 pi).
    - `holds`: `f`, or `f cos_o`, which stays smooth where f grows without bound towards the horizon, as in RGL files.

    Raises `UserError` when the shape or a value is not as above, or for a reciprocal table of `f cos_o`.
    """

    values: NDArray[np.float32]
    cells: Cells = "nodes"
    is_reciprocal: bool = False
    holds: Holds = "f"

    def __post_init__(self) -> None:
        if self.values.ndim != 4 or self.values.shape[3] != 3 or min(self.values.shape) < 1:
            raise UserError(f"`values {self.values.shape}` is not a table. Pass (theta_h, theta_d, phi_d, 3).")
        if self.cells == "nodes" and min(self.values.shape[:2]) < 2:
            raise UserError(
                f"`values {self.values.shape}` has no node at both ends of an axis. Pass 2 or more of each."
            )
        least = float(self.values.min())
        if not (least >= 0 and np.isfinite(self.values.max())):
            raise UserError(
                f"`values` holds negative numbers or such that are not finite; the least is `{least:g}`. Fill holes "
                "from their neighbours and clamp at 0."
            )
        if self.is_reciprocal and self.holds == "f cos_o":
            raise UserError("`f cos_o` is not the same for exchanged directions. Pass phi_d over [0, 2 pi).")

    @functools.cached_property
    def twin(self) -> Twin:
        """The table as shaders see it."""
        nodes = self.values.shape[:3]
        ends = 1 if self.cells == "nodes" else 0
        cells = (nodes[0] - ends, nodes[1] - ends, nodes[2] * (2 if self.is_reciprocal else 1))
        proposal = estimate(self._in_f(), *axes(nodes, self.cells, self.is_reciprocal)[:2])
        # std140: a vec3 starts at a multiple of 16 bytes, a float fills its fourth place (`glsl/tabulated.glsl`).
        numbers = (*nodes, *cells, _OFFSET[self.cells], float(self.holds == "f cos_o"), *proposal)
        block = struct.pack("=3i4x3fff12x3f4x", *numbers)
        text = f'#define PROPOSALS {int(proposal.specular > 0)}\n#include "tabulated.glsl"\n'
        buffer = np.ascontiguousarray(self.values, np.float32).tobytes()
        return Twin(text, block, int(proposal.specular > 0), (buffer,))

    def _in_f(self) -> NDArray[np.floating]:
        """The values without a factor of cos_o; nothing where the viewer is below the horizon."""
        if self.holds == "f":
            return self.values
        h, d, p = np.meshgrid(*axes(self.values.shape[:3], self.cells, self.is_reciprocal), indexing="ij", sparse=True)
        cos_o = np.cos(h) * np.cos(d) + np.sin(h) * np.sin(d) * np.cos(p)
        return self.values * np.where(cos_o > 1e-3, 1 / np.maximum(cos_o, 1e-3), 0)[..., None]


def axes(
    nodes: tuple[int, int, int], cells: Cells = "nodes", is_reciprocal: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The angles at which a table's values stand.

    **Arguments:**

    - `nodes`: how many along theta_h, theta_d and phi_d.
    - `cells`, `is_reciprocal`: as in `Tabulated`.

    **Returns:** theta_h, theta_d and phi_d, each one-dimensional, radians.
    """
    ends = 1 if cells == "nodes" else 0
    h, d, p = (np.arange(count) + _OFFSET[cells] for count in nodes)
    turn = np.pi if is_reciprocal else 2 * np.pi
    theta_h = (h / (nodes[0] - ends)) ** 2 * (np.pi / 2)
    return theta_h, d / (nodes[1] - ends) * (np.pi / 2), p / nodes[2] * turn

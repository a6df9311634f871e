"""A material under light from all around, as a few round lobes: what the interactive tier shades with.

The light reflected to a viewer is the environment weighted by f(wi, wo) cos_i. That weight is approximated by

    sum over lobes of  amplitude(cos_o) kernel(wi . d),    d = h + tilt(cos_o) (r - h),

with the normal h, the mirror direction r, and each lobe's `Kernel`, by which the environment is blurred beforehand:
shading costs one look-up per lobe. Amplitudes and tilts are polynomials in cos_o, so that what the textbooks tabulate
and correct one by one, directional albedo, dominant direction, the highlight that stretches at grazing angles, comes
out of one fit to the material's own values (`round_fit`), diffuse and specular together, whatever its model.

A brushed material has its lobes side by side: h leans from the normal along the wide slope by `lean`, to that side of
it on which the viewer is, and amplitudes vary with the viewer's azimuth phi from there as a cos^2(phi) + b sin^2(phi).

- Karis 2013, "Real Shading in Unreal Engine 4": the split sum, which is one lobe with tilt 1.
- Lagarde, de Rousiers 2014, "Moving Frostbite to Physically Based Rendering": the dominant direction.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .evaluation import evaluate
from .kept_tables import kept
from .kernel import Kernel
from .source import assemble
from .twin import Twin

# Names the way in which lobes are found: another one must not find the lobes that this one kept.
_KIND = "lobes-14"
# Of the viewer, in the table: neighbours differ by less than eight bits show.
_COSINES = 1024


@dataclasses.dataclass(frozen=True, eq=False)
class RoundLobes:
    """A material's lobes.

    - `kernels`: one per lobe.
    - `tilt`: shape (n, 3), the coefficients of a polynomial in cos_o.
    - `lean`: shape (n,), the slope of h along the wide direction.
    - `amplitude`: shape (n, a, k, 3), coefficients of polynomials in cos_o, lowest first; a is 1, or 2 for the azimuths
      along and across the wide direction.
    - `azimuth`: of the wide direction in the tangent frame, radians.
    - `misfit`: the root mean square error of the light reflected from a part of the sphere around, in units of that.
    """

    kernels: tuple[Kernel, ...]
    tilt: NDArray[np.float64]
    lean: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    azimuth: float
    misfit: float

    @property
    def is_anisotropic(self) -> bool:
        return self.amplitude.shape[1] == 2

    @property
    def cubes(self) -> tuple[Kernel, ...]:
        """The kernels, each once: those of the blurred environments that are looked up."""
        return tuple(sorted(set(self.kernels)))

    @functools.cached_property
    def highlight_width(self) -> float | None:
        """The width of the one kernel that is as high as all round ones together are to a viewer above; None if nothing
        is reflected to there but what ends at the horizon."""
        amplitude = np.maximum(self.amplitude.sum(axis=2), 0).mean(axis=(1, 2))
        widths = np.array([kernel.width for kernel in self.kernels])
        is_round = np.array([kernel.power > 0 for kernel in self.kernels]) & (amplitude > 0)
        if not is_round.any():
            return None
        return math.sqrt(amplitude[is_round].sum() / (amplitude / widths**2)[is_round].sum())

    def defines(self) -> dict[str, str]:
        """What `glsl/round_lobes.glsl` is compiled with."""
        cube_of = ", ".join(str(self.cubes.index(kernel)) for kernel in self.kernels)
        return {
            "LOBES": str(len(self.kernels)),
            "AZIMUTHS": str(self.amplitude.shape[1]),
            "CUBES": str(len(self.cubes)),
            "CUBE_OF_LOBE": f"int[]({cube_of})",
        }

    def uniforms(self) -> dict[str, Any]:
        """The uniforms of `glsl/round_lobes.glsl` that are not textures."""
        wide = (math.cos(self.azimuth), math.sin(self.azimuth))
        heights = [one.values(np.zeros(1))[0] for one in self.kernels]
        kernels = [
            (1 / one.width**2, 0.0 if math.isinf(one.power) else one.power, height)
            for one, height in zip(self.kernels, heights, strict=True)
        ]
        return {"lean": self.lean.tolist(), "wide_azimuth": wide, "kernel": kernels}

    def table(self) -> NDArray[np.float32]:
        """The texture `lobe_table` of `glsl/round_lobes.glsl`: shape (n a, cosines, 4)."""
        lobes, azimuths = self.amplitude.shape[:2]
        powers = np.vander((np.arange(_COSINES) + 0.5) / _COSINES, max(self.amplitude.shape[2], 3), increasing=True)
        table = np.empty((lobes, azimuths, _COSINES, 4), np.float32)
        table[..., :3] = np.maximum(powers[:, : self.amplitude.shape[2]] @ self.amplitude, 0)
        table[..., 3] = (self.tilt @ powers[:, : self.tilt.shape[1]].T)[:, None]
        return table.reshape(lobes * azimuths, _COSINES, 4)


@functools.lru_cache(64)
def round_lobes(twin: Twin) -> RoundLobes:
    """The lobes of a material, from memory or disk if they were found before.

    Raises `UserError` when there is no OpenGL 4.3, by which the material's values are computed.
    """
    # With all that it includes: other shaders make another material.
    text = assemble("material", {}, {"material": twin.text}).text
    ingredients = (text.encode(), twin.block, bytes([twin.is_anisotropic]), *twin.buffers)
    found = kept(_KIND, ingredients, lambda: _arrays(twin))
    kernels = tuple(Kernel(float(power), int(step)) for power, step in found["kernels"])
    tilt, lean, amplitude = (np.asarray(found[name], np.float64) for name in ("tilt", "lean", "amplitude"))
    return RoundLobes(kernels, tilt, lean, amplitude, float(found["azimuth"]), float(found["misfit"]))


def _arrays(twin: Twin) -> dict[str, NDArray[np.generic]]:
    from .round_fit import fit_lobes

    fit = fit_lobes(lambda wi, wo: evaluate(twin, wi, wo), twin.is_anisotropic)
    azimuths = 2 if twin.is_anisotropic else 1
    return {
        "kernels": np.array([(one.power, one.step) for one in fit.kernels], np.float64).reshape(-1, 2),
        "tilt": fit.tilt,
        "lean": fit.lean,
        "amplitude": _monomials(fit.amplitude.reshape(len(fit.kernels), azimuths, -1, 3)),
        "azimuth": np.array(fit.azimuth),
        "misfit": np.array(fit.misfit),
    }


def _monomials(bernstein: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of Bernstein's polynomials, shape (n, a, k, 3), as those of powers."""
    degree = bernstein.shape[2] - 1
    change = np.zeros((degree + 1, degree + 1))
    for b in range(degree + 1):
        for k in range(b, degree + 1):
            change[k, b] = (-1) ** (k - b) * math.comb(degree, k) * math.comb(k, b)
    return np.einsum("kb,nabc->nakc", change, bernstein)

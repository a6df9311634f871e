"""Synthetic measurements: a known material at the directions of an instrument, with noise."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from brdf.errors import UserError, nearest
from brdf.material import Material, check_choice, check_live, check_parameter
from brdf.model import AbstractBRDF
from brdf.parameter import Choice, Parameter, choices, parameters
from brdf.registry import build, combine, split

from .formats import merl
from .reflectance import HORIZON_COSINE, Grid, Reflectance
from .rusinkiewicz import directions

NOISE_KINDS = ("multiplicative", "additive")
RANDOM_SAMPLES = 20_000
SAMPLES_MAX = 20_000_000
# Random directions end here, as instruments do.
_THETA_MAX = np.radians(85.0)

Pairs = tuple[np.ndarray, np.ndarray, Grid | None]


def synthesize(
    model: str | AbstractBRDF | Material,
    *,
    values: Mapping[str, Any] | None = None,
    layout: str = "random",
    samples: int | None = None,
    noise: float = 0.0,
    noise_kind: str = "multiplicative",
    seed: int = 0,
) -> Reflectance:
    """Measures a known material as an instrument would.

    Use it to see what a fit can recover from such data, and how the noise comes through.

    **Arguments:**

    - `model`: an expression such as `"lambert+ggx"`, a model or a material: the truth.
    - `values`: what differs from that, such as `{"alpha": 0.2, "ggx.f0": [1, 0.9, 0.8], "masking": "smith"}`.
    - `layout`: where it is measured, a name of `LAYOUTS`:
      `random`, pairs of directions up to 85 degrees, half of them near the mirror direction;
      `merl`, the cells of a MERL table; `slice`, those at phi_d = 90 degrees, 90 x 90;
      `plane`, in the plane of incidence, theta_i = 0, 15, ... 75 and theta_o to 85 degrees in steps of one degree;
      `goniometer`, four incident angles with the plane of incidence in steps of 2.5 degrees and the rest 5 x 15.
    - `samples`: how many; 20,000 by default for `random`, all for the others, of which fewer are drawn at random.
    - `noise`: standard deviation of the Gaussian noise: relative to the value (`multiplicative`) or in 1/sr
      (`additive`). A channel that falls below 0 becomes 0 and is counted in `clamped`.
    - `noise_kind`: one of the two.
    - `seed`: the same seed gives the same measurement.

    **Returns:** the measurement; its `source` tells the truth as JSON. `merl` and `slice` have their `grid`.

    **Raises:** `UserError` for an unknown model, parameter, layout or kind of noise, or a number out of range.
    """
    if layout not in LAYOUTS:
        raise UserError(f"`{layout}` is not a layout. {nearest(layout, LAYOUTS)}")
    if noise_kind not in NOISE_KINDS:
        raise UserError(f"`{noise_kind}` is not a kind of noise. {nearest(noise_kind, NOISE_KINDS)}")
    if not (np.isfinite(noise) and noise >= 0):
        raise UserError(f"`noise = {noise}` is not a standard deviation. Give 0 or more, such as 0.05.")
    if samples is not None and not 1 <= samples <= SAMPLES_MAX:
        raise UserError(f"`samples = {samples}` is outside [1, {SAMPLES_MAX}].")
    if seed < 0:
        raise UserError(f"`seed = {seed}` is negative. Give 0 or more.")
    truth = truth_of(model, values or {}).brdf
    # The noise has a stream of its own: it is the same whether or not directions were drawn before.
    wi, wo, grid = LAYOUTS[layout](samples, np.random.default_rng([seed, 1]))
    value = _evaluate(truth, wi, wo)
    error = noise * np.random.default_rng(seed).normal(size=value.shape)
    measured = value * (1 + error) if noise_kind == "multiplicative" else value + error
    return Reflectance(
        wi=wi,
        wo=wo,
        value=np.maximum(measured, 0.0),
        source=f"synthetic: {json.dumps(Material(truth).to_dict())}, {noise:g} {noise_kind} noise, layout {layout}, "
        f"seed {seed}",
        format="synthetic",
        clamped=int(np.count_nonzero(measured < 0)),
        grid=grid,
    )


def truth_of(model: str | AbstractBRDF | Material, values: Mapping[str, Any]) -> Material:
    """The material that `synthesize` measures, for the same `model` and `values`."""
    if isinstance(model, Material):
        model = model.brdf
    elif isinstance(model, str):
        model = build(model)
    lobes = split(model)
    named = [(*_find(lobes, key), value) for key, value in values.items()]
    # Choices first: they decide which parameters there are.
    for lobe, field, value in sorted(named, key=lambda entry: isinstance(entry[1], Parameter)):
        if isinstance(field, Parameter):
            check_live(field, lobes[lobe], lobe)
            checked: Any = check_parameter(value, field, lobe)
        else:
            checked = check_choice(value, field, lobe)
        lobes[lobe] = dataclasses.replace(lobes[lobe], **{field.name: checked})
    return Material(combine(lobes), {"made by": "brdf synthesize"})


def _find(lobes: Mapping[str, AbstractBRDF], key: str) -> tuple[str, Parameter | Choice]:
    """The lobe and the declaration that `alpha` or `ggx.alpha` names."""
    known = [(lobe, field) for lobe, part in lobes.items() for field in (*parameters(type(part)), *choices(part))]
    found = [(lobe, field) for lobe, field in known if key in (field.name, f"{lobe}.{field.name}")]
    if len(found) == 1:
        return found[0]
    if found:
        options = " or ".join(f"`{lobe}.{field.name}`" for lobe, field in found)
        raise UserError(f"`{key}` is a parameter of several lobes. Write {options}.")
    raise UserError(f"`{key}` is not a parameter here. {nearest(key, [f'{lobe}.{f.name}' for lobe, f in known])}")


def _evaluate(model: AbstractBRDF, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    import jax

    from brdf.model import evaluate

    with jax.enable_x64(True):
        value = np.asarray(evaluate(model, wi, wo))
    if not np.isfinite(value).all():
        raise UserError("The model is not finite everywhere. Check its parameters.")
    return value


def _random(samples: int | None, rng: np.random.Generator) -> Pairs:
    count = RANDOM_SAMPLES if samples is None else samples

    def hemisphere(n: int) -> np.ndarray:
        return _spherical(np.arccos(rng.uniform(np.cos(_THETA_MAX), 1, n)), rng.uniform(-np.pi, np.pi, n))

    wi, wo = hemisphere(count), hemisphere(count)
    # Distances from the mirror direction over three decades find highlights of any width.
    spread = 10 ** rng.uniform(-3, 0, (count, 1)) * rng.normal(size=(count, 3))
    near = wi * [-1, -1, 1] + spread
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    use = (np.arange(count) % 2 == 0) & (near[:, 2] > np.cos(_THETA_MAX))
    return wi, np.where(use[:, None], near, wo), None


def _merl(samples: int | None, rng: np.random.Generator) -> Pairs:
    return _table(merl.axes(), samples, rng)


def _slice(samples: int | None, rng: np.random.Generator) -> Pairs:
    axes = merl.axes()
    return _table({"theta_d": axes["theta_d"], "theta_h": axes["theta_h"]}, samples, rng)


def _table(axes: Mapping[str, np.ndarray], samples: int | None, rng: np.random.Generator) -> Pairs:
    """The cells of a table over half and difference angles that lie above the horizon."""
    mesh = dict(zip(axes, (angle.ravel() for angle in np.meshgrid(*axes.values(), indexing="ij")), strict=True))
    wi, wo = directions(mesh["theta_h"], mesh["theta_d"], mesh.get("phi_d", np.pi / 2))
    index = np.flatnonzero((wi[:, 2] > HORIZON_COSINE) & (wo[:, 2] > HORIZON_COSINE))
    index = index[_some(len(index), samples, rng)]
    return wi[index], wo[index], Grid(axes, index)


def _plane(samples: int | None, rng: np.random.Generator) -> Pairs:
    return _degrees([(i, o, p) for i in range(0, 76, 15) for p in (0, 180) for o in range(p == 180, 86)], samples, rng)


def _goniometer(samples: int | None, rng: np.random.Generator) -> Pairs:
    incident = (10, 30, 50, 70)
    plane = [(i, o, p) for i in incident for p in (0, 180) for o in np.arange(0, 78, 2.5)]
    beside = [(i, o, p) for i in incident for p in range(15, 180, 15) for o in range(5, 76, 5)]
    return _degrees(plane + beside, samples, rng)


def _degrees(rows: Sequence[tuple[float, float, float]], samples: int | None, rng: np.random.Generator) -> Pairs:
    """Pairs of directions from theta_i, theta_o and phi_o."""
    theta_i, theta_o, phi_o = np.radians(np.array(rows, np.float64)[_some(len(rows), samples, rng)]).T
    return _spherical(theta_i, np.zeros_like(theta_i)), _spherical(theta_o, phi_o), None


def _some(count: int, samples: int | None, rng: np.random.Generator) -> np.ndarray:
    """Which of `count` things are kept, in their order."""
    if samples is None or samples == count:
        return np.arange(count)
    if samples > count:
        raise UserError(f"`samples = {samples}` is more than the {count} of this layout. Give fewer or leave it out.")
    return np.sort(rng.choice(count, samples, replace=False))


def _spherical(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


LAYOUTS: Mapping[str, Callable[[int | None, np.random.Generator], Pairs]] = {
    "random": _random,
    "merl": _merl,
    "slice": _slice,
    "plane": _plane,
    "goniometer": _goniometer,
}

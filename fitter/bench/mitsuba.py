"""The models that Mitsuba 3 has, measured beside ours: run as a process, since too old an LLVM ends the process.

Mitsuba's `eval` is vectorised by Dr.Jit's LLVM back end, in float32, and holds the cosine. Its first vector, `si.wi`,
points to the viewer.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from brdf.model import AbstractBRDF
from brdf.registry import MODELS

_VARIANT = "llvm_ad_rgb"
# Copper-like, so that no compiler takes three channels for one.
_COLOUR, _ETA, _K = (0.9, 0.6, 0.3), (0.3, 0.9, 1.1), (3.9, 2.4, 2.2)
_CONDUCTOR = {"masking": "smith_separable", "fresnel": "conductor", "eta": _ETA, "k": _K}
_MINUTES_MAX = 10


@dataclasses.dataclass(frozen=True)
class Peer:
    """A model of Mitsuba beside ours at the same parameters.

    - `plugin`: Mitsuba's name of it.
    - `choices`: ours that make it the same formula.
    - `ours`, `theirs`: values per second, float32.
    - `median`, `largest`: of the relative difference of their value to ours.
    """

    plugin: str
    choices: str
    ours: float
    theirs: float
    median: float
    largest: float


@dataclasses.dataclass(frozen=True)
class Peers:
    """What was found: `note` says which Mitsuba, or why something is missing."""

    rows: dict[str, Peer]
    note: str


def peers(names: Sequence[str], points: int, rounds: int) -> Peers:
    """Measures those of the models that Mitsuba has."""
    wanted = [name for name in names if name in _PLUGINS]
    if importlib.util.find_spec("mitsuba") is None:
        return Peers({}, "n/a: Mitsuba 3 is not installed (`pip install mitsuba`)")
    if not wanted:
        return Peers({}, "n/a: Mitsuba has none of these models")
    command = [sys.executable, "-m", __name__, str(points), str(rounds), *wanted]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60 * _MINUTES_MAX)
    except subprocess.TimeoutExpired:
        return Peers({}, f"n/a: Mitsuba took longer than {_MINUTES_MAX} minutes")
    found: dict[str, Any] = {}
    for line in done.stdout.splitlines():
        # Dr.Jit writes warnings between our lines.
        if line.startswith("{"):
            found |= json.loads(line)
    note = f"Mitsuba {found.pop('version', '3')}, {_VARIANT}"
    if done.returncode != 0:
        reason = next(
            (line for line in done.stderr.splitlines() if "error" in line.lower()), f"exit status {done.returncode}"
        )
        missing = ", ".join(name for name in wanted if name not in found)
        # LLVM's message goes on with addresses.
        reason = reason.partition(": 0x")[0][:100]
        note += f"; n/a for {missing}: {reason} (another LLVM is named by DRJIT_LIBLLVM_PATH)"
    return Peers({name: Peer(**row) for name, row in found.items()}, note)


def _diffuse() -> tuple[dict[str, Any], AbstractBRDF]:
    return {"type": "diffuse", "reflectance": _rgb(_COLOUR)}, MODELS["lambert"](albedo=_COLOUR)


def _rough_conductor(name: str) -> tuple[dict[str, Any], AbstractBRDF]:
    plugin = {"type": "roughconductor", "distribution": name, "alpha": 0.3, "eta": _rgb(_ETA), "k": _rgb(_K)}
    return plugin, MODELS[name](alpha=0.3, **_CONDUCTOR)


def _principled() -> tuple[dict[str, Any], AbstractBRDF]:
    plugin = {"type": "principled", "base_color": _rgb(_COLOUR), "roughness": 0.5, "specular": 0.5}
    return plugin, MODELS["disney"](base_color=_COLOUR)


_PLUGINS = {
    "lambert": (_diffuse, ""),
    "ggx": (lambda: _rough_conductor("ggx"), "masking = smith_separable, fresnel = conductor"),
    "beckmann": (lambda: _rough_conductor("beckmann"), "masking = smith_separable, fresnel = conductor"),
    "disney": (_principled, ""),
}


def _rgb(colour: tuple[float, float, float]) -> dict[str, Any]:
    return {"type": "rgb", "value": list(colour)}


def main(points: int, rounds: int, names: Sequence[str]) -> None:
    """Prints a line of JSON per model."""
    # An optional package, which the type checker need not find.
    dr: Any = importlib.import_module("drjit")
    mi: Any = importlib.import_module("mitsuba")
    mi.set_variant(_VARIANT)
    import jax
    import jax.numpy as jnp
    import numpy as np

    from .measure import NEGLIGIBLE, directions, rates, value

    print(json.dumps({"version": mi.__version__}), flush=True)
    wi, wo = directions(points, "float32")
    to_light, to_viewer = (mi.Vector3f(*map(mi.Float, w)) for w in (wi, wo))
    interaction = dr.zeros(mi.SurfaceInteraction3f, points)
    interaction.wi = to_viewer
    dr.eval(interaction, to_light)
    context = mi.BSDFContext()
    for name in names:
        make, choices = _PLUGINS[name]
        plugin, model = make()
        bsdf = mi.load_dict(plugin)

        def theirs(bsdf: Any = bsdf) -> Any:
            found = bsdf.eval(context, interaction, to_light)
            dr.eval(found)
            dr.sync_thread()
            return found

        arguments = jax.tree.map(lambda leaf: jnp.asarray(leaf, "float32"), (model, wi, wo))
        compiled = jax.jit(value).lower(*arguments).compile()
        ours = lambda run=compiled, arguments=arguments: jax.block_until_ready(run(*arguments))  # noqa: E731
        measured = rates({"ours": (ours, points), "theirs": (theirs, points)}, rounds)
        truth = np.asarray(ours()) * wi[2]
        # Mitsuba may give one value for what does not depend on the direction.
        apart = np.abs(np.array(theirs()) - truth) / np.maximum(truth, NEGLIGIBLE)
        row = {"plugin": plugin["type"], "choices": choices, **measured}
        row |= {"median": float(np.median(apart)), "largest": float(np.max(apart))}
        print(json.dumps({name: row}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])

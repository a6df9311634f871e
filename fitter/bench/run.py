"""Runs the measurements of `brdf bench models`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from brdf.model import specialized
from brdf.registry import MODELS, build

from .measure import cost, speed
from .mitsuba import peers
from .report import Bench

# Without and with what a static choice, or a weight that is 0 beforehand, leaves out.
_PAIRS = {
    ("disney, lobes of weight 0 absent", "disney, weights as numbers"): lambda: (
        specialized(build("disney")),
        build("disney"),
    ),
    ("openpbr, lobes of weight 0 absent", "openpbr, weights as numbers"): lambda: (
        specialized(build("openpbr")),
        build("openpbr"),
    ),
    ("ggx", "lambert+ggx"): lambda: (build("ggx"), build("lambert+ggx")),
    ("ggx, energy = single", "ggx, energy = multiple"): lambda: (build("ggx"), MODELS["ggx"](energy="multiple")),
    ("ashikhmin_shirley, diffuse = none", "ashikhmin_shirley, diffuse = coupled"): lambda: (
        build("ashikhmin_shirley"),
        MODELS["ashikhmin_shirley"](diffuse="coupled"),
    ),
}
# Mitsuba traces its program at every call; more points make that small.
_MITSUBA_POINTS = 16


def bench(
    names: Sequence[str], points: int, dtype: str, rounds: int, one_core: bool, say: Callable[[str], None]
) -> Bench:
    """Measures models, or all of them if none is named; only then also what absent lobes cost.

    **Arguments:**

    - `names`: models or sums.
    - `points`: pairs of directions per call.
    - `dtype`: `"float64"` or `"float32"`.
    - `rounds`: interleaved rounds, whose median counts.
    - `one_core`: whether the process is bound to one core, for the report.
    - `say`: is told what is being done.

    Raises `UserError` for an unknown model.
    """
    models = {name: build(name) for name in names or MODELS}
    speeds = {}
    for name, model in models.items():
        say(f"measuring {name}")
        speeds[name] = speed(model, points, dtype, rounds)
    costs = {}
    for pair, make in ({} if names else _PAIRS).items():
        say(f"measuring {' and '.join(pair)}")
        without, present = (cost(model, points, dtype, rounds) for model in make())
        costs[pair] = (without, present)
    say("measuring Mitsuba")
    return Bench(speeds, costs, peers(list(models), _MITSUBA_POINTS * points, rounds), points, dtype, rounds, one_core)

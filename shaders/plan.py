"""Which passes a frame needs: passes say what they read and write, and only what leads to an output is run."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable


@dataclasses.dataclass(frozen=True)
class Pass:
    """What a pass declares of itself, for one scene.

    - `name`: unique in a plan.
    - `reads`, `writes`: names of the pictures it uses and changes. A pass that adds to a picture writes it only.
    - `enabled`: whether the scene asks for it.
    - `side_effect`: whether it does something beyond its writes, and so is kept although nobody reads them.
    - `every_frame`: whether it is run for each of the jittered frames, or once after them.
    """

    name: str
    reads: frozenset[str]
    writes: frozenset[str]
    enabled: bool = True
    side_effect: bool = False
    every_frame: bool = False


@dataclasses.dataclass(frozen=True)
class FramePlan:
    """The passes to run, in order, and for each dropped one the reason."""

    passes: tuple[Pass, ...]
    dropped: dict[str, str]

    def runs(self, name: str) -> bool:
        return any(kept.name == name for kept in self.passes)


def plan(passes: Iterable[Pass], outputs: Iterable[str]) -> FramePlan:
    """Walks back from the outputs and drops the passes that are disabled or whose writes nobody reads.

    **Arguments:**

    - `passes`: in the order in which they would run.
    - `outputs`: the pictures that are wanted.

    **Returns:** the `FramePlan`.

    Raises `ValueError` when a pass that is kept, or an output, needs a picture that no kept pass writes before.
    """
    ordered = list(passes)
    needed = set(outputs)
    kept: list[Pass] = []
    dropped: dict[str, str] = {}
    for candidate in reversed(ordered):
        if not candidate.enabled:
            dropped[candidate.name] = "disabled"
        elif not candidate.side_effect and not candidate.writes & needed:
            dropped[candidate.name] = "not read"
        else:
            kept.insert(0, candidate)
            needed |= candidate.reads
    _check(kept, set(outputs))
    return FramePlan(tuple(kept), dict(reversed(dropped.items())))


def _check(kept: list[Pass], outputs: set[str]) -> None:
    written: set[str] = set()
    for one in kept:
        missing = one.reads - written
        if missing:
            raise ValueError(f"The pass `{one.name}` reads `{min(missing)}`, which no pass writes before it.")
        written |= one.writes
    if outputs - written:
        raise ValueError(f"No pass writes the output `{min(outputs - written)}`.")

"""Which passes a frame needs: passes say what they read and write; only what leads to an output and is new is run.

A resource is anything that a pass writes: a picture, a texture, a buffer. Its version is what it was made of: the names
and keys of the passes that wrote it, and the versions of what they read. A resource that is kept from an earlier frame
with the same version need not be made again, nor what only it was made of.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterable, Mapping

# For each pass that wrote the resource, in order: its name, its key, and the versions of what it read by name.
Version = tuple[tuple[str, Hashable, tuple[tuple[str, "Version"], ...]], ...]


@dataclasses.dataclass(frozen=True)
class Pass:
    """What a pass declares of itself, for one scene.

    - `name`: unique in a plan.
    - `reads`, `writes`: names of the resources it uses and changes. A pass that adds to a resource writes it only.
    - `key`: everything else that its result depends on.
    - `enabled`: whether the scene asks for it.
    - `side_effect`: whether it does something beyond its writes, and so is run although nobody reads them.
    - `every_frame`: whether it is run for each of the jittered frames, or once.
    """

    name: str
    reads: frozenset[str]
    writes: frozenset[str]
    key: Hashable = None
    enabled: bool = True
    side_effect: bool = False
    every_frame: bool = False


@dataclasses.dataclass(frozen=True)
class FramePlan:
    """What is to be done with each declared pass.

    - `declared`: all passes, in order.
    - `passes`: those to run, in order.
    - `reused`: the names of those whose writes are kept and are read by a pass that runs, or are outputs.
    - `dropped`: name -> reason for the rest: `"disabled"`, `"not read"` or `"its reader is reused"`.
    - `versions`: of every resource that the scene has, made or not. What is not among them may be freed.
    """

    declared: tuple[Pass, ...]
    passes: tuple[Pass, ...]
    reused: tuple[str, ...]
    dropped: dict[str, str]
    versions: dict[str, Version]

    def runs(self, name: str) -> bool:
        return any(one.name == name for one in self.passes)


def plan(passes: Iterable[Pass], outputs: Iterable[str], kept: Mapping[str, Version]) -> FramePlan:
    """Walks back from the outputs and drops passes that are disabled, that nobody reads or whose result is kept.

    **Arguments:**

    - `passes`: in the order in which they would run.
    - `outputs`: the resources that are wanted.
    - `kept`: the versions of the resources that exist already.

    **Returns:** the `FramePlan`.

    Raises `ValueError` when a pass that is needed, or an output, needs a resource that no needed pass writes before.
    """
    declared = tuple(passes)
    wanted = frozenset(outputs)
    live, dropped = _live(declared, wanted)
    versions = _versions(live, wanted)
    valid = {name for name, version in versions.items() if kept.get(name) == version} - _handed_over(live)
    # A pass that runs makes all that it writes anew, and so makes run whatever else writes there.
    made = wanted - valid
    while True:
        running = [one for one in live if one.side_effect or one.writes & made]
        wanted = wanted.union(*(one.reads for one in running))
        grown = made.union(wanted - valid, *(one.writes for one in running))
        if grown == made:
            break
        made = grown
    idle = [one for one in live if one not in running]
    reused = tuple(one.name for one in idle if one.writes & wanted)
    reasons = dropped | {one.name: "its reader is reused" for one in idle if one.name not in reused}
    in_order = {one.name: reasons[one.name] for one in declared if one.name in reasons}
    return FramePlan(declared, tuple(running), reused, in_order, versions)


def _live(declared: tuple[Pass, ...], outputs: frozenset[str]) -> tuple[list[Pass], dict[str, str]]:
    """The passes that lead to an output if nothing is kept, and why each of the others does not."""
    needed = set(outputs)
    live: list[Pass] = []
    dropped: dict[str, str] = {}
    for one in reversed(declared):
        if not one.enabled:
            dropped[one.name] = "disabled"
        elif not one.side_effect and not one.writes & needed:
            dropped[one.name] = "not read"
        else:
            live.insert(0, one)
            needed |= one.reads
    return live, dropped


def _versions(live: list[Pass], outputs: frozenset[str]) -> dict[str, Version]:
    versions: dict[str, Version] = {}
    for one in live:
        missing = one.reads - versions.keys()
        if missing:
            raise ValueError(f"The pass `{one.name}` reads `{min(missing)}`, which no pass writes before it.")
        written = (one.name, one.key, tuple((name, versions[name]) for name in sorted(one.reads)))
        versions |= {name: (*versions.get(name, ()), written) for name in one.writes}
    if outputs - versions.keys():
        raise ValueError(f"No pass writes the output `{min(outputs - versions.keys())}`.")
    return versions


def _handed_over(live: list[Pass]) -> set[str]:
    """What the passes of a jittered frame hand to each other: the next frame overwrites it, so it is never kept."""
    looped = [one for one in live if one.every_frame]
    return {name for one in looped for name in one.reads} & {name for one in looped for name in one.writes}

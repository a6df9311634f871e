"""What `brdf preview --stats` prints of a picture's counts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def stats_text(counts: Mapping[str, Any]) -> str:
    """The counts of a picture as lines to read.

    - `counts`: as `shaders.Image.counts` has them.
    """
    lines = ["passes"]
    for name in counts["passes"]:
        lines.append(f"  {name:<15} run      {counts['milliseconds'][name]:>10.1f} ms")
    lines += [f"  {name:<15} reused" for name in counts["reused"]]
    lines += [f"  {name:<15} dropped  {reason}" for name, reason in counts["dropped"].items()]
    error = "unknown" if counts["error"] is None else f"{counts['error']:.2g}"
    values = {
        "draws": f"{counts['draws']}",
        "culled parts": f"{counts['culled_parts']}",
        "bytes uploaded": f"{counts['bytes_uploaded']:,}",
        "programs compiled": f"{counts['programs_compiled']}",
        "frames": f"{counts['frames']}, {counts['samples']} samples per pixel",
        "error": f"{error} (estimated RMS, 1 is white)" if counts["error"] is not None else error,
        "stopped since": counts["stopped"],
        "seconds": f"{counts['seconds']:.3f}",
    }
    return "\n".join([*lines, *(f"{name:<17} {value}" for name, value in values.items())])

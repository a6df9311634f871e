"""One thing found in measured data."""

from __future__ import annotations

import dataclasses

from ..reflectance import Reflectance


@dataclasses.dataclass(frozen=True)
class Finding:
    """One thing found in measured data.

    - `name`: what, in a word or two.
    - `count`: how many samples (channel values where the sentence says so) it concerns; `share`: of all, 0 to 1.
    - `sentence`: what was found, how many, and what to do.
    """

    name: str
    count: int
    share: float
    sentence: str


def found(name: str, count: int, data: Reflectance, sentence: str) -> Finding:
    """A finding about `count` samples; `{count}` becomes `12 of 916 samples (1.3 %)`, `{number}` 12."""
    share = count / len(data)
    counted = f"{count} of {len(data)} samples ({100 * share:.2g} %)"
    return Finding(name, count, share, sentence.replace("{count}", counted).replace("{number}", str(count)))

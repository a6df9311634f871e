"""What a comparison of models gives back: a row for each, and the one that was taken."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

from brdf.errors import UserError

from .physics import PhysicalCheck, check
from .result import FitResult


@dataclasses.dataclass(frozen=True)
class Candidate:
    """One model and what became of it.

    - `expression`: such as `lambert+ggx`; `choices`: its static choices that differ from the default, as written in a
      material.
    - `result`: the fit to all samples; None if it failed.
    - `held_out`: mean |log(1 + f cos_i) - log(1 + y cos_i)| of the samples that a fit did not see; NaN if it failed or
      nothing could be held out. `standard_error`: of that mean, from the scatter between blocks of angles.
    - `seconds`: wall time of all of its fits, compilation included.
    - `note`: what went wrong, or nothing.
    """

    expression: str
    choices: str
    result: FitResult | None
    held_out: float
    standard_error: float
    seconds: float
    note: str

    @property
    def name(self) -> str:
        """The expression, with the choices in brackets."""
        return f"{self.expression} ({self.choices})" if self.choices else self.expression

    @property
    def numbers(self) -> int | None:
        """How many numbers the fit was free to choose."""
        return self.result and self.result.unknowns.size

    @property
    def log_mae(self) -> float:
        """The mean error over all samples, fitted to all of them; NaN if the fit failed."""
        return self.result.errors["log_mae"] if self.result else math.nan

    @functools.cached_property
    def delta_e_itp(self) -> float:
        """The mean Delta E ITP of a rendered sphere (see `fitter.judge`), computed when first asked for; NaN if the fit
        failed or cannot be judged."""
        from .judge import judge

        try:
            return judge(self.result.brdf, self.result.data).mean if self.result else math.nan
        except UserError:
            return math.nan

    def to_dict(self) -> dict[str, Any]:
        """The candidate as a JSON object, numbers that do not exist as null."""
        numbers = {
            "held_out": self.held_out,
            "standard_error": self.standard_error,
            "log_mae": self.log_mae,
            "delta_e_itp": self.delta_e_itp,
        }
        return {
            "model": self.expression,
            "choices": self.choices,
            **{name: value if math.isfinite(value) else None for name, value in numbers.items()},
            "numbers": self.numbers,
            "seconds": self.seconds,
            "note": self.note,
        }


@dataclasses.dataclass(frozen=True)
class Selection:
    """The models that were compared and the one that was taken.

    - `candidates`: in the order in which they were tried.
    - `chosen`: the one taken; `result` is its fit to all samples.
    - `angle`, `folds`: what was held out, `theta_d` for example, and in how many fits; 0 if nothing could be.
    - `reason`: why this one, a sentence.
    """

    candidates: tuple[Candidate, ...]
    chosen: Candidate
    angle: str
    folds: int
    reason: str

    @property
    def result(self) -> FitResult:
        """The chosen model's fit to all samples."""
        assert self.chosen.result is not None
        return self.chosen.result

    @functools.cached_property
    def physics(self) -> PhysicalCheck:
        """Whether the chosen model keeps energy and reciprocity, see `fitter.physics`."""
        return check(self.result.brdf)

    def to_dict(self) -> dict[str, Any]:
        """The comparison as one JSON object, without the chosen material."""
        return {
            "candidates": [candidate.to_dict() for candidate in self.candidates],
            "chosen": self.chosen.name,
            "held_out_angle": self.angle if self.folds else None,
            "folds": self.folds,
            "reason": self.reason,
            "physics": self.physics.to_dict(),
        }

    def report(self) -> str:
        """The table of candidates, for reading."""
        what = f"{self.folds} fits without blocks of {self.angle}" if self.folds else "nothing could be held out"
        width = max(len(candidate.name) for candidate in self.candidates)
        lines = [
            f"[[Models]] mean error of log(1 + f cos_i); held out: {what}",
            f"      {'model':{width}}  {'held out':>9} {'+/-':>8}  {'all':>8}  {'dE ITP':>6}  numbers  seconds",
        ]
        for one in self.candidates:
            mark = "->" if one is self.chosen else "  "
            numbers = "-" if one.numbers is None else one.numbers
            lines.append(
                f"   {mark} {one.name:{width}}  {_digits(one.held_out, 5):>9} {_digits(one.standard_error, 5):>8}  "
                f"{_digits(one.log_mae, 5):>8}  {_digits(one.delta_e_itp, 1):>6}  {numbers:>7}  {one.seconds:7.1f}"
            )
            if one.note:
                lines.append(f"      {'':{width}}  {one.note}")
        return "\n".join([*lines, f"    {self.reason}", f"    It {self.physics.sentence()}."])


def _digits(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"

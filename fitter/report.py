"""The text of a fit: statistics, parameters with errors, what the data leave open, and what to beware of."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from brdf.material import Material
from brdf.model import AbstractBRDF
from brdf.registry import expression_of

if TYPE_CHECKING:
    from .result import FitResult

# Correlations below this are left out of the report; above the second one they are a warning.
CORRELATION_SHOWN = 0.1
_CORRELATION_WARNED = 0.95
_CORRELATIONS_WARNED_MAX = 3
# A mean log error above the first is a misfit that shows; above the second the data are likely in another unit.
_MISFIT_WARNED = 0.08
_UNITS_WARNED = 1.5
# Singular values that are shown: the largest is 1, the smallest decide.
_SINGULAR_SHOWN = 4


def report(result: FitResult) -> str:
    """The result for reading."""
    errors, sure = result.errors, result.certainty
    lines = [
        f"[[Fit of {expression_of(result.brdf)}]]",
        f"    data          {result.data.source}",
        f"    samples       {result.samples} used, {sum(result.dropped.values())} left out{_reasons(result.dropped)}",
        f"    loss          {result.loss}, weights {result.weights}, theta < {result.max_theta_deg:g} deg",
        f"    status        {result.status}",
        f"    log error     mean {errors['log_mae']:.5f}, rms {errors['log_rms']:.5f}"
        "  (of log(1 + f cos_i); 0.01 is about 1 % where f is large)",
        f"    appearance    {result.judgement.sentence()}",
        *_looks(result),
        f"    time          {result.seconds:.2f} s, {result.passes:.1f} passes over all samples",
        _parameters_title(result),
        *_parameter_lines(result),
    ]
    strong = result.correlations()
    if strong:
        lines.append(f"[[Correlations]] (above {CORRELATION_SHOWN:g} in magnitude; the strongest 10)")
        width = max(len(f"{a}, {b}") for a, b, _ in strong[:10])
        lines += [f"    {f'{a}, {b}':{width}}  {rho:+.3f}" for a, b, rho in strong[:10]]
    if sure.singular_values.size:
        smallest = ", ".join(f"{value:.2g}" for value in sure.singular_values[-_SINGULAR_SHOWN:])
        lines.append("[[Identifiability]]")
        lines.append(f"    determined    {sure.rank} of {sure.singular_values.size} numbers that are not at a bound")
        lines.append(f"    singular      {smallest}  (the smallest of the scaled Jacobian; the largest is 1)")
        lines += [f"    freedom       {_freedom(labels)}" for labels in sure.freedoms]
    if result.advice is not None:
        lines.append("[[What to measure next]]")
        lines += [f"    {advice.sentence()}" for advice in result.advice] or [
            "    No further scan would lower a standard error by more than 5 %."
        ]
    found = notes(result)
    if found:
        lines.append("[[Notes]]")
        lines += [f"    {note}" for note in found]
    return "\n".join(lines)


def notes(result: FitResult) -> list[str]:
    """What a user should know before trusting the numbers, one sentence each."""
    sure = result.certainty
    found = []
    if result.errors["log_mae"] > _MISFIT_WARNED:
        found.append(_misfit(result.errors["log_mae"]))
    if result.judgement.verdict == "wrong":
        found.append(
            "The fitted sphere looks WRONG beside the measured one, whatever the log error says: look at --plot, and "
            "try `--loss adaptive` or `--model auto`."
        )
    found += [finding.sentence for finding in result.findings]
    found += _held(result)
    if sure.inflation > 1:
        found.append(
            "Where the model misses the data neighbouring samples err together. Standard errors and intervals are of "
            f"a bootstrap over incident angles, {math.sqrt(sure.inflation):.1f} times what independent samples give."
        )
    if 3 * result.samples <= result.unknowns.size:
        found.append(f"{result.samples} samples are too few for {result.unknowns.size} free numbers and their errors.")
    if result.at_bound():
        found.append(f"At a bound: {', '.join(result.at_bound())}. Their intervals are profiles of the cost.")
    if idle := _idle(result):
        found.append(f"Without any effect at this solution, and as they were at its start: {', '.join(idle)}.")
    for a, b, rho in result.correlations(_CORRELATION_WARNED)[:_CORRELATIONS_WARNED_MAX]:
        found.append(f"{a} and {b} trade off against each other ({rho:+.3f}): fix one of them to pin the other.")
    return found


def elements(model: AbstractBRDF) -> dict[str, Any]:
    """Every number and choice of a model by label, such as `"ggx.f0.r"`, in the order of the declaration."""
    found: dict[str, Any] = {}
    for lobe, values in Material(model).to_dict()["parameters"].items():
        for name, value in values.items():
            if isinstance(value, list):
                found |= {f"{lobe}.{name}.{channel}": x for channel, x in zip("rgb", value, strict=True)}
            else:
                found[f"{lobe}.{name}"] = value
    return found


def _looks(result: FitResult) -> list[str]:
    if result.looks is None:
        return []
    tried = ", ".join(f"{loss} {mean:.3g}" for loss, mean in result.looks.items())
    return [f"    adaptive      {result.loss} looks most like the measurement (Delta E ITP: {tried})"]


def _parameters_title(result: FitResult) -> str:
    how = "bootstrap over incident angles" if result.certainty.inflation > 1 else "independent samples"
    return f"[[Parameters]] +/- standard error [95 % interval] ({how})"


def _parameter_lines(result: FitResult) -> list[str]:
    rows = {
        label: (error, interval, is_stuck)
        for label, error, interval, is_stuck in zip(
            result.unknowns.element_labels,
            result.certainty.standard_errors,
            result.certainty.intervals,
            result.certainty.at_bound & ~result.certainty.idle,
            strict=True,
        )
    }
    tied = {".".join(place): unknown.label for unknown in result.unknowns.free for place in unknown.places[1:]}
    initial, values, idle = elements(result.initial), elements(result.brdf), _idle(result)
    width = max(len(label) for label in values)
    lines = []
    for label, value in values.items():
        line = f"    {label:{width}}  {_digits(value):<12}"
        owner = next((other for place, other in tied.items() if label == place or label.startswith(f"{place}.")), None)
        if isinstance(value, str):
            line += "(choice)"
        elif owner is not None:
            line += f"(tied to {owner})"
        elif label not in rows:
            line += "(held)" if _is_held(result, label) else "(fixed)"
        else:
            error, (low, high), is_stuck = rows[label]
            start = f"(init = {initial[label]:.4g})"
            if is_stuck:
                limit = f" [{low:.3g}, {high:.3g}]" if math.isfinite(low) else ""
                line += f"at its bound {limit:32} {start}"
            elif not math.isfinite(error):
                line += f"{'no effect' if label in idle else 'not determined':46}{start}"
            else:
                percent = f"{100 * error / abs(value):.2f} %" if value else "-"
                line += f"+/- {error:<9.3g} ({percent:>8}) [{low:<8.4g}, {high:>8.4g}]  {start}"
        lines.append(line.rstrip())
    return lines


def _idle(result: FitResult) -> list[str]:
    rows = zip(result.unknowns.element_labels, result.certainty.idle, strict=True)
    return [label for label, is_idle in rows if is_idle]


def _is_held(result: FitResult, label: str) -> bool:
    return any(label == ".".join(place) for place, _ in result.unknowns.held)


def _held(result: FitResult) -> list[str]:
    """What the fit held of its own accord, and how to free it."""
    values = elements(result.brdf)
    sentences = []
    for (lobe, name), options in result.unknowns.held:
        label = f"{lobe}.{name}"
        parameter = result.unknowns.declaration((lobe, name))
        others = [f"{option:g}" for option in options if option != values[label]]
        worse = f" ({' and '.join(others)} fits worse)" if others else ""
        why = parameter.because or "needs data that turn the sample about its normal"
        sentences.append(f"{label} {why}; held at {values[label]:g}{worse}: `--free {name}` to override.")
    return sentences


def _freedom(labels: tuple[str, ...]) -> str:
    if len(labels) == 1:
        return f"{labels[0]} changes nothing on these data. Fix it."
    return f"{', '.join(labels)} trade off exactly on these data. Fix one of them."


def _misfit(log_mae: float) -> str:
    if log_mae > _UNITS_WARNED:
        return (
            f"THE MODEL MISSES THE DATA (mean log error {log_mae:.2f}). Check the data's units: 1/sr, without cosine."
        )
    return (
        f"The model misses the data: {log_mae:.2f} is about {100 * math.expm1(log_mae):.0f} % where f is large. "
        "Look at the --plot, and try `--model auto`."
    )


def _reasons(dropped: dict[str, int]) -> str:
    return " (" + ", ".join(f"{reason}: {count}" for reason, count in dropped.items()) + ")" if dropped else ""


def _digits(value: float | str) -> str:
    return value if isinstance(value, str) else f"{np.float64(value):.6g}"

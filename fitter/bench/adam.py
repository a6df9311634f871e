"""torch Adam on lambert+ggx: what somebody with a deep-learning background would write."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .problem import Problem
from .trace import Run, Stopped, Trace

_MODEL = "lambert+ggx"
_RATE, _STEPS_MAX = 0.2, 2000
# The rate falls by this factor per step, so that the last digits settle.
_DECAY = 0.995
# Ends when the cost has changed by a smaller share over so many steps.
_FTOL, _PATIENCE = 1e-9, 10


def prepare(problem: Problem) -> Callable[[float], Run] | None:
    """A run of Adam in float64, or None for another model than lambert+ggx.

    What depends on directions alone is computed once and not counted. GGX as in `brdf/models/ggx.py`: Smith's
    height-correlated masking and Schlick's Fresnel term.
    """
    if problem.model != _MODEL:
        return None
    torch = importlib.import_module("torch")
    wi, wo, target = (torch.tensor(np.array(a).T) for a in problem.samples[:3])
    root = torch.tensor(np.sqrt(problem.data.weight / problem.data.weight.mean()))
    half = wi + wo
    half = half / half.norm(dim=0)
    cos_i, cos_o, cos_h2 = wi[2], wo[2], half[2] ** 2
    sin_h2 = half[0] ** 2 + half[1] ** 2
    schlick = (1 - (wi * half).sum(0).clamp(0, 1)) ** 5
    low, high = (torch.tensor(bound) for bound in problem.bounds)

    def cost(y: Any) -> Any:
        alpha2 = y[6] ** 2
        d = alpha2 / (math.pi * (alpha2 * cos_h2 + sin_h2) ** 2)
        lambda_i = cos_o * torch.sqrt(alpha2 + (1 - alpha2) * cos_i**2)
        lambda_o = cos_i * torch.sqrt(alpha2 + (1 - alpha2) * cos_o**2)
        f0 = y[3:6, None]
        fresnel = f0 + (1 - f0) * schlick
        f = y[0:3, None] / math.pi + fresnel * (d * 0.5 / (lambda_i + lambda_o))
        return 0.5 * (((torch.log1p(f * cos_i) - target) * root) ** 2).sum()

    def run(limit: float) -> Run:
        trace = Trace(limit, problem.start)
        share = (torch.tensor(problem.start) - low) / (high - low)
        z = torch.logit(share).requires_grad_()
        adam = torch.optim.Adam([z], lr=_RATE)
        schedule = torch.optim.lr_scheduler.ExponentialLR(adam, _DECAY)
        costs: list[float] = []
        y = problem.start
        try:
            for _ in range(_STEPS_MAX):
                adam.zero_grad()
                now = low + (high - low) * torch.sigmoid(z)
                loss = cost(now)
                loss.backward()
                y = np.array(now.tolist())
                trace.see(y)
                costs.append(loss.item())
                if len(costs) > _PATIENCE and abs(costs[-1 - _PATIENCE] - costs[-1]) <= _FTOL * costs[-1]:
                    break
                adam.step()
                schedule.step()
        except Stopped:
            return trace.stop()
        return trace.end(y)

    return run

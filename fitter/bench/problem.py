"""One fit as a plain least-squares problem, which is what the peers are given: they know nothing of our solver."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from brdf.model import AbstractBRDF, specialized
from brdf.parameter import Parameter, parameters
from brdf.registry import build, combine, split

from ..reflectance import Reflectance

Array = NDArray[Any]

# The plain sum of squares of log(1 + f cos_i): every peer can minimise it, and every sample counts.
LOSS = "log_squares"
MAX_THETA_DEG = 90.0
# Where the peers start; a second lobe of the same kind starts broader. Ours finds its own start in its own time.
_START = {"albedo": 0.3, "f0": 0.1, "alpha": 0.15}
_SECOND = {"f0": 0.05, "alpha": 0.5}
_DISNEY = {"base_color": 0.3, "clearcoat_gloss": 0.8}
_ELSEWHERE = 0.5
# What is held besides the user's choice, so that there is one minimum: metallic trades off exactly against the
# colours (a gauge freedom), and an isotropic table has no preferred azimuth.
GAUGE: Mapping[str, Mapping[str, float]] = {"disney": {"metallic": 0.0, "anisotropic": 0.0, "rotation": 0.0}}


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """A model and a measurement.

    - `model`: an expression such as `"lambert+ggx"`.
    - `data`: every sample counts with its `weight` over the mean weight.

    The vector `y` of the free parameters stands in the order of lobes and declaration, in natural parameters; a colour
    has three elements.
    """

    model: str
    data: Reflectance

    @property
    def fixed(self) -> dict[str, float]:
        """What `fitter.fit` is told to hold."""
        return dict(GAUGE.get(self.model, {}))

    @functools.cached_property
    def free(self) -> tuple[tuple[str, Parameter], ...]:
        """Lobe and parameter, in the order of the vector."""
        lobes = split(build(self.model))
        return tuple((lobe, p) for lobe, part in lobes.items() for p in parameters(part) if p.name not in self.fixed)

    @functools.cached_property
    def _template(self) -> AbstractBRDF:
        lobes = split(build(self.model))
        for name, part in lobes.items():
            mine = {p.name: self.fixed[p.name] for p in parameters(part) if p.name in self.fixed}
            lobes[name] = dataclasses.replace(part, **mine)
        return specialized(combine(lobes))

    def brdf(self, y: Any) -> AbstractBRDF:
        """The model at a vector."""
        lobes, offset = split(self._template), 0
        for name, p in self.free:
            number = y[offset : offset + 3] if p.size == 3 else y[offset]
            lobes[name] = dataclasses.replace(lobes[name], **{p.name: number})
            offset += p.size
        return combine(lobes)

    def vector(self, model: AbstractBRDF) -> Array:
        """The inverse of `brdf`."""
        lobes = split(model)
        parts = [np.atleast_1d(np.asarray(getattr(lobes[name], p.name), np.float64)) for name, p in self.free]
        return np.concatenate(parts)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the vector."""
        low = [p.lower for _, p in self.free for _ in range(p.size)]
        high = [p.upper for _, p in self.free for _ in range(p.size)]
        return np.array(low, np.float64), np.array(high, np.float64)

    @property
    def start(self) -> Array:
        """The vector at which every peer starts."""
        found = []
        for name, p in self.free:
            known = _START | (_SECOND if name.endswith("_2") else {}) | _DISNEY
            found += [known.get(p.name, _ELSEWHERE)] * p.size
        return np.array(found)

    def start_described(self) -> str:
        """The start for reading; the elements of a colour are alike."""
        parts, offset = [], 0
        for lobe, p in self.free:
            parts.append(f"{lobe}.{p.name} {self.start[offset]:g}")
            offset += p.size
        return ", ".join(parts)

    def inside(self, y: Array) -> bool:
        """Whether a vector keeps the declared bounds, to rounding."""
        low, high = self.bounds
        return bool(np.all((y >= low - 1e-9) & (y <= high + 1e-9)))

    @functools.cached_property
    def samples(self) -> tuple[jax.Array, ...]:
        """`wi`, `wo` and target, each (n, 3), which Optimistix is faster with than with (3, n); and the square roots of
        the weights, (n, 1), unless all are alike."""
        arrays = [self.data.wi, self.data.wo, np.log1p(self.data.value * self.data.wi[:, 2:3])]
        if np.ptp(self.data.weight) > 0:
            arrays.append(np.sqrt(self.data.weight / self.data.weight.mean())[:, None])
        return tuple(map(jnp.asarray, arrays))

    def residual(self, y: Any, samples: tuple[jax.Array, ...]) -> jax.Array:
        """(3 n,): the differences whose squares are summed."""
        wi, wo, target, *root = samples
        apart = jnp.log1p(jax.vmap(self.brdf(y))(wi, wo) * wi[:, 2:3]) - target
        return (apart * root[0] if root else apart).ravel()

    @functools.cached_property
    def compiled(self) -> tuple[Callable[[Any], jax.Array], Callable[[Any], jax.Array]]:
        """`y` to the residual, (3 n,), and to the transposed Jacobian, (k, 3 n), in forward mode."""
        residual = jax.jit(self.residual)

        @jax.jit
        def rows(y: jax.Array, samples: tuple[jax.Array, ...]) -> jax.Array:
            push = lambda tangent: jax.jvp(lambda z: self.residual(z, samples), (y,), (tangent,))[1]  # noqa: E731
            return jax.vmap(push)(jnp.eye(len(y)))

        return lambda y: residual(jnp.asarray(y), self.samples), lambda y: rows(jnp.asarray(y), self.samples)

    def cost(self, y: Array) -> float:
        """Half the sum of squares, by which every contestant is judged, ours included."""
        return float(_half_square(self.compiled[0](y)))


@jax.jit
def _half_square(residual: jax.Array) -> jax.Array:
    return 0.5 * jnp.sum(residual * residual)

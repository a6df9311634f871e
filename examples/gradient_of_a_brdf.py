"""Differentiates a model by its parameters and by a direction: a model is a JAX pytree.

python examples/gradient_of_a_brdf.py
"""

import jax
import jax.numpy as jnp

import brdf


def luminance(model: brdf.AbstractBRDF, wi: jax.Array, wo: jax.Array) -> jax.Array:
    return jnp.dot(model(wi, wo), jnp.array([0.2126, 0.7152, 0.0722]))


def main() -> None:
    model = brdf.MODELS["ggx"](f0=[0.9, 0.7, 0.4], alpha=0.3)
    wi, wo = jnp.array([0.6, 0.0, 0.8]), jnp.array([-0.5, 0.1, 0.8602325])
    value, (by_model, by_wi) = jax.value_and_grad(luminance, argnums=(0, 1))(model, wi, wo)
    print(f"luminance of f    {value:.6f} 1/sr")
    print(f"by alpha          {by_model.alpha:.6f}")
    print(f"by f0             {by_model.f0}")
    print(f"by wi             {by_wi}")


if __name__ == "__main__":
    main()

"""Masking and shadowing, as visibility `V = G / (4 cos_i cos_o)`, which stays finite where G and a cosine vanish.

- Smith 1967, "Geometrical shadowing of a random rough surface".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".

The twin of this file is `shaders/glsl/masking.glsl`.
"""

from __future__ import annotations

from .frame import Geometry, Scalar


def v_smith(g: Geometry, cos_lambda_i: Scalar, cos_lambda_o: Scalar) -> Scalar:
    """Smith visibility with height correlation (Heitz 2014, eq. 99); `cos_lambda` from `brdf.distributions`."""
    return 0.25 / (g.cos_i * g.cos_o + g.cos_o * cos_lambda_i + g.cos_i * cos_lambda_o)


def v_smith_separable(g: Geometry, cos_lambda_i: Scalar, cos_lambda_o: Scalar) -> Scalar:
    """Smith visibility of independent masking and shadowing (Heitz 2014, eq. 98)."""
    return 0.25 / ((g.cos_i + cos_lambda_i) * (g.cos_o + cos_lambda_o))


VISIBILITY = {"smith": v_smith, "smith_separable": v_smith_separable}

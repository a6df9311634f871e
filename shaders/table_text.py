"""The GLSL twin of a Chebyshev table: a function of straight-line code, no array to index.

For a table of x and y, whose rows are sums over y:

    float NAME(float x, float y) {
        float s = 2.0 * x - 1.0, t = 2.0 * y - 1.0;
        float row_0 = ..., row_1 = ...;     // Clenshaw in t
        return ...;                         // Clenshaw in s
    }
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def table_text(name: str, coefficients: NDArray[np.float64] | None) -> str:
    """A GLSL function `float NAME(float x)` or `float NAME(float x, float y)`; for None, an unused one of each kind.

    **Arguments:** `coefficients`: as in `brdf.chebyshev.Chebyshev`.
    """
    if coefficients is None:
        return f"float {name}(float x) {{ return 0.0; }}\nfloat {name}(float x, float y) {{ return 0.0; }}"
    if coefficients.ndim == 1:
        lines = [f"float {name}(float x) {{", "    float s = 2.0 * x - 1.0;"]
        terms = [_literal(value) for value in coefficients]
    else:
        lines = [f"float {name}(float x, float y) {{", "    float s = 2.0 * x - 1.0;", "    float t = 2.0 * y - 1.0;"]
        for index, row in enumerate(coefficients):
            lines += _clenshaw(f"row_{index}", [_literal(value) for value in row], "t")
        terms = [f"row_{index}" for index in range(len(coefficients))]
    return "\n".join([*lines, *_clenshaw("total", terms, "s"), "    return total;", "}"])


def _literal(value: float) -> str:
    return f"{value:.9e}"


def _clenshaw(name: str, terms: list[str], variable: str) -> list[str]:
    """Lines that define `name` as the sum of `terms` times the Chebyshev polynomials of a variable."""
    lines = [f"    float {name}_{len(terms)} = 0.0;", f"    float {name}_{len(terms) + 1} = 0.0;"]
    for index in range(len(terms) - 1, 0, -1):
        after, later = f"{name}_{index + 1}", f"{name}_{index + 2}"
        lines.append(f"    float {name}_{index} = 2.0 * {variable} * {after} - {later} + {terms[index]};")
    return [*lines, f"    float {name} = {variable} * {name}_1 - {name}_2 + {terms[0]};"]

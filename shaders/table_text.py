"""The GLSL twin of a Chebyshev table: a function of straight-line code, no array to index.

For a table of x and y, whose rows are sums over y:

    float NAME(float x, float y) {
        float s = 2.0 * x - 1.0, t = 2.0 * y - 1.0;
        float row_0 = ..., row_1 = ...;     // Clenshaw in t
        return ...;                         // Clenshaw in s
    }
"""

from __future__ import annotations

from brdf.chebyshev import Chebyshev


def table_text(name: str, table: Chebyshev | None) -> str:
    """A GLSL function `float NAME(float x)` or `float NAME(float x, float y)`; for None, an unused one of each kind."""
    if table is None:
        return f"float {name}(float x) {{ return 0.0; }}\nfloat {name}(float x, float y) {{ return 0.0; }}"
    rows = table.coefficients
    if rows.ndim == 1:
        lines = [f"float {name}(float x) {{", "    float s = 2.0 * x - 1.0;"]
        terms = [_literal(value) for value in rows]
    else:
        lines = [f"float {name}(float x, float y) {{", "    float s = 2.0 * x - 1.0;", "    float t = 2.0 * y - 1.0;"]
        for index, row in enumerate(rows):
            lines += _clenshaw(f"row_{index}", [_literal(value) for value in row], "t")
        terms = [f"row_{index}" for index in range(len(rows))]
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

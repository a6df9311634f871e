"""The stress test of a model: does a number anywhere break, and how far is it from the exact one?

- `points`: which static choices, parameters and directions are tried.
- `sweep`: counts NaN, Inf and negative values over millions of them.
- `exact`: a model's own formula in 50-digit arithmetic.
- `accuracy`: the error against it, and how much of it the mathematics itself explains.
- `run`, `report`: one model after the other, and what is printed.
"""

"""The endless sequence of points in the square, for the host; its twin, `glsl/sequence.glsl`, says whose it is."""

from __future__ import annotations

_BITS = 32
_MASK = (1 << _BITS) - 1


def sequence_point(index: int, seed: tuple[int, int]) -> tuple[float, float]:
    """Point `index` in [0, 1)^2, scrambled by two seeds below 2^32."""
    x, y = (_reversed(_permuted_upwards(v, s)) for v, s in zip((index, _sobol_reversed(index)), seed, strict=True))
    return x / 2**_BITS, y / 2**_BITS


def shuffled_index(index: int, seed: int) -> int:
    """Another order of a sequence's points, in which the first 2^m are an aligned run of 2^m (Burley 2020, section 5).

    Points of two sequences that are both taken by `index` share its bits, so that each half of one square would be seen
    with its own half of the other's, however many are drawn. One of them has to be taken in another order.
    """
    return _reversed(_permuted_upwards(_reversed(index), seed))


def _permuted_upwards(v: int, seed: int) -> int:
    v = (v + seed) & _MASK
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        v ^= (v * factor) & _MASK
    return v


def _sobol_reversed(index: int) -> int:
    index ^= index >> 16
    index ^= (index >> 8) & 0x00FF00FF
    index ^= (index >> 4) & 0x0F0F0F0F
    index ^= (index >> 2) & 0x33333333
    return index ^ ((index >> 1) & 0x55555555)


def _reversed(v: int) -> int:
    return int(f"{v:0{_BITS}b}"[::-1], 2)

"""Random numbers that are a function of a seed and an index: SplitMix64.

Source: Guy Steele, Doug Lea, Christine Flood, "Fast splittable pseudorandom number generators",
    OOPSLA 2014.
"""

from __future__ import annotations

_MASK = 2**64 - 1


def random_draw(seed: int, index: int) -> float:
    """Return draw number ``index``, from 0, of the stream of a seed: the top 53 bits, in [0, 1)."""
    z = (seed + (index + 1) * 0x9E3779B97F4A7C15) & _MASK
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & _MASK
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB & _MASK
    z = z ^ (z >> 31)
    return float(z >> 11) * 2.0**-53

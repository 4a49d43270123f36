"""The only source of randomness: a counter-based SplitMix64 stream, the same on every machine.

NumPy promises stable raw bit streams but not stable ``Generator`` methods, so worlds draw from this
small generator instead. Every method below fixes how bits become numbers; changing one changes
worlds.

Source: Guy L. Steele Jr., Doug Lea, Christine H. Flood, "Fast Splittable Pseudorandom Number
Generators", OOPSLA 2014, with the constants of Vigna's public SplitMix64.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np

from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Floats, Words

__all__ = ["GAMMA", "RandomStream", "Seed", "mix64", "seed_of"]

T = TypeVar("T")

Seed: TypeAlias = "int | np.integer[Any] | np.random.Generator"
"""Anything that can seed randomness, wherever a seed is requested."""

# 2**64 / golden ratio, odd.
GAMMA = 0x9E3779B97F4A7C15


def mix64(z: int) -> int:
    """Return SplitMix64's finaliser of a word: a bijection that spreads every bit."""
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK64
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK64
    return z ^ (z >> 31)


def seed_of(seed: Seed) -> int:
    """Convert a seed to a number of 64 bits.

    Args:
        seed: An integer, Python's or NumPy's, of which the low 64 bits count; or a NumPy generator,
            which is advanced: its bit generator's next two draws of 32 bits are the low and the
            high half. NumPy guarantees those bits, so a generator's state gives the same seed on
            every machine.

    Raises:
        InvalidParameter: If it is something else.
    """
    if isinstance(seed, np.random.Generator):
        low, high = (int(draw) & 0xFFFFFFFF for draw in seed.bit_generator.random_raw(2))
        return high << 32 | low
    if isinstance(seed, bool | np.bool_) or not isinstance(seed, int | np.integer):
        raise InvalidParameter(
            "wrong-type",
            "seed={seed!r} is a {kind}",
            "use a whole number, or a NumPy generator: numpy.random.default_rng(7)",
            seed=seed,
            kind=type(seed).__name__,
        )
    return int(seed) & MASK64


class RandomStream:
    """A stream of random numbers that depends only on its seed.

    Args:
        seed: Any integer; its low 64 bits count.
    """

    __slots__ = ("_state",)

    def __init__(self, seed: int) -> None:
        self._state = seed & MASK64

    def child(self, *labels: int | str) -> RandomStream:
        """Return an independent stream for a named part; its draws never shift another part's.

        The parent's own sequence is not advanced.
        """
        state = self._state
        for label in labels:
            number = label if isinstance(label, int) else _fnv1a(label)
            state = mix64(mix64((state + GAMMA) & MASK64) ^ (number & MASK64))
        return RandomStream(state)

    def next64(self) -> int:
        """Return the next 64 random bits."""
        self._state = (self._state + GAMMA) & MASK64
        return mix64(self._state)

    def random(self) -> float:
        """Return a float in [0, 1): the top 53 bits."""
        return (self.next64() >> 11) * 2.0**-53

    def below(self, bound: int) -> int:
        """Return an integer in [0, bound), without bias.

        Source: Daniel Lemire, "Fast Random Integer Generation in an Interval", 2019.
        """
        if bound < 1:
            raise ValueError(f"bound={bound}: must be at least 1")
        threshold = ((1 << 64) - bound) % bound
        while True:
            product = self.next64() * bound
            if (product & MASK64) >= threshold:
                return product >> 64

    def between(self, low: int, high: int) -> int:
        """Return an integer in [low, high], including both ends."""
        return low + self.below(high - low + 1)

    def uniform(self, low: float, high: float) -> float:
        """Return a float in [low, high)."""
        return low + (high - low) * self.random()

    def choice(self, items: Sequence[T]) -> T:
        """Return one of the items."""
        return items[self.below(len(items))]

    def shuffle(self, items: MutableSequence[T]) -> None:
        """Put the items in random order, in place (Fisher-Yates)."""
        for last in range(len(items) - 1, 0, -1):
            other = self.below(last + 1)
            items[last], items[other] = items[other], items[last]

    def bits(self, count: int) -> Words:
        """Return the next ``count`` outputs of :meth:`next64` as a (count,) uint64 array."""
        with np.errstate(over="ignore"):
            steps = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(GAMMA)
            z = steps + np.uint64(self._state)
            z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            z ^= z >> np.uint64(31)
        self._state = (self._state + count * GAMMA) & MASK64
        return z

    def floats(self, count: int) -> Floats:
        """Return the next ``count`` outputs of :meth:`random` as a (count,) float64 array."""
        return (self.bits(count) >> np.uint64(11)).astype(np.float64) * 2.0**-53


def _fnv1a(text: str) -> int:
    value = 0xCBF29CE484222325
    for byte in text.encode():
        value = ((value ^ byte) * 0x100000001B3) & MASK64
    return value

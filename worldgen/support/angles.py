"""Sine and cosine of whole degrees in whole numbers: the same on every machine."""

from __future__ import annotations

import functools

__all__ = ["SCALE", "direction"]

SCALE = 1 << 20  # a sine of 1
_QUARTER = 90  # degrees
_PI = 3141592653589793238462643383279  # times 10**30
_DIGITS = 10**30


def _sine(degrees: int) -> int:
    """Return the sine of 0 to 90 degrees, times ``SCALE``, rounded; from its series in integers."""
    x = _PI * degrees // 180
    term = x
    total = 0
    order = 1
    while term:
        total += term
        term = -term * x // _DIGITS * x // _DIGITS // ((order + 1) * (order + 2))
        term = 0 if term == -1 else term  # what floor division leaves of a vanishing negative term
        order += 2
    return (2 * total * SCALE + _DIGITS) // (2 * _DIGITS)


@functools.cache
def direction(degrees: int) -> tuple[int, int]:
    """Return the cosine and sine of any whole angle, times ``SCALE``.

    Exactly symmetric under quarter turns.
    """
    quarters, rest = divmod(degrees % (4 * _QUARTER), _QUARTER)
    cos = _sine(_QUARTER - rest)
    sin = _sine(rest)
    for _ in range(quarters):
        cos, sin = -sin, cos
    return cos, sin

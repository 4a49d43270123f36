"""Sine and cosine of whole degrees in integers: the same on every machine."""

from __future__ import annotations

import functools

# The sine of 90 degrees.
SCALE = 1 << 20
# In degrees.
_QUARTER = 90
# Pi times 10**30.
_PI = 3141592653589793238462643383279
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
        # Floor division leaves this remainder of a vanishing negative term.
        term = 0 if term == -1 else term
        order += 2
    return (2 * total * SCALE + _DIGITS) // (2 * _DIGITS)


@functools.cache
def direction(degrees: int) -> tuple[int, int]:
    """Return the cosine and sine of any whole angle, times ``SCALE``.

    It is exactly symmetric under quarter turns.
    """
    quarters, rest = divmod(degrees % (4 * _QUARTER), _QUARTER)
    cos = _sine(_QUARTER - rest)
    sin = _sine(rest)
    for _ in range(quarters):
        cos, sin = -sin, cos
    return cos, sin

"""Convert angles to and from degrees, as files store them, without losing a bit of the radians."""

from __future__ import annotations

from fractions import Fraction

from worldgen.interop.format import decimal_text

__all__ = ["degrees_text", "radians"]

_PI = Fraction(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798"
)
# Number of decimals; the smallest float, 5e-324 rad, needs fewer.
_MOST_PLACES = 400


def radians(degrees: Fraction) -> float:
    """Convert degrees to an angle in rad, correctly rounded."""
    return float(degrees * _PI / 180)


def degrees_text(angle: float) -> str:
    """Return the shortest decimal of degrees that :func:`radians` converts to the same angle.

    Args:
        angle: Angle, rad.
    """
    whole = Fraction(angle) * 180 / _PI
    tried = (Fraction(round(whole * 10**places), 10**places) for places in range(_MOST_PLACES))
    return next(decimal_text(value) for value in tried if radians(value) == angle)

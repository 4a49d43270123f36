"""Angles in degrees, as files have them, without losing a bit of the radians."""

from __future__ import annotations

from fractions import Fraction

from worldgen.interop.format import decimal_text

__all__ = ["degrees_text", "radians"]

_PI = Fraction(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798"
)
_MOST_PLACES = 400  # decimals; the smallest angle that there is, 5e-324 rad, needs fewer


def radians(degrees: Fraction) -> float:
    """Return an angle in rad, correctly rounded."""
    return float(degrees * _PI / 180)


def degrees_text(angle: float) -> str:
    """Return the shortest decimal of degrees that :func:`radians` makes the same angle of.

    Args:
        angle: rad.
    """
    whole = Fraction(angle) * 180 / _PI
    tried = (Fraction(round(whole * 10**places), 10**places) for places in range(_MOST_PLACES))
    return next(decimal_text(value) for value in tried if radians(value) == angle)

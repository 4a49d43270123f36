"""Sine, cosine and arc tangent with fdlibm's bits, using only ``+ - * /``.

The same on every machine. The thesis's simulator moves two or three pixels a tick depending on the
last bit of a cosine, and C libraries differ in that bit. These follow Sun's algorithms and
constants step by step, so they return what Java's ``StrictMath`` returns.

Source: "Freely Distributable LIBM" (fdlibm 5.3), Sun Microsystems, 1993: ``k_sin``, ``k_cos``,
``e_rem_pio2``, ``s_sin``, ``s_cos``, ``s_atan``. Polynomials: Remez; reduction: Cody and Waite,
"Software Manual for the Elementary Functions" (1980), in two or three pieces of pi/2.
"""

from __future__ import annotations

import math

import numpy as np

# Largest |x| that sin and cos reduce, 2**19 * pi/2; beyond it they return nan. Headings stay below
# 2 pi.
REDUCTION_LIMIT = 823549.6645826427

_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10

_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11

_TWO_OVER_PI = 6.36619772367581382433e-01
# pi/2 in pieces of 33 bits; each tail is the remainder after the pieces before it.
_PIO2_1, _PIO2_1_TAIL = 1.57079632673412561417e00, 6.07710050650619224932e-11
_PIO2_2, _PIO2_2_TAIL = 6.07710050630396597660e-11, 2.02226624879595063154e-21
_PIO2_3, _PIO2_3_TAIL = 2.02226624871116645580e-21, 8.47842766036889956997e-32

_A0, _A1, _A2 = 3.33333333333329318027e-01, -1.99999999998764832476e-01, 1.42857142725034663711e-01
_A3, _A4, _A5 = -1.11111104054623557880e-01, 9.09088713343650656196e-02, -7.69187620504482999495e-02
_A6, _A7, _A8 = 6.66107313738753120669e-02, -5.83357013379057348645e-02, 4.97687799461593236017e-02
_A9, _A10 = -3.65315727442169155270e-02, 1.62858201153657823623e-02

# atan(1/2), atan(1), atan(3/2), atan(infinity): value and rounding error.
_ATAN_HALF, _ATAN_HALF_TAIL = 4.63647609000806093515e-01, 2.26987774529616870924e-17
_ATAN_ONE, _ATAN_ONE_TAIL = 7.85398163397448278999e-01, 3.06161699786838301793e-17
_ATAN_THREE_HALVES, _ATAN_THREE_HALVES_TAIL = 9.82793723247329054082e-01, 1.39033110312309984516e-17
_ATAN_INF, _ATAN_INF_TAIL = 1.57079632679489655800e00, 6.12323399573676603587e-17

_QUARTER_PI_END = 0.7853984832763672  # first double whose high word is above that of pi/4
_TINY = 2.0**-27


def float_bits(value: float) -> int:
    """The IEEE-754 bits of a double as a signed 64-bit integer."""
    return np.float64(value).view(np.int64)  # type: ignore[return-value]


def _high_word(value: float) -> int:
    return (float_bits(value) >> 32) & 0x7FFFFFFF


def _sin_reduced(x: float, tail: float, has_tail: bool) -> float:
    """Sine of ``x + tail``, for x between about -pi/4 and pi/4."""
    if -_TINY < x < _TINY:
        return x
    z = x * x
    v = z * x
    r = _S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))
    if not has_tail:
        return x + v * (_S1 + z * r)
    return x - ((z * (0.5 * tail - v * r) - tail) - v * _S1)


def _cos_reduced(x: float, tail: float) -> float:
    """Cosine of ``x + tail``, for x between about -pi/4 and pi/4."""
    if -_TINY < x < _TINY:
        return 1.0
    z = x * x
    r = z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))
    high = _high_word(x)
    if high < 0x3FD33333:  # |x| < 0.3
        return 1.0 - (0.5 * z - (z * r - x * tail))
    quarter = 0.28125
    if high <= 0x3FE90000:  # about a quarter of |x|, low word cleared so that 1 - quarter is exact
        quarter = np.int64((high - 0x00200000) << 32).view(np.float64)
    half = 0.5 * z - quarter
    return (1.0 - quarter) - (half - (z * r - x * tail))


def _reduce_positive(x: float) -> tuple[int, float, float]:
    """Quadrant and ``x - quadrant * pi/2`` in two parts, for x in (pi/4, REDUCTION_LIMIT].

    fdlibm uses a table to decide whether one piece of pi/2 is enough: the high words of k * pi/2.
    """
    high = _high_word(x)
    if high < 0x4002D97C:  # below 3 pi/4
        z = x - _PIO2_1
        tail = _PIO2_1_TAIL
        if high == 0x3FF921FB:  # near pi/2
            z -= _PIO2_2
            tail = _PIO2_2_TAIL
        y = z - tail
        return 1, y, (z - y) - tail
    quadrant = int(x * _TWO_OVER_PI + 0.5)
    fn = float(quadrant)
    r = x - fn * _PIO2_1
    w = fn * _PIO2_1_TAIL
    y = r - w
    if quadrant < 32 and high != _high_word(fn * _ATAN_INF):
        return quadrant, y, (r - y) - w
    exponent = high >> 20
    if exponent - (_high_word(y) >> 20) > 16:
        t = r
        w = fn * _PIO2_2
        r = t - w
        w = fn * _PIO2_2_TAIL - ((t - r) - w)
        y = r - w
        if exponent - (_high_word(y) >> 20) > 49:
            t = r
            w = fn * _PIO2_3
            r = t - w
            w = fn * _PIO2_3_TAIL - ((t - r) - w)
            y = r - w
    return quadrant, y, (r - y) - w


def sin(x: float) -> float:
    """Sine of ``x`` rad with fdlibm's bits.

    Nan if ``abs(x)`` exceeds ``REDUCTION_LIMIT``, and for nan.
    """
    if -_QUARTER_PI_END < x < _QUARTER_PI_END:
        return _sin_reduced(x, 0.0, False)
    if not -REDUCTION_LIMIT <= x <= REDUCTION_LIMIT:
        return math.nan
    quadrant, y, tail = _reduce_positive(abs(x))
    value = _cos_reduced(y, tail) if quadrant & 1 else _sin_reduced(y, tail, True)
    return -value if (quadrant & 2 != 0) != (x < 0.0) else value


def cos(x: float) -> float:
    """Cosine of ``x`` rad with fdlibm's bits.

    Nan if ``abs(x)`` exceeds ``REDUCTION_LIMIT``, and for nan.
    """
    if -_QUARTER_PI_END < x < _QUARTER_PI_END:
        return _cos_reduced(x, 0.0)
    if not -REDUCTION_LIMIT <= x <= REDUCTION_LIMIT:
        return math.nan
    quadrant, y, tail = _reduce_positive(abs(x))
    value = _sin_reduced(y, tail, True) if quadrant & 1 else _cos_reduced(y, tail)
    return -value if (quadrant + 1) & 2 else value


def atan(x: float) -> float:
    """Arc tangent of ``x`` in rad with fdlibm's bits; keeps the sign of zero."""
    size = abs(x)
    if not size < 2.0**66:
        return x + x if math.isnan(x) else math.copysign(_ATAN_INF + _ATAN_INF_TAIL, x)
    if size < 2.0**-29:
        return x
    base, tail, t = 0.0, 0.0, x
    if size >= 2.4375:
        base, tail, t = _ATAN_INF, _ATAN_INF_TAIL, -1.0 / size
    elif size >= 1.1875:
        base, tail, t = (
            _ATAN_THREE_HALVES,
            _ATAN_THREE_HALVES_TAIL,
            (size - 1.5) / (1.0 + 1.5 * size),
        )
    elif size >= 0.6875:
        base, tail, t = _ATAN_ONE, _ATAN_ONE_TAIL, (size - 1.0) / (size + 1.0)
    elif size >= 0.4375:
        base, tail, t = _ATAN_HALF, _ATAN_HALF_TAIL, (2.0 * size - 1.0) / (2.0 + size)
    z = t * t
    w = z * z
    s1 = z * (_A0 + w * (_A2 + w * (_A4 + w * (_A6 + w * (_A8 + w * _A10)))))
    s2 = w * (_A1 + w * (_A3 + w * (_A5 + w * (_A7 + w * _A9))))
    if size < 0.4375:
        return t - t * (s1 + s2)
    value = base - ((t * (s1 + s2) - tail) - t)
    return -value if x < 0.0 else value

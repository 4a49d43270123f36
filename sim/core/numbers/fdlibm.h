// Sine, cosine and arc tangent with fdlibm's bits, from + - * / alone: the same on every machine.
//
// The thesis's simulator moves two or three pixels a tick depending on the last bit of a cosine,
// and C libraries differ in that bit. These functions follow Sun's algorithms and constants step by
// step, so they return what Java's StrictMath returns.
//
// Source: "Freely Distributable LIBM" (fdlibm 5.3), Sun Microsystems, 1993: k_sin, k_cos,
// e_rem_pio2, s_sin, s_cos, s_atan. Polynomials: Remez; reduction: Cody and Waite, "Software Manual
// for the Elementary Functions" (1980), in two or three pieces of pi/2.

#ifndef WG_FDLIBM_H
#define WG_FDLIBM_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// Largest |x| that wg_sin and wg_cos reduce, 2^19 pi/2; beyond it they return NaN. Headings stay below 2 pi.
static const double WG_REDUCTION_LIMIT = 823549.6645826427;

// pi/2, and the first double whose high word is above that of pi/4.
static const double WG_HALF_PI = 1.57079632679489655800e00;
static const double WG_QUARTER_PI_END = 0.7853984832763672;

// An angle minus a multiple of pi/2, in two parts whose sum is more precise than one double.
typedef struct WgReduced {
    int64_t quadrant;
    double high;
    double low;
} WgReduced;

// The IEEE-754 bits of a double.
static inline int64_t wg_float_bits(double value)
{
    int64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

// The upper half of these bits, without the sign.
static inline int64_t wg_high_word(double value)
{
    return (wg_float_bits(value) >> 32) & 0x7FFFFFFF;
}

// The double whose upper 32 bits are these; the lower ones are 0.
static inline double wg_from_high_word(int64_t high)
{
    int64_t bits = (int64_t)((uint64_t)high << 32);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// Sine of x + tail, for x between about -pi/4 and pi/4.
static inline double wg_sin_reduced(double x, double tail, bool has_tail)
{
    static const double s1 = -1.66666666666666324348e-01;
    static const double s2 = 8.33333333332248946124e-03;
    static const double s3 = -1.98412698298579493134e-04;
    static const double s4 = 2.75573137070700676789e-06;
    static const double s5 = -2.50507602534068634195e-08;
    static const double s6 = 1.58969099521155010221e-10;

    if (-0x1p-27 < x && x < 0x1p-27) {
        return x;
    }
    double z = x * x;
    double v = z * x;
    double r = s2 + z * (s3 + z * (s4 + z * (s5 + z * s6)));
    if (!has_tail) {
        return x + v * (s1 + z * r);
    }
    return x - ((z * (0.5 * tail - v * r) - tail) - v * s1);
}

// Cosine of x + tail, for x between about -pi/4 and pi/4.
static inline double wg_cos_reduced(double x, double tail)
{
    static const double c1 = 4.16666666666666019037e-02;
    static const double c2 = -1.38888888888741095749e-03;
    static const double c3 = 2.48015872894767294178e-05;
    static const double c4 = -2.75573143513906633035e-07;
    static const double c5 = 2.08757232129817482790e-09;
    static const double c6 = -1.13596475577881948265e-11;

    if (-0x1p-27 < x && x < 0x1p-27) {
        return 1.0;
    }
    double z = x * x;
    double r = z * (c1 + z * (c2 + z * (c3 + z * (c4 + z * (c5 + z * c6)))));
    int64_t high = wg_high_word(x);
    if (high < 0x3FD33333) {  // |x| < 0.3
        return 1.0 - (0.5 * z - (z * r - x * tail));
    }
    // About a quarter of |x|, its lower half cleared so that 1 - quarter is exact.
    double quarter = high <= 0x3FE90000 ? wg_from_high_word(high - 0x00200000) : 0.28125;
    double half = 0.5 * z - quarter;
    return (1.0 - quarter) - (half - (z * r - x * tail));
}

// Reduces x in (pi/4, WG_REDUCTION_LIMIT].
//
// fdlibm uses a table to decide if one piece of pi/2 is enough; the table is the high words of k
// pi/2.
static inline WgReduced wg_reduce_positive(double x)
{
    static const double two_over_pi = 6.36619772367581382433e-01;
    // pi/2 in pieces of 33 bits; each tail is the remainder after the pieces before it.
    static const double piece_1 = 1.57079632673412561417e00;
    static const double tail_1 = 6.07710050650619224932e-11;
    static const double piece_2 = 6.07710050630396597660e-11;
    static const double tail_2 = 2.02226624879595063154e-21;
    static const double piece_3 = 2.02226624871116645580e-21;
    static const double tail_3 = 8.47842766036889956997e-32;

    int64_t high = wg_high_word(x);
    if (high < 0x4002D97C) {  // below 3 pi/4
        double z = x - piece_1;
        double tail = tail_1;
        if (high == 0x3FF921FB) {  // near pi/2
            z -= piece_2;
            tail = tail_2;
        }
        double y = z - tail;
        return (WgReduced){1, y, (z - y) - tail};
    }
    int64_t quadrant = (int64_t)(x * two_over_pi + 0.5);
    double fn = (double)quadrant;
    double r = x - fn * piece_1;
    double w = fn * tail_1;
    double y = r - w;
    if (quadrant < 32 && high != wg_high_word(fn * WG_HALF_PI)) {
        return (WgReduced){quadrant, y, (r - y) - w};
    }

    // Use more pieces if too many leading bits have cancelled.
    int64_t exponent = high >> 20;
    if (exponent - (wg_high_word(y) >> 20) > 16) {
        double t = r;
        w = fn * piece_2;
        r = t - w;
        w = fn * tail_2 - ((t - r) - w);
        y = r - w;
        if (exponent - (wg_high_word(y) >> 20) > 49) {
            t = r;
            w = fn * piece_3;
            r = t - w;
            w = fn * tail_3 - ((t - r) - w);
            y = r - w;
        }
    }
    return (WgReduced){quadrant, y, (r - y) - w};
}

// Sine of x rad; NaN if |x| exceeds WG_REDUCTION_LIMIT, and for NaN.
static inline double wg_sin(double x)
{
    if (-WG_QUARTER_PI_END < x && x < WG_QUARTER_PI_END) {
        return wg_sin_reduced(x, 0.0, false);
    }
    if (!(-WG_REDUCTION_LIMIT <= x && x <= WG_REDUCTION_LIMIT)) {
        return (double)NAN;
    }
    WgReduced part = wg_reduce_positive(fabs(x));
    double value =
        (part.quadrant & 1) != 0 ? wg_cos_reduced(part.high, part.low) : wg_sin_reduced(part.high, part.low, true);
    bool negated = ((part.quadrant & 2) != 0) != (x < 0.0);
    return negated ? -value : value;
}

// Cosine of x rad; NaN if |x| exceeds WG_REDUCTION_LIMIT, and for NaN.
static inline double wg_cos(double x)
{
    if (-WG_QUARTER_PI_END < x && x < WG_QUARTER_PI_END) {
        return wg_cos_reduced(x, 0.0);
    }
    if (!(-WG_REDUCTION_LIMIT <= x && x <= WG_REDUCTION_LIMIT)) {
        return (double)NAN;
    }
    WgReduced part = wg_reduce_positive(fabs(x));
    double value =
        (part.quadrant & 1) != 0 ? wg_sin_reduced(part.high, part.low, true) : wg_cos_reduced(part.high, part.low);
    return ((part.quadrant + 1) & 2) != 0 ? -value : value;
}

// Arc tangent of x, rad; keeps the sign of zero.
static inline double wg_atan(double x)
{
    // atan(1/2), atan(1), atan(3/2), atan(infinity), each as a value and its rounding error.
    static const double half = 4.63647609000806093515e-01;
    static const double half_tail = 2.26987774529616870924e-17;
    static const double one = 7.85398163397448278999e-01;
    static const double one_tail = 3.06161699786838301793e-17;
    static const double three_halves = 9.82793723247329054082e-01;
    static const double three_halves_tail = 1.39033110312309984516e-17;
    static const double infinite = 1.57079632679489655800e00;
    static const double infinite_tail = 6.12323399573676603587e-17;

    static const double a0 = 3.33333333333329318027e-01;
    static const double a1 = -1.99999999998764832476e-01;
    static const double a2 = 1.42857142725034663711e-01;
    static const double a3 = -1.11111104054623557880e-01;
    static const double a4 = 9.09088713343650656196e-02;
    static const double a5 = -7.69187620504482999495e-02;
    static const double a6 = 6.66107313738753120669e-02;
    static const double a7 = -5.83357013379057348645e-02;
    static const double a8 = 4.97687799461593236017e-02;
    static const double a9 = -3.65315727442169155270e-02;
    static const double a10 = 1.62858201153657823623e-02;

    double size = fabs(x);
    if (!(size < 0x1p66)) {
        return isnan(x) ? x + x : copysign(infinite + infinite_tail, x);
    }
    if (size < 0x1p-29) {
        return x;
    }

    // A multiple of about atan(1/2) is subtracted, which leaves an argument below 7/16.
    double base = 0.0;
    double tail = 0.0;
    double t = x;
    if (size >= 2.4375) {
        base = infinite;
        tail = infinite_tail;
        t = -1.0 / size;
    } else if (size >= 1.1875) {
        base = three_halves;
        tail = three_halves_tail;
        t = (size - 1.5) / (1.0 + 1.5 * size);
    } else if (size >= 0.6875) {
        base = one;
        tail = one_tail;
        t = (size - 1.0) / (size + 1.0);
    } else if (size >= 0.4375) {
        base = half;
        tail = half_tail;
        t = (2.0 * size - 1.0) / (2.0 + size);
    }
    double z = t * t;
    double w = z * z;
    double s1 = z * (a0 + w * (a2 + w * (a4 + w * (a6 + w * (a8 + w * a10)))));
    double s2 = w * (a1 + w * (a3 + w * (a5 + w * (a7 + w * a9))));
    if (size < 0.4375) {
        return t - t * (s1 + s2);
    }
    double value = base - ((t * (s1 + s2) - tail) - t);
    return x < 0.0 ? -value : value;
}

#endif

// Arithmetic with Python's semantics: division and remainder round down, and so on.

#ifndef WG_NUMBERS_H
#define WG_NUMBERS_H

#include <math.h>
#include <stdint.h>

// The quotient, rounded down; the divisor is positive.
static inline int64_t wg_floor_div(int64_t value, int64_t divisor)
{
    int64_t quotient = value / divisor;
    return value % divisor < 0 ? quotient - 1 : quotient;
}

// The remainder of that division, in [0, divisor).
static inline int64_t wg_floor_mod(int64_t value, int64_t divisor)
{
    int64_t rest = value % divisor;
    return rest < 0 ? rest + divisor : rest;
}

static inline int64_t wg_abs(int64_t value)
{
    return value < 0 ? -value : value;
}

static inline int64_t wg_least(int64_t a, int64_t b)
{
    return b < a ? b : a;
}

static inline int64_t wg_most(int64_t a, int64_t b)
{
    return b > a ? b : a;
}

// Like Python's min and max: the first wins a tie, and a NaN only wins if it comes first.
static inline double wg_lower(double a, double b)
{
    return b < a ? b : a;
}

static inline double wg_higher(double a, double b)
{
    return b > a ? b : a;
}

// The next integers below and above, for values within the range of an int64. Unlike the library's
// functions they are not calls on processors that may lack the instruction.
static inline int64_t wg_floor(double value)
{
    int64_t whole = (int64_t)value;
    return whole - (value < (double)whole);
}

static inline int64_t wg_ceil(double value)
{
    int64_t whole = (int64_t)value;
    return whole + (value > (double)whole);
}

// The nearest integer, halves away from zero, so that rounding has every mirror symmetry. For a
// positive sum, adding half and truncating equals rounding down, with half the instructions.
static inline int64_t wg_round_away(double value)
{
    return (int64_t)(value + copysign(0.5, value));
}

#endif

// Integers beyond 128 bits, with just the operations that comparing roots needs.

#ifndef WG_WIDE_H
#define WG_WIDE_H

#include <stdbool.h>
#include <stdint.h>

typedef __int128 WgInt128;
typedef unsigned __int128 WgUint128;

enum { WG_LIMBS = 6 };

// A number below 2^384, the lowest 64 bits first.
typedef struct WgWide {
    uint64_t limbs[WG_LIMBS];
} WgWide;

static inline WgWide wg_wide_of(WgUint128 value)
{
    return (WgWide){{(uint64_t)value, (uint64_t)(value >> 64)}};
}

// The product; it must be below 2^384.
static inline WgWide wg_wide_times(const WgWide *wide, WgUint128 factor)
{
    WgWide product = {{0}};
    const uint64_t parts[2] = {(uint64_t)factor, (uint64_t)(factor >> 64)};
    for (int part = 0; part < 2; part++) {
        uint64_t carried = 0;
        for (int i = 0; i + part < WG_LIMBS; i++) {
            WgUint128 sum = (WgUint128)wide->limbs[i] * parts[part] + product.limbs[i + part] + carried;
            product.limbs[i + part] = (uint64_t)sum;
            carried = (uint64_t)(sum >> 64);
        }
    }
    return product;
}

// Returns a negative number if a is below b, a positive one if it is above.
static inline int wg_wide_compare(const WgWide *a, const WgWide *b)
{
    for (int i = WG_LIMBS - 1; i >= 0; i--) {
        if (a->limbs[i] != b->limbs[i]) {
            return a->limbs[i] < b->limbs[i] ? -1 : 1;
        }
    }
    return 0;
}

static inline WgUint128 wg_magnitude(WgInt128 value)
{
    return value < 0 ? -(WgUint128)value : (WgUint128)value;
}

static inline int wg_sign_128(WgInt128 value)
{
    return (value > 0) - (value < 0);
}

// Returns the exact sign of whole + factor * sqrt(square);
// the absolute values of all three are below 2^127.
static inline int wg_sign_of_sum(WgInt128 whole, WgInt128 factor, WgUint128 square)
{
    int a = wg_sign_128(whole);
    int b = square > 0 ? wg_sign_128(factor) : 0;
    if (a * b >= 0) {
        return a != 0 ? a : b;
    }
    WgUint128 u = wg_magnitude(whole);
    WgUint128 v = wg_magnitude(factor);
    // Most numbers are small enough for 128 bits.
    if (u >> 63 == 0 && v >> 31 == 0 && square >> 64 == 0) {
        WgUint128 right = v * v * square;
        return u * u == right ? 0 : (u * u > right ? a : -a);
    }
    WgWide left = wg_wide_of(u);
    WgWide right = wg_wide_of(v);
    left = wg_wide_times(&left, u);
    right = wg_wide_times(&right, v);
    right = wg_wide_times(&right, square);
    return a * wg_wide_compare(&left, &right);
}

#endif

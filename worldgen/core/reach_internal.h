// What the files of the prover share among themselves. Lengths in lu are 1/1024 of a cell's side.

#ifndef REACH_INTERNAL_H
#define REACH_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "wg_reach.h"

enum { WG_UNIT = 1024 };

static inline int64_t wg_min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static inline int64_t wg_max(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static inline int64_t wg_abs(int64_t a)
{
    return a < 0 ? -a : a;
}

// Rounds down, as Python does; b is positive.
static inline int64_t wg_floor_div(int64_t a, int64_t b)
{
    int64_t quotient = a / b;
    return a % b < 0 ? quotient - 1 : quotient;
}

// The cell in which a coordinate (lu) lies.
static inline int64_t wg_cell_of(int64_t lu)
{
    return wg_floor_div(lu, WG_UNIT);
}

// Rounds a root down; the square is less than 2^62.
int64_t wg_root_floor(int64_t square);

// A piece of a path, lu.
typedef struct WgPiece {
    int64_t px;
    int64_t py;
    int64_t qx;
    int64_t qy;
} WgPiece;

// A pose to any precision, half cells.
typedef struct WgFinePose {
    int64_t x;               // rounded down
    int64_t y;               // rounded down
    const uint32_t *rest_x;  // (limbs,) what that left off, as digits to the base 2^32, the highest first
    const uint32_t *rest_y;  // (limbs,)
    int64_t limbs;
} WgFinePose;

// What a scan of a piece found.
typedef struct WgScan {
    int64_t least;      // least whole square of a distance, lu^2
    int64_t side;       // of the corner next to the line that is nearest, its distance times the length; 0 for none
    int64_t length_sq;  // squared length of the piece if side is of interest, else 0
    bool nearer;        // surely nearer than was asked
} WgScan;

// Whether the disc may sweep a piece; WG_UNSURE if only fractions can tell.
WgAnswer wg_sweep(const WgWalls *walls, WgPiece piece, const WgDisc *disc);

#endif

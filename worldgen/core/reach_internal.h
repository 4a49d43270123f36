// Shared by the files of the prover. Lengths in lu are 1/1024 of a cell's side.

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

// The cell that contains a coordinate (lu).
static inline int64_t wg_cell_of(int64_t lu)
{
    return wg_floor_div(lu, WG_UNIT);
}

// Returns true if a cell is solid; all cells outside the grid are.
static inline bool wg_is_solid(const WgWalls *walls, int64_t ix, int64_t iy)
{
    bool inside = ix >= 0 && iy >= 0 && ix < walls->width && iy < walls->height;
    return !inside || walls->solid[iy * walls->width + ix] != 0;
}

// Offsets that the eight steps add to a node's number, the four along the axes first, and offsets
// of the middles of the other four.
static inline void wg_eight_steps(int64_t stride, int64_t shifts[8], int64_t corners[8])
{
    const int64_t steps[8] = {1, -1, stride, -stride, stride + 1, -stride - 1, stride - 1, 1 - stride};
    const int64_t middles[8] = {0, 0, 0, 0, 0, -stride - 1, -1, -stride};
    for (int step = 0; step < 8; step++) {
        shifts[step] = steps[step];
        corners[step] = middles[step];
    }
}

// Returns the first entry from ``v`` on that is its own root,
// and halves the path there for later calls.
static inline int64_t wg_next_unseen(int32_t *skip, int64_t v)
{
    while (skip[v] != v) {
        skip[v] = skip[skip[v]];
        v = skip[v];
    }
    return v;
}

// Returns the square root, rounded down, of a number below 2^62.
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
    // (limbs,) the remainder, as digits to the base 2^32, the highest first
    const uint32_t *rest_x;
    const uint32_t *rest_y;  // (limbs,)
    int64_t limbs;
} WgFinePose;

// The result of a scan of a piece.
typedef struct WgScan {
    int64_t least;      // smallest integer square of a distance, lu^2
    // distance of the nearest corner next to the line, times the length; 0 for none
    int64_t side;
    int64_t length_sq;  // squared length of the piece if side is of interest, else 0
    bool nearer;        // certainly nearer than requested
} WgScan;

// Reports whether the disc may sweep a piece; WG_UNSURE if only fractions can decide.
WgAnswer wg_sweep(const WgWalls *walls, WgPiece piece, const WgDisc *disc);

#endif

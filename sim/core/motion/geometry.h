// Exact tests of a disc against square cells, on the pose lattice: those that every step needs. The
// others are in wg_parts.h.
//
// Coordinates are integers in 1/1024 of a cell, so "is this pose clear" and "is this segment clear"
// are decided in integers, without tolerance. Cells outside the grid are solid.

#ifndef WG_GEOMETRY_H
#define WG_GEOMETRY_H

#include <stdbool.h>
#include <stdint.h>

#include "numbers.h"
#include "wg_parts.h"

static inline WgGrid wg_grid(const WgArena *arena)
{
    return (WgGrid){arena->cells, arena->width, arena->height};
}

static inline WgDisc wg_disc(const WgSettings *settings)
{
    return (WgDisc){settings->clear_sq, settings->reach};
}

// Column or row of a coordinate. WG_UNIT is a power of two, and a shift rounds down.
static inline int64_t wg_cell_of(int64_t coordinate)
{
    return coordinate >> WG_UNIT_BITS;
}

static inline bool wg_is_in_grid(WgGrid grid, int64_t ix, int64_t iy)
{
    return (uint64_t)ix < (uint64_t)grid.width && (uint64_t)iy < (uint64_t)grid.height;
}

// State of a cell; outside the grid everything is solid.
static inline int wg_cell_state(WgGrid grid, int64_t ix, int64_t iy)
{
    return wg_is_in_grid(grid, ix, iy) ? grid.cells[iy * grid.width + ix] : WG_SOLID;
}

// Squared distance from a lattice point to a closed cell.
static inline int64_t wg_point_box_distance_sq(int64_t x, int64_t y, int64_t ix, int64_t iy)
{
    int64_t left = ix * WG_UNIT;
    int64_t low = iy * WG_UNIT;
    int64_t dx = wg_most(wg_most(left - x, 0), x - left - WG_UNIT);
    int64_t dy = wg_most(wg_most(low - y, 0), y - low - WG_UNIT);
    return dx * dx + dy * dy;
}

// Returns true if some point of a segment is within a distance of (x, y).
static inline bool wg_segment_point_within(WgSegment way, int64_t x, int64_t y, int64_t within_sq)
{
    int64_t cx = x - way.px;
    int64_t cy = y - way.py;
    int64_t ex = x - way.qx;
    int64_t ey = y - way.qy;
    if (cx * cx + cy * cy <= within_sq || ex * ex + ey * ey <= within_sq) {
        return true;
    }
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    int64_t length_sq = dx * dx + dy * dy;
    int64_t along = dx * cx + dy * cy;
    if (along <= 0 || along >= length_sq) {
        return false;
    }
    double across = (double)(dx * cy - dy * cx);
    return across * across <= (double)within_sq * (double)length_sq;
}

// Returns true if a point stays at least the root of `clear_sq` away from a segment whose first end
// is assumed to be that far away, decided in integers. In geometry.c.
bool wg_point_is_clear(int64_t clear_sq, WgSegment way, int64_t x, int64_t y);

// Returns true if the masks show that no cell in the box around a disc's path is taken; if not, the
// exact test is needed.
static inline bool wg_window_is_free(const WgArena *arena, int64_t reach, WgSegment way)
{
    // the lowest bit of each of the five rows
    enum { SIDE = 2 * WG_NEAR + 1, EACH_ROW = 0x108421 };

    int64_t ix = wg_cell_of(way.px);
    int64_t iy = wg_cell_of(way.py);
    if (!wg_is_in_grid(wg_grid(arena), ix, iy)) {
        return false;
    }
    int64_t left = wg_cell_of(wg_least(way.px, way.qx) - reach) - ix + WG_NEAR;
    int64_t right = wg_cell_of(wg_most(way.px, way.qx) + reach - 1) - ix + WG_NEAR;
    int64_t low = wg_cell_of(wg_least(way.py, way.qy) - reach) - iy + WG_NEAR;
    int64_t high = wg_cell_of(wg_most(way.py, way.qy) + reach - 1) - iy + WG_NEAR;
    if (left < 0 || low < 0 || right >= SIDE || high >= SIDE) {
        return false;
    }
    int64_t columns = ((INT64_C(2) << right) - 1) & ~((INT64_C(1) << left) - 1);
    int64_t rows = ((INT64_C(1) << (SIDE * (high + 1))) - 1) & ~((INT64_C(1) << (SIDE * low)) - 1);
    return (arena->near[iy * arena->width + ix] & (columns * EACH_ROW) & rows) == 0;
}

#endif

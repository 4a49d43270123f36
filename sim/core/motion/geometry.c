// Exact tests of a disc against square cells; see geometry.h.

#include "geometry.h"

#include <math.h>
#include <string.h>

// The cells with row, or column, numbers from `first` to `last`; the ring around the grid belongs
// to them.
typedef struct Span {
    int64_t first;
    int64_t last;
} Span;

// The cells that coordinates from `low` to `high` touch.
static Span span(int64_t low, int64_t high, int64_t cells)
{
    return (Span){wg_most(wg_cell_of(low), -1), wg_least(wg_cell_of(high), cells)};
}

bool wg_disc_is_clear(WgGrid grid, int state, WgDisc disc, int64_t x, int64_t y)
{
    if (x < 0 || y < 0 || x > grid.width * WG_UNIT || y > grid.height * WG_UNIT) {
        return state != WG_SOLID;
    }
    Span rows = span(y - disc.reach, y + disc.reach, grid.height);
    Span columns = span(x - disc.reach, x + disc.reach, grid.width);
    for (int64_t iy = rows.first; iy <= rows.last; iy++) {
        for (int64_t ix = columns.first; ix <= columns.last; ix++) {
            if (wg_cell_state(grid, ix, iy) == state && wg_point_box_distance_sq(x, y, ix, iy) < disc.clear_sq) {
                return false;
            }
        }
    }
    return true;
}

// Returns true if a corner is clear of the inside of a segment, from its dot and cross products
// with it.
static bool corner_is_clear(int64_t clear_sq, int64_t along, int64_t across, int64_t length_sq)
{
    // Above this a squared cross product does not fit in 63 bits; calls closer than 1e-12 then
    // count as "not clear".
    const int64_t most_exact = 3000000000;

    if (along <= 0 || along >= length_sq) {
        return true;  // an end is nearest, and ends are tested as poses
    }
    double needed = (double)clear_sq * (double)length_sq;
    double have = (double)across * (double)across;
    if (have > needed * (1.0 + 1e-12)) {
        return true;
    }
    if (have < needed * (1.0 - 1e-12) || wg_abs(across) > most_exact) {
        return false;
    }
    return across * across >= clear_sq * length_sq;
}

bool wg_point_is_clear(int64_t clear_sq, WgSegment way, int64_t x, int64_t y)
{
    int64_t ex = x - way.qx;
    int64_t ey = y - way.qy;
    if (ex * ex + ey * ey < clear_sq) {
        return false;
    }
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    int64_t cx = x - way.px;
    int64_t cy = y - way.py;
    return corner_is_clear(clear_sq, dx * cx + dy * cy, dx * cy - dy * cx, dx * dx + dy * dy);
}

// Returns true if the disc is clear of one closed cell along a segment whose first end is assumed
// to be clear.
//
// The nearest points of a segment and a box that do not cross include an end of the segment or a
// corner of the box, so these and the crossing itself decide.
static bool segment_box_is_clear(int64_t clear_sq, WgSegment way, int64_t ix, int64_t iy)
{
    if (wg_point_box_distance_sq(way.qx, way.qy, ix, iy) < clear_sq) {
        return false;
    }
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    int64_t length_sq = dx * dx + dy * dy;
    int64_t left = ix * WG_UNIT - way.px;
    int64_t low = iy * WG_UNIT - way.py;
    bool above = false;
    bool below = false;
    for (int corner = 0; corner < 4; corner++) {
        int64_t cx = left + (corner & 1) * WG_UNIT;
        int64_t cy = low + (corner >> 1) * WG_UNIT;
        int64_t across = dx * cy - dy * cx;
        if (!corner_is_clear(clear_sq, dx * cx + dy * cy, across, length_sq)) {
            return false;
        }
        above = above || across > 0;
        below = below || across < 0;
    }
    bool apart = wg_most(0, dx) < left || wg_least(0, dx) > left + WG_UNIT || wg_most(0, dy) < low ||
                 wg_least(0, dy) > low + WG_UNIT;
    return apart || !(above && below);
}

WgFound wg_first_not_clear(WgGrid grid, int state, WgDisc disc, WgSegment way)
{
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    int64_t left = wg_least(way.px, way.qx);
    int64_t right = wg_most(way.px, way.qx);
    Span rows = span(wg_least(way.py, way.qy) - disc.reach, wg_most(way.py, way.qy) + disc.reach, grid.height);
    bool is_long = wg_abs(dx) > 2 * WG_UNIT && wg_abs(dy) > 2 * WG_UNIT;
    for (int64_t iy = rows.first; iy <= rows.last; iy++) {
        // Only the part near this row of a long slanted move counts.
        if (is_long) {
            double a = (double)(iy * WG_UNIT - disc.reach - way.py) / (double)dy;
            double b = (double)((iy + 1) * WG_UNIT + disc.reach - way.py) / (double)dy;
            double first = wg_higher(0.0, wg_lower(a, b));
            double last = wg_lower(1.0, wg_higher(a, b));
            int64_t one = way.px + wg_floor(first * (double)dx);
            int64_t two = way.px + wg_ceil(last * (double)dx);
            left = wg_least(one, two) - 1;
            right = wg_most(one, two) + 1;
        }
        Span columns = span(left - disc.reach, right + disc.reach, grid.width);
        for (int64_t ix = columns.first; ix <= columns.last; ix++) {
            if (wg_cell_state(grid, ix, iy) == state && !segment_box_is_clear(disc.clear_sq, way, ix, iy)) {
                return (WgFound){true, ix, iy};
            }
        }
    }
    return (WgFound){false, 0, 0};
}

bool wg_segment_crosses_box(WgSegment way, int64_t ix, int64_t iy)
{
    int64_t left = ix * WG_UNIT - way.px;
    int64_t low = iy * WG_UNIT - way.py;
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    if (wg_most(0, dx) <= left || wg_least(0, dx) >= left + WG_UNIT || wg_most(0, dy) <= low ||
        wg_least(0, dy) >= low + WG_UNIT) {
        return false;
    }
    bool above = false;
    bool below = false;
    for (int corner = 0; corner < 4; corner++) {
        int64_t across = dx * (low + (corner >> 1) * WG_UNIT) - dy * (left + (corner & 1) * WG_UNIT);
        above = above || across > 0;
        below = below || across < 0;
    }
    return (above && below) || (dx == 0 && dy == 0);
}

double wg_segment_box_depth(double radius, WgSegment way, int64_t ix, int64_t iy)
{
    if (wg_segment_crosses_box(way, ix, iy)) {
        return radius;
    }
    double nearest = wg_lower((double)wg_point_box_distance_sq(way.px, way.py, ix, iy),
                              (double)wg_point_box_distance_sq(way.qx, way.qy, ix, iy));
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    int64_t length_sq = dx * dx + dy * dy;
    for (int corner = 0; corner < 4; corner++) {
        int64_t cx = (ix + (corner & 1)) * WG_UNIT - way.px;
        int64_t cy = (iy + (corner >> 1)) * WG_UNIT - way.py;
        int64_t along = dx * cx + dy * cy;
        if (0 < along && along < length_sq) {
            double across = (double)(dx * cy - dy * cx);
            nearest = wg_lower(nearest, across * across / (double)length_sq);
        }
    }
    return wg_higher(0.0, radius - sqrt(nearest));
}

void wg_mark_near(WgGrid grid, int32_t *near, int64_t ix, int64_t iy)
{
    const int64_t side = 2 * WG_NEAR + 1;
    bool taken = wg_cell_state(grid, ix, iy) != WG_FREE;
    int64_t top = wg_least(iy + WG_NEAR, grid.height - 1);
    int64_t right = wg_least(ix + WG_NEAR, grid.width - 1);
    for (int64_t jy = wg_most(iy - WG_NEAR, 0); jy <= top; jy++) {
        for (int64_t jx = wg_most(ix - WG_NEAR, 0); jx <= right; jx++) {
            int32_t bit = (int32_t)(1 << ((iy - jy + WG_NEAR) * side + ix - jx + WG_NEAR));
            int32_t *mask = &near[jy * grid.width + jx];
            *mask = taken ? *mask | bit : *mask & ~bit;
        }
    }
}

void wg_near_masks(WgGrid grid, int32_t *near)
{
    memset(near, 0, (size_t)(grid.width * grid.height) * sizeof *near);
    for (int64_t iy = -WG_NEAR; iy < grid.height + WG_NEAR; iy++) {
        for (int64_t ix = -WG_NEAR; ix < grid.width + WG_NEAR; ix++) {
            if (wg_cell_state(grid, ix, iy) != WG_FREE) {
                wg_mark_near(grid, near, ix, iy);
            }
        }
    }
}

// Returns the smallest entry of the neighbours in the row above or below, plus one.
static int32_t beyond(const int32_t *row, int64_t ix, int64_t width, int32_t least)
{
    for (int64_t k = wg_most(ix - 1, 0); k <= wg_least(ix + 1, width - 1); k++) {
        least = row[k] + 1 < least ? row[k] + 1 : least;
    }
    return least;
}

void wg_chessboard_clearance(WgGrid grid, int32_t *clearance)
{
    int64_t width = grid.width;
    int64_t height = grid.height;
    // First pass, upwards from the lower left: the outside, and the cells below or to the left.
    for (int64_t iy = 0; iy < height; iy++) {
        int32_t *row = clearance + iy * width;
        for (int64_t ix = 0; ix < width; ix++) {
            int64_t border = wg_least(wg_least(ix, width - 1 - ix), wg_least(iy, height - 1 - iy)) + 1;
            int32_t nearest = grid.cells[iy * width + ix] != WG_FREE ? 0 : (int32_t)border;
            if (nearest > 0 && iy > 0) {
                nearest = beyond(row - width, ix, width, nearest);
            }
            if (nearest > 0 && ix > 0 && row[ix - 1] + 1 < nearest) {
                nearest = row[ix - 1] + 1;
            }
            row[ix] = nearest;
        }
    }
    // Second pass, backwards: the cells above or to the right.
    for (int64_t iy = height - 1; iy >= 0; iy--) {
        int32_t *row = clearance + iy * width;
        for (int64_t ix = width - 1; ix >= 0; ix--) {
            int32_t nearest = row[ix];
            if (nearest > 0 && iy < height - 1) {
                nearest = beyond(row + width, ix, width, nearest);
            }
            if (nearest > 0 && ix < width - 1 && row[ix + 1] + 1 < nearest) {
                nearest = row[ix + 1] + 1;
            }
            row[ix] = nearest;
        }
    }
}

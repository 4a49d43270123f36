// Tests straight pieces of a path against solid cells with integers and floats; doubtful cases are
// left to the caller.
//
// All lengths are whole lu. Intersections of pieces with boxes, and distances between boxes, are
// exact in 64 bits. The distance of a slanted piece from a corner is side / length, both whole;
// only its comparison with the radius uses floats, with an error below 1e-15. If the two are within
// 1e-13 of each other, the answer is "unsure", and the caller compares fractions.

#include <math.h>

#include "reach_internal.h"

// The length to compare a piece with, and how far to look.
typedef struct Bound {
    int64_t reach;  // lu; no cell within it is missed
    double radius_sq;  // square of the distance in question, lu^2
    int64_t limit;     // the same for integers: squares below it are nearer
    bool stop;         // true if the first nearer cell ends the scan
} Bound;

// A scan in progress: the piece, rising, and its result so far.
typedef struct Scan {
    WgPiece piece;
    int64_t ex;
    int64_t ey;
    int64_t length_sq;
    int64_t least;
    int64_t nearest_side;  // -1 if there is none yet
} Scan;

// Squared distance from a point to a box with its lower left corner at (x0, y0).
static inline int64_t point_box_sq(int64_t x, int64_t y, int64_t x0, int64_t y0)
{
    int64_t dx = wg_max(wg_max(x0 - x, 0), x - x0 - WG_UNIT);
    int64_t dy = wg_max(wg_max(y0 - y, 0), y - y0 - WG_UNIT);
    return dx * dx + dy * dy;
}

// A slanted piece and one solid cell: its ends, the cell's corners, and whether they meet.
static inline void look_at_slanted(Scan *scan, int64_t x0, int64_t y0)
{
    WgPiece p = scan->piece;
    scan->least = wg_min(scan->least, point_box_sq(p.px, p.py, x0, y0));
    scan->least = wg_min(scan->least, point_box_sq(p.qx, p.qy, x0, y0));
    bool right = false;
    bool left = false;
    bool on_line = false;
    for (int corner = 0; corner < 4; corner++) {
        int64_t ux = x0 + WG_UNIT * (corner & 1) - p.px;
        int64_t uy = y0 + WG_UNIT * (corner >> 1) - p.py;
        int64_t side = scan->ex * uy - scan->ey * ux;
        right = right || side < 0;
        left = left || side > 0;
        on_line = on_line || side == 0;
        int64_t along = scan->ex * ux + scan->ey * uy;
        bool next_to = 0 < along && along < scan->length_sq;
        if (next_to && (scan->nearest_side < 0 || wg_abs(side) < scan->nearest_side)) {
            scan->nearest_side = wg_abs(side);
        }
    }
    bool level = wg_max(p.px, p.qx) >= x0 && wg_min(p.px, p.qx) <= x0 + WG_UNIT && p.qy >= y0 &&
                 p.py <= y0 + WG_UNIT;
    if (level && (on_line || (right && left))) {
        scan->least = 0;
    }
}

// A piece along an axis is a box itself.
static inline void look_at_straight(Scan *scan, int64_t x0, int64_t y0)
{
    WgPiece p = scan->piece;
    int64_t dx = wg_max(wg_max(x0 - wg_max(p.px, p.qx), wg_min(p.px, p.qx) - x0 - WG_UNIT), 0);
    int64_t dy = wg_max(wg_max(y0 - p.qy, p.py - y0 - WG_UNIT), 0);
    scan->least = wg_min(scan->least, dx * dx + dy * dy);
}

static WgScan scan_piece(const WgWalls *walls, WgPiece piece, Bound bound)
{
    if (piece.py > piece.qy) {
        piece = (WgPiece){piece.qx, piece.qy, piece.px, piece.py};
    }
    int64_t ex = piece.qx - piece.px;
    int64_t ey = piece.qy - piece.py;
    Scan scan = {piece, ex, ey, ex * ex + ey * ey, bound.limit, -1};
    bool slanted = ex != 0 && ey != 0;
    double length_sq = (double)scan.length_sq;
    int64_t reach = bound.reach;
    const WgScan met = {0, 0, 0, true};

    // Go row by row; outside the grid, the ring of cells next to it is enough.
    int64_t last = wg_min(walls->height, wg_cell_of(piece.qy + reach) + 1);
    for (int64_t iy = wg_max(-1, wg_cell_of(piece.py - reach) - 1); iy <= last; iy++) {
        int64_t low = wg_min(piece.px, piece.qx);
        int64_t high = wg_max(piece.px, piece.qx);
        int64_t y0 = iy * WG_UNIT;
        // Only the part of the piece that is level with the row counts.
        if (ey > 0) {
            int64_t below = wg_min(wg_max(y0 - reach - piece.py, 0), ey);
            int64_t above = wg_min(wg_max(y0 + WG_UNIT + reach - piece.py, 0), ey);
            int64_t one = piece.px + wg_floor_div(ex * below, ey);
            int64_t two = piece.px + wg_floor_div(ex * above, ey);
            low = wg_min(one, two);
            high = wg_max(one, two);
        }
        int64_t end = wg_min(walls->width, wg_cell_of(high + 1 + reach) + 1);
        for (int64_t ix = wg_max(-1, wg_cell_of(low - 1 - reach) - 1); ix <= end; ix++) {
            if (!wg_is_solid(walls, ix, iy)) {
                continue;
            }
            if (slanted) {
                look_at_slanted(&scan, ix * WG_UNIT, y0);
            } else {
                look_at_straight(&scan, ix * WG_UNIT, y0);
            }
            if (bound.stop && scan.least < bound.limit) {
                return met;
            }
        }
        if (bound.stop && scan.nearest_side >= 0) {
            double square = (double)scan.nearest_side * (double)scan.nearest_side;
            if (square < bound.radius_sq * length_sq * (1.0 - 1e-13)) {
                return met;
            }
        }
    }

    // Keep the corner next to the line if it is nearer than everything else,
    // or if floats cannot tell.
    WgScan found = {scan.least, 0, 0, scan.least < bound.limit};
    if (scan.nearest_side >= 0) {
        double square = (double)scan.nearest_side * (double)scan.nearest_side;
        double asked = fmin(bound.radius_sq, (double)scan.least) * length_sq;
        if (square <= asked * (1.0 + 1e-13)) {
            found.side = scan.nearest_side;
            found.length_sq = scan.length_sq;
            found.nearer = found.nearer || square < asked * (1.0 - 1e-13);
        }
    }
    return found;
}

WgAnswer wg_sweep(const WgWalls *walls, WgPiece piece, const WgDisc *disc)
{
    WgScan scan = scan_piece(walls, piece, (Bound){disc->reach, disc->radius_sq, disc->limit, true});
    if (scan.nearer) {
        return WG_MEETS;
    }
    return scan.length_sq > 0 ? WG_UNSURE : WG_CLEAR;
}

WgStatus wg_shorten(const WgWalls *walls, const WgDisc *disc, const int64_t *x, const int64_t *y,
                    const uint8_t *whole, int64_t count, int64_t patience, int64_t *state, int64_t *kept,
                    int64_t *done)
{
    int64_t at = state[0];
    int64_t seen = state[1];
    int64_t far = state[2];
    int64_t found = state[3];
    WgAnswer answer = (WgAnswer)state[4];
    // Corners kept never outnumber corners passed, so there is always room;
    // and the search only looks ahead.
    if (at < 0 || at >= count || found < 1 || found > at + 1 || seen <= at || far <= at) {
        return WG_BAD_VALUE;
    }
    if (at < count - 1 && seen >= count) {
        return WG_BAD_VALUE;
    }
    while (at < count - 1) {
        // Tests corners ahead, until too many in a row are out of sight.
        while (far < count && far <= seen + patience) {
            if (answer == WG_UNSURE && whole[at] != 0 && whole[far] != 0) {
                answer = wg_sweep(walls, (WgPiece){x[at], y[at], x[far], y[far]}, disc);
            }
            if (answer == WG_UNSURE) {
                state[0] = at;
                state[1] = seen;
                state[2] = far;
                state[3] = found;
                *done = 0;
                return WG_OK;
            }
            if (answer == WG_CLEAR) {
                seen = far;
            }
            answer = WG_UNSURE;
            far++;
        }
        kept[found++] = seen;
        at = seen;
        far = seen + 2;
        seen++;
    }
    state[3] = found;
    *done = 1;
    return WG_OK;
}

WgStatus wg_sweep_least(const WgWalls *walls, const int64_t *x, const int64_t *y, int64_t count, int64_t reach,
                        int64_t *sides, int64_t *lengths_sq, int64_t *found, int64_t *least)
{
    if (count < 1 || reach < 0 || reach > INT32_MAX) {
        return WG_BAD_VALUE;
    }
    int64_t best = reach * reach;
    double bound = (double)best;
    *found = 0;
    for (int64_t i = 0; i < wg_max(1, count - 1); i++) {
        int64_t next = wg_min(i + 1, count - 1);
        WgPiece piece = {x[i], y[i], x[next], y[next]};
        WgScan scan = scan_piece(walls, piece, (Bound){reach, bound, best, false});
        best = wg_min(best, scan.least);
        bound = fmin(bound, (double)scan.least);
        if (scan.length_sq > 0) {
            sides[*found] = scan.side;
            lengths_sq[*found] = scan.length_sq;
            *found += 1;
            bound = fmin(bound, (double)scan.side * (double)scan.side / (double)scan.length_sq);
        }
        // Nothing farther than the nearest so far is of interest.
        reach = wg_min(reach, (int64_t)sqrt(bound) + 2);
    }
    *least = best;

    // The error of floats is below 1e-15, so cells farther away than the nearest by more than that
    // do not count.
    double nearest = INFINITY;
    for (int64_t i = 0; i < *found; i++) {
        nearest = fmin(nearest, (double)sides[i] * (double)sides[i] / (double)lengths_sq[i]);
    }
    int64_t kept = 0;
    for (int64_t i = 0; i < *found; i++) {
        double square = (double)sides[i] * (double)sides[i] / (double)lengths_sq[i];
        bool same = kept > 0 && sides[i] == sides[kept - 1] && lengths_sq[i] == lengths_sq[kept - 1];
        if (square <= nearest * (1.0 + 1e-12) && !same) {
            sides[kept] = sides[i];
            lengths_sq[kept] = lengths_sq[i];
            kept++;
        }
    }
    *found = kept;
    return WG_OK;
}

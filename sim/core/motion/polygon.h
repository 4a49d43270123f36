// Exact tests of a convex polygonal body against square cells, on the pose lattice.
//
// A body's corners are lattice points of its own frame. The table of headings turns them by a
// matrix of multiples of 2^-30, so that each corner of a placed body is a multiple of 2^-30 of a
// lattice unit, which a double holds exactly. "Is this pose clear", "is this move clear" and "is
// this turn clear" are decided without tolerance: floating point answers where its error bound
// allows, 128-bit integers otherwise. Cells outside the grid are solid.

#ifndef WG_POLYGON_H
#define WG_POLYGON_H

#include <stdbool.h>
#include <stdint.h>

#include "motion.h"
#include "wg_parts.h"

// A body at a heading, relative to its axle, lattice units.
typedef struct WgPolygon {
    int64_t count;
    double x[WG_MOST_FOOTPRINT];  // corners, counter-clockwise
    double y[WG_MOST_FOOTPRINT];
    double out_x[WG_MOST_FOOTPRINT];  // outward normal of the edge that begins at a corner, as long as the edge
    double out_y[WG_MOST_FOOTPRINT];
    double left;  // bounds
    double right;
    double low;
    double high;
} WgPolygon;

// Turns a body to a heading.
void wg_polygon_turned(const int64_t *headings, const WgFootprint *footprint, int64_t heading, WgPolygon *polygon);

// The first cell in `state`, in row order, that a body cuts while it moves along a segment.
WgFound wg_polygon_first_not_clear(WgGrid grid, int state, const WgPolygon *polygon, WgSegment way);

// Returns the first contact of a body with a solid cell on a move; time 2 if there is none.
//
// One that goes less than `graze` lattice units deep does not count.
WgContact wg_polygon_contact(WgGrid grid, const WgPolygon *polygon, WgPlace from, WgVector by, double graze);

#endif

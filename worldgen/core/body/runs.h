// Runs of poses in which a body may meet a rectangle, and in which it must.
//
// A box of poses has a range of headings, and a range of places along each axis. Along one of the axes,
// the places at which the body is apart from a rectangle for all other coordinates in the box, and those
// at which it overlaps the rectangle for all of them, are runs, because both are convex. Separating axes
// give their ends: the rectangle's sides and the body's are all that are needed.

#ifndef WG_RUNS_H
#define WG_RUNS_H

#include "solids.h"

enum { WG_X = 0, WG_Y = 1, WG_HEADING = 2 };

// A closed box of poses: bounds of x and y in lu, and of the heading; those of headings are not reduced.
typedef struct WgRange {
    int32_t low[3];
    int32_t high[3];
} WgRange;

// The body over a range of headings.
typedef struct WgSpan {
    double outer[4];  // most that it reaches toward -x, +x, -y, +y at any heading of the range
    double inner[4];  // what it reaches at each of them
    double shrink;    // cosine of half the range
    double safety;    // by which bounds are moved to the safe side, lu
    struct {
        double normal[2][2];  // outward, at both ends of the range
        double outer;         // the side's distance from the axle, times the normal's length
        double inner;
    } sides[WG_MOST_CORNERS];
} WgSpan;

// What both discs about the axle say of any heading.
typedef struct WgDiscs {
    double outer;  // radius of the smallest that holds the body
    double inner;  // and of the largest in it
} WgDiscs;

// Where the body may meet a rectangle: only strictly between the first two numbers. Where it must: at
// the last two and between them. A run is empty if its end is before its begin.
typedef struct WgRun {
    int64_t may_begin;
    int64_t may_end;
    int64_t must_begin;
    int64_t must_end;
} WgRun;

// Prepares a range of headings, at most a sixteenth of a turn; of length 0 it must be a quarter turn's
// multiple, and is exact.
void wg_span_make(const WgBody *body, int64_t heading, int64_t turn, WgSpan *span);

WgDiscs wg_discs_of(const WgBody *body);

// Finds the runs along an axis. span is NULL for all headings.
WgRun wg_run_along(const WgBody *body, const WgSpan *span, const WgDiscs *discs, const WgRange *range,
                   const WgSolid *solid, int axis);

#endif

// Shared by the files that prove reachability for bodies.

#ifndef BODY_H
#define BODY_H

#include <stdbool.h>
#include <stdint.h>

#include "reach_internal.h"
#include "wg_body.h"

enum {
    WG_TURN = 65536,             // headings
    WG_HEADING_BITS = 16,
    WG_EIGHTH = WG_TURN / 8,
    WG_MOST_CORNERS = 16,
    WG_MOST_HULL = 3 * WG_MOST_CORNERS + 2,
    WG_MOST_REACH = 257 * WG_UNIT,  // lu from the axle to a corner
};

// The table's unit, and the radians of a heading's.
#define WG_ONE 0x1p30
#define WG_RADIANS (6.283185307179586477 / 65536.0)

// A convex polygon, counter-clockwise; corners in 2^-30 lu.
typedef struct WgHull {
    int64_t count;
    int64_t x[WG_MOST_HULL];
    int64_t y[WG_MOST_HULL];
} WgHull;

static inline int64_t wg_cosine(const WgBody *body, int64_t heading)
{
    return body->cosines[heading & (WG_TURN - 1)];
}

static inline int64_t wg_sine(const WgBody *body, int64_t heading)
{
    return wg_cosine(body, heading - WG_TURN / 4);
}

// Checks sizes and ranges of what a caller gives.
bool wg_body_is_valid(const WgWalls *walls, const WgBody *body);

// Distance, lu, from the axle to the farthest corner.
double wg_body_reach(const WgBody *body);

// The body at a pose.
void wg_body_hull(const WgBody *body, int64_t x, int64_t y, int64_t heading, WgHull *hull);

// Returns true if the interior of a polygon meets no interior of a solid cell.
bool wg_hull_is_clear(const WgWalls *walls, const WgHull *hull);

// The three tests of wg_body.h, for arguments that are known to be valid.
bool wg_clear_at(const WgWalls *walls, const WgBody *body, WgBodyPose pose);
bool wg_clear_along(const WgWalls *walls, const WgBody *body, WgBodyPose pose, int64_t x, int64_t y);
bool wg_clear_turning(const WgWalls *walls, const WgBody *body, WgBodyPose pose, int64_t turn);

// The turn from one heading to another, the shorter way; half a turn is positive.
static inline int64_t wg_turn_between(int64_t from, int64_t to)
{
    int64_t turn = (to - from) & (WG_TURN - 1);
    return turn > WG_TURN / 2 ? turn - WG_TURN : turn;
}

#endif

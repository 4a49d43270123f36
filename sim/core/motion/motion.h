// Parts of motion.c that a fleet's motion uses as well.

#ifndef WG_MOTION_H
#define WG_MOTION_H

#include "geometry.h"

// A lattice point.
typedef struct WgPlace {
    int64_t x;
    int64_t y;
} WgPlace;

// The time of a touch, as a share of a displacement (2: never),
// and the direction away from the touched thing.
typedef struct WgContact {
    double time;
    WgNormal normal;
} WgContact;

// Returns when a point that moves by a displacement from a place first meets the circle around the
// origin; 2 if it never does. The result has the same bits with both signs flipped, so that two
// robots agree on when they touch.
double wg_touch_time(double radius_sq, WgPlace from, WgVector by);

// Returns the first contact with a wall on a path that is not clear; the end of the path if only
// exact arithmetic detects it.
WgContact wg_wall_contact(WgGrid grid, WgDisc disc, WgPlace from, WgVector by);

#endif

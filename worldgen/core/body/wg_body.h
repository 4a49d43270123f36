// Proofs of reachability for a body: a convex polygon that turns about its axle.
//
// Lengths in lu are 1/1024 of a cell's side, headings are in 1/65536 of a turn. A corner (cx, cy) of
// a body at (x, y) with heading h is at (x + (cx C - cy S) / 2^30, y + (cx S + cy C) / 2^30), where C
// and S are the cosine and sine of h in a table: a fraction, so every test below is exact. A body is
// clear if its interior meets no interior of a solid cell; everything outside the grid is solid.

#ifndef WG_BODY_H
#define WG_BODY_H

#include <stdint.h>

#include "wg_reach.h"

// headings.c

// Fills the table of cosines: (65536,) units of 2^-30, rounded, halves up.
void wg_body_cosines(int64_t *cosines);

// hull.c

// A body and the numbers that turn it. Its arrays must outlive every call.
typedef struct WgBody {
    const int64_t *corners;  // (count, 2) x and y in its frame, lu, counter-clockwise, strictly convex
    int64_t count;           // 3 to 16
    const int64_t *cosines;  // (65536,) from wg_body_cosines
} WgBody;

typedef struct WgBodyPose {
    int64_t x;  // lu
    int64_t y;
    int64_t heading;  // 0 to 65535
} WgBodyPose;

// Reports in ``clear`` whether a body is clear at a pose: 1 or 0.
WgStatus wg_body_is_clear(const WgWalls *walls, const WgBody *body, const WgBodyPose *pose, int64_t *clear);

// Reports whether it stays clear on the straight line to (x, y), with its heading kept.
WgStatus wg_body_may_move(const WgWalls *walls, const WgBody *body, const WgBodyPose *pose, int64_t x, int64_t y,
                          int64_t *clear);

// Reports whether it is clear at every heading of the table from a pose's on, as it turns on the spot.
//
// turn:       -32768 to 32768, positive is counter-clockwise.
WgStatus wg_body_may_turn(const WgWalls *walls, const WgBody *body, const WgBodyPose *pose, int64_t turn,
                          int64_t *clear);

// decide.c

typedef enum WgBodyOutcome {
    WG_BODY_REACHED = 0,    // there is a path
    WG_BODY_COVERED = 1,    // the body overlaps a wall at the start
    WG_BODY_STOPPED = 2,    // boxes of poses that overlap a wall separate the start from the target
    WG_BODY_UNDECIDED = 3,  // the search reached its limit
} WgBodyOutcome;

// A query about a body in a static world, and its answer.
//
// Boxes of poses are split where start and target may be connected, until a chain of boxes in which
// the body is clear connects them, or no box that isn't full of overlaps does.
typedef struct WgBodyQuery {
    WgBodyPose start;
    double target_x;  // the target's disc, lu
    double target_y;
    double target_radius;
    int64_t from_heading;  // headings of the target: from this one
    int64_t headings;      // as many more counter-clockwise; 65535 for all
    int64_t most_boxes;    // limit on boxes
    int64_t wants_proof;   // 0 if it is enough to know whether there is one

    int64_t outcome;      // a WgBodyOutcome
    int64_t boxes;        // that were made
    int64_t finest_side;  // shortest side of a box, lu
    int64_t finest_turn;  // smallest range of headings of a box
    // the path: (count, 3) x, y and heading; between two poses the body moves or turns on the spot,
    // the shorter way. Or the cut: (count, 6) as in worldgen.world.Cut
    int64_t *rows;
    int64_t count;
    // lower bound of the distance, lu, between the body on its path and the walls
    double clearance;
} WgBodyQuery;

WgStatus wg_body_decide(const WgWalls *walls, const WgBody *body, WgBodyQuery *query);

// Measures the clearance of a path: (count, 3) x, y and heading. It is a lower bound, less than ``slack``
// lu below the distance.
WgStatus wg_body_clearance(const WgWalls *walls, const WgBody *body, const int64_t *poses, int64_t count,
                           double slack, double *clearance);

// Releases what an answer holds.
void wg_body_free(WgBodyQuery *query);

#endif

// Paths of a car: a robot whose turning circle has a least radius.
//
// A car's pose is the pose of its axle. Lengths of curves are in turning radii, angles in rad.

#ifndef WG_CAR_H
#define WG_CAR_H

#include <stdint.h>

#include "wg_body.h"
#include "wg_reach.h"
#include "wg_types.h"

// curves.c

enum { WG_CURVE_PARTS = 5, WG_MOST_CURVES = 48 };

// Arcs of the turning circle and straight lines, driven one after the other.
typedef struct WgCurve {
    int64_t count;     // number of parts
    int64_t steer[5];  // of each part: 1 to the left, 0 straight, -1 to the right
    double amount[5];  // angle of an arc, length of a straight line; negative backwards
    double length;     // of all parts
} WgCurve;

// Lists the curves from the pose (0, 0, 0) to (x, y, heading) that Dubins's car, which never
// reverses, may need; shortest first. Returns their number, at most 6.
int64_t wg_dubins(double x, double y, double heading, WgCurve *found);

// Lists those that Reeds and Shepp's car, which may reverse, may need; shortest first.
// found: (48,). Returns their number.
int64_t wg_reeds_shepp(double x, double y, double heading, WgCurve *found);

// search.c

// A car, its start and its target, and the path found.
//
// From pose to pose of the path, the car turns by half of what its heading changes, rounded towards
// zero, drives straight, and turns by the rest.
typedef struct WgCarQuery {
    const WgBody *body;      // NULL for a disc about the axle
    WgDisc disc;             // this disc, or one that the body holds; its limit is 0 if it holds none
    WgDisc around;           // a disc that holds the body
    double turning_radius;   // lu, above 0
    int64_t reverse;         // 1 if it may drive backwards
    double start_x;          // lu
    double start_y;
    int64_t start_heading;   // 1/65536 turn
    double target_x;         // lu
    double target_y;
    double target_radius;
    int64_t from_heading;    // headings of the target: from this one
    int64_t headings;        // as many more counter-clockwise; 65535 for all
    // smallest squared distance, in quarters of a cell, at which the disc is clear
    int64_t clear_from;
    double bin;              // lu, at least 2; of two poses this near to each other, one is searched
    int64_t heading_bins;    // of a turn, at most 2^14; the same for headings
    int64_t most;            // limit on the poses searched, or the curves tried

    int64_t expanded;        // poses searched, or curves tried
    int64_t count;           // of the path's poses; 0 if none was found
    int64_t *poses;          // (count, 3) x and y, lu; heading, units
} WgCarQuery;

// Searches for a path of the car by motion primitives: arcs and lines, curves to the target, and
// turns onto lines along the nearest walls.
WgStatus wg_car_search(const WgWalls *walls, WgCarQuery *asked);

// follow.c

// Follows a path of a robot that turns on the spot with a car that may reverse. Only the car, its
// start, its target and the limit of the query count.
//
// poses:      (count, 3) x and y, lu; heading, units. Between two of them, the robot moves or turns.
WgStatus wg_car_follow(const WgWalls *walls, WgCarQuery *asked, const int64_t *poses, int64_t count);

// Releases the path.
void wg_car_free(WgCarQuery *asked);

// confine.c

// Boxes of poses of a car that never reverses, and where it gets from them. Box (heading, row, column) has the places
// (column to column + 1, row to row + 1) times ``side``, and the headings half a part of a turn around its own.
typedef struct WgCarFlood {
    double side;             // of a box, cells
    int64_t columns;
    int64_t rows;
    int64_t headings;
    int64_t most_turn;       // of a step, headings
    int64_t parts;           // of a step, after which its place is bounded
    // (headings, 2 most_turn + 1, parts, 4) by heading and turn: the boxes, left, right, low, high, relative to the first
    // one, in which the car may be after each part
    const int32_t *steps;
    const uint8_t *may_arrive;  // (headings, 2 most_turn + 1, parts) 1 if its heading may be the target's there
    // The body is never smaller than these discs, whose middles are ahead of the axle. The first is about the axle.
    int64_t discs;
    const double *reaches;   // (discs,) cells from a box's middle at which a wall meets it at all poses of the box
    const int32_t *shifts;   // (headings, discs, 2) columns and rows from a box to the middles of its discs
    double target_x;         // cells
    double target_y;
    double target_reach;     // cells from there to the middle of a box in which the car may arrive
    double step;             // cells from a box to the farthest one that a step may lead to or through
    int64_t start_arrives;   // 1 if its heading may be the target's at the start
    int64_t starts;
    const int64_t *start;    // (starts, 3) headings, rows and columns of the boxes in which it may start
    int64_t most;            // limit on the steps tried

    int64_t outcome;         // a WgCarFlooded
    int64_t tried;           // steps
    int64_t count;           // of runs
    int64_t *runs;           // (count, 4) heading, row, first and last column: the boxes that the car cannot leave
} WgCarFlood;

enum WgCarFlooded {
    WG_CAR_CONFINED = 0,
    WG_CAR_ESCAPES = 1,   // a box is reached in which it may arrive
    WG_CAR_UNKNOWN = 2,   // the limit is reached
};

// Finds the boxes that the car can get into.
WgStatus wg_car_flood(const WgWalls *walls, WgCarFlood *asked);

// Releases the runs.
void wg_car_flood_free(WgCarFlood *asked);

#endif

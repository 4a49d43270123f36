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

// Boxes of poses of a car, and where it gets from them in a step. Rectangles are (left, right, low, high),
// in columns and rows relative to a box's own, included.
typedef struct WgCarFlood {
    int64_t columns;
    int64_t rows;
    int64_t headings;
    int64_t most_turn;       // headings by which a step turns at most
    int64_t parts;           // rectangles of a step, the last one at its end
    const int32_t *steps;    // (headings, 2 most_turn + 1, parts, 4) by heading and turn
    const uint8_t *places;   // (rows, columns) one of these:
} WgCarFlood;

enum {
    WG_CAR_IN_WALL = 0,  // everywhere in the box, the car overlaps a wall
    WG_CAR_ELSEWHERE = 1,
    WG_CAR_AT_TARGET = 2,  // it may arrive from there in less than a step
};

// Adds to some boxes all that the car can reach from them, until one is near the target.
//
// reached: (headings, rows, columns), 1 for boxes that it may be in.
// escapes: 1 if one is near the target, else 0.
WgStatus wg_car_flood(const WgCarFlood *asked, uint8_t *reached, int64_t *escapes);

#endif

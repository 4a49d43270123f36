// How a car drives: parts of curves as chains of legs on the lattice, each tested exactly.

#ifndef WG_DRIVE_H
#define WG_DRIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "angles.h"
#include "body.h"
#include "wg_car.h"

// A pose of the axle. Headings are whole, so that a path has no error that grows.
typedef struct WgCarPose {
    double x;  // lu
    double y;
    int64_t heading;  // units, in [0, 65536)
} WgCarPose;

// An arc or a line on the lattice.
typedef struct WgCarPart {
    int64_t steer;   // 1 to the left, 0 straight, -1 to the right
    double amount;   // units of an arc, whole; lu of a line; negative backwards
} WgCarPart;

// A list of poses on the lattice.
typedef struct WgCarTrail {
    int64_t *values;  // (room, 3) x and y, lu; heading, units
    int64_t count;
    int64_t room;
} WgCarTrail;

// A car in its world, and where it is going.
typedef struct WgCar {
    const WgWalls *walls;
    const WgCarQuery *asked;
    int64_t most_turn;  // units; an arc's leg turns no more, so that it stays near the arc
} WgCar;

// The result of a drive.
typedef enum WgDriven {
    WG_DRIVEN,    // to the end of its parts
    WG_HIT,       // a wall would stop the body
    WG_ARRIVED,   // at a pose in the target, before the end
    WG_NO_ROOM,   // memory ran out
} WgDriven;

WgCar wg_car_of(const WgWalls *walls, const WgCarQuery *asked);

static inline int64_t wg_car_heading(int64_t units)
{
    return units & (WG_TURN - 1);
}

static inline WgAngle wg_car_direction(int64_t heading)
{
    return wg_car_angle((double)heading * (2.0 * WG_CAR_PI / (double)WG_TURN));
}

// The length of a part, lu.
double wg_car_length(const WgCar *car, WgCarPart part);

// Returns true if a pose, rounded to the lattice, is in the target.
bool wg_car_is_there(const WgCar *car, WgCarPose pose);

// Drives some parts; stops where a wall is, or, if ``arrives``, at the first pose in the target.
//
// pose:       receives the last pose.
// trail:      receives the poses after the first, or NULL.
WgDriven wg_car_drive(const WgCar *car, WgCarPose *pose, const WgCarPart *parts, int64_t count, bool arrives,
                      WgCarTrail *trail);

// Returns the end of some parts, up to rounding, whether or not a wall is in the way.
WgCarPose wg_car_end(const WgCar *car, WgCarPose pose, const WgCarPart *parts, int64_t count);

// Returns the curves to a pose as parts, shortest first.
typedef struct WgCarRoute {
    int64_t count;
    WgCarPart parts[WG_CURVE_PARTS];
    double length;  // lu
} WgCarRoute;

// routes: (48,). Returns their number.
int64_t wg_car_routes(const WgCar *car, WgCarPose from, WgCarPose to, WgCarRoute *routes);

#endif

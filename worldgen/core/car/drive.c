// Drives a car along arcs and lines. Its exact path is a chain of chords: the axle turns from chord
// to chord by small whole numbers of heading units, and each chord's direction is half-way between
// the headings at its ends. All corners of the chain are on the arcs, rounded to the lattice.

#include "drive.h"

#include <math.h>
#include <stdlib.h>

// A chord is at most this far from its arc, lu: 1/512 cell.
static const double MOST_SAGITTA = 2.0;
// No chord turns by more than this, units, or an eighth of a quarter turn: near 11 degrees.
enum { MOST_TURN = 2048 };
// Rounding errors in the comparison with the target's radius, as a fraction of it.
static const double SURE = 1e-9;

static const double UNITS_PER_RADIAN = (double)WG_TURN / 6.28318530717958647692;

WgCar wg_car_of(const WgWalls *walls, const WgCarQuery *asked)
{
    // The sagitta of a chord that turns by an angle is about radius angle^2 / 8.
    double angle = sqrt(8.0 * MOST_SAGITTA / asked->turning_radius);
    int64_t units = 2 * (int64_t)floor(0.5 * angle * UNITS_PER_RADIAN);
    return (WgCar){walls, asked, wg_max(2, wg_min(units, MOST_TURN))};
}

double wg_car_length(const WgCar *car, WgCarPart part)
{
    double size = fabs(part.amount);
    return part.steer == 0 ? size : size * car->asked->turning_radius / UNITS_PER_RADIAN;
}

bool wg_car_is_there(const WgCar *car, WgCarPose pose)
{
    const WgCarQuery *asked = car->asked;
    double dx = floor(pose.x + 0.5) - asked->target_x;
    double dy = floor(pose.y + 0.5) - asked->target_y;
    if (dx * dx + dy * dy > asked->target_radius * asked->target_radius * (1.0 - SURE)) {
        return false;
    }
    return wg_car_heading(pose.heading - asked->from_heading) <= asked->headings;
}

static WgDriven append(WgCarTrail *trail, WgCarPose pose)
{
    if (trail == NULL) {
        return WG_DRIVEN;
    }
    if (trail->count == trail->room) {
        int64_t room = 2 * trail->room + 256;
        int64_t *values = realloc(trail->values, (size_t)(3 * room) * sizeof *values);
        if (values == NULL) {
            return WG_NO_ROOM;
        }
        trail->values = values;
        trail->room = room;
    }
    int64_t *row = trail->values + 3 * trail->count++;
    row[0] = (int64_t)floor(pose.x + 0.5);
    row[1] = (int64_t)floor(pose.y + 0.5);
    row[2] = pose.heading;
    return WG_DRIVEN;
}

// Returns true if the body is clear along one leg, which it drives at a heading between those of its
// ends.
static bool is_clear(const WgCar *car, WgCarPose from, WgCarPose to, int64_t heading)
{
    const WgCarQuery *asked = car->asked;
    WgPiece piece = {(int64_t)floor(from.x + 0.5), (int64_t)floor(from.y + 0.5), (int64_t)floor(to.x + 0.5),
                     (int64_t)floor(to.y + 0.5)};
    if (asked->body == NULL) {
        return wg_sweep(car->walls, piece, &asked->disc) == WG_CLEAR;
    }
    // The two discs about the axle decide most legs.
    if (asked->disc.limit > 0 && wg_sweep(car->walls, piece, &asked->disc) == WG_MEETS) {
        return false;
    }
    if (wg_sweep(car->walls, piece, &asked->around) == WG_CLEAR) {
        return true;
    }
    WgBodyPose begin = {piece.px, piece.py, from.heading};
    WgBodyPose along = {piece.px, piece.py, heading};
    WgBodyPose end = {piece.qx, piece.qy, heading};
    return wg_clear_along(car->walls, asked->body, along, piece.qx, piece.qy) &&
           (heading == from.heading ||
            wg_clear_turning(car->walls, asked->body, begin, wg_turn_between(from.heading, heading))) &&
           (heading == to.heading ||
            wg_clear_turning(car->walls, asked->body, end, wg_turn_between(heading, to.heading)));
}

WgDriven wg_car_drive(const WgCar *car, WgCarPose *pose, const WgCarPart *parts, int64_t count, bool arrives,
                      WgCarTrail *trail)
{
    double radius = car->asked->turning_radius;
    for (int64_t p = 0; p < count; p++) {
        WgCarPart part = parts[p];
        bool is_arc = part.steer != 0;
        double gear = part.amount < 0.0 ? -1.0 : 1.0;
        int64_t units = is_arc ? (int64_t)floor(fabs(part.amount) + 0.5) : 0;
        int64_t legs = is_arc ? (units + car->most_turn - 1) / car->most_turn : 1;
        for (int64_t leg = 0; leg < legs; leg++) {
            // An arc's legs turn by even numbers, except the last, so that half of one is whole.
            int64_t halves = units / 2;
            int64_t turn = 2 * ((leg + 1) * halves / legs - leg * halves / legs);
            turn += leg == legs - 1 ? units % 2 : 0;
            int64_t signed_half = part.steer * (int64_t)gear * (turn / 2);
            double length = fabs(part.amount);
            if (is_arc) {
                length = 2.0 * radius * wg_car_angle(0.5 * (double)turn / UNITS_PER_RADIAN).sine;
            }
            int64_t middle = wg_car_heading(pose->heading + signed_half);
            WgAngle along = wg_car_direction(middle);
            WgCarPose next = {pose->x + gear * length * along.cosine, pose->y + gear * length * along.sine,
                              wg_car_heading(pose->heading + part.steer * (int64_t)gear * turn)};
            if (!is_clear(car, *pose, next, middle)) {
                return WG_HIT;
            }
            *pose = next;
            if (append(trail, next) == WG_NO_ROOM) {
                return WG_NO_ROOM;
            }
            if (arrives && wg_car_is_there(car, next)) {
                return WG_ARRIVED;
            }
        }
    }
    return WG_DRIVEN;
}

WgCarPose wg_car_end(const WgCar *car, WgCarPose pose, const WgCarPart *parts, int64_t count)
{
    for (int64_t p = 0; p < count; p++) {
        int64_t steer = parts[p].steer;
        WgAngle from = wg_car_direction(pose.heading);
        if (steer == 0) {
            pose.x += parts[p].amount * from.cosine;
            pose.y += parts[p].amount * from.sine;
            continue;
        }
        pose.heading = wg_car_heading(pose.heading + steer * (int64_t)parts[p].amount);
        WgAngle to = wg_car_direction(pose.heading);
        double radius = (double)steer * car->asked->turning_radius;
        pose.x += radius * (to.sine - from.sine);
        pose.y -= radius * (to.cosine - from.cosine);
    }
    return pose;
}

int64_t wg_car_routes(const WgCar *car, WgCarPose from, WgCarPose to, WgCarRoute *routes)
{
    // Solve with the start at the origin, in turning radii.
    double radius = car->asked->turning_radius;
    WgAngle along = wg_car_direction(from.heading);
    double dx = (to.x - from.x) / radius;
    double dy = (to.y - from.y) / radius;
    double x = dx * along.cosine + dy * along.sine;
    double y = dy * along.cosine - dx * along.sine;
    double heading = (double)wg_turn_between(from.heading, to.heading) / UNITS_PER_RADIAN;
    WgCurve curves[WG_MOST_CURVES];
    int64_t count =
        car->asked->reverse != 0 ? wg_reeds_shepp(x, y, heading, curves) : wg_dubins(x, y, heading, curves);

    // Round arcs to even numbers of heading units, so that halves of all legs are whole.
    for (int64_t c = 0; c < count; c++) {
        WgCarRoute *route = &routes[c];
        *route = (WgCarRoute){0, {{0}}, curves[c].length * radius};
        for (int64_t part = 0; part < curves[c].count; part++) {
            int64_t steer = curves[c].steer[part];
            double amount = curves[c].amount[part];
            amount = steer == 0 ? amount * radius : 2.0 * floor(0.5 * amount * UNITS_PER_RADIAN + 0.5);
            if (amount != 0.0) {
                route->parts[route->count++] = (WgCarPart){steer, amount};
            }
        }
    }
    return count;
}

// Directions and distances in the plane, the directions of beams and target, and commands to turn.
//
// Only + - * /, sqrt and fdlibm's functions are used, so every machine gets the same bits.

#ifndef WG_DIRECTIONS_H
#define WG_DIRECTIONS_H

#include <math.h>
#include <stdint.h>

#include "fdlibm.h"
#include "numbers.h"
#include "worldgen_controller.h"

static const double WG_PI = 3.14159265358979323846;
static const double WG_WHOLE_TURN = 6.28318530717958647693;

// The remainder of a division by a positive number, in [0, divisor).
static inline double wg_remainder(double value, double divisor)
{
    double rest = fmod(value, divisor);
    if (rest == 0.0) {
        return 0.0;
    }
    return rest < 0.0 ? rest + divisor : rest;
}

// The same angle in [-pi, pi), rad.
static inline double wg_wrap(double angle)
{
    return angle - WG_WHOLE_TURN * (double)wg_floor((angle + WG_PI) / WG_WHOLE_TURN);
}

// Direction of the vector (dx, dy), rad; 0 for the zero vector.
static inline double wg_angle_of(double dx, double dy)
{
    if (dx == 0.0 && dy == 0.0) {
        return 0.0;
    }
    if (fabs(dy) <= fabs(dx)) {
        double angle = wg_atan(dy / dx);
        if (dx > 0.0) {
            return angle;
        }
        return dy >= 0.0 ? angle + WG_PI : angle - WG_PI;
    }
    double angle = wg_atan(dx / dy);
    return dy > 0.0 ? WG_PI / 2.0 - angle : -WG_PI / 2.0 - angle;
}

// Distance between two points.
static inline double wg_distance(double x, double y, double to_x, double to_y)
{
    double dx = to_x - x;
    double dy = to_y - y;
    return sqrt(dx * dx + dy * dy);
}

// Distance of a point from a straight path.
static inline double wg_distance_to_path(double x, double y, double from_x, double from_y, double to_x, double to_y)
{
    double dx = to_x - from_x;
    double dy = to_y - from_y;
    double length_sq = dx * dx + dy * dy;
    double share = 0.0;
    if (length_sq > 0.0) {
        share = wg_lower(1.0, wg_higher(0.0, ((x - from_x) * dx + (y - from_y) * dy) / length_sq));
    }
    return wg_distance(x, y, from_x + share * dx, from_y + share * dy);
}

// Direction of a range beam from the heading, rad, for beams over a full turn, the first ahead.
static inline double wg_bearing_of(int64_t beam, int64_t beams)
{
    return WG_WHOLE_TURN * (double)beam / (double)beams;
}

// The ends of the beams, m, in a frame at the robot.
typedef struct WgPoints {
    double x[WG_MOST_BEAMS];
    double y[WG_MOST_BEAMS];
    int64_t count;
} WgPoints;

// Finds the ends of the beams in a frame that the robot's heading is relative to, rad.
static inline void wg_beam_ends(const WgObservation *seen, double heading, WgPoints *points)
{
    points->count = wg_least(seen->beam_count, WG_MOST_BEAMS);
    for (int64_t beam = 0; beam < points->count; beam++) {
        double angle = heading + wg_bearing_of(beam, seen->beam_count);
        points->x[beam] = seen->beams[beam] * wg_cos(angle);
        points->y[beam] = seen->beams[beam] * wg_sin(angle);
    }
}

// Direction of the target from the heading, rad in [-pi, pi).
static inline double wg_target_bearing(const WgObservation *seen)
{
    return wg_wrap(seen->target_heading - seen->heading);
}

// Commands a turn, rad, within the next step, and a speed, m/s.
static inline void wg_steer(const WgObservation *seen, WgCommand *command, double turn, double speed)
{
    command->turn_rate = turn / seen->time_step;
    command->speed = speed;
}

#endif

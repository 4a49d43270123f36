// Two simple rules for several robots: drive straight at the target, and keep to the right.

#include "directions.h"
#include "library.h"

// Drives straight at the target and ignores everything else.
void wg_naive_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)memory;
    wg_steer(seen, command, wg_target_bearing(seen), seen->top_speed);
}

static const double ROUNDING = 1e-6;  // m: far more than the rounding error of distances
// times the sum of the radii: distance at which robots pass each other
static const double MARGIN = 1.3;

// Returns the angle, rad, of a sine from 0 to 1.
static double arc_sine(double sine)
{
    return sine < 1.0 ? wg_atan(sine / sqrt(1.0 - sine * sine)) : WG_PI / 2.0;
}

// Returns half the angle that a robot at a distance covers, including the margin.
static double half_angle(double radii, double distance)
{
    return arc_sine(wg_lower(1.0, MARGIN * radii / distance));
}

// Keeps to the right, as ships do.
//
// It passes an oncoming or standing robot with that robot on its left. A robot that crosses from
// the right goes first. It ignores all others, which are overtaken or cross from the left.
//
// Source: International Regulations for Preventing Collisions at Sea (1972),
// rules 14 (head-on) and 15 (crossing).
void wg_right_hand_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)memory;
    double target = wg_target_bearing(seen);
    double turn = target;
    double speed = seen->top_speed;
    double ahead_x = seen->neighbour_count > 0 ? wg_cos(turn) : 1.0;
    double ahead_y = seen->neighbour_count > 0 ? wg_sin(turn) : 0.0;
    for (int64_t k = 0; k < seen->neighbour_count; k++) {
        const WgNeighbour *other = &seen->neighbours[k];
        // Most robots are clearly not in the way: behind, or too far from the straight path. For
        // the others, compare angles, which are rounded differently.
        double along = other->x * ahead_x + other->y * ahead_y;
        double across = other->y * ahead_x - other->x * ahead_y;
        if (along < -ROUNDING || fabs(across) > MARGIN * (seen->radius + other->radius) + ROUNDING) {
            continue;
        }
        double distance = wg_distance(0.0, 0.0, other->x, other->y);
        double bearing = wg_angle_of(other->x, other->y);
        double half = half_angle(seen->radius + other->radius, distance);
        double off = wg_wrap(bearing - turn);
        if (off > half || off < -half) {
            continue;  // it is not in the way
        }
        double away = wg_wrap(other->heading - bearing);
        bool stands = other->speed == 0.0;
        bool comes = away > 0.75 * WG_PI || away < -0.75 * WG_PI;
        if (stands || comes) {
            turn = wg_wrap(bearing - half);
            ahead_x = wg_cos(turn);
            ahead_y = wg_sin(turn);
        } else if (bearing < 0.0 && away > 0.0) {
            speed = 0.0;
        }
    }
    // Never turn farther than a right angle from the target,
    // or it would drive in circles around a crowd.
    if (wg_wrap(turn - target) < -WG_PI / 2.0 || wg_wrap(turn - target) > WG_PI / 2.0) {
        turn = wg_wrap(target - WG_PI / 2.0);
    }
    wg_steer(seen, command, turn, speed);
}

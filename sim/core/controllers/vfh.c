// VFH+: the robot drives through the opening between obstacles that requires the least turning.
//
// Source: Iwan Ulrich and Johann Borenstein, "VFH+: reliable obstacle avoidance for fast mobile
// robots", IEEE International Conference on Robotics and Automation, 1998: the four stages and the
// weights of section 3. Departures: the histogram is filled from the scan of one step rather than
// from a certainty grid, so the nearest obstacle of a sector counts, not a sum; the speed falls
// with the density in the chosen direction as in their "The vector field histogram" (1991),
// equation 11.

#include <stdbool.h>

#include "directions.h"
#include "library.h"

enum { SECTORS = 72 };  // 5 degrees each, in the world's frame

static const double WIDTH = 6.28318530717958647693 / 72.0;  // width of a sector, rad

const WgVfh wg_vfh_default = {
    .safety = 1.0 / 7.0,
    .window = 40.0 / 7.0,
    .low = 0.6,
    .high = 0.7,
    .wide = 16.0,
    .to_target = 5.0,
    .to_heading = 2.0,
    .to_last = 2.0,
    .turning_radius = 0.0,
    .slowest = 0.15,
};

// The angles by which the robot can turn to either side, rad; the right is negative.
typedef struct Sides {
    double right;
    double left;
} Sides;

// The reference directions for a cost, in sectors.
typedef struct Wanted {
    double heading;
    double target;
    double last;  // negative: none
} Wanted;

// Stage 1: the polar histogram; each beam's obstacle covers the sectors
// that the widened obstacle covers.
static void fill(const WgObservation *seen, double *density, const WgVfh *tuned)
{
    double reach = seen->radius * (1.0 + tuned->safety);
    double window = tuned->window * seen->radius;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        double distance = seen->beams[beam];
        if (distance >= window) {
            continue;
        }
        double share = 1.0 - distance / window;
        double half = 0.5 * WG_PI;
        if (distance > reach) {
            half = wg_atan(reach / sqrt(distance * distance - reach * reach));
        }
        double middle = seen->heading + wg_bearing_of(beam, seen->beam_count);
        int64_t first = wg_ceil((middle - half) / WIDTH);
        int64_t last = wg_floor((middle + half) / WIDTH);
        for (int64_t sector = first; sector <= last; sector++) {
            double *cell = &density[wg_floor_mod(sector, SECTORS)];
            *cell = wg_higher(*cell, share);
        }
    }
}

// Stage 2: the binary histogram; between the two thresholds a sector keeps its state.
static void block(const double *density, WgVfhMemory *own, const WgVfh *tuned)
{
    for (int64_t sector = 0; sector < SECTORS; sector++) {
        if (density[sector] > tuned->high) {
            own->blocked[sector] = 1.0;
        } else if (density[sector] < tuned->low) {
            own->blocked[sector] = 0.0;
        }
    }
}

// Stage 3: find how far to the right and to the left the robot can turn before its circle meets an
// obstacle.
static Sides reachable_sides(const WgObservation *seen, const WgVfh *tuned)
{
    double turn = tuned->turning_radius;
    double near = turn + seen->radius * (1.0 + tuned->safety);
    Sides sides = {-WG_PI, WG_PI};
    if (turn <= 0.0) {
        return sides;
    }
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        double distance = seen->beams[beam];
        if (distance >= tuned->window * seen->radius) {
            continue;
        }
        double angle = wg_wrap(wg_bearing_of(beam, seen->beam_count));
        double x = distance * wg_cos(angle);
        double y = distance * wg_sin(angle);
        if (angle < 0.0 && x * x + (y + turn) * (y + turn) < near * near) {
            sides.right = wg_higher(sides.right, angle);
        }
        if (angle > 0.0 && x * x + (y - turn) * (y - turn) < near * near) {
            sides.left = wg_lower(sides.left, angle);
        }
    }
    return sides;
}

// Sectors between two directions, the short way around.
static double apart(double one, double other)
{
    double away = wg_remainder(fabs(one - other), SECTORS);
    return wg_lower(away, (double)SECTORS - away);
}

// Stage 4's cost of a direction in sectors.
static double cost_of(double direction, const Wanted *wanted, const WgVfh *tuned)
{
    double cost = tuned->to_target * apart(direction, wanted->target);
    cost += tuned->to_heading * apart(direction, wanted->heading);
    return wanted->last < 0.0 ? cost : cost + tuned->to_last * apart(direction, wanted->last);
}

// Returns true if the masked histogram leaves a sector open.
static bool is_free(int64_t sector, double heading, Sides sides, const WgVfhMemory *own)
{
    int64_t at = wg_floor_mod(sector, SECTORS);
    double turn = wg_wrap(((double)at - heading) * WIDTH);
    return own->blocked[at] == 0.0 && sides.right <= turn && turn <= sides.left;
}

// Stage 4: the cheapest direction through an opening, sectors; -1 if all are blocked.
static double choose(const Wanted *wanted, Sides sides, const WgVfhMemory *own, const WgVfh *tuned)
{
    // Counting starts at a blocked sector, so that no opening is split in two.
    int64_t border = 0;
    while (border < SECTORS && is_free(border, wanted->heading, sides, own)) {
        border++;
    }
    if (border == SECTORS) {
        return wanted->target;
    }

    double best = -1.0;
    double least = INFINITY;
    int64_t left;
    for (int64_t right = border + 1; right < border + SECTORS; right = left + 1) {
        left = right;
        while (left < border + SECTORS && is_free(left, wanted->heading, sides, own)) {
            left++;
        }
        int64_t width = left - right;  // sectors right .. left - 1 are free
        if (width <= 0) {
            continue;
        }

        // A narrow opening has one candidate direction, its middle; a wide one has both sides, and
        // the target if it is inside.
        double directions[3] = {0.5 * (double)(right + left - 1), -1.0, -1.0};
        if ((double)width > tuned->wide) {
            double near = (double)right + 0.5 * tuned->wide;
            double far = (double)(left - 1) - 0.5 * tuned->wide;
            directions[0] = near;
            directions[1] = far;
            if (wg_remainder(wanted->target - near, SECTORS) <= far - near) {
                directions[2] = wanted->target;
            }
        }
        for (int k = 0; k < 3; k++) {
            double cost = directions[k] >= 0.0 ? cost_of(directions[k], wanted, tuned) : INFINITY;
            if (cost < least) {
                best = wg_remainder(directions[k], SECTORS);
                least = cost;
            }
        }
    }
    return best;
}

// Runs the four stages of one step; stops if every direction is blocked.
static void drive(const WgObservation *seen, WgVfhMemory *own, WgCommand *command, const WgVfh *tuned)
{
    Wanted wanted = {.last = own->last};
    wanted.heading = wg_remainder(seen->heading / WIDTH, SECTORS);
    wanted.target = wg_remainder(wanted.heading + wg_target_bearing(seen) / WIDTH, SECTORS);

    double density[SECTORS] = {0.0};
    fill(seen, density, tuned);
    block(density, own, tuned);
    double direction = choose(&wanted, reachable_sides(seen, tuned), own, tuned);
    own->last = direction;
    if (direction < 0.0) {
        return;
    }
    double dense = density[wg_floor_mod(wg_floor(direction + 0.5), SECTORS)];
    double share = wg_higher(1.0 - dense / tuned->high, tuned->slowest);
    wg_steer(seen, command, wg_wrap((direction - wanted.heading) * WIDTH), share * seen->top_speed);
}

void wg_vfh_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, (WgVfhMemory *)memory, command, &wg_vfh_default);
}

void wg_vfh_tuned_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgVfhTunedMemory *own = (WgVfhTunedMemory *)memory;
    drive(seen, &own->state, command, &own->tuned);
}

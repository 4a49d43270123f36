// How a robot follows a wall by touch; boundary.h describes it.

#include "boundary.h"

#include "directions.h"

#define DEGREE (3.14159265358979323846 / 180.0)

// fraction of the radius; a stride longer than the diameter would step over openings
static const double STRIDE = 0.03 / 0.07;
// m: a robot smaller than half of this would take forever
static const double LEAST_STRIDE = 0.005;
static const double FLAT = 20.0 * DEGREE;  // lean on a flat wall
static const double ROUND = 40.0 * DEGREE;  // lean around a corner
static const double FLAT_AFTER = 2.0;  // touches in a row by which a wall counts as flat
static const double SEARCH = 30.0 * DEGREE;  // turn towards a wall that is lost, in each step
static const double WHOLE_TURN = 12.0;  // steps of a search that turn it once
static const double WHOLE_TURNS = 24.0;  // steps after which the count goes back by one turn
static const double GIVE_WAY = 40.0 * DEGREE;  // turns away from a wall at which it is stuck
static const double SAME_FLAT = 5.0 * DEGREE;  // a wall that turns by less is flat
static const double AHEAD = 45.0 * DEGREE;  // turn of one wall into the path
static const double BEHIND = 120.0 * DEGREE;  // turn of one wall out of the path
static const double STANDS = 0.02;  // a move ahead of less than this share of a step counts as none
// share of a step by which the target must come nearer, or else a slide counts as a stop
static const double PROGRESS = 0.5;
static const double PRESSES = 3.0;  // presses without finding the wall before it is searched for

double wg_stride(const WgObservation *seen)
{
    double longest = wg_higher(STRIDE * seen->radius, LEAST_STRIDE);
    return wg_lower(longest, seen->top_speed * seen->time_step);
}

void wg_drive(const WgObservation *seen, WgWallBody *body, WgCommand *command, double direction, double length)
{
    body->x = seen->x;
    body->y = seen->y;
    body->step = length;
    wg_steer(seen, command, wg_wrap(direction - seen->heading), length / seen->time_step);
}

void wg_head_for_target(const WgObservation *seen, WgWallBody *body, WgCommand *command)
{
    double length = seen->bump != 0.0 ? wg_stride(seen) : seen->top_speed * seen->time_step;
    wg_drive(seen, body, command, seen->target_heading, wg_lower(length, seen->target_distance));
}

bool wg_is_stopped(const WgObservation *seen, const WgWallBody *body, double far)
{
    if (seen->bump == 0.0 || body->step > 1.001 * wg_stride(seen)) {
        return false;
    }
    double nearer = far - seen->target_distance;
    bool ahead = fabs(wg_wrap(wg_touched(seen) - seen->target_heading)) < 0.5 * WG_PI;
    return nearer <= (ahead ? PROGRESS : STANDS) * body->step;
}

double wg_touched(const WgObservation *seen)
{
    return wg_wrap(seen->heading + seen->bump_bearing);
}

void wg_begin_following(WgWallBody *body, double wall)
{
    body->wall = wall;
    body->phase = WG_PRESS;
    body->stuck = 0.0;
    body->lost = 0.0;
    body->smooth = 0.0;
}

// Returns how far the last step got in its direction, m; walls may have pushed the robot back,
// or aside.
static double moved_ahead(const WgObservation *seen, const WgWallBody *body)
{
    return (seen->x - body->x) * wg_cos(seen->heading) + (seen->y - body->y) * wg_sin(seen->heading);
}

bool wg_feel(const WgObservation *seen, WgWallBody *body)
{
    bool stands = moved_ahead(seen, body) < STANDS * body->step;

    // It touches nothing: its wall is lost, and after some presses the robot searches for it.
    if (seen->bump == 0.0) {
        body->stuck = 0.0;
        body->smooth = 0.0;
        body->lost += body->lost < WHOLE_TURNS ? 1.0 : 1.0 - WHOLE_TURN;
        if (body->lost >= PRESSES) {
            body->phase = WG_ADVANCE;
        }
        return false;
    }

    // How far the wall has turned out of the path decides whether it is the same wall.
    double wall = wg_touched(seen);
    double turn = wg_wrap(body->hand * (wall - body->wall) + AHEAD - WG_PI) + WG_PI - AHEAD;
    double searched = body->lost;
    bool advanced = body->phase == WG_ADVANCE;
    body->lost = 0.0;
    if (turn < BEHIND + SEARCH * searched) {
        bool smooth = advanced && searched == 0.0 && fabs(turn) < SAME_FLAT;
        body->smooth = smooth ? wg_lower(body->smooth + 1.0, FLAT_AFTER) : 0.0;
        body->stuck = stands && advanced ? body->stuck + 1.0 : 0.0;
    } else if (stands || body->stuck > 0.0) {
        // Another wall blocks the path: follow it from here.
        body->stuck = 0.0;
        body->smooth = 0.0;
    } else {
        body->phase = WG_PRESS;
        return false;
    }
    body->wall = wall;
    body->phase = WG_ADVANCE;
    return true;
}

bool wg_has_lost_it(const WgWallBody *body)
{
    return body->lost >= WHOLE_TURNS;
}

void wg_follow(const WgObservation *seen, WgWallBody *body, WgCommand *command)
{
    double length = wg_stride(seen);
    if (body->phase == WG_PRESS) {
        wg_drive(seen, body, command, body->wall, 0.5 * length);
        return;
    }
    double lean = body->smooth >= FLAT_AFTER ? FLAT : ROUND;
    lean += SEARCH * body->lost - GIVE_WAY * body->stuck;
    if (body->lost > 0.0) {
        length *= 0.5;
    }
    wg_drive(seen, body, command, body->wall + body->hand * (lean - WG_PI / 2.0), length);
}

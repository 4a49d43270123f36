// TangentBug: looks ahead with range beams, and goes around obstacles along their tangents.
//
// Source: I. Kamon, E. Rimon and E. Rivlin, "TangentBug: a range-sensor-based navigation
// algorithm", The International Journal of Robotics Research 17 (1998).

#include "boundary.h"
#include "directions.h"
#include "library.h"

static const double GOAL = 0.0;
static const double APPROACH = 1.0;
static const double WALL = 2.0;
static const double LEAVE = 3.0;

static const double RANGE = 1.0;  // m: points farther away are ignored
// radii: points farther apart than this from beam to beam are also ignored
static const double APART = 1.4;
// radii: a touched wall is at least this far away, so it doesn't block the path along it
static const double TOUCHING = 0.97;
// radii: a wall ends where the free path becomes longer by this in the next direction
static const double JUMP = 0.08 / 0.07;
// m: the path by an end may become this much longer before a wall is followed
static const double LONGER = 0.05;
// share of its distance by which a wall may be nearer or farther in the next direction
static const double CONTINUES = 0.5;
// m: a place worth leaving a wall for is nearer to the target than the whole wall by this
static const double NEARER = 0.03;
static const double PATIENCE = 60.0;  // steps within which the path must have become shorter

// A place in sight, and the length in m by which places are ranked.
typedef struct Sighting {
    double worth;    // m: infinity if there is none
    double bearing;  // rad, from the heading
    double length;   // m: distance of the place
} Sighting;

// Distance, m, up to which points are considered; a disc's free path is at most that minus its
// radius.
static double sight_of(const WgObservation *seen)
{
    return wg_lower(RANGE, APART * seen->radius * (double)seen->beam_count / WG_WHOLE_TURN);
}

// Returns how far, m, the disc can go in a direction from the heading, rad,
// past all points that beams hit.
static double free_path(const WgObservation *seen, double bearing)
{
    double sight = sight_of(seen);
    double free = sight - seen->radius;
    double wide = TOUCHING * seen->radius;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        double far = seen->beams[beam];
        if (far >= 0.999 * sight) {
            continue;
        }
        double angle = wg_wrap(wg_bearing_of(beam, seen->beam_count) - bearing);

        // Most points are behind the robot or far to the side: sin(x) >= 2 x / pi up to a quarter
        // turn. This halves the time of a step.
        double turned = fabs(angle);
        if (turned > 1.5708 || 0.6366 * turned * far > 1.001 * wide) {
            continue;
        }
        double along = far * wg_cos(angle);
        double across = far * wg_sin(angle);
        if (along > 0.0 && fabs(across) < wide) {
            free = wg_lower(free, along - sqrt(wide * wide - across * across));
        }
    }
    return wg_higher(free, 0.0);
}

// Distance to the target from the place at this distance in a direction from the heading.
static double rest_from(const WgObservation *seen, double bearing, double length)
{
    double far = seen->target_distance;
    double angle = seen->target_heading - seen->heading - bearing;
    double squared = far * far + length * length - 2.0 * far * length * wg_cos(wg_wrap(angle));
    return sqrt(wg_higher(squared, 0.0));
}

// Finds the end of a wall with the shortest path to the target; its value is the length of that
// path.
static Sighting best_end(const WgObservation *seen)
{
    int64_t beams = seen->beam_count;
    Sighting best = {INFINITY, 0.0, 0.0};
    double first = free_path(seen, 0.0);
    double before = first;
    for (int64_t beam = 1; beam <= beams; beam++) {
        double bearing = wg_bearing_of(beam, beams);
        double free = beam == beams ? first : free_path(seen, bearing);
        if (fabs(free - before) > JUMP * seen->radius) {
            double length = wg_lower(wg_lower(free, before) + seen->radius, wg_higher(free, before));
            double towards = free > before ? bearing : bearing - WG_WHOLE_TURN / (double)beams;
            double path = length + rest_from(seen, towards, length);
            if (path < best.worth) {
                best = (Sighting){path, towards, length};
            }
        }
        before = free;
    }
    return best;
}

// Finds the free place in sight that is nearest to the target; its value is that distance.
static Sighting nearest_seen(const WgObservation *seen)
{
    double offset = seen->target_heading - seen->heading;
    Sighting best = {INFINITY, 0.0, 0.0};
    for (int64_t beam = -1; beam < seen->beam_count; beam++) {
        double bearing = beam < 0 ? offset : wg_bearing_of(beam, seen->beam_count);
        double along = seen->target_distance * wg_cos(wg_wrap(offset - bearing));
        if (along <= 0.0) {
            continue;
        }
        double length = wg_lower(along, free_path(seen, bearing));
        double rest = rest_from(seen, bearing, length);
        if (rest < best.worth) {
            best = (Sighting){rest, bearing, length};
        }
    }
    return best;
}

// Drives towards the target, or to the best end of the wall in front of it; follows a wall if both
// fail.
static void go(const WgObservation *seen, WgTangentBugMemory *own, WgCommand *command)
{
    double ahead = seen->target_heading - seen->heading;
    Sighting chosen = {seen->target_distance, ahead, seen->target_distance};
    double in_sight = 0.999 * (sight_of(seen) - seen->radius);
    if (free_path(seen, ahead) < wg_lower(seen->target_distance, in_sight)) {
        chosen = best_end(seen);
        own->body.hand = wg_wrap(chosen.bearing - ahead) > 0.0 ? -1.0 : 1.0;
    }

    // If the path does not get shorter, approach the wall.
    own->since += 1.0;
    if (chosen.worth < own->best) {
        own->best = chosen.worth;
        own->since = 0.0;
    }
    bool stopped = wg_is_stopped(seen, &own->body, own->far);
    if (chosen.worth > own->best + LONGER || own->since > PATIENCE || stopped) {
        own->mode = APPROACH;
        own->wall_far = seen->target_distance;
        wg_head_for_target(seen, &own->body, command);
        return;
    }
    double step = seen->bump != 0.0 ? wg_stride(seen) : seen->top_speed * seen->time_step;
    double direction = seen->heading + chosen.bearing;
    wg_drive(seen, &own->body, command, direction, wg_lower(step, chosen.length));
}

// Updates how near the followed wall comes to the target, from the points seen on one side,
// 1 or -1.
static void see_wall(const WgObservation *seen, WgTangentBugMemory *own, int64_t side)
{
    int64_t beams = seen->beam_count;
    double sight = sight_of(seen);
    double towards = wg_wrap(own->body.wall - seen->heading) / WG_WHOLE_TURN;
    int64_t first = wg_floor(towards * (double)beams + 0.5);
    double before = seen->radius;
    for (int64_t k = 0; k < beams / 2; k++) {
        int64_t at = wg_floor_mod(first + side * k, beams);
        double far = seen->beams[at];
        if (far >= 0.999 * sight || fabs(far - before) > CONTINUES * before) {
            break;
        }
        double rest = rest_from(seen, wg_bearing_of(at, beams), wg_higher(far - seen->radius, 0.0));
        own->wall_far = wg_lower(own->wall_far, rest);
        before = far;
    }
}

// Records a visible place to leave the wall for, if one is nearer to the target than the whole wall
// was.
static void see_whether_to_leave(const WgObservation *seen, WgTangentBugMemory *own)
{
    see_wall(seen, own, 1);
    see_wall(seen, own, -1);
    own->wall_far = wg_lower(own->wall_far, seen->target_distance);
    Sighting place = nearest_seen(seen);
    if (place.worth < own->wall_far - NEARER) {
        double heading = wg_wrap(seen->heading + place.bearing);
        own->leave_x = seen->x + place.length * wg_cos(heading);
        own->leave_y = seen->y + place.length * wg_sin(heading);
        own->mode = LEAVE;
    }
}

// Drives to the place for which the robot left the wall.
static void leave(const WgObservation *seen, WgTangentBugMemory *own, WgCommand *command)
{
    double left = wg_distance(seen->x, seen->y, own->leave_x, own->leave_y);
    double step = seen->top_speed * seen->time_step;
    double direction = wg_angle_of(own->leave_x - seen->x, own->leave_y - seen->y);
    wg_drive(seen, &own->body, command, direction, wg_lower(step, left));
}

static void head_for_goal(WgTangentBugMemory *own)
{
    own->mode = GOAL;
    own->best = INFINITY;
    own->since = 0.0;
}

void wg_tangent_bug_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgTangentBugMemory *own = (WgTangentBugMemory *)memory;

    // Processes the result of the last step.
    if (own->mode == LEAVE) {
        double moved = wg_distance(own->body.x, own->body.y, seen->x, seen->y);
        if (seen->target_distance < own->wall_far - 0.5 * NEARER) {
            head_for_goal(own);
        } else if (seen->bump != 0.0 || moved < 0.01 * wg_stride(seen)) {
            own->mode = APPROACH;
        }
    } else if (own->mode == APPROACH && wg_is_stopped(seen, &own->body, own->far)) {
        own->mode = WALL;
        wg_begin_following(&own->body, wg_touched(seen));
    } else if (own->mode == WALL && wg_feel(seen, &own->body)) {
        see_whether_to_leave(seen, own);
    } else if (own->mode == WALL && wg_has_lost_it(&own->body)) {
        head_for_goal(own);
    }

    // Commands the next step.
    if (own->mode == GOAL) {
        go(seen, own, command);
    } else if (own->mode == APPROACH) {
        own->wall_far = wg_lower(own->wall_far, seen->target_distance);
        wg_head_for_target(seen, &own->body, command);
    } else if (own->mode == LEAVE) {
        leave(seen, own, command);
    } else {
        wg_follow(seen, &own->body, command);
    }
    own->far = seen->target_distance;
}

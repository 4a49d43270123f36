// Bug2: goes around an obstacle until it is back on the straight line to the target, at a nearer
// point.
//
// Source: V. J. Lumelsky and A. A. Stepanov, "Path-planning strategies for a point mobile automaton
// moving amidst unknown obstacles of arbitrary shape", Algorithmica 2 (1987), section 5. In the
// paper the line runs from the start to the target; here each hit point defines a new line.

#include "boundary.h"
#include "directions.h"
#include "library.h"

static const double START = 0.0;
static const double GOAL = 1.0;
static const double ROUND = 2.0;
static const double BACK = 3.0;

// fraction of a step by which a leave point must be nearer than the hit point
static const double NEARER = 0.05;
// fraction of a step: within this distance the robot is at the leave point
static const double THERE = 0.02;

// Starts to follow a wall, with a new line if it is nearer to the target than the last one.
static void hit(const WgObservation *seen, WgBug2Memory *own)
{
    wg_begin_following(&own->body, wg_touched(seen));
    own->mode = ROUND;
    if (seen->target_distance < own->hit_far - 0.5 * NEARER * wg_stride(seen)) {
        own->hit_x = seen->x;
        own->hit_y = seen->y;
        own->hit_far = seen->target_distance;
        own->line_x = wg_cos(seen->target_heading);
        own->line_y = wg_sin(seen->target_heading);
    }
}

// Returns true if the last step crossed the line at a possible leave point, and records it.
static bool crosses(const WgObservation *seen, WgBug2Memory *own)
{
    double from_x = own->body.x - own->hit_x;
    double from_y = own->body.y - own->hit_y;
    double to_x = seen->x - own->hit_x;
    double to_y = seen->y - own->hit_y;

    // Find the sides of the line on which the step began and ended.
    double before = own->line_x * from_y - own->line_y * from_x;
    double after = own->line_x * to_y - own->line_y * to_x;
    if ((before > 0.0) == (after > 0.0)) {
        return false;
    }
    double share = before / (before - after);
    double x = from_x + share * (to_x - from_x);
    double y = from_y + share * (to_y - from_y);
    double along = own->line_x * x + own->line_y * y;
    own->leave_x = own->hit_x + x;
    own->leave_y = own->hit_y + y;
    return NEARER * wg_stride(seen) < along && along < own->hit_far;
}

void wg_bug2_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug2Memory *own = (WgBug2Memory *)memory;
    if (own->mode == START) {
        own->mode = GOAL;
    } else if (own->mode == GOAL && wg_is_stopped(seen, &own->body, own->far)) {
        hit(seen, own);
    } else if (own->mode == ROUND) {
        wg_feel(seen, &own->body);
        if (wg_has_lost_it(&own->body)) {
            own->mode = GOAL;
            own->hit_far = INFINITY;
        } else if (crosses(seen, own)) {
            own->mode = BACK;
        }
    } else if (own->mode == BACK) {
        own->mode = GOAL;
    }

    own->far = seen->target_distance;
    double left = wg_distance(seen->x, seen->y, own->leave_x, own->leave_y);
    if (own->mode == BACK && left < THERE * wg_stride(seen)) {
        own->mode = GOAL;
    }
    if (own->mode == GOAL) {
        wg_head_for_target(seen, &own->body, command);
    } else if (own->mode == BACK) {
        double direction = wg_angle_of(own->leave_x - seen->x, own->leave_y - seen->y);
        wg_drive(seen, &own->body, command, direction, left);
    } else {
        wg_follow(seen, &own->body, command);
    }
}

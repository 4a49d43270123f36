// Bug1: goes around each obstacle once, and leaves it where it was nearest to the target.
//
// Source: V. J. Lumelsky and A. A. Stepanov, "Path-planning strategies for a point mobile automaton
// moving amidst unknown obstacles of arbitrary shape", Algorithmica 2 (1987), section 4.

#include "boundary.h"
#include "directions.h"
#include "library.h"

static const double START = 0.0;
static const double GOAL = 1.0;
static const double MEET = 2.0;
static const double ROUND = 3.0;
static const double BACK = 4.0;

static const double SAME_PLACE = 0.5;  // fraction of a step
// steps: beyond this distance the robot has left the hit point
static const double ELSEWHERE = 1.5;
// rad by which the direction of the wall may differ at the same place
static const double SAME_WALL = 100.0 * (3.14159265358979323846 / 180.0);
// fraction of a step: a hit on the same wall must be nearer than the last leave point by this,
// otherwise the robot drives to that point
static const double NEARER = 0.1;

// Returns true if the last step passed a remembered place along the same wall.
static bool passes(const WgObservation *seen, const WgBug1Memory *own, const WgWallPlace *place)
{
    double apart = wg_distance_to_path(place->x, place->y, own->body.x, own->body.y, seen->x, seen->y);
    double turned = fabs(wg_wrap(own->body.wall - place->wall));
    return apart < SAME_PLACE * wg_stride(seen) && turned < SAME_WALL;
}

static WgWallPlace place_here(const WgObservation *seen, const WgBug1Memory *own)
{
    return (WgWallPlace){seen->x, seen->y, own->body.wall};
}

// Makes one step around the obstacle: updates the nearest place,
// and checks if the hit point is reached again.
static void go_round(const WgObservation *seen, WgBug1Memory *own, bool touches)
{
    own->path += wg_distance(own->body.x, own->body.y, seen->x, seen->y);
    if (touches && (own->mode == MEET || seen->target_distance < own->leave_far)) {
        own->leave = place_here(seen, own);
        own->leave_far = seen->target_distance;
        own->leave_path = own->path;
    }

    // The first touch is the hit point; later it counts as reached only after the robot has been
    // away from it.
    if (touches && own->mode == MEET) {
        own->hit = place_here(seen, own);
        own->mode = ROUND;
        own->path = 0.0;
        own->leave_path = 0.0;
        own->away = 0.0;
    } else if (wg_distance(seen->x, seen->y, own->hit.x, own->hit.y) > ELSEWHERE * wg_stride(seen)) {
        own->away = 1.0;
    } else if (own->away == 1.0 && passes(seen, own, &own->hit)) {
        own->away = 2.0;
    }

    // Back at the hit point: drive to the leave point by the shorter route.
    if (touches && own->away == 2.0) {
        own->mode = BACK;
        if (own->leave_path > 0.5 * own->path) {
            own->body.hand = -own->body.hand;
            wg_begin_following(&own->body, own->body.wall);
        }
    }
}

// Decides whether a wall on the path to the target is a new obstacle or the last one again.
static void meet(const WgObservation *seen, WgBug1Memory *own)
{
    if (!wg_is_stopped(seen, &own->body, own->far)) {
        return;
    }
    wg_begin_following(&own->body, wg_touched(seen));
    double margin = NEARER * wg_stride(seen);
    if (own->leave_far < INFINITY && fabs(wg_wrap(own->body.wall - own->leave.wall)) > SAME_WALL) {
        // a wall across a gap hardly wider than the robot is a different one, however near
        margin = 0.0;
    }
    own->mode = seen->target_distance < own->leave_far - margin ? MEET : BACK;
    if (own->mode == MEET) {
        own->body.hand = 1.0;
    }
}

void wg_bug1_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug1Memory *own = (WgBug1Memory *)memory;
    if (own->mode == START) {
        own->mode = GOAL;
    } else if (own->mode == GOAL) {
        meet(seen, own);
    } else {
        bool touches = wg_feel(seen, &own->body);
        if (own->mode != BACK) {
            go_round(seen, own, touches);
        }
        if (wg_has_lost_it(&own->body)) {
            own->mode = GOAL;
            own->leave_far = INFINITY;
        } else if (own->mode == BACK && passes(seen, own, &own->leave)) {
            own->mode = GOAL;
        }
    }
    own->far = seen->target_distance;
    if (own->mode == GOAL) {
        wg_head_for_target(seen, &own->body, command);
    } else {
        wg_follow(seen, &own->body, command);
    }
}

// Faults in the controllers that follow walls by touch: Bug1 and Bug2.
// benchmarks/faults/by_touch.py describes each fault.

#include <stdbool.h>

#include "faults.h"

// Values of WgBug1Memory.mode and WgBug2Memory.mode.
static const double BUG1_MEET = 2.0;
static const double BUG1_ROUND = 3.0;
static const double BUG2_GOAL = 1.0;
static const double BUG2_ROUND = 2.0;

static const double STILL_ROUND = 2.0;  // WgBug1Memory.away: the robot is back at the hit point

typedef struct StaleRound {
    WgBug1Memory own;
    double seen_round;  // value of `away` when a circuit was completed
} StaleRound;

typedef struct StaleLine {
    WgBug2Memory own;
    double hit_x;  // values of the first obstacle
    double hit_y;
    double line_x;
    double line_y;
} StaleLine;

static void bug1_keeps_the_last_place(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug1Memory *own = (WgBug1Memory *)memory;
    if (own->mode == BUG1_ROUND) {
        own->leave_far = INFINITY;
    }
    wg_bug1_act(seen, memory, command);
}

static void bug1_hit_point_moves_along(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug1Memory *own = (WgBug1Memory *)memory;
    wg_bug1_act(seen, memory, command);
    if (own->mode == BUG1_ROUND) {
        own->hit.x = seen->x;
        own->hit.y = seen->y;
    }
}

static void bug1_stale_round_is_over(const WgObservation *seen, double *memory, WgCommand *command)
{
    StaleRound *all = (StaleRound *)memory;
    WgBug1Memory *own = &all->own;
    double before = own->mode;
    wg_bug1_act(seen, memory, command);
    if (own->away == STILL_ROUND) {
        all->seen_round = STILL_ROUND;
    }
    if (before == BUG1_MEET && own->mode == BUG1_ROUND && all->seen_round == STILL_ROUND) {
        own->away = STILL_ROUND;
    }
}

static void bug1_lost_wall_wrong_side(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug1Memory *own = (WgBug1Memory *)memory;
    wg_bug1_act(seen, memory, command);
    if (own->body.lost == 1.0) {
        own->body.hand = -own->body.hand;
    }
}

static void bug1_turn_not_wrapped(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_bug1_act(seen, memory, command);
    wg_unwrap_turn(seen, command);
}

static void bug2_leaves_by_equality(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug2Memory *own = (WgBug2Memory *)memory;
    double before = own->mode;
    wg_bug2_act(seen, memory, command);
    double x = seen->x - own->hit_x;
    double y = seen->y - own->hit_y;
    double off = own->line_x * y - own->line_y * x;
    if (before == BUG2_ROUND && own->mode != BUG2_ROUND && off != 0.0) {
        own->mode = BUG2_ROUND;
    }
}

static void bug2_stale_line(const WgObservation *seen, double *memory, WgCommand *command)
{
    StaleLine *all = (StaleLine *)memory;
    WgBug2Memory *own = &all->own;
    double before = own->mode;
    wg_bug2_act(seen, memory, command);
    if (before != BUG2_GOAL || own->mode != BUG2_ROUND) {
        return;
    }
    if (all->line_x == 0.0 && all->line_y == 0.0) {
        all->hit_x = own->hit_x;
        all->hit_y = own->hit_y;
        all->line_x = own->line_x;
        all->line_y = own->line_y;
    }
    own->hit_x = all->hit_x;
    own->hit_y = all->hit_y;
    own->line_x = all->line_x;
    own->line_y = all->line_y;
}

static void bug2_hit_point_not_kept(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug2Memory *own = (WgBug2Memory *)memory;
    wg_bug2_act(seen, memory, command);
    if (own->mode == BUG2_ROUND && own->body.lost == 1.0) {
        own->hit_x = seen->x;
        own->hit_y = seen->y;
    }
}

static void bug2_leaves_behind_the_hit_point(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgBug2Memory *own = (WgBug2Memory *)memory;
    double from_x = own->body.x - own->hit_x;
    double from_y = own->body.y - own->hit_y;
    wg_bug2_act(seen, memory, command);
    double x = seen->x - own->hit_x;
    double y = seen->y - own->hit_y;
    double before = own->line_x * from_y - own->line_y * from_x;
    double after = own->line_x * y - own->line_y * x;
    bool away = x * x + y * y > 0.01;  // (0.1 m)^2: do not leave immediately after hitting
    if (own->mode == BUG2_ROUND && away && (before > 0.0) != (after > 0.0)) {
        own->mode = BUG2_GOAL;
    }
}

static void bug2_bearing_in_degrees(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgObservation mistaken = *seen;
    if (mistaken.bump_bearing < 0.0) {
        mistaken.bump_bearing *= 180.0 / WG_PI;
    }
    wg_bug2_act(&mistaken, memory, command);
}

static void bug2_turn_not_wrapped(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_bug2_act(seen, memory, command);
    wg_unwrap_turn(seen, command);
}

const WgFault wg_faults_by_touch[] = {
    {"bug1-keeps-the-last-place", bug1_keeps_the_last_place, 0},
    {"bug1-hit-point-moves-along", bug1_hit_point_moves_along, 0},
    {"bug1-stale-round-is-over", bug1_stale_round_is_over, WG_ROOM(StaleRound, WgBug1Memory)},
    {"bug1-lost-wall-wrong-side", bug1_lost_wall_wrong_side, 0},
    {"bug1-turn-not-wrapped", bug1_turn_not_wrapped, 0},
    {"bug2-leaves-by-equality", bug2_leaves_by_equality, 0},
    {"bug2-stale-line", bug2_stale_line, WG_ROOM(StaleLine, WgBug2Memory)},
    {"bug2-hit-point-not-kept", bug2_hit_point_not_kept, 0},
    {"bug2-leaves-behind-the-hit-point", bug2_leaves_behind_the_hit_point, 0},
    {"bug2-bearing-in-degrees", bug2_bearing_in_degrees, 0},
    {"bug2-turn-not-wrapped", bug2_turn_not_wrapped, 0},
};
const size_t wg_faults_by_touch_count = sizeof wg_faults_by_touch / sizeof wg_faults_by_touch[0];

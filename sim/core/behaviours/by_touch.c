// Behaviours by touch: turn away from a wall, or follow it.
//
// Sources: avoid is layer 0 of Rodney A. Brooks, "A robust layered control system for a mobile
// robot", IEEE Journal of Robotics and Automation 2 (1986); follow leaves its wall as I-Bug does,
// Kamilah Taylor and Steven M. LaValle, "I-Bug: an intensity-based bug algorithm", IEEE
// International Conference on Robotics and Automation (2009).

#include "behaviours.h"
#include "boundary.h"
#include "directions.h"

// the robot leaves a wall when the signal is this many times as strong as at the hit
static const double STRONGER = 1.02;

typedef struct Avoid {
    double direction;  // rad: direction of driving
} Avoid;

typedef struct Follow {
    WgWallBody body;
    double fresh;   // 1 if no step along the wall has been made yet
    double signal;  // where the wall was met
} Follow;

static int64_t touches(const WgSituation *now)
{
    return now->seen->bump != 0.0;
}

// options[0]: angle between the wall's direction and the one to drive, rad.
static void begin_avoiding(const WgSituation *now)
{
    Avoid *own = (Avoid *)now->state;
    double angle = now->options[0];
    own->direction = wg_wrap(wg_touched(now->seen) + (now->seen->bump_bearing > 0.0 ? -angle : angle));
}

// options[1]: share of the top speed.
static int64_t avoid_on(const WgSituation *now)
{
    const Avoid *own = (const Avoid *)now->state;
    double turn = wg_wrap(own->direction - now->seen->heading);
    wg_steer(now->seen, now->command, turn, now->options[1] * now->seen->top_speed);
    return 0;
}

// Returns true if the robot touches a wall in the direction of the signal. It also touches a wall
// that it has just left.
static int64_t is_barred(const WgSituation *now)
{
    const WgObservation *seen = now->seen;
    return seen->bump != 0.0 && fabs(wg_wrap(seen->signal_heading - wg_touched(seen))) < 0.5 * WG_PI;
}

// options[0]: 1 to keep the wall on the left, -1 on the right.
static void begin_wall(const WgSituation *now)
{
    Follow *own = (Follow *)now->state;
    own->body.hand = now->options[0];
    own->fresh = 1.0;
    own->signal = now->seen->signal;
    wg_begin_following(&own->body, wg_touched(now->seen));
}

// Returns true if the signal is stronger than where the wall was hit,
// and the wall does not block its direction.
static bool may_leave(const WgObservation *seen, const Follow *own)
{
    bool away = fabs(wg_wrap(seen->signal_heading - own->body.wall)) > 0.5 * WG_PI;
    return away && seen->signal > STRONGER * own->signal;
}

static int64_t follow_on(const WgSituation *now)
{
    Follow *own = (Follow *)now->state;
    int64_t done = 0;
    if (own->fresh == 0.0) {
        wg_feel(now->seen, &own->body);
        done = wg_has_lost_it(&own->body) || may_leave(now->seen, own);
    }
    own->fresh = 0.0;
    wg_follow(now->seen, &own->body, now->command);
    return done;
}

const WgBehaviour wg_avoid = {.name = "avoid",
                              .trigger = touches,
                              .action = avoid_on,
                              .begin = begin_avoiding,
                              .restarts = 1,
                              .state_size = sizeof(Avoid) / sizeof(double)};
const WgBehaviour wg_follow_wall = {.name = "follow",
                                    .trigger = is_barred,
                                    .action = follow_on,
                                    .begin = begin_wall,
                                    .state_size = sizeof(Follow) / sizeof(double)};

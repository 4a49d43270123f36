// The thesis's three behaviours on the pose lattice: turn and get away after a collision,
// turn to the signal, drive.
//
// Source: the thesis on behaviour-based search and rescue robots that this program descends from
// (2005-2006), sections 3 and 4 and its listing.

#include <math.h>

#include "behaviours.h"
#include "directions.h"
#include "wg_sim.h"

static const double UNITS = (double)WG_TURN / 6.28318530717958647693;  // heading units per rad
static const int64_t TURN_STEP = 834;  // heading units turned in a step: 0.08 rad
// heading units: a remainder of at most 0.2 rad is turned immediately
static const int64_t SNAP = 2086;

static int64_t heading_units(double radians)
{
    return wg_floor_mod(wg_floor(radians * UNITS + 0.5), WG_TURN);
}

// Returns the signed difference, in (-half turn, half turn], from one heading to another.
static int64_t turn_between(int64_t heading, int64_t target)
{
    int64_t turn = wg_floor_mod(target - heading, WG_TURN);
    return turn > WG_TURN / 2 ? turn - WG_TURN : turn;
}

// Turns towards the target heading; returns true if the robot already pointed there.
static bool turn_on(const WgSituation *now)
{
    int64_t heading = heading_units(now->seen->heading);
    int64_t target = (int64_t)now->shared->target;
    if (heading == target) {
        return true;
    }
    int64_t turn = turn_between(heading, target);
    if (wg_abs(turn) > SNAP) {
        turn = turn > 0 ? TURN_STEP : -TURN_STEP;
    }
    now->command->turn_rate = (double)turn / UNITS / now->seen->time_step;
    return false;
}

static void drive_at_speed(const WgSituation *now)
{
    now->command->speed = now->shared->speed * now->seen->top_speed;
}

static int64_t collides(const WgSituation *now)
{
    return now->seen->bump != 0.0;
}

// Remembers the speed, stops, and sets the target heading by the rule.
static void begin_escape(const WgSituation *now)
{
    WgShared *shared = now->shared;
    int64_t heading = heading_units(now->seen->heading);
    shared->old_speed = shared->speed;
    shared->speed = 0.0;
    switch ((int)now->options[0]) {
    case WG_TURN_RIGHT:
        shared->target = (double)wg_floor_mod(heading - WG_TURN / 4, WG_TURN);
        break;
    case WG_TURN_LEFT:
        shared->target = (double)wg_floor_mod(heading + WG_TURN / 4, WG_TURN);
        break;
    default:
        shared->target = (double)wg_floor(now->seen->random * (double)WG_TURN);
        now->command->used_random = 1.0;
    }
}

// Turns, then drives at the speed from before the collision until its counter runs out.
static int64_t escape_on(const WgSituation *now)
{
    int64_t done = 0;
    if (turn_on(now)) {
        if (now->shared->counter >= 0.0) {
            now->shared->speed = now->shared->old_speed;
            now->shared->counter -= 1.0;
        } else {
            done = 1;
        }
    }
    drive_at_speed(now);
    return done;
}

static int64_t is_free(const WgSituation *now)
{
    return now->seen->bump == 0.0;
}

static int64_t seek_on(const WgSituation *now)
{
    now->shared->speed = 0.0;
    now->shared->target = (double)heading_units(now->seen->signal_heading);
    int64_t done = turn_on(now);
    drive_at_speed(now);
    return done;
}

static int64_t points_to_signal(const WgSituation *now)
{
    return now->seen->bump == 0.0 && (int64_t)now->shared->target == heading_units(now->seen->signal_heading);
}

static int64_t drive_straight(const WgSituation *now)
{
    int64_t done = 1;
    if (now->shared->counter >= 0.0 && now->seen->bump == 0.0) {
        now->shared->speed = 1.0;
        now->shared->counter -= 1.0;
        done = 0;
    }
    drive_at_speed(now);
    return done;
}

const WgBehaviour wg_collide = {
    .name = "collide", .trigger = collides, .action = escape_on, .begin = begin_escape, .keeps_time = 1, .restarts = 1};
const WgBehaviour wg_seek = {.name = "seek", .trigger = is_free, .action = seek_on, .keeps_time = 1};
const WgBehaviour wg_drive_on = {
    .name = "drive", .trigger = points_to_signal, .action = drive_straight, .keeps_time = 1, .restarts = 1};

// The thesis's robot on the pose lattice: seek the signal, drive, and after a collision turn by a fixed or random angle.
//
// Three behaviours (drive, seek, collide) run under an arbiter; the one that took control keeps it
// until it is done.
//
// Source: the thesis on behaviour-based search and rescue robots that this program is based on
// (2005-2006), sections 3 and 4 and its listing; the arbiter is reconstructed from the prose.

#include <math.h>

#include "directions.h"
#include "library.h"
#include "thesis_arbiter.h"
#include "wg_sim.h"

// The constants of the thesis's rules.
typedef enum Rule { RIGHT = 1, LEFT = 2, RANDOM = 3 } Rule;

static const double UNITS = (double)WG_TURN / 6.28318530717958647693;  // heading units per rad
static const int64_t TURN_STEP = 834;  // heading units turned in a step: 0.08 rad
static const int64_t SNAP = 2086;  // heading units: a rest of at most 0.2 rad is turned at once

// As in the thesis: 6 steps of escape, 3 of drive.
enum { COLLIDE_TICKS = 5, DRIVE_TICKS = 2 };

static int64_t heading_units(double radians)
{
    return wg_floor_mod(wg_floor(radians * UNITS + 0.5), WG_TURN);
}

// Target heading, units, after a collision.
static int64_t turn_after_collision(Rule rule, int64_t heading, double random)
{
    switch (rule) {
    case RIGHT:
        return wg_floor_mod(heading - WG_TURN / 4, WG_TURN);
    case LEFT:
        return wg_floor_mod(heading + WG_TURN / 4, WG_TURN);
    case RANDOM:
    default:
        return wg_floor(random * (double)WG_TURN);
    }
}

// Signed units, in (-half turn, half turn], from one heading to another.
static int64_t turn_between(int64_t heading, int64_t target)
{
    int64_t turn = wg_floor_mod(target - heading, WG_TURN);
    return turn > WG_TURN / 2 ? turn - WG_TURN : turn;
}

// One tick of the three behaviours.
static void tick(const WgObservation *seen, WgThesisMemory *own, WgCommand *command, Rule rule)
{
    bool collision = seen->bump != 0.0;
    int64_t heading = heading_units(seen->heading);
    int64_t signal = heading_units(seen->signal_heading);
    int64_t target = (int64_t)own->target;

    // Select the behaviour in control.
    WgCharge charge = wg_select_behaviour(WG_A0, (int64_t)own->behaviour, (int64_t)own->counter, collision,
                                          target == signal, COLLIDE_TICKS, DRIVE_TICKS);
    if (charge.taken && charge.behaviour == WG_COLLIDE) {
        own->old_speed = own->speed;
        own->speed = 0.0;
        target = turn_after_collision(rule, heading, seen->random);
        command->used_random = rule == RANDOM ? 1.0 : 0.0;
    }
    if (charge.behaviour == WG_SEEK) {
        own->speed = 0.0;
        target = signal;
    }

    // Let it act.
    WgAction action = wg_run_behaviour(charge.behaviour, charge.ticks, collision, heading == target);
    if (action.wheels == WG_WHEELS_TURN) {
        int64_t turn = turn_between(heading, target);
        if (wg_abs(turn) > SNAP) {
            turn = turn > 0 ? TURN_STEP : -TURN_STEP;
        }
        command->turn_rate = (double)turn / UNITS / seen->time_step;
    } else if (action.wheels == WG_WHEELS_GO) {
        own->speed = 1.0;
    } else if (action.wheels == WG_WHEELS_RESUME) {
        own->speed = own->old_speed;
    }
    own->behaviour = (double)action.behaviour;
    own->counter = (double)action.ticks;
    own->target = (double)target;
    command->speed = own->speed * seen->top_speed;
}

void wg_turn_right_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    tick(seen, (WgThesisMemory *)memory, command, RIGHT);
}

void wg_turn_left_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    tick(seen, (WgThesisMemory *)memory, command, LEFT);
}

void wg_turn_random_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    tick(seen, (WgThesisMemory *)memory, command, RANDOM);
}

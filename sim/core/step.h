// One step on the pose lattice: the move at the speed of the wheels, with the events that fall into it each at its
// time, then sensing, then the controller, whose turn takes effect at once and whose speed drives the next step.
//
// What every step needs is inline, so that the compiler keeps the loop around it in registers; what few steps need is
// in step.c.

#ifndef WG_STEP_H
#define WG_STEP_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "wg_episode.h"

enum {
    WG_STATE_WORDS = 5,  // of a WgState
    WG_SENSES = 17,      // numbers of an observation before its beams
};

// Of the traces' digests, as in the thesis's vectors: FNV-1a over 64-bit words.
static const uint64_t WG_HASH_START = 1469598103934665603u;
static const uint64_t WG_HASH_PRIME = 1099511628211u;

// Time in a step.
#define WG_STEP_TIME ((int64_t)1 << 32)

// Puts a robot at its start, with its memory at reset.
void wg_robot_begin(WgRobot *robot, const WgSettings *settings, const WgController *controller);

// What a controller senses before its first step: nothing but constants.
void wg_workspace_begin(WgWorkspace *workspace, const WgSettings *settings);

// Step in which the world changes for the last time; 0 if it never does.
static inline int64_t wg_last_event(const WgArena *arena)
{
    return arena->event_count > 0 ? arena->events[arena->event_count - 1].step : 0;
}

// Whole units of speed, never more than asked for, so that nobody outruns the top speed.
static inline int64_t wg_whole_speed(double asked)
{
    int64_t whole = (int64_t)(fabs(asked) + 1e-9);
    return asked >= 0.0 ? whole : -whole;
}

#endif

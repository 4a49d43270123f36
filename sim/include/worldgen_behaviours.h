// Behaviours and the arbiter that composes them, for controllers written in C or C++.
//
// A behaviour defines when it applies (its trigger) and what it then does (its action). A
// composition lists parts: a behaviour each, with a priority, a duration, and whether it can be
// interrupted. wg_arbitrate lets one of them act. See worldgen_controller.h for how a library
// offers a controller:
//
//     static void mine(const WgObservation *seen, double *memory, WgCommand *command)
//     {
//         const WgPart parts[] = {
//             {.does = &back_off, .priority = 2.0, .duration = 20.0},
//             {.does = &seek, .priority = 1.0, .interruptible = 1.0},
//         };
//         wg_arbitrate(parts, 2, (WgShared *)memory, seen, command);
//     }
//     WG_CONTROLLER(mine, .memory_size = sizeof(WgShared) / sizeof(double), .reset = mine_reset)
//
// Sources: Rodney A. Brooks, "A robust layered control system for a mobile robot", IEEE Journal of
// Robotics and Automation 2 (1986); the thesis on behaviour-based search and rescue robots that
// this program descends from (2005-2006), sections 3 and 6.

#ifndef WORLDGEN_BEHAVIOURS_H
#define WORLDGEN_BEHAVIOURS_H

#include <stddef.h>
#include <stdint.h>

#include "worldgen_controller.h"

#ifdef __cplusplus
extern "C" {
#endif

// No behaviour is in charge.
static const double WG_NO_BEHAVIOUR = -1.0;

// What all behaviours of a robot can read and change. A memory begins with it, and at reset
// `behaviour` is WG_NO_BEHAVIOUR.
typedef struct WgShared {
    double behaviour;  // in charge: its index among the parts, or WG_NO_BEHAVIOUR
    double counter;    // steps left before it is done
    double target;     // heading units: the heading that the robot turns to; -1 if there is none
    double speed;      // share of the top speed
    double old_speed;  // same, before a collision
} WgShared;

// The arguments of a behaviour.
typedef struct WgSituation {
    const WgObservation *seen;
    const double *options;  // the part's options
    WgShared *shared;
    double *state;       // the part's own numbers; all zero at reset
    WgCommand *command;  // all zero before the action
} WgSituation;

typedef struct WgBehaviour {
    const char *name;
    int64_t (*trigger)(const WgSituation *now);  // 1 if it applies; must not change anything
    int64_t (*action)(const WgSituation *now);   // commands one step; 1 if the behaviour is done
    // called in each step before the triggers; may be NULL
    void (*watch)(const WgSituation *now);
    void (*begin)(const WgSituation *now);       // called when it takes control; may be NULL
    // 1: its action counts `counter` down itself, such as one that turns before it drives
    int64_t keeps_time;
    int64_t restarts;    // 1: if it can be interrupted, a new trigger restarts it
    int64_t state_size;  // size of its own memory, in numbers
} WgBehaviour;

typedef struct WgPart {
    const WgBehaviour *does;
    // the applicable part with the highest priority acts; ties go to the first
    double priority;
    double duration;       // steps; without keeps_time a part acts for this many, at least one
    double interruptible;  // 0: it keeps control until it is done
    const double *options;
    double *state;
} WgPart;

// The arguments of a part.
static inline WgSituation wg_situation(const WgPart *part, WgShared *shared, const WgObservation *seen,
                                       WgCommand *command)
{
    WgSituation now = {seen, part->options, shared, part->state, command};
    return now;
}

// Shows a step to all parts that watch.
static inline void wg_watch(const WgPart *parts, int64_t count, WgShared *shared, const WgObservation *seen,
                            WgCommand *command)
{
    for (int64_t k = 0; k < count; k++) {
        if (parts[k].does->watch != NULL) {
            WgSituation now = wg_situation(&parts[k], shared, seen, command);
            parts[k].does->watch(&now);
        }
    }
}

// Lets a part act, with the counter in `shared`. Returns 1 if it is done.
static inline int64_t wg_act_part(const WgPart *part, int64_t begins, WgShared *shared, const WgObservation *seen,
                                  WgCommand *command)
{
    WgSituation now = wg_situation(part, shared, seen, command);
    if (begins != 0) {
        shared->counter = part->duration;
        if (part->does->begin != NULL) {
            part->does->begin(&now);
        }
    }
    int64_t done = part->does->action(&now);
    if (part->does->keeps_time == 0) {
        shared->counter -= 1.0;
        done = done != 0 || shared->counter <= 0.0;
    }
    return done;
}

// Lets one part act by priority and returns its index. If none applies, the robot stops and the
// result is -1.
//
// The part in charge keeps control until it is done. If it can be interrupted, a part of higher
// priority that applies takes over, and its own trigger restarts it if it allows that.
static inline int64_t wg_arbitrate(const WgPart *parts, int64_t count, WgShared *shared, const WgObservation *seen,
                                   WgCommand *command)
{
    int64_t active = (int64_t)shared->behaviour;
    int64_t chosen = active;
    int64_t begins = 0;
    wg_watch(parts, count, shared, seen, command);

    // The part in control. A trigger is only called if its answer can make a difference.
    if (active < 0 || parts[active].interruptible != 0.0) {
        chosen = -1;
        for (int64_t k = 0; k < count; k++) {
            if (chosen >= 0 && parts[k].priority <= parts[chosen].priority) {
                continue;
            }
            int64_t wants = 0;
            if (k != active || parts[k].does->restarts != 0) {
                WgSituation now = wg_situation(&parts[k], shared, seen, command);
                wants = parts[k].does->trigger(&now);
            }
            if (wants != 0 || k == active) {
                chosen = k;
                begins = wants;
            }
        }
    }
    if (chosen < 0) {
        shared->behaviour = WG_NO_BEHAVIOUR;
        return -1;
    }

    // What it does.
    shared->behaviour = (double)chosen;
    if (wg_act_part(&parts[chosen], begins, shared, seen, command) != 0) {
        shared->behaviour = WG_NO_BEHAVIOUR;
        shared->counter = 0.0;
    }
    return chosen;
}

#ifdef __cplusplus
}
#endif

#endif

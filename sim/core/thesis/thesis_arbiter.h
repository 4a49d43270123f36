// Decides which behaviour controls the thesis's robot, and what it does:
// a state machine without any geometry.
//
// wg_select_behaviour lets a behaviour take control; the caller then sets the new target heading if
// collide has just taken control, and checks whether the robot already points there.
// wg_run_behaviour lets the controlling behaviour act, and reports what the wheels do.
//
// The thesis's listing lacks the arbiter, so it is reconstructed from the prose. In reading A0 a
// behaviour keeps control until it gives it up, and acts in the same tick in which it took over. A1
// does not act in that tick; A2 acts first and then selects; A3 acts, selects and acts. In every
// tick A4 checks again if the behaviour in control would take control, and so restarts it; A6 does
// that only for collide. In A5 no behaviour has control for longer than a tick. WG_INTERRUPTIBLE is
// what the thesis proposes as further work: every tick decides again, and a collision restarts the
// escape whatever is in control; until then an escape, or a drive, continues.

#ifndef WG_THESIS_ARBITER_H
#define WG_THESIS_ARBITER_H

#include <stdbool.h>
#include <stdint.h>

// Behaviours.
enum { WG_IDLE = -1, WG_COLLIDE = 0, WG_SEEK = 1, WG_DRIVE = 2 };

// Readings of the arbiter.
enum { WG_A0 = 0, WG_A1, WG_A2, WG_A3, WG_A4, WG_A5, WG_A6, WG_INTERRUPTIBLE };

// Actions of the wheels: stop and turn towards the target heading; drive at the robot's speed;
// drive at the speed from before the collision; stop; keep the speed, whatever it is.
typedef enum WgWheels {
    WG_WHEELS_TURN,
    WG_WHEELS_GO,
    WG_WHEELS_RESUME,
    WG_WHEELS_HALT,
    WG_WHEELS_COAST
} WgWheels;

typedef struct WgCharge {
    int64_t behaviour;  // WG_IDLE if no behaviour has control
    int64_t ticks;     // its counter
    bool taken;        // 1 if it has just taken control
} WgCharge;

typedef struct WgAction {
    WgWheels wheels;
    int64_t behaviour;  // in control afterwards
    int64_t ticks;     // its counter
} WgAction;

// Lets a behaviour take control, asked in the order drive, seek, collide, if the reading allows it.
//
// reading:        of the arbiter.
// behaviour:      in control so far;
// ticks:          its counter.
// collision:      1 if the last move hit a wall.
// at_signal:      1 if the target heading is already the signal's direction.
// collide_ticks:  initial counter of collide;
// drive_ticks:    that of drive.
//
// If collide takes control, the caller remembers the speed, stops, and sets the target heading by
// its rule.
static inline WgCharge wg_select_behaviour(int64_t reading, int64_t behaviour, int64_t ticks,
                                           bool collision, bool at_signal, int64_t collide_ticks,
                                           int64_t drive_ticks)
{
    const WgCharge kept = {behaviour, ticks, false};
    const WgCharge collide = {WG_COLLIDE, collide_ticks, true};
    const WgCharge drive = {WG_DRIVE, drive_ticks, true};
    const WgCharge seek = {WG_SEEK, 0, true};
    if (reading == WG_INTERRUPTIBLE) {
        if (collision) {
            return collide;
        }
        if (behaviour == WG_COLLIDE || (behaviour == WG_DRIVE && ticks >= 0)) {
            return kept;
        }
    } else if (behaviour != WG_IDLE && reading != WG_A5) {
        if (collision && behaviour == WG_COLLIDE && (reading == WG_A4 || reading == WG_A6)) {
            return collide;
        }
        if (!collision && at_signal && behaviour == WG_DRIVE && reading == WG_A4) {
            return drive;
        }
        return kept;
    }
    if (collision) {
        return collide;
    }
    return at_signal ? drive : seek;
}

// Lets the controlling behaviour act.
//
// behaviour:  WG_COLLIDE, WG_SEEK (the caller has made the signal's direction its target) or
//             WG_DRIVE.
// ticks:      its counter.
// collision:  1 if the last move hit a wall.
// turned:     1 if the robot points along its target heading.
static inline WgAction wg_run_behaviour(int64_t behaviour, int64_t ticks, bool collision,
                                        bool turned)
{
    const WgAction gives_up = {WG_WHEELS_COAST, WG_IDLE, 0};
    if (behaviour == WG_DRIVE) {
        const WgAction drives = {WG_WHEELS_GO, WG_DRIVE, ticks - 1};
        return ticks >= 0 && !collision ? drives : gives_up;
    }
    if (!turned) {
        const WgAction turns = {WG_WHEELS_TURN, behaviour, ticks};
        return turns;
    }
    if (behaviour == WG_SEEK) {
        const WgAction arrives = {WG_WHEELS_HALT, WG_IDLE, 0};
        return arrives;
    }
    const WgAction resumes = {WG_WHEELS_RESUME, WG_COLLIDE, ticks - 1};
    return ticks >= 0 ? resumes : gives_up;
}

#endif

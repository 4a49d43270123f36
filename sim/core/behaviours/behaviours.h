// The library's behaviours, each defined once and shared by compositions and the thesis's robots.

#ifndef WG_BEHAVIOURS_H
#define WG_BEHAVIOURS_H

#include "wg_controllers.h"

// From the thesis: thesis_behaviours.c.
extern const WgBehaviour wg_collide;
extern const WgBehaviour wg_seek;
extern const WgBehaviour wg_drive_on;

// By touch: by_touch.c.
extern const WgBehaviour wg_avoid;
extern const WgBehaviour wg_follow_wall;

// By signal, by sight, and without any sense: by_sense.c.
extern const WgBehaviour wg_approach;
extern const WgBehaviour wg_escape;
extern const WgBehaviour wg_home;
extern const WgBehaviour wg_swerve;
extern const WgBehaviour wg_wander;

// Values of the first option of collide, its turn: the thesis's numbers for its rules.
enum { WG_TURN_RIGHT = 1, WG_TURN_LEFT = 2, WG_TURN_RANDOM = 3 };

#endif

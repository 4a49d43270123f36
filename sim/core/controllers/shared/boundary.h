// Following a wall by touch: what wall followers and bug algorithms share.
//
// The robot knows its position and the direction to the wall that it touched last. It *advances*
// along that wall, turned a little towards it, so that it slides on a flat wall and stays in touch
// around a corner. If it hits something else, it *presses* against its own wall again before it
// continues: the obstacle may be the far side of a passage hardly wider than the robot. Only if it
// then cannot move ahead at all does it turn to the other wall. If it loses its wall, it turns
// towards it step by step. So it follows the edge of the region that its centre can reach, and does
// not skip openings.
//
// A step is never longer than wg_stride, which is less than the robot's diameter.

#ifndef WG_BOUNDARY_H
#define WG_BOUNDARY_H

#include <stdbool.h>

#include "wg_controllers.h"

// Values of WgWallBody.phase.
static const double WG_ADVANCE = 0.0;
static const double WG_PRESS = 1.0;

// Length of a step along a wall, m.
double wg_stride(const WgObservation *seen);

// Commands a step of a length, m, in a world direction, rad, and records it.
void wg_drive(const WgObservation *seen, WgWallBody *body, WgCommand *command, double direction, double length);

// Commands a step straight to the target: a short one if the last step touched a wall, otherwise as
// long as possible.
void wg_head_for_target(const WgObservation *seen, WgWallBody *body, WgCommand *command);

// Returns true if a wall stopped, rather than deflected, the last step to the target, which was no
// longer than a stride.
//
// A wall that is no longer ahead has only deflected it, however far that step went: the disc has
// slid around it.
//
// far: distance to the target before the step, m.
bool wg_is_stopped(const WgObservation *seen, const WgWallBody *body, double far);

// Returns the world direction, rad, of the thing that the last step touched.
double wg_touched(const WgObservation *seen);

// Starts to follow a wall in a direction, rad, by pressing against it.
void wg_begin_following(WgWallBody *body, double wall);

// Processes the touch of the last step; returns true if it was the followed wall, which makes
// `wall` a measured direction.
bool wg_feel(const WgObservation *seen, WgWallBody *body);

// Returns true if the wall is no longer around the robot; only a world that changes can remove it.
bool wg_has_lost_it(const WgWallBody *body);

// Commands the next step along the wall.
void wg_follow(const WgObservation *seen, WgWallBody *body, WgCommand *command);

#endif

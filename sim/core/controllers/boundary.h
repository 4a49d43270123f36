// Following a wall by touch: what wall followers and bug algorithms share.
//
// The robot knows its position and, of the wall that it touched last, the direction to it. It *advances* along that
// wall, turned a little towards it, so that it slides on a flat wall and keeps in touch around a corner. Where it meets
// something else, it *presses* against its own wall again before it continues: what stopped it may be the far side of a
// passage hardly wider than itself. Only if it then cannot move ahead at all does it turn to the other wall. Where it
// loses its wall it turns towards it step by step. So it follows the edge of what its centre can reach, and skips no
// opening.
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

// Commands a step in a direction of the world, rad, of a length, m, and notes it.
void wg_drive(const WgObservation *seen, WgWallBody *body, WgCommand *command, double direction, double length);

// Commands a step straight to the target: a short one if the last touched a wall, else as long as can be.
void wg_head_for_target(const WgObservation *seen, WgWallBody *body, WgCommand *command);

// Whether a wall stopped the last step to the target, of a length not above a stride, rather than bent it.
//
// A wall that is not ahead any more has only bent it, however far that step came: the disc has slid around it.
//
// far: distance to the target before the step, m.
bool wg_is_stopped(const WgObservation *seen, const WgWallBody *body, double far);

// Direction of the world, rad, of what the last step touched.
double wg_touched(const WgObservation *seen);

// Takes up a wall in a direction, rad; it is pressed against first.
void wg_begin_following(WgWallBody *body, double wall);

// Takes in what the last step touched; whether that was the wall that is followed, so that `wall` was measured here.
bool wg_feel(const WgObservation *seen, WgWallBody *body);

// Whether the wall is nowhere around the robot any more: only a world that changes can take it away.
bool wg_has_lost_it(const WgWallBody *body);

// Commands the next step along the wall.
void wg_follow(const WgObservation *seen, WgWallBody *body, WgCommand *command);

#endif

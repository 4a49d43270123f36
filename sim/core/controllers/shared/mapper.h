// What controllers that drive like the mapper learn from it, and tell it.

#ifndef WG_MAPPER_H
#define WG_MAPPER_H

#include <stdbool.h>

#include "wg_controllers.h"

// Returns true if the last step felt for a wall and touched one, and sets the place that it touched, m.
// It must be called before the mapper acts.
bool wg_mapper_feels(const WgObservation *seen, const WgMapperMemory *own, double *x, double *y);

// Marks everything on the map that is too near to a place on a wall as blocked, once the mapper has
// acted.
//
// x, y:  the place, m.
// room:  distance within which there is no room for the robot, in radii.
void wg_mapper_learn(const WgObservation *seen, WgMapperMemory *own, double x, double y, double room);

#endif

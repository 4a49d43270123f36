// The faults, grouped by how the controller senses. Each is the controller's own act
// with one deviation around it.

#ifndef WG_FAULTS_INTERNAL_H
#define WG_FAULTS_INTERNAL_H

#include <stddef.h>

#include "directions.h"
#include "library.h"
#include "wg_faults.h"

extern const WgFault wg_faults_by_touch[];
extern const size_t wg_faults_by_touch_count;
extern const WgFault wg_faults_by_sight[];
extern const size_t wg_faults_by_sight_count;

// Numbers in a memory besides those of the controller without the fault.
#define WG_ROOM(with_fault, without) ((int64_t)((sizeof(with_fault) - sizeof(without)) / sizeof(double)))

// Makes the commanded turn the difference of two headings in [-pi, pi),
// as if it had not been wrapped.
static inline void wg_unwrap_turn(const WgObservation *seen, WgCommand *command)
{
    double turn = command->turn_rate * seen->time_step;
    if (seen->heading + turn > WG_PI) {
        command->turn_rate = (turn - 2.0 * WG_PI) / seen->time_step;
    }
}

#endif

// Random walk: legs of equal length in random directions; a wall ends a leg early.
//
// Source: Karl Pearson, "The problem of the random walk", Nature 72 (1905), p. 294.

#include "directions.h"
#include "library.h"

// m; shorter ones stay near the start for longer, longer ones follow walls
static const double LEG = 0.5;

void wg_random_walk_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgRandomWalkMemory *own = (WgRandomWalkMemory *)memory;
    if (seen->bump != 0.0 || own->left <= 0.0) {
        own->left = LEG;
        command->turn_rate = 2.0 * WG_PI * (seen->random - 0.5);
        command->turn_rate /= seen->time_step;
        command->used_random = 1.0;
    }
    double length = wg_lower(own->left, seen->top_speed * seen->time_step);
    own->left -= length;
    command->speed = length / seen->time_step;
}

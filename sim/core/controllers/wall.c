// Wall following: drives to the target until it touches a wall, and then keeps its hand on that
// wall forever.
//
// Source: the hand-on-wall rule, W. H. Matthews, "Mazes and Labyrinths: A General Account of Their
// History and Developments" (1922), on the solution of mazes; for robots V. J. Lumelsky and A. A.
// Stepanov, "Path-planning strategies for a point mobile automaton moving amidst unknown obstacles
// of arbitrary shape", Algorithmica 2 (1987), for the step from a wall at hand to the next one.

#include "boundary.h"
#include "library.h"

static const double GOAL = 0.0;
static const double WALL = 1.0;

void wg_wall_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgWallMemory *own = (WgWallMemory *)memory;
    if (own->mode == GOAL && seen->bump != 0.0) {
        own->mode = WALL;
        wg_begin_following(&own->body, wg_touched(seen));
    } else if (own->mode == WALL) {
        wg_feel(seen, &own->body);
        own->mode = wg_has_lost_it(&own->body) ? GOAL : WALL;
    }
    if (own->mode == WALL) {
        wg_follow(seen, &own->body, command);
    } else {
        wg_head_for_target(seen, &own->body, command);
    }
}

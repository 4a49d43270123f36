// The thesis's robot on the pose lattice: a composition of its three behaviours, in which the one
// that takes control keeps it until it is done.
//
// Source: the thesis on behaviour-based search and rescue robots that this program descends from
// (2005-2006), sections 3 and 4 and its listing; the arbiter is reconstructed from the prose, where
// the last in the list has the highest priority.

#include "behaviours.h"
#include "library.h"

enum { PARTS = 3 };

// As in the thesis: 6 steps of escape, 3 of drive.
static const double COLLIDE_TICKS = 5.0;
static const double DRIVE_TICKS = 2.0;

static void act(const WgObservation *seen, double *memory, WgCommand *command, double rule)
{
    const WgPart parts[PARTS] = {
        {.does = &wg_collide, .priority = 0.0, .duration = COLLIDE_TICKS, .options = &rule},
        {.does = &wg_seek, .priority = 1.0},
        {.does = &wg_drive_on, .priority = 2.0, .duration = DRIVE_TICKS},
    };
    wg_arbitrate(parts, PARTS, (WgShared *)memory, seen, command);
}

void wg_turn_right_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    act(seen, memory, command, WG_TURN_RIGHT);
}

void wg_turn_left_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    act(seen, memory, command, WG_TURN_LEFT);
}

void wg_turn_random_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    act(seen, memory, command, WG_TURN_RANDOM);
}

// What a seat does with a run in addition to running it.

#ifndef WG_LOOKS_PARTS_H
#define WG_LOOKS_PARTS_H

#include <stdbool.h>

#include "layouts.h"
#include "wg_looks.h"

// Draws the world of a run and packs it if a robot can surely reach the target; else returns false.
bool wg_look_open(WgSeat *seat, int64_t run);

// Notes what came of a run that has ended.
void wg_look_close(WgSeat *seat);

// Prepares the notes on a robot that loops, or that spent its budget, and continues for a while.
void wg_look_watch(WgSeat *seat);

// Whether a robot is watched for another step; notes its heading before that.
bool wg_look_goes_on(WgSeat *seat);

// Notes touches, turning, extent and progress of a step that was watched.
void wg_look_note_step(WgSeat *seat);

#endif

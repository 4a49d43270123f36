// The tasks of a seat in addition to running a controller.

#ifndef WG_LOOKS_PARTS_H
#define WG_LOOKS_PARTS_H

#include <stdbool.h>

#include "layouts.h"
#include "wg_looks.h"

// Draws the world of a run and packs it if a robot can certainly reach the target;
// otherwise returns false.
bool wg_look_open(WgSeat *seat, int64_t run);

// Notes the result of a run that has ended.
void wg_look_close(WgSeat *seat);

// Prepares the notes on a robot that loops, or has spent its budget,
// and is watched for further steps.
void wg_look_watch(WgSeat *seat);

// Returns true if a robot is watched for another step, and notes its heading before that step.
bool wg_look_goes_on(WgSeat *seat);

// Notes contacts, turning, extent and progress of a watched step.
void wg_look_note_step(WgSeat *seat);

#endif

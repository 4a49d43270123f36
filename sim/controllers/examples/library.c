// A controller in C, as fast as the simulator itself. Build it and try it with:
//
//     cc -std=c17 -O2 -shared -fPIC -I"$(worldgen --include)" example.c -o example.so
//     worldgen run w.grid --controller lib:./example.so:example --picture run.png

#include <math.h>

#include "worldgen_controller.h"

static const double PI = 3.14159265358979323846;
static const double TURN = 1.5;       // how far to turn after a bump, rad, counter-clockwise
// steps to drive straight on before heading for the target again
static const double PATIENCE = 20.0;

// All of its state. A static variable would hide state, and make proofs of loops wrong.
typedef struct Memory {
    double waiting;  // steps left to drive straight on
} Memory;

// Drive one step: head for the target, and after a bump turn away for a while.
static void example(const WgObservation *seen, double *memory, WgCommand *command)
{
    Memory *own = (Memory *)memory;

    // After a bump, turn away, and then drive straight on for some steps.
    double turn = 0.0;
    if (seen->bump != 0.0) {
        turn = TURN;
        own->waiting = PATIENCE;
    } else if (own->waiting > 0.0) {
        own->waiting -= 1.0;
    } else {
        // Turn towards the target, the shorter way around.
        turn = seen->target_heading - seen->heading;
        turn -= 2.0 * PI * floor((turn + PI) / (2.0 * PI));
    }

    // A turn rate of turn / time_step completes the turn within this step.
    command->speed = seen->top_speed;
    command->turn_rate = turn / seen->time_step;
}

// It senses the target's heading and what costs no time. For another sense, such as target_distance, add
// its WG_SENSE_ bit: a sense that is not declared is NaN. Without .senses, it senses everything.
WG_CONTROLLER(example, .memory_size = sizeof(Memory) / sizeof(double), .senses = WG_SENSE_TARGET_HEADING)

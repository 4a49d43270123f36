// A controller in C: as fast as the simulator itself. Build it, try it, change it, try it again:
//
//     cc -std=c17 -O2 -shared -fPIC -I"$(worldgen --include)" example.c -o example.so
//     worldgen run w.grid --controller lib:./example.so:example --trail run.png

#include <math.h>

#include "worldgen_controller.h"

static const double PI = 3.14159265358979323846;
static const double TURN = 1.5;       // rad, counter-clockwise, after each bump
static const double PATIENCE = 20.0;  // steps for which it drives on before it looks at the target again

// All of its state: a variable that outlives the function would make proofs of loops wrong.
typedef struct Memory {
    double waiting;  // steps still to drive on
} Memory;

// One step: drives to the target; after a bump turns away and drives straight on for a while.
static void example(const WgObservation *seen, double *memory, WgCommand *command)
{
    Memory *own = (Memory *)memory;
    double turn = 0.0;
    if (seen->bump != 0.0) {
        turn = TURN;
        own->waiting = PATIENCE;
    } else if (own->waiting > 0.0) {
        own->waiting -= 1.0;
    } else {
        turn = seen->target_heading - seen->heading;
        turn -= 2.0 * PI * floor((turn + PI) / (2.0 * PI));
    }
    command->speed = seen->top_speed;
    command->turn_rate = turn / seen->time_step;
}

WG_CONTROLLER(example, .memory_size = sizeof(Memory) / sizeof(double), .senses = WG_SENSE_TARGET_HEADING)

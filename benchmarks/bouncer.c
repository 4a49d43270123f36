// The controller of benchmarks/simulator.py in C: straight ahead, and after a bump on the spot for
// 5 to 24 steps.

#include <math.h>

#include "worldgen_controller.h"

static const double TOP_SPEED = 2.0;  // m/s
static const double TURN_RATE = 12.0; // rad/s

static void bouncer(const WgObservation *seen, double *memory, WgCommand *command)
{
    if (seen->bump != 0.0) {
        memory[0] = 5.0 + floor(seen->random * 20.0);
        command->used_random = 1.0;
    }
    if (memory[0] > 0.0) {
        memory[0] -= 1.0;
        command->turn_rate = TURN_RATE;
    } else {
        command->speed = TOP_SPEED;
    }
}

// The same with range beams, which it ignores.
static void eyes(const WgObservation *seen, double *memory, WgCommand *command)
{
    bouncer(seen, memory, command);
}

WG_CONTROLLER(bouncer, .memory_size = 1, .senses = WG_SENSE_RANDOM, .start_speed = 2.0)
WG_CONTROLLER(eyes, .memory_size = 1, .senses = WG_SENSE_RANDOM | WG_SENSE_BEAMS,
              .start_speed = 2.0)

// Controllers that misbehave; most drive to the target until they touch a wall.

#include <stdlib.h>

#include "worldgen_controller.h"

static void drive(const WgObservation *seen, WgCommand *command)
{
    command->speed = seen->top_speed;
    command->turn_rate = (seen->target_heading - seen->heading) / seen->time_step;
}

static void segfault(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)memory;
    drive(seen, command);
    if (seen->bump != 0.0) {
        *(volatile int *)0 = 1;
    }
}

static void give_up(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)memory;
    drive(seen, command);
    if (seen->bump != 0.0) {
        abort();
    }
}

// Keeps count in a variable of its own, as no controller should:
// it fails in the 5000th step of a process.
static void wear_out(const WgObservation *seen, double *memory, WgCommand *command)
{
    static int steps;
    (void)memory;
    drive(seen, command);
    if (++steps == 5000) {
        abort();
    }
}

static void hang(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, command);
    while (seen->bump != 0.0) {
        ((volatile double *)memory)[0] += 1.0;
    }
}

static void complain(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)memory;
    drive(seen, command);
    if (seen->bump != 0.0) {
        command->error = "lost the map";
    }
}

// Like segfault, but reports that it has failed.
static void own_up(const WgObservation *seen, double *memory, WgCommand *command)
{
    complain(seen, memory, command);
}

// Turns on the spot and counts its steps, so that no state recurs.
static void count_steps(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)seen;
    memory[0] += 1.0;
    command->turn_rate = 1.0;
}

static void begin(double *memory)
{
    memory[1] = 0.25;
}

WG_CONTROLLER(segfault, .memory_size = 1, .senses = WG_SENSE_TARGET_HEADING)
WG_CONTROLLER(give_up, .memory_size = 1, .senses = WG_SENSE_TARGET_HEADING)
WG_CONTROLLER(wear_out, .memory_size = 1, .senses = WG_SENSE_TARGET_HEADING)
WG_CONTROLLER(hang, .memory_size = 1, .senses = WG_SENSE_TARGET_HEADING)
WG_CONTROLLER(own_up, .memory_size = 1, .senses = WG_SENSE_TARGET_HEADING)
WG_CONTROLLER(count_steps, .memory_size = 1, .senses = WG_SENSE_NOTHING_ELSE)
WG_CONTROLLER(complain, .reset = begin, .memory_size = 2, .beams = 12, .beam_range = 0.5, .start_speed = 0.1)

// Not declared as a controller.
WG_EXPORT int alone(void)
{
    return 0;
}

static const WgControllerInfo OTHER_VERSION = {.abi = 99, .size = sizeof(WgControllerInfo), .act = complain};
static const WgControllerInfo OTHER_SIZE = {.abi = WG_CONTROLLER_ABI, .size = 8, .act = complain};
static const WgControllerInfo OTHER_SENSES = {
    .abi = WG_CONTROLLER_ABI, .size = sizeof(WgControllerInfo), .act = complain, .senses = 1 << 20};

WG_EXPORT const WgControllerInfo *old_controller(void)
{
    return &OTHER_VERSION;
}

WG_EXPORT const WgControllerInfo *small_controller(void)
{
    return &OTHER_SIZE;
}

WG_EXPORT const WgControllerInfo *clairvoyant_controller(void)
{
    return &OTHER_SENSES;
}

// Controllers that do whatever a library can do to the program that loads it. Most drive to the
// target, and misbehave in every step in which they touch a wall.

#define _GNU_SOURCE

#include <fenv.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "worldgen_controller.h"

static void drive(const WgObservation *seen, WgCommand *command)
{
    command->speed = seen->top_speed;
    command->turn_rate = (seen->target_heading - seen->heading) / seen->time_step;
}

// Defines the controller `name`, which drives and then does something if it touches a wall.
#define MISBEHAVES(name, ...)                                                              \
    static void name(const WgObservation *seen, double *memory, WgCommand *command)        \
    {                                                                                      \
        drive(seen, command);                                                              \
        if (seen->bump != 0.0) {                                                           \
            __VA_ARGS__                                                                    \
        }                                                                                  \
        (void)memory;                                                                      \
    }                                                                                      \
    WG_CONTROLLER(name, .memory_size = 3, .senses = WG_SENSE_TARGET_HEADING)

// Defines the controller `name`, whose reset does something.
#define RESET(name, ...)                                                                   \
    static void name(const WgObservation *seen, double *memory, WgCommand *command)        \
    {                                                                                      \
        (void)memory;                                                                      \
        drive(seen, command);                                                              \
    }                                                                                      \
    static void name##_reset(double *memory)                                               \
    {                                                                                      \
        volatile double *own = memory;                                                     \
        own[0] = 1.0;                                                                      \
        __VA_ARGS__                                                                        \
    }                                                                                      \
    WG_CONTROLLER(name, .reset = name##_reset, .memory_size = 3, .senses = WG_SENSE_TARGET_HEADING)

#define WRITE(at) ((volatile double *)memory)[at] = 7.5

static volatile int zero;

static int recurse(int depth)
{
    volatile char page[4096];
    page[depth % 4096] = (char)depth;
    return zero != 0 ? 0 : recurse(depth + 1) + page[0];
}

static void smash(volatile char *end)
{
    char small[8];
    volatile char *byte = small;
    for (int k = 0; k < 256; k++) {
        byte[k] = (char)k;
    }
    *end = small[0];
}

MISBEHAVES(behaves, )
MISBEHAVES(segfault, *(volatile int *)(uintptr_t)zero = 1;)
MISBEHAVES(aborts, abort();)
MISBEHAVES(exits, exit(0);)
MISBEHAVES(quits, _exit(3);)
MISBEHAVES(terminates, raise(SIGTERM);)
MISBEHAVES(sends_segv, raise(SIGSEGV);)
MISBEHAVES(overflows_stack, command->speed = recurse(0);)
MISBEHAVES(smashes_stack, char byte; smash(&byte);)
MISBEHAVES(never_returns, for (;;) { WRITE(0); })
MISBEHAVES(sleeps, for (;;) { pause(); })
MISBEHAVES(stops, raise(SIGSTOP);)
MISBEHAVES(says_nan, command->speed = (double)NAN;)
MISBEHAVES(says_inf, command->turn_rate = -(double)INFINITY;)
MISBEHAVES(writes_before, WRITE(-1);)
MISBEHAVES(writes_state, WRITE(-5);)
MISBEHAVES(writes_further_before, WRITE(-9);)
MISBEHAVES(writes_far_before, WRITE(-3000);)
MISBEHAVES(writes_after, WRITE(3);)
MISBEHAVES(writes_far_after, WRITE(100000);)
MISBEHAVES(reads_after, WRITE(0); command->speed = memory[3 + zero];)
MISBEHAVES(writes_command_before, ((volatile double *)command)[-1] = 7.5;)
MISBEHAVES(writes_command_after, ((volatile double *)command)[5] = 7.5;)
MISBEHAVES(writes_observation, ((volatile WgObservation *)(uintptr_t)seen)->time_step = 7.5;)
MISBEHAVES(complains_nowhere, command->error = (const char *)(uintptr_t)(8 + zero);)
MISBEHAVES(closes_all, for (int k = 0; k < 256; k++) { close(k); })
MISBEHAVES(closes_all_and_waits, for (int k = 0; k < 256; k++) { close(k); } for (;;) { pause(); })
// These do no harm.
MISBEHAVES(closes, close(0); close(1); close(2);)
MISBEHAVES(prints, printf("on stdout\n"); fflush(stdout); fprintf(stderr, "on stderr\n");)
MISBEHAVES(prints_part, printf("on stdout");)
MISBEHAVES(prints_and_faults, printf("on stdout\n"); *(volatile int *)(uintptr_t)zero = 1;)
MISBEHAVES(rounds_up, fesetround(FE_UPWARD);)
MISBEHAVES(traps, feenableexcept(FE_INEXACT);)

RESET(reset_behaves, )
RESET(reset_segfault, *(volatile int *)(uintptr_t)zero = 1;)
RESET(reset_aborts, abort();)
RESET(reset_exits, exit(0);)
RESET(reset_never_returns, for (;;) { own[0] += 1.0; })
RESET(reset_writes_before, own[-1] = 7.5;)
RESET(reset_writes_far_before, own[-3000] = 7.5;)
RESET(reset_writes_after, own[3] = 7.5;)
RESET(reset_writes_far_after, own[100000] = 7.5;)
RESET(reset_prints, printf("on stdout\n"); fflush(stdout);)
RESET(reset_says_nan, own[1] = (double)NAN;)

// A description that changes whenever it is asked for.
static void grow(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, command);
    memory[0] += 1.0;
}

WG_EXPORT const WgControllerInfo *grow_controller(void)
{
    static WgControllerInfo info = {.abi = WG_CONTROLLER_ABI, .size = sizeof info, .act = grow, .memory_size = 1};
    info.memory_size += 5;
    return &info;
}

// A library that cannot even be asked.
WG_EXPORT const WgControllerInfo *bursts_controller(void)
{
    abort();
}

WG_EXPORT const WgControllerInfo *ponders_controller(void)
{
    for (;;) {
        zero = 0;
    }
}

// Runs a controller that is a Python object: the loop of an episode, through Python's stable ABI.

#ifndef WG_PYTHON_ACT_H
#define WG_PYTHON_ACT_H

#include <stdint.h>

#include "wg_episode.h"

// Takes the answer of a controller, if it had to act; then runs until it must act again,
// WG_ACTS, or WG_OVER.
typedef int64_t (*WgStop)(void *subject);

// A run whose controller acts in Python.
typedef struct WgActing {
    WgStop stop;
    void *subject;       // argument of `stop`
    WgEpisode *episode;  // buffers of the controller
    int64_t calls;       // calls of the controller so far
    int64_t every;       // one call in this many is measured
    int64_t over;        // 1 once `stop` has returned WG_OVER
} WgActing;

// wg_episode_step as a WgStop, of a WgEpisode.
int64_t wg_episode_stop(void *subject);

// Lets the controller act at most this many times, or until the run is over. Arguments and result
// are Python objects, so the caller must hold Python's lock: call it by its address, as ctypes does
// with PYFUNCTYPE.
//
// tools:  a tuple of nine: the controller's function; the same measured, for the first call; the
//         same measured, for one call in `every`; tuple.__new__; the types Observation, Command,
//         tuple and float; and a function that takes an answer in any other form and the size of
//         the memory, and returns speed, turn rate, whether the random number was used, and the
//         memory, all as floats in one tuple, or raises.
// memory: a tuple of floats.
//
// Returns the memory after the last call, a new reference; NULL after an exception.
void *wg_act_in_python(WgActing *acting, void *tools, void *memory, int64_t most);

#endif

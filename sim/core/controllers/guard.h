// A controller in a process of its own: what crashes or hangs there ends a run, not the program that made it.
//
// Two processes share a WgGuard. The owner calls wg_guarded_act(slot), which hands the observation and the memory over
// and waits for the command. The server forks a worker that calls the controller; when a worker dies, the server says
// how and forks the next. So a step costs two handovers instead of two messages, and no start of a process.

#ifndef WG_GUARD_H
#define WG_GUARD_H

#include <stdatomic.h>
#include <stdint.h>

#include "wg_controllers.h"

enum {
    WG_LONGEST_ERROR = 256,  // bytes of what a controller says is wrong, with the zero at its end
};

// Whose turn it is.
enum { WG_NOBODY = 0, WG_WORKER = 1, WG_ANSWERED = 2, WG_ENDED = 3 };

struct WgGuard {
    _Atomic uint32_t turn;
    _Atomic uint32_t sleepers;  // processes that the kernel wakes when the turn changes
    _Atomic uint32_t ready;     // 1 once a worker has waited for its first turn
    _Atomic int64_t worker;     // its process
    int64_t owner;              // process that the server serves; it ends with it
    int64_t status;             // of the worker that ended, as waitpid says
    int64_t memory_size;
    WgObservation seen;
    double beams[WG_MOST_BEAMS];
    WgCommand command;
    int64_t has_error;
    char error[WG_LONGEST_ERROR];
    double memory[];
};

#endif

// Calls of the core in another process, so that a controller that crashes or hangs ends a run,
// not the program.
//
// wg_guard_start forks a process that waits for a byte, makes the call described in shared memory,
// and answers with a byte. Everything that a call works on is in memory that both processes share,
// so if the process dies in the middle, the owner finds the state from before the controller's
// call, and can report the step and the run. Not on Windows.

#ifndef WG_GUARD_H
#define WG_GUARD_H

#include <stdint.h>

#include "wg_episode.h"

enum {
    WG_CALL_OBJECTS = 8,
    WG_LONGEST_ERROR = 256,  // bytes of a controller's error message, with its terminating zero
};

typedef struct WgCall WgCall;

// Makes a call with the core's own function.
typedef int64_t (*WgWork)(const WgCall *call);

struct WgCall {
    WgWork work;
    void *objects[8];        // the function's pointer arguments, in order
    int64_t number;          // the function's number argument
    const WgReport *report;  // report of the current run; NULL if there is none
    int64_t result;          // filled: the function's return value
    int64_t has_error;       // filled: 1 if the last run's controller left a message
    char error[256];         // filled: the message
};

// Forks the process that makes the calls, which ends with its owner: it reads from `asked`, and
// writes to `answered`. Returns its number; -1 if there is none.
int64_t wg_guard_start(WgCall *call, int asked, int answered);

// Processor time of a process, s; -1 if the system does not report it.
double wg_guard_seconds(int64_t process);

// The functions that can be called.
int64_t wg_call_run(const WgCall *call);         // wg_episode_run
int64_t wg_call_run_many(const WgCall *call);    // wg_run_many
int64_t wg_call_first_edit(const WgCall *call);  // wg_first_edit; the grid as a pointer
int64_t wg_call_outcomes(const WgCall *call);    // wg_outcomes

#endif

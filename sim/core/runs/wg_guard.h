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
#include "wg_fleet.h"

enum { WG_CALL_OBJECTS = 8 };

typedef struct WgCall WgCall;

// Makes a call with the core's own function.
typedef int64_t (*WgWork)(const WgCall *call);

struct WgCall {
    WgWork work;
    void *objects[8];        // the function's pointer arguments, in order
    int64_t number;          // the function's number argument
    int64_t result;          // filled: the function's return value
    int64_t done;            // filled: 1 once the function has returned
    // filled: the address that could not be used, if that ended the process; else 0
    uint64_t fault;
};

// The system's dlopen and dlsym. They come from Python, so that nothing needs to be linked for them.
typedef void *(*WgOpen)(const char *file, int flags);
typedef void *(*WgFind)(void *library, const char *name);

// A library and its function that describes a controller.
typedef struct WgOffer {
    WgOpen open;
    WgFind find;
    int64_t flags;  // for `open`
    const char *file;
    const char *function;
} WgOffer;

// Forks the process that makes the calls, which ends with its owner: it reads from `asked`, and
// writes to `answered`. Returns its number; -1 if there is none.
int64_t wg_guard_start(WgCall *call, int asked, int answered);

// Processor time of a process, s; -1 if the system does not report it.
double wg_guard_seconds(int64_t process);

// Returns the size of a page, bytes, which the sizes of fenced pages must be a multiple of.
int64_t wg_page_size(void);

// Returns new pages that this process shares with those that it forks, in two parts of these sizes.
// Before, between and after them are `fence` bytes that no process can touch. They are never
// released. Returns NULL if memory runs out.
void *wg_map_fenced(int64_t fence, int64_t first_size, int64_t second_size);

// The functions that can be called.
int64_t wg_call_run(const WgCall *call);         // wg_episode_run
int64_t wg_call_batch(const WgCall *call);       // wg_batch_run
int64_t wg_call_first_edit(const WgCall *call);  // wg_first_edit; the grid as a pointer
int64_t wg_call_fleet(const WgCall *call);       // wg_fleet_run
int64_t wg_call_reset(const WgCall *call);       // wg_cage_reset; the function as a WgReset *
// Loads the library of a WgOffer, and asks for the description of the controller.
int64_t wg_call_offer(const WgCall *call);

#endif

// Many runs in one call: of one world from many starts, of edited copies of a world, or of one step
// from many states.
//
// Each takes an episode with the caller's own arena and settings, and modifies them.

#ifndef WG_RUNS_H
#define WG_RUNS_H

#include <stdint.h>

#include "wg_episode.h"
#include "wg_parts.h"

// A start. As rows of (n, 3) int64 in Python.
typedef struct WgStart {
    int64_t x;  // lattice units
    int64_t y;
    int64_t heading;  // heading units
} WgStart;

// batch.c

// A run from its start to its verdict. It takes up to three passes of its episode: the first seeks a
// recurrence, by fingerprints; the second proves it, up to the end of its first period; and if two
// different states only had the same fingerprint, a third runs until the budget is spent.
typedef struct WgRun {
    WgEpisode *episode;
    WgSettings *settings;  // the episode's own; each pass changes the steps and the search for loops
    const WgArena *fresh;  // the surroundings before the first event; not changed
    int64_t budget;        // steps
    int64_t find_loop;     // of the first pass: WG_SEEK_LOOP, or WG_NO_LOOP for a single pass
} WgRun;

// Begins the first pass.
WgStatus wg_run_begin(const WgRun *run);

// Call it when the episode is over. Begins the next pass and returns true, or returns false if the
// episode's report is that of the run.
bool wg_run_goes_on(const WgRun *run);

// Runs of one controller in one world, one after another.
typedef struct WgBatch {
    WgRun run;              // whose start and seed are those of each run in turn
    const WgStart *starts;  // (count,)
    const uint64_t *seeds;  // (count,)
    WgReport *reports;      // (count,) filled
    int64_t count;
    int64_t at;             // index of the next run, or of the one that is running
    int64_t running;        // 1 if one is
    int64_t status;         // WG_OK, or why the batch ended before its last run
} WgBatch;

// Continues a batch for at most this many steps, and for about a quarter of a second. Returns
// WG_OVER after the last run, and after a crash.
int64_t wg_batch_run(WgBatch *batch, int64_t most_steps);

// edits.c

// The effect of an edit on the grid.
enum {
    WG_FREE_BOX = 0,      // ix, iy, width, height: the solid cells in this box become free
    WG_FREE_RUN = 1,      // first, count: this many of the solid cells, in row order
    WG_FREE_RIM = 2,      // the outermost cells
    WG_DROP_ROWS = 3,     // first, count; rows above move down
    WG_DROP_COLUMNS = 4,  // first, count; columns to the right move left
};

// As rows of (n, 5) int64 in Python.
typedef struct WgEdit {
    int64_t kind;
    int64_t a;
    int64_t b;
    int64_t c;
    int64_t d;
} WgEdit;

// WgWanted.ending for a run that ends as WG_LIMIT, WG_REACHED or WG_LOOP.
enum { WG_ANY_ENDING = -1 };

// The requirements on the edited worlds.
typedef struct WgWanted {
    int64_t ending;   // WG_LIMIT, ... or WG_ANY_ENDING
    int64_t overlap;  // 1: with an overlap; 0: without; -1: it does not matter
    int64_t by_way;   // 1: the target must certainly be reachable after an edit that moves cells
    // steps after which to return, even in the middle of a run, so that Ctrl-C is noticed
    int64_t steps;
} WgWanted;

// The progress so far.
typedef struct WgTried {
    int64_t next;     // index of the edit at which to continue
    int64_t runs;
    int64_t found;    // 1: the edit before `next` is the one searched for
    // 1: the run of the edit before `next` is not over; the next call continues it
    int64_t running;
} WgTried;

// Tries edits, starting with tried->next, until one is found or wanted->steps steps are done. A run
// that was not over after the last call continues first, so the memory behind the arguments must
// not change in between.
//
// settings:  those of the episode, whose arena has the shape after the edits and its events.
// before:    those of the world before the edit, with the world's start.
// old:       the cells before the edit, at time 0.
// edits:     (count,) all of the arena's shape.
WgStatus wg_first_edit(WgEpisode *episode, WgSettings *settings, const WgSettings *before, WgGrid old,
                       const WgEdit *edits, int64_t count, const WgWanted *wanted, WgTried *tried);

// sensed.c

// Computes the senses of a controller that walls determine, except contact, at each of many poses.
//
// seen:  (count, 17 + beams) filled; 0 for senses that are off.
WgStatus wg_sensed_of_walls(const WgArena *arena, const WgSettings *settings, const WgStart *poses, int64_t count,
                            double *seen);

// lockstep.c: many robots in lockstep, whose controller acts for all of them at once,
// outside the core

// Makes an episode for each robot and begins its run; wg_lockstep_free frees them, also after a
// failure.
//
// arenas:      (count,)
// controller:  without a function
// runs:        (count,) all but the episodes, which are NULL
WgStatus wg_lockstep_new(const WgArena *arenas, const WgController *controller, WgRun *runs, int64_t count);

void wg_lockstep_free(WgRun *runs, int64_t count);

// Applies the commands of the robots in the first slots, and runs each until it must act again, or
// its run ends. Those that must act move up to the first slots, in order; in the first call no robot
// has acted yet.
//
// slots:         (count,) runs
// commands:      (count, 3) speed, turn rate, and whether the random number was used
// after:         (count, memory) the robots' memories, in the controller's layout
// observations:  (count, 17 + beams, and 1 for a declared goal's heading) filled for the slots that act
// memories:      (count, memory) same
//
// Returns how many slots act.
int64_t wg_lockstep_step(WgRun **slots, int64_t count, const double *commands, const double *after,
                         double *observations, double *memories);

#endif

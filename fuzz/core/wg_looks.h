// First looks: many worlds from layout bytes, each with one run of a controller.
//
// A seat holds one robot and its world. A controller that is a C function runs in one seat, world after
// world (wg_looks_run). For others the core stops wherever the controller is to act: one seat for a
// controller that drives one robot (wg_seat_step), many for one that drives many at once
// (wg_seats_act). Arrays belong to the caller and must outlive the seats.

#ifndef WG_LOOKS_H
#define WG_LOOKS_H

#include <stdbool.h>
#include <stdint.h>

#include "wg_episode.h"
#include "wg_guard.h"
#include "wg_parts.h"

// WgReport.ending of a look without a run: the flood found no path.
enum { WG_NOT_RUN = -1 };

// Kinds of contact, the one that says most first.
enum {
    WG_NOOK = 0,
    WG_END = 1,
    WG_POST = 2,
    WG_EDGE = 3,
    WG_FACE = 4,
    WG_NO_CONTACT = 5,
};

// A clearance of that many cells, or more.
enum { WG_FAR = 3 };

// What came of a run.
typedef struct WgLook {
    WgReport report;
    int64_t distance; // cells of a path to the target, an upper bound; -1: none was found
    int64_t budget;   // steps
    int64_t width;    // cells
    int64_t height;
    int64_t solid;           // solid cells
    int64_t straight_sq;     // squared distance of start and target, cells
    int64_t visited;         // cells that the centre was in
    int64_t least_clearance; // least chessboard distance of such a cell to a solid one, at most WG_FAR
    int64_t clearances;      // sum of all these distances
    int64_t watched;         // further steps: one period of a loop
    int64_t bumps;           // times that a wall was begun to be touched in these
    int64_t turned;          // net turn in these, heading units
    int64_t left;            // least and greatest x of the centre in these, lattice units
    int64_t right;
    int64_t low; // the same of y
    int64_t high;
    int64_t contact; // of the walls touched in these, the kind that says most
    int64_t closer;  // 1 if these come closer to the target than the start is
    int64_t around;  // solid cells that share an edge with the one that was hit; -1: none was
} WgLook;

// How many steps a run gets that has no budget of its own, and for how many it is watched after that.
typedef struct WgPatience {
    int64_t multiple; // of the time that the path takes at top speed
    int64_t fewest;
    int64_t most;
    int64_t watched; // of a run that spent its budget
} WgPatience;

// Runs, and what came of them.
typedef struct WgLooks {
    const uint8_t *layouts; // (count, layout_bytes)
    int64_t layout_bytes;   // 56 for layouts, 59 for scenes
    int64_t count;
    const uint64_t *seeds;      // (count,)
    const int64_t *kinds;       // (count,) which of the settings
    const int64_t *budgets;     // (count,) steps; 0 for some that the path to the target suggests
    const WgSettings *settings; // (setting_count,) of each time step, for any start
    int64_t setting_count;
    const WgDisc *discs; // (radius_count,) of each radius of a scene's robot
    const double *radii; // (radius_count,) the same in m
    int64_t radius_count;
    const int64_t *targets; // (target_count,) squared radii of a scene's targets, lattice units
    int64_t target_count;
    const int64_t *headings; // the table of wg_heading_table
    const WgRay *rays;       // (8193,) the table of wg_ray_table
    WgPatience patience;
    WgLook *looks; // (count,) filled
    int64_t at;    // the run that comes next, or that is under way
} WgLooks;

// A robot in a world of its own.
typedef struct WgSeat {
    WgLooks *looks;
    WgEpisode *episode;
    WgArena *arena;
    WgSettings *settings;
    int32_t *clearance; // what arena->clearance points to where it is needed
    uint16_t *runs;     // the same for arena->runs
    int64_t *spread;    // the same for arena->spread
    int64_t number; // for its owner
    int64_t run;    // -1: it has no world
    int64_t watch;  // steps for which it is watched; -1 before its run is over
    int64_t fresh;  // 1 until the controller has acted in this world
    int64_t heading; // before the next step, of a robot that is watched
    int64_t touched; // 1 if it touched a wall then
} WgSeat;

// The most steps that a run can have.
int64_t wg_looks_longest(const WgLooks *looks);

// Makes a seat without a world. The controller's memory at reset is read whenever a run begins.
WgStatus wg_seat_new(WgLooks *looks, const WgController *controller, WgSeat **made);

void wg_seat_free(WgSeat *seat);

// The same in memory of the caller's: the bytes of three blocks, of which the first two are all zero.
WgStatus wg_seat_sizes(const WgLooks *looks, const WgController *controller, int64_t sizes[3]);

// Makes a seat in such blocks. Nothing of it is to be freed.
WgSeat *wg_seat_place(void *const blocks[3], WgLooks *looks, const WgController *controller);

// Draws worlds from run `at` on, up to the next in which a robot can surely reach the target, and makes
// it the seat's. Returns its number, which `at` is then; -1 if none is left.
int64_t wg_seat_next(WgSeat *seat);

// Makes a run's world the seat's, whatever the run that comes next. Returns false if no path was found.
bool wg_seat_open(WgSeat *seat, int64_t run);

// Puts the robot at its start.
WgStatus wg_seat_begin(WgSeat *seat);

// Applies the command if the controller was to act, and continues until it is to act again, WG_ACTS, or the
// run is noted, WG_OVER. seat->watch says whether the robot is only watched.
int64_t wg_seat_step(WgSeat *seat);

// The same as a WgStop, of a WgSeat.
int64_t wg_seat_stop(void *subject);

// For a controller that is a C function: runs from `at` on, so many steps or little more. Returns WG_OVER
// when all runs are noted, else WG_GOES_ON.
int64_t wg_looks_run(WgSeat *seat, int64_t most_steps);

// The same as a call in another process: seat, and the steps.
int64_t wg_call_looks(const WgCall *call);

// Notes that the controller has failed in the run under way, after the process that ran it has ended. Returns false if
// no run was under way.
bool wg_looks_fail(WgSeat *seat);

// Gives each seat the next world, in order. Those with a robot that is to act come first then; returns
// how many.
int64_t wg_seats_board(WgSeat **seats, int64_t count);

// Copies what the first `count` seats sense, and their memories.
//
// observations: (count, 17 + beams)
// memories:     (count, memory)
// numbers:      (count,) of the seats
// fresh:        (count,) 1 before the first act in a world
void wg_seats_sense(WgSeat **seats, int64_t count, double *observations, double *memories,
                    int64_t *numbers, uint8_t *fresh);

// Lets the first `count` seats continue with commands and memories, each up to where its controller is to
// act again, in the next world if its run is over. Seats without a world come last; returns how many have one.
//
// commands: (count, 3) speed, turn rate, and whether the random number was used.
int64_t wg_seats_act(WgSeat **seats, int64_t count, const double *commands, const double *memories);

// For tests: draws a layout into the arena of a seat, and notes what can be said of its world. Returns how
// many cells are solid.
int64_t wg_look_draw(const uint8_t *layout, WgSeat *seat, WgLook *look);

#endif

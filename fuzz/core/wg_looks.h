// Screening: many worlds from layout bytes, each with one run of a controller.
//
// A seat holds one robot and its world. A controller that is a C function runs in one seat, in one
// world after another (wg_looks_run). For others the core stops wherever the controller must act:
// with one seat for a controller that drives one robot (wg_seat_step), with many for one that
// drives many at the same time (wg_seats_act). Arrays belong to the caller
// and must outlive the seats.

#ifndef WG_LOOKS_H
#define WG_LOOKS_H

#include <stdbool.h>
#include <stdint.h>

#include "wg_episode.h"
#include "wg_guard.h"
#include "wg_parts.h"

// Value of WgReport.ending without a run, because the flood found no path.
enum { WG_NOT_RUN = -1 };

// Kinds of contact, the most specific first.
enum {
    WG_NOOK = 0,
    WG_END = 1,
    WG_POST = 2,
    WG_EDGE = 3,
    WG_FACE = 4,
    WG_NO_CONTACT = 5,
};

// A clearance of this many cells or more.
enum { WG_FAR = 3 };

// The result of a run.
typedef struct WgLook {
    WgReport report;
    int64_t distance; // cells of a path to the target, an upper bound; -1 if none was found
    int64_t budget;   // steps
    int64_t width;    // cells
    int64_t height;
    int64_t solid;           // solid cells
    int64_t straight_sq;     // squared distance between start and target, cells
    int64_t visited;         // cells that the centre was in
    // sum of their chessboard distances to a solid cell, each at most WG_FAR
    int64_t clearances;
    int64_t watched;         // further steps: one period of a loop
    int64_t bumps;           // number of contacts with a wall that began in these
    int64_t turned;          // net turn in these, heading units
    int64_t left;            // smallest and largest x of the centre in these, lattice units
    int64_t right;
    int64_t low; // the same of y
    int64_t high;
    int64_t contact; // most specific kind of wall touched in these
    int64_t closer;  // 1 if these get closer to the target than the start is
    int64_t around;  // solid cells that share an edge with the one that was hit; -1 if none was hit
} WgLook;

// The budget of runs that don't set one, and the length of the watch after that.
typedef struct WgPatience {
    int64_t multiple; // multiple of the time that the path takes at top speed
    int64_t fewest;
    int64_t most;
    int64_t watched; // steps for a run that spent its budget
} WgPatience;

// A batch of runs, and their results.
typedef struct WgLooks {
    const uint8_t *layouts; // (count, layout_bytes)
    int64_t layout_bytes;   // 56 for layouts, 59 for scenes
    int64_t count;
    const uint64_t *seeds;      // (count,)
    const int64_t *kinds;       // (count,) index of the settings to use
    const int64_t *budgets;     // (count,) steps; 0 to derive them from the path to the target
    const WgSettings *settings; // (setting_count,) one per time step, for any start
    int64_t setting_count;
    const WgDisc *discs; // (radius_count,) for each radius of a scene's robot
    const double *radii; // (radius_count,) the same in m
    int64_t radius_count;
    // Reach of the disc for which a path must be wide enough, lattice units; 0 for the robot's own.
    int64_t flood_reach;
    const int64_t *targets; // (target_count,) squared radii of a scene's targets, lattice units
    int64_t target_count;
    const int64_t *headings; // the table of wg_heading_table
    const WgRay *rays;       // (8193,) the table of wg_ray_table
    WgPatience patience;
    WgLook *looks; // (count,) filled by the runs
    int64_t at;    // the next run, or the current one
} WgLooks;

// A robot in its own world.
typedef struct WgSeat {
    WgLooks *looks;
    WgEpisode *episode;
    WgArena *arena;
    WgSettings *settings;
    int32_t *clearance; // target of arena->clearance, if that is needed
    uint16_t *runs;     // the same for arena->runs
    int64_t *spread;    // the same for arena->spread
    int64_t number; // for the caller's use
    int64_t run;    // -1 without a world
    int64_t watch;  // steps for which it is watched; -1 before its run has ended
    int64_t fresh;  // 1 until the controller has acted in this world
    int64_t heading; // heading of a watched robot before the next step
    int64_t touched; // 1 if it touched a wall then
} WgSeat;

// Returns the maximum number of steps of a run.
int64_t wg_looks_longest(const WgLooks *looks);

// Makes a seat without a world. The controller's memory at reset is read whenever a run begins.
WgStatus wg_seat_new(WgLooks *looks, const WgController *controller, WgSeat **made);

void wg_seat_free(WgSeat *seat);

// For memory of the caller: returns the sizes of three blocks in bytes;
// the first two must contain zeros.
WgStatus wg_seat_sizes(const WgLooks *looks, const WgController *controller, int64_t sizes[3]);

// Makes a seat in such blocks. Nothing in it needs to be freed.
WgSeat *wg_seat_place(void *const blocks[3], WgLooks *looks, const WgController *controller);

// Draws worlds from run `at` on, up to the next in which a robot can certainly reach the target,
// and gives it to the seat. Returns its number, which is then the value of `at`;
// -1 if no run is left.
int64_t wg_seat_next(WgSeat *seat);

// Gives a run's world to the seat, without changing the next run.
// Returns false if no path was found.
bool wg_seat_open(WgSeat *seat, int64_t run);

// Puts the robot at its start.
WgStatus wg_seat_begin(WgSeat *seat);

// Applies the command if the controller had to act, and continues until it must act again (WG_ACTS)
// or the run is noted (WG_OVER). seat->watch tells whether the robot is only watched.
int64_t wg_seat_step(WgSeat *seat);

// Is a WgStop; its subject is a WgSeat.
int64_t wg_seat_stop(void *subject);

// For a controller that is a C function: starts at run `at` and takes this many steps or slightly
// more. Returns WG_OVER when all runs are noted, else WG_GOES_ON.
int64_t wg_looks_run(WgSeat *seat, int64_t most_steps);

// Does the same in another process; takes a seat and the number of steps.
int64_t wg_call_looks(const WgCall *call);

// Notes that the controller failed in the current run, after the process that ran it has ended.
// Returns false if there is no current run.
bool wg_looks_fail(WgSeat *seat);

// Gives each seat the next world, in order, and moves those whose robot must act to the front;
// returns their number.
int64_t wg_seats_board(WgSeat **seats, int64_t count);

// Copies the senses and memories of the first `count` seats.
//
// observations: (count, 17 + beams, and 1 for a declared goal's heading)
// memories:     (count, memory)
// numbers:      (count,) numbers of the seats
// fresh:        (count,) 1 before the first act in a world
void wg_seats_sense(WgSeat **seats, int64_t count, double *observations, double *memories,
                    int64_t *numbers, uint8_t *fresh);

// Continues the first `count` seats with commands and memories, each until its controller must act
// again (in the next world if its run has ended). Seats without a world move to the end; returns
// the number of seats that have one.
//
// commands: (count, 3) speed, turn rate, and whether the random number was used.
int64_t wg_seats_act(WgSeat **seats, int64_t count, const double *commands, const double *memories);

// For tests: draws a layout into the arena of a seat, and notes the facts about its world. Returns
// the number of solid cells.
int64_t wg_look_draw(const uint8_t *layout, WgSeat *seat, WgLook *look);

#endif

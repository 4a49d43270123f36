// Fleets: several robots in one world, each with its own controller.
//
// In each step all robots move at the same time, then all sense, then all act. A robot that has
// reached its target parks: it stops and gets no more observations, but remains an obstacle. A
// fleet consists of episodes, one for each robot, whose states are stored next to each other:
// together they form the complete state that a recurrence repeats.

#ifndef WG_FLEET_H
#define WG_FLEET_H

#include <stdint.h>

#include "wg_episode.h"
#include "wg_parts.h"

enum { WG_MOST_ROBOTS = 1000 };

// Settings of a fleet's run.
typedef struct WgFleetSettings {
    int64_t motion;      // WG_SWEPT or WG_ENDPOINT: the same for all robots
    int64_t steps;       // budget
    int64_t find_loop;   // WG_NO_LOOP, WG_SEEK_LOOP or WG_PROVE_LOOP
    int64_t loop_entry;  // for WG_PROVE_LOOP
    int64_t log_steps;   // longest run in which a recurrence is searched for; 0 for none
    int64_t message;     // numbers that a robot sends in each step, at most WG_MOST_MESSAGE
    int64_t kinds;       // sizes of discs
    const int64_t *kind;      // (robots,) size of each robot, from 0
    // (kinds, kinds) squared distance that the centres of two robots must keep, lattice units
    const int64_t *clear_sq;
} WgFleetSettings;

// The report of a fleet, in addition to the reports of its robots.
typedef struct WgFleetReport {
    // WG_LIMIT, ...; WG_REACHED when all robots have parked; WG_LOOP: the complete state recurred
    int64_t ending;
    int64_t steps;
    int64_t period;
    int64_t entry;   // first step from which the states repeat, for WG_LOOP; else -1
    int64_t robot;   // index of the robot that ended the run; -1 if none did
    int64_t other;   // for WG_COLLISION: the index of the other one; else -1
    int64_t parked;  // robots that have reached their targets
} WgFleetReport;

typedef struct WgMover WgMover;  // what a robot does within a step: fleet.h
typedef struct WgNear WgNear;    // which robots are near each other: fleet.h

typedef struct WgFleet {
    const WgFleetSettings *settings;
    int64_t count;
    WgEpisode **members;    // (count,)
    // (search.words,) the complete state: each robot's, its memory, its message, whether it parked
    uint64_t *state;
    WgSearch search;
    WgFleetReport report;
    int64_t *moved;         // (count,) last step in which each robot's centre moved
    // (count, count) in the period of a loop that is proved: 1 where a robot drove into another
    uint8_t *blocked;
    WgMover *movers;        // (count,)
    WgNear *near;
    WgCorner *chains;       // corners of the robots' paths of the last step
    WgVector *by;           // (count,) displacements of the step
    WgVector *before;       // (count,) where the robots were before it
    int64_t *is_inside;     // (count,) whether the centre is in the grid
    int64_t *acts;          // (count,) 1 if the controller acts in this step
    WgOther *around;        // (count,) the robots around the one that senses
    WgOthers others;
    WgArena *arenas;        // (count,) the robots' arenas, with those around them
    WgNeighbour *seen;      // neighbours of all robots that sense them
    double *flat;           // flat observations of the same
    int64_t senses_others;  // 1 if a robot senses others, by beams or as neighbours
    double furthest;        // the longest range of these senses, lattice units
    int64_t next_event;     // index of the first event that has not happened
    int64_t quiet;          // step of the last event: states before it prove nothing
    int64_t step;           // steps done
    // 1 while controllers outside the core have to act: those of members whose `waits` is 1
    int64_t waits;
    int64_t over;           // 1 when the run has ended
    int64_t is_in_block;    // 1 if its memory is the caller's
} WgFleet;

// Memory for a fleet.
typedef struct WgBlock {
    void *bytes;   // all zeros; NULL for the heap
    int64_t size;  // bytes
    int64_t used;  // filled: bytes that the fleet takes
} WgBlock;

// Makes a fleet, whose settings, arenas and members' settings stay the caller's. All arenas have
// the same cells, masks and events. wg_fleet_free frees it, unless it is in a block of the caller.
WgStatus wg_fleet_new(const WgFleetSettings *settings, const WgArena *const *arenas, const WgSettings *const *robots,
                      const WgController *const *controllers, int64_t count, WgBlock *block, WgFleet **made);

void wg_fleet_free(WgFleet *fleet);

// Puts all robots at their starts. The arenas must be as they are before the first event.
WgStatus wg_fleet_begin(WgFleet *fleet);

// Runs at most this many steps, for about a tenth of a second: WG_GOES_ON, WG_OVER, or WG_ACTS if controllers outside the core
// must act. For those members `waits` is 1; each finds what it observes in `flat`, and leaves its
// command and memory as in WgWorkspace before the next call.
int64_t wg_fleet_run(WgFleet *fleet, int64_t most_steps);

// Ends a run as a crash of a robot's controller, in the step in which it last had to act.
void wg_fleet_fail(WgFleet *fleet, int64_t robot);

// The motion part of a step, for tests: what wg_fleet_run does with given displacements.
//
// by:  (count,) displacement of each robot, lattice units.
void wg_fleet_move(WgFleet *fleet, const WgVector *by);

#endif

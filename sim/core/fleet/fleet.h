// Declarations shared by the files of the fleet; see wg_fleet.h.

#ifndef WG_FLEET_PARTS_H
#define WG_FLEET_PARTS_H

#include <stdbool.h>

#include "motion.h"
#include "step.h"
#include "wg_fleet.h"

// Phases that a move of robots near each other may have. A robot that has not arrived by then waits
// for the next step.
enum { WG_MOST_PHASES = 12 };

// The corners that one move may add to a robot's path: two for each phase, and a wait.
enum { WG_FLEET_CORNERS = 2 * WG_MOST_PHASES + 1 };

// Up to this many robots, all pairs are examined; above it, a grid is faster.
enum { WG_FEW_ROBOTS = 12 };

// A robot within a step.
struct WgMover {
    WgPlace begin;       // where it was when the move began
    WgPlace place;       // where it is
    WgVector left;       // rest of its displacement
    WgPlace goal;        // goal of this phase
    int64_t far;         // the disc stays within this distance of its place during this move
    WgContact wall;      // its first contact with a wall in the phase
    WgNormal normal;     // normal of its last contact in this move
    WgNormal touch;      // normal of its contacts in this phase
    int64_t touching;    // number of things that it touches
    int64_t contacts;    // number of phases of this move with a contact
    int64_t since;       // time in the step of its last corner, 2^-32 steps
    int64_t candidate;   // number of the lattice point near the desired one that `goal` is
    int64_t column;      // column of its cell in the grid of robots
    int64_t row;
    int64_t cluster;     // index of the first robot of its cluster, once found
    int64_t next;        // index of the next robot of its cluster; -1
    bool is_active;      // it has neither parked nor ended the run
    bool is_clear;       // the path to `goal` is known to be clear of walls
    bool is_violated;    // something blocks the path to `goal`
};

// Two robots that may meet in a move.
typedef struct WgPair {
    int64_t one;
    int64_t other;
    int64_t clear_sq;  // squared distance to keep
    double time;       // time of their first contact in the phase; 2 if there is none
    int64_t next;      // index of the next pair of the cluster; -1
} WgPair;

// A robot as others may sense it.
typedef struct WgSpot {
    WgPlace place;
    double reach;     // its radius, lattice units
    double radius;    // m
    double speed;     // m/s
    int64_t heading;
    int64_t robot;
} WgSpot;

// A robot near the one that senses.
typedef struct WgNearby {
    int64_t away_sq;  // squared distance between them
    int64_t spot;     // its index in `spots`
} WgNearby;

// The robots sorted by the cells of a coarse grid, for those that sense others.
typedef struct WgRobotGrid {
    WgPlace low;     // the corner of its first cell
    int64_t cell;    // side of a cell, lattice units
    int64_t columns;
    int64_t rows;
    // (columns * rows + 1,) index in `spots` of the first robot of each cell, row by row
    int64_t *first;
    WgSpot *spots;   // (count,)
    WgNearby *found;  // (count + 1,) robots near the one that senses
} WgRobotGrid;

struct WgNear {
    WgPair *pairs;        // (pair_count,)
    int64_t pair_count;
    int64_t *first;       // (count,) first robot of the cluster that a robot is the root of; -1
    int64_t *first_pair;  // (count,) same, first pair
    int64_t *heads;       // (buckets,) first robot in each bucket of the grid; -1
    int64_t *chain;       // (count,) next robot in the same bucket; -1
    int64_t buckets;      // a power of two
    WgRobotGrid grid;
};

// Robots that may meet, directly or through others.
typedef struct WgCluster {
    int64_t first;       // index of a robot; the others follow by `next`
    int64_t first_pair;  // index of a pair; same
} WgCluster;

// When a part of a step begins and ends, 2^-32 steps.
typedef struct WgSpan {
    int64_t from;
    int64_t until;
} WgSpan;

// Finds the pairs that may meet, from `place` and `far` of each mover, and links them into
// clusters. A robot that cannot meet another one has no cluster.
// Two robots that both stand still cannot meet.
void wg_find_near(WgFleet *fleet);

// Returns the word of the complete state that tells if a robot has parked.
uint64_t *wg_parked_word(const WgFleet *fleet, int64_t robot);

// The message in a robot's state.
double *wg_message_of(const WgFleet *fleet, int64_t robot);

// Prepares what all robots need to sense others, after they have moved.
void wg_ready_senses(WgFleet *fleet);

// Finds the robots around a robot, the nearest first, for its beams and its neighbours.
void wg_sense_others(WgFleet *fleet, int64_t robot);

// Moves all robots for a step by their displacements, with each event in the step at its time.
void wg_move_fleet(WgFleet *fleet, int64_t step, const WgVector *by);

#endif

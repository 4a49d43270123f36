// Proofs of reachability.
//
// Arrays are row-major. Functions check the sizes they are given; they keep no pointer longer than
// stated. Lengths in lu are 1/1024 of a cell's side. A graph has nodes at multiples of 1/k cell.

#ifndef WG_REACH_H
#define WG_REACH_H

#include <stdint.h>

#include "wg_types.h"

// rasters.c

// Finds where a disc is clear, for every node of a graph and every midpoint of four nodes.
//
// solid:      (height, width) 1 is solid; everything outside is solid.
// k:          nodes in a cell's side, 1 to 64.
// limit:      smallest squared distance, in 1/(2 k) cell, at which the disc is clear;
//             at most (2 k * 20,000)^2.
// clear:      (k height + 1, k width + 1) gets 1 where the disc is clear at the node, else 0.
// middle:     the same, half a step right of and above each node; 0 in the last row and column.
WgStatus wg_disc_rasters(const uint8_t *solid, int64_t height, int64_t width, int64_t k, int64_t limit,
                         uint8_t *clear, uint8_t *middle);

// flood.c

// Marks every node of a graph that can be reached from a source by steps to the eight neighbours.
//
// clear:      (nodes,) 1 where the disc is clear; 0 on the rim of the grid.
// middle:     (nodes,) 1 where it is clear half a step right of and above each node.
// stride:     nodes in a row.
// sources:    (source_count,) clear nodes.
// stops:      (stop_count,) a few nodes; the flood ends once one of them is reached.
// seen:       (nodes,) zeros; set to 1 for nodes that are reached.
WgStatus wg_flood(const uint8_t *clear, const uint8_t *middle, int64_t nodes, int64_t stride,
                  const int64_t *sources, int64_t source_count, const int64_t *stops, int64_t stop_count,
                  uint8_t *seen);

// search.c

typedef struct WgGraph {
    const uint8_t *clear;   // (nodes,) 1 where the disc is clear; 0 on the rim of the grid
    const uint8_t *middle;  // (nodes,) 1 where it is clear half a step right of and above each node
    int64_t nodes;          // less than 2^31
    int64_t stride;         // nodes in a row
} WgGraph;

typedef enum WgProgress {
    WG_GOING = 0,      // there is more to search
    WG_FOUND = 1,      // an end, or the best spare end
    WG_EXHAUSTED = 2,  // there is no path
    WG_GAVE_UP = 3,    // the search reached its limit
} WgProgress;

// A search for the shortest path from any source to any end; it does bounded work per call.
typedef struct WgSearch WgSearch;

// Begins a search. The graph's rasters and the bridges must outlive it.
//
// sources:    (source_count,) clear nodes.
// ends:       (end_count,) nodes at which the search stops.
// spare:      (spare_count,) nodes to accept if no end can be reached.
// toward_x:   column of the node that guides the search; toward_y: its row.
// bridges:    (bridge_count, 2) pairs of clear nodes that are also connected, in both directions;
//             used only when nothing else is left.
// made:       receives the search, to be released by wg_search_free.
WgStatus wg_search_new(const WgGraph *graph, const int64_t *sources, int64_t source_count, const int64_t *ends,
                       int64_t end_count, const int64_t *spare, int64_t spare_count, int64_t toward_x,
                       int64_t toward_y, const int64_t *bridges, int64_t bridge_count, WgSearch **made);

// Continues until it is done or ``most`` more nodes have been expanded.
WgStatus wg_search_advance(WgSearch *search, int64_t most, WgProgress *progress);

// Declares that no end can be reached, so that the first spare one is enough.
void wg_search_be_content(WgSearch *search);

// Returns the number of nodes of the path found, without those in the middle of a straight line;
// 0 if none was found.
int64_t wg_search_path_length(const WgSearch *search);

// Copies these nodes, from source to end.
void wg_search_path(const WgSearch *search, int64_t *nodes);

void wg_search_free(WgSearch *search);

// segments.c

typedef struct WgWalls {
    const uint8_t *solid;  // (height, width) 1 is solid; everything outside is solid
    int64_t height;        // cells, at most 20,000
    int64_t width;         // cells, at most 20,000
} WgWalls;

// A disc, with its radius as integers and as floats for comparisons.
typedef struct WgDisc {
    int64_t reach;     // at least the radius, lu
    int64_t limit;     // smallest integer that is at least the squared radius, lu^2
    double radius_sq;  // its square, lu^2
} WgDisc;

// Reports whether the disc may sweep a piece; unsure if only fractions can decide.
typedef enum WgAnswer {
    WG_CLEAR = 0,
    WG_MEETS = 1,
    WG_UNSURE = 2,
} WgAnswer;

// Goes from corner to corner of a path as far as the disc may sweep; stops where only fractions can
// decide.
//
// x, y:       (count,) corners, lu, rounded down.
// whole:      (count,) 0 where a corner is not an integer point:
//             the caller decides each piece there.
// patience:   limit on consecutive hidden corners.
// state:      (5,) index of the current corner, of the farthest one seen, of the one being tested;
//             number of corners kept; the caller's WgAnswer, WG_UNSURE for none. At first 0, 1,
//             2, 1, WG_UNSURE.
// kept:       (count,) receives the indices of the corners kept; the first is 0.
// done:       1; or 0 if the caller must decide the piece from state[0] to state[2].
WgStatus wg_shorten(const WgWalls *walls, const WgDisc *disc, const int64_t *x, const int64_t *y,
                    const uint8_t *whole, int64_t count, int64_t patience, int64_t *state, int64_t *kept,
                    int64_t *done);

// Finds the smallest distance from a path to a solid cell, up to ``reach``.
//
// x, y:       (count,) integer corners, lu; at least one.
// sides:      (count,) receives, for pieces that may be nearest to a corner next to them,
//             distance times length.
// lengths_sq: (count,) receives the squared lengths of these pieces.
// found:      receives their number.
// least:      receives the smallest other square, lu^2; at most reach^2.
WgStatus wg_sweep_least(const WgWalls *walls, const int64_t *x, const int64_t *y, int64_t count, int64_t reach,
                        int64_t *sides, int64_t *lengths_sq, int64_t *found, int64_t *least);

// target_poses.c

// A robot, and the target's disc.
typedef struct WgTarget {
    int64_t scale;   // the first four lengths are in 1/scale cell
    int64_t x;       // x of the disc's centre
    int64_t y;
    int64_t reach;   // the robot's radius
    int64_t radius;  // the disc's; -1 if it is not a multiple of 1/scale
    double centre_x;     // the same as floats, cells
    double centre_y;
    double robot_radius;
    double disc_radius;
} WgTarget;

// The clear poses of a disc that are sufficient to decide for all of them.
typedef struct WgPoses WgPoses;

// The state of a list of poses.
typedef enum WgListed {
    WG_LISTED = 0,
    WG_TOO_MANY = 1,  // thousands of corners are near the disc
    WG_TOO_LONG = 2,  // the numbers have too many digits
} WgListed;

// The lines or circles that meet at a pose.
typedef enum WgPoseKind {
    WG_PLAIN = 0,      // lines: its coordinates are whole
    WG_ON_RAY = 1,     // the circle around a corner, and the ray from there through the centre
    WG_ON_ROW = 2,     // this circle and a line y = ...
    WG_ON_COLUMN = 3,  // this circle and a line x = ...
    WG_BETWEEN = 4,    // the circles around two corners
} WgPoseKind;

// A pose, for callers that compute it to any precision.
typedef struct WgPoseOf {
    int64_t kind;   // a WgPoseKind
    int64_t x;      // x of the corner, cells; for lines of the pose, 1/scale cell
    int64_t y;
    int64_t dx;     // the other corner's x less this one's
    int64_t dy;
    int64_t level;  // level at which the line meets the circle, 1/scale cell
    int64_t side;   // 1 or -1: which of two points
} WgPoseOf;

// Lists the poses. made receives them, to be freed by wg_poses_free; listed receives the outcome.
// The walls must outlive the call.
WgStatus wg_poses_new(const WgWalls *walls, const WgTarget *target, WgPoses **made, WgListed *listed);

int64_t wg_poses_count(const WgPoses *poses);

// Describes one of them; index is below their number.
void wg_poses_describe(const WgPoses *poses, int64_t index, WgPoseOf *described);

// Returns the first pose, from ``begin`` on, that a chain winds around as often as ``winds``; the
// number of poses if there is none.
int64_t wg_poses_next(const WgPoses *poses, const int64_t *cells, int64_t count, int64_t winds, int64_t begin);

void wg_poses_free(WgPoses *poses);

// still.c

// The conversion of lattice units to metres and ticks: fractions of integers.
typedef struct WgPace {
    int64_t metre_over;   // metres of a lu
    int64_t metre_under;  // less than 2^53
    int64_t tick_over;    // squared ticks of a squared lu
    int64_t tick_under;
    int64_t ticks;        // ticks per second, less than 2^53
} WgPace;

// The outcome of a decision.
typedef enum WgOutcome {
    WG_OPEN = 0,           // nothing is known
    WG_REACHED = 1,        // there is a path
    WG_START_COVERED = 2,  // the start is nearer than the radius to a cell
    WG_NO_PATH = 3,        // the start is clear, and no path over half cells leads to the target
    WG_PARTED = 4,         // and chains of cells separate the start from all of the target
} WgOutcome;

// A query about a static world, and its answer.
typedef struct WgStill {
    int64_t start_x;  // lu; the start, rounded
    int64_t start_y;
    int64_t has_goal;  // 0 if no lattice point next to the target's centre is in the target
    int64_t goal_x;    // this point, lu
    int64_t goal_y;
    int64_t toward_x;  // node over half cells that guides the search
    int64_t toward_y;
    // smallest squared distance, in quarters of a cell, at which the disc is clear
    int64_t clear_from;
    // smallest squared gap, cells, that lets the disc through; 0 if lu are too coarse to tell
    int64_t limit;
    WgDisc disc;
    // if clear at start_x, start_y, so is the robot's disc at the start and on the way there
    WgDisc start_disc;
    WgDisc start_core;  // if this disc is not clear, the robot's disc is not clear at the start
    WgDisc goal_disc;  // for the path to the goal: slightly smaller
    WgDisc both;       // as wide as robot and target together
    WgTarget target;   // its scale is 0 if the numbers have too many digits
    WgPace pace;
    int64_t wants_path;  // 0 if it is enough to know that one exists
    int64_t wants_cut;   // 0 if it is enough to know whether one exists

    int64_t outcome;     // a WgOutcome
    int64_t goal_clear;  // 1 if the robot may be at the goal
    int64_t count;       // number of the path's points
    int64_t room;        // for each part of the following
    // (4 room,) x, y in lu; then sides and squared lengths, as from wg_sweep_least
    int64_t *points;
    double *metres;      // (3 room,) x, y in m; then times in s
    int64_t least;       // smallest integer square of the distance to a solid cell, lu^2
    int64_t corners;     // number of sides
} WgStill;

// Searches for a path over half cells from a lattice pose to the target; if there is none, searches
// for chains unless the cut itself is wanted.
WgStatus wg_still_decide(const WgWalls *walls, WgStill *still);

// Releases what an answer holds.
void wg_still_free(WgStill *still);

// intervals.c

// A raster of points and the spans in which cells near them are blocked.
typedef struct WgBlocked {
    const uint8_t *clear;   // (rows, columns) 0 where a point is never safe
    int64_t rows;
    int64_t columns;
    int64_t k;                   // points in a cell's side
    const int64_t *class_first;  // (k^2 + 1,) where the steps of each point of a cell begin
    // to cells that make the point unsafe, added to the number of its own
    const int64_t *steps;
    int64_t pad;                 // cells of padding around the grid
    int64_t stride;              // cells in a row, including the padding
    int64_t cells;
    const int64_t *span_first;  // (cells + 1,) where each cell's spans begin
    const int64_t *span_begin;  // ticks
    const int64_t *span_end;
    int64_t most;  // limit on the spans around one point
} WgBlocked;

// Counts the safe intervals of the points ``from`` to ``to - 1``, each in first[point + 1], or
// writes them starting at first[point].
//
// writes:     0 to count.
// begin, end: ticks; unused while counting.
WgStatus wg_safe_intervals(const WgBlocked *blocked, int64_t from, int64_t to, int64_t *first, int64_t *begin,
                           int64_t *end, int64_t writes);

// timed.c

// The data of a search over (node, safe interval). All arrays must outlive it.
typedef struct WgTimed {
    int64_t nodes;
    int64_t stride;            // nodes in a row; those on the rim have no interval
    const int64_t *first;      // (nodes + 1,) where each node's states begin
    const int64_t *begin;      // (states,) ticks
    const int64_t *end;        // (states,)
    const int64_t *mid_first;  // the same for the middle right of and above each node
    const int64_t *mid_begin;
    const int64_t *mid_end;
    int64_t states;
    const int32_t *node_of;  // (states,)
    const uint8_t *goal;     // (nodes,) 1 where the search stops
    int64_t toward_x;        // node that guides the search
    int64_t toward_y;
    int64_t slack;           // ticks by which an end may be nearer than that
    int64_t axis_ticks;      // that a step along an axis takes
    int64_t diagonal_ticks;  // and a diagonal one
    // (states,) later than everything at first; receives the earliest arrival
    int64_t *cost;
    int32_t *came;           // (states,) receives the state before
    int64_t *depart;         // (states,) receives the departure from that state
} WgTimed;

typedef struct WgTimedSearch WgTimedSearch;

// begun: (begun_count, 2) states and arrivals.
WgStatus wg_timed_new(const WgTimed *asked, const int64_t *begun, int64_t begun_count, WgTimedSearch **made);

// Processes ``most`` more entries of its queue; final receives the state at which it stopped, or
// -1.
WgStatus wg_timed_advance(WgTimedSearch *search, int64_t most, WgProgress *progress, int64_t *final);

void wg_timed_free(WgTimedSearch *search);

// confine.c

// Tiles with the intervals in which they are alive, in slabs of time.
// All arrays must outlive a spread.
typedef struct WgTiles {
    int64_t rows;
    int64_t columns;
    const int64_t *first;      // (rows columns + 1,) where each tile's states begin
    int64_t states;
    const int64_t *tile;  // (states,)
    const int64_t *low;   // (states,) first slab in which the tile is alive
    const int64_t *high;  // (states,) last one
    const uint8_t *goal;     // (rows columns,) 1 where the spread stops
    int64_t *came;        // (states,) -1 at first; receives the slab in which a state is reached
} WgTiles;

typedef struct WgSpread WgSpread;

WgStatus wg_spread_new(const WgTiles *tiles, const int64_t *sources, int64_t source_count, WgSpread **made);

// Processes ``most`` more states; slab receives the one in which the goal is reached, or -1.
WgStatus wg_spread_advance(WgSpread *spread, int64_t most, WgProgress *progress, int64_t *slab);

void wg_spread_free(WgSpread *spread);

// cut.c

// A search for a cut: a closed chain of solid cells, with gaps below the disc's diameter, that
// separates poses.
typedef struct WgCutSearch WgCutSearch;

// Begins a search. No argument has to outlive the call.
//
// limit:      smallest squared gap, cells, that does not stop the disc.
// targets:    1 to 6 poses that the chain separates from the start.
// poses:      (1 + targets, 2) start and targets: x, y in half cells, rounded down.
// limbs:      at least 1.
// rest:       (1 + targets, 2, limbs) the rounding errors, as digits in base 2^32, highest first.
// made:       receives the search, to be released by wg_cut_search_free.
WgStatus wg_cut_search_new(const WgWalls *walls, int64_t limit, int64_t targets, const int64_t *poses, int64_t limbs,
                           const uint32_t *rest, WgCutSearch **made);

// Continues for about ``most`` rows and cells.
WgStatus wg_cut_search_advance(WgCutSearch *search, int64_t most, WgProgress *progress);

// Returns the number of cells in the chain found; 0 if nothing separates the poses.
int64_t wg_cut_length(const WgCutSearch *search);

// Copies these cells in chain order: ix, iy of each.
void wg_cut_cells(const WgCutSearch *search, int64_t *cells);

void wg_cut_search_free(WgCutSearch *search);

// Reports whether a chain winds around a pose an even (0) or odd (1) number of times, and whether
// its line stays outside a radius. Lengths are multiples of 1/scale half cell, less than 2^59; so
// are scale times a chain's coordinates.
//
// cells:      (count, 2) ix, iy in chain order, -2 to 20,001.
// radius:     -1 if it is not a multiple.
// rough:      the same as a float.
// away:       receives 1 or 0; -1 if floats cannot tell and there is no exact value.
WgStatus wg_chain_around(const int64_t *cells, int64_t count, int64_t scale, int64_t x, int64_t y, int64_t radius,
                         double rough, int64_t *winds, int64_t *away);

// Returns the widest gap between neighbours of a closed chain, cells squared.
int64_t wg_chain_gap_sq(const int64_t *cells, int64_t count);

// coarse.c

// A search over free squares of whole cells. The walls must outlive it.
typedef struct WgSquares WgSquares;

// side:       of the squares, cells.
// source:     where to start: (row + 1) (width + 2) + column + 1 of a square's first cell;
//             goal: where to end.
WgStatus wg_squares_new(const WgWalls *walls, int64_t side, int64_t source, int64_t goal, WgSquares **made);

// Processes about ``most`` more cells.
WgStatus wg_squares_advance(WgSquares *squares, int64_t most, WgProgress *progress);

// Returns the number of squares from source to goal, without those in the middle of a straight
// line; 0 if there is no path.
int64_t wg_squares_way_length(const WgSquares *squares);

// Copies these squares.
void wg_squares_way(const WgSquares *squares, int64_t *way);

void wg_squares_free(WgSquares *squares);

// joint.c

// Several robots on one lattice of nodes, in ticks: in each tick every robot waits or takes one of
// eight steps, all at the same speed. All arrays must outlive a search.
//
// Robots with equal radii are in the same class. Two robots are clear of each other in a tick if
// the segment that one traces relative to the other stays away from the origin: the squared
// distance, in nodes, times the squared length of that segment (0, 1, 2, 4, 5 or 8) is at least a
// whole number. limits[(a classes + b) 9 + length squared] is that number for two classes,
// with 1 for the ends.
typedef struct WgJoint {
    int64_t robots;   // at most 32,767
    int64_t classes;
    int64_t nodes;    // less than 2^31
    int64_t stride;   // nodes in a row
    int64_t rasters;
    const uint8_t *clear;      // (rasters, classes, nodes) as in WgGraph
    const uint8_t *middle;
    int64_t ticks;             // at least 1
    // (ticks,) raster of each tick; the last one stays valid from then on
    const int64_t *raster_of;
    const int64_t *class_of;   // (robots,)
    const int64_t *limits;     // (classes, classes, 9)
    // two robots that are farther apart than this, in nodes, across or up, are clear
    int64_t reach;
    const int64_t *starts;     // (robots,) nodes
    // (robots, nodes) lower bound of steps to the target; 0 in it, where it parks; -1 if no steps
    // lead there
    const int32_t *distances;
    const int64_t *crossed_from;  // (robots + 1,) where each robot's crossings begin
    // (crossed_from[robots],) rising for each robot: 8 times a node outside its target, plus the
    // number of a step from there to another such node, across the target: the robot would park on
    // the way
    const int64_t *crossings;
} WgJoint;

// Paths of all robots: for each tick the node of each.
typedef struct WgJointPlan WgJointPlan;

// A robot of a joint search; the arrays are those of WgJoint, for this robot only.
typedef struct WgJointRobot {
    int64_t number;  // from 0
    int64_t start;   // node
    const int32_t *distances;  // (nodes,)
    const int64_t *crossings;  // (crossing_count,)
    int64_t crossing_count;
} WgJointRobot;

// Robots that are planned one after the other, each around those before it, by safe intervals.
typedef struct WgJointOrder WgJointOrder;

// Begins without a robot. Of the robots in ``joint``, only the number and classes count;
// it must outlive the order.
WgStatus wg_joint_order_new(const WgJoint *joint, WgJointOrder **made);

// Begins to plan one more robot, whose arrays must outlive its search; a search that has not ended
// is dropped.
//
// most:       states that it may reach.
WgStatus wg_joint_order_add(WgJointOrder *order, const WgJointRobot *robot, int64_t most);

// Continues to plan it, for about ``most`` ticks and spans. WG_FOUND if it has a path. After
// WG_EXHAUSTED (it has no path) and WG_GAVE_UP, the order is as it was before the robot was added.
WgStatus wg_joint_order_advance(WgJointOrder *order, int64_t most, WgProgress *progress);

// Makes the plan of an order with a path for each robot.
WgStatus wg_joint_order_plan(const WgJointOrder *order, WgJointPlan **made);

void wg_joint_order_free(WgJointOrder *order);

// A search over joint states, which hold the positions of all robots at once.
typedef struct WgJointSearch WgJointSearch;

// Begins a search of all joint states, the most promising first; complete.
//
// most:       limit on joint states examined.
WgStatus wg_joint_exhaust(const WgJoint *joint, int64_t most, WgJointSearch **made);

// Does the same depth first with lazily added constraints (LaCAM), for many robots.
//
// most:       limit on joint states kept.
WgStatus wg_joint_lacam(const WgJoint *joint, int64_t most, WgJointSearch **made);

// Continues either search, for about ``most`` moves of a robot.
//
// made:       receives the plan after WG_FOUND, otherwise NULL.
WgStatus wg_joint_search_advance(WgJointSearch *search, int64_t most, WgJointPlan **made, WgProgress *progress);

void wg_joint_search_free(WgJointSearch *search);

// Returns the ticks until the last robot parks.
int64_t wg_joint_length(const WgJointPlan *plan);

// nodes:      (length + 1, robots) receives the nodes.
void wg_joint_nodes(const WgJointPlan *plan, int64_t *nodes);

void wg_joint_free(WgJointPlan *plan);

// Counts the fewest steps from every node to a goal.
//
// clear, middle: (nodes,) as in WgGraph.
// goals:      (nodes,) 1 for nodes in the target; those that are not clear do not count.
// distances:  (nodes,) receives them; -1 where no path exists.
WgStatus wg_joint_distances(const WgGraph *graph, const uint8_t *goals, int32_t *distances);

#endif

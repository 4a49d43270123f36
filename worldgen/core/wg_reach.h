// Proofs of reachability.
//
// Arrays are row-major. Functions check the sizes that they are given; none keeps a pointer longer than it says.
// Lengths in lu are 1/1024 of a cell's side. A graph has nodes at multiples of 1/k cell.

#ifndef WG_REACH_H
#define WG_REACH_H

#include <stdint.h>

#include "wg_types.h"

// rasters.c

// Where a disc is clear, for every node of a graph and every middle of four.
//
// solid:      (height, width) 1 is solid; everything outside is.
// k:          nodes in a cell's side, 1 to 64.
// limit:      least squared distance, in 1/(2 k) cell, at which the disc is clear; at most (2 k * 20,000)^2.
// clear:      (k height + 1, k width + 1) gets 1 where the disc is clear at the node, else 0.
// middle:     the same, half a step right of and above each node; 0 in the last row and column.
WgStatus wg_disc_rasters(const uint8_t *solid, int64_t height, int64_t width, int64_t k, int64_t limit,
                         uint8_t *clear, uint8_t *middle);

// flood.c

// Marks every node of a graph that a source leads to by steps to its eight neighbours.
//
// clear:      (nodes,) 1 where the disc is clear; 0 on the rim of the grid.
// middle:     (nodes,) 1 where it is clear half a step right of and above each node.
// stride:     nodes in a row.
// sources:    (source_count,) clear nodes.
// stops:      (stop_count,) few nodes; once one of them is reached, that is enough.
// seen:       (nodes,) zeros; 1 for what is reached.
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
} WgProgress;

// A search for the shortest path from any source to any end; bounded work at a time.
typedef struct WgSearch WgSearch;

// Begins a search. The graph's rasters and the bridges must outlive it.
//
// sources:    (source_count,) clear nodes.
// ends:       (end_count,) nodes at which the search stops.
// spare:      (spare_count,) nodes to be content with where no end can be reached.
// toward_x:   node that the search leans to, across; toward_y: up.
// bridges:    (bridge_count, 2) pairs of clear nodes that are joined too, either way; used once there is no other way.
// made:       gets the search, for wg_search_free.
WgStatus wg_search_new(const WgGraph *graph, const int64_t *sources, int64_t source_count, const int64_t *ends,
                       int64_t end_count, const int64_t *spare, int64_t spare_count, int64_t toward_x,
                       int64_t toward_y, const int64_t *bridges, int64_t bridge_count, WgSearch **made);

// Goes on, until it is done or ``most`` nodes more were expanded.
WgStatus wg_search_advance(WgSearch *search, int64_t most, WgProgress *progress);

// Says that no end can be reached, so that the first spare one will do.
void wg_search_be_content(WgSearch *search);

// Number of nodes of the path that was found, without those in the middle of a straight line; 0 if none was.
int64_t wg_search_path_length(const WgSearch *search);

// These nodes, from source to end.
void wg_search_path(const WgSearch *search, int64_t *nodes);

void wg_search_free(WgSearch *search);

// segments.c

typedef struct WgWalls {
    const uint8_t *solid;  // (height, width) 1 is solid; everything outside is
    int64_t height;        // cells, at most 20,000
    int64_t width;         // cells, at most 20,000
} WgWalls;

// A disc, so that whole numbers and floats can be compared with its radius.
typedef struct WgDisc {
    int64_t reach;     // at least the radius, lu
    int64_t limit;     // least whole square that is not below the radius's, lu^2
    double radius_sq;  // its square, lu^2
} WgDisc;

// Whether the disc may sweep a piece; unsure if only fractions can tell.
typedef enum WgAnswer {
    WG_CLEAR = 0,
    WG_MEETS = 1,
    WG_UNSURE = 2,
} WgAnswer;

// Goes from corner to corner of a path as far as the disc may sweep; stops where only fractions can tell.
//
// x, y:       (count,) corners, lu, rounded down.
// whole:      (count,) 0 where a corner is not a whole point: each piece there is asked about.
// patience:   corners in a row that may be out of sight.
// state:      (5,) index of the corner gone from, of the farthest one seen, of the one looked at; number of corners
//             kept; the WgAnswer to what was asked, WG_UNSURE for none. At first 0, 1, 2, 1, WG_UNSURE.
// kept:       (count,) gets the indices of the corners kept; the first is 0.
// done:       gets 1; or 0 if the piece from state[0] to state[2] is asked about.
WgStatus wg_shorten(const WgWalls *walls, const WgDisc *disc, const int64_t *x, const int64_t *y,
                    const uint8_t *whole, int64_t count, int64_t patience, int64_t *state, int64_t *kept,
                    int64_t *done);

// Least distance from a path to a solid cell, as far as ``reach``.
//
// x, y:       (count,) whole corners, lu; two or more, or one.
// sides:      (count,) gets, of the pieces that may be nearest by a corner next to them, the distance times length.
// lengths_sq: (count,) gets the squared lengths of these.
// found:      gets their number.
// least:      gets the least other square, lu^2; at most reach^2.
WgStatus wg_sweep_least(const WgWalls *walls, const int64_t *x, const int64_t *y, int64_t count, int64_t reach,
                        int64_t *sides, int64_t *lengths_sq, int64_t *found, int64_t *least);

// still.c

// How lattice units become metres and ticks: fractions of whole numbers.
typedef struct WgPace {
    int64_t metre_over;   // metres of a lu
    int64_t metre_under;  // less than 2^53
    int64_t tick_over;    // squared ticks of a squared lu
    int64_t tick_under;
    int64_t ticks;        // of a second, less than 2^53
} WgPace;

// A question about a still world, and its answer.
typedef struct WgStill {
    int64_t start_x;  // lu
    int64_t start_y;
    int64_t goal_x;  // a point in the target's disc, lu
    int64_t goal_y;
    int64_t toward_x;  // node over half cells that the search leans to
    int64_t toward_y;
    int64_t clear_from;  // least squared distance, in quarters of a cell, at which the disc is clear
    WgDisc disc;
    WgDisc goal_disc;  // on the way to the goal: a touch smaller
    WgPace pace;
    int64_t wants_path;  // 0 if it is enough to know that there is one

    int64_t reachable;  // 1 if there is a path; 0 says nothing
    int64_t count;      // of its points
    int64_t room;       // of each part of the following
    int64_t *points;    // (4 room,) x, y in lu; then sides and squared lengths, as from wg_sweep_least
    double *metres;     // (3 room,) x, y in m; then times in s
    int64_t least;      // least whole square of the distance to a solid cell, lu^2
    int64_t corners;    // number of sides
} WgStill;

// Looks for a path over half cells, from a lattice pose to another.
WgStatus wg_still_decide(const WgWalls *walls, WgStill *still);

// Releases what an answer holds.
void wg_still_free(WgStill *still);

// intervals.c

// A raster of points and the spans in which cells near them are blocked.
typedef struct WgBlocked {
    const uint8_t *clear;  // (rows, columns) 0 where a point is never safe
    int64_t rows;
    int64_t columns;
    int64_t k;                   // points in a cell's side
    const int64_t *class_first;  // (k^2 + 1,) where the steps of each point of a cell begin
    const int64_t *steps;        // to cells that make the point unsafe, added to the number of its own
    int64_t pad;                 // cells around the grid
    int64_t stride;              // cells in a row, those around included
    int64_t cells;
    const int64_t *span_first;  // (cells + 1,) where each cell's spans begin
    const int64_t *span_begin;  // ticks
    const int64_t *span_end;
    int64_t most;  // spans around one point at most
} WgBlocked;

// Counts the safe intervals of points from to to - 1, each in first[point + 1], or writes them from first[point] on.
//
// writes:     0 to count.
// begin, end: ticks; unused while counting.
WgStatus wg_safe_intervals(const WgBlocked *blocked, int64_t from, int64_t to, int64_t *first, int64_t *begin,
                           int64_t *end, int64_t writes);

// timed.c

// What a search over (node, safe interval) works on. All arrays must outlive it.
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
    int64_t toward_x;        // node that the search leans to
    int64_t toward_y;
    int64_t slack;           // ticks by which an end may be nearer than that
    int64_t axis_ticks;      // that a step along an axis takes
    int64_t diagonal_ticks;  // and a diagonal one
    int64_t *cost;           // (states,) at first later than everything; gets the earliest arrival
    int32_t *came;           // (states,) gets the state before
    int64_t *depart;         // (states,) gets the departure from that
} WgTimed;

typedef struct WgTimedSearch WgTimedSearch;

// begun: (begun_count, 2) states and arrivals.
WgStatus wg_timed_new(const WgTimed *asked, const int64_t *begun, int64_t begun_count, WgTimedSearch **made);

// Goes on with ``most`` entries of its queue; final gets the state at which it stopped, or -1.
WgStatus wg_timed_advance(WgTimedSearch *search, int64_t most, WgProgress *progress, int64_t *final);

void wg_timed_free(WgTimedSearch *search);

// confine.c

// Tiles with the intervals in which they are alive, in slabs of time. All arrays must outlive a spread.
typedef struct WgTiles {
    int64_t rows;
    int64_t columns;
    const int64_t *first;  // (rows columns + 1,) where each tile's states begin
    int64_t states;
    const int64_t *tile;  // (states,)
    const int64_t *low;   // (states,) first slab in which the tile is alive
    const int64_t *high;  // (states,) last one
    const uint8_t *goal;  // (rows columns,) 1 where it stops
    int64_t *came;        // (states,) at first -1; gets the slab in which a state is reached
} WgTiles;

typedef struct WgSpread WgSpread;

WgStatus wg_spread_new(const WgTiles *tiles, const int64_t *sources, int64_t source_count, WgSpread **made);

// Goes on with ``most`` states; slab gets that in which the goal is reached, or -1.
WgStatus wg_spread_advance(WgSpread *spread, int64_t most, WgProgress *progress, int64_t *slab);

void wg_spread_free(WgSpread *spread);

// cut.c

// A walk over cells and links with bits, from (source, no bit) to (source, all bits). All arrays must outlive it.
typedef struct WgOddWalk {
    int64_t cells;
    int64_t bits;           // 1 to 8
    const int32_t *rank;    // how many cells are before a place of the raster
    const int64_t *place;   // (cells,) where in the raster a cell is
    int64_t row_count;      // rows of linked cells around a cell
    const int64_t *rows;    // (row_count, 2) what to add to a place, and how far to either side the row is linked
    const int64_t *slot;    // (cells,) number of a cell whose links are listed, else -1
    const int64_t *begins;  // (slots + 1,) where its links begin
    const int64_t *ends;    // (links,) cells
    const uint8_t *odd;     // (links,) bits
    int32_t *before;        // (cells << bits,) at first -1; the state before a state
    int32_t *order;         // (cells << bits,) states in the order in which they are seen
    int32_t *skip;          // ((cells + 1) << bits,) at first 0, 1, 2, ...; leads to the next cell that was not seen
    int32_t *chain;         // (cells << bits,) gets the cells found, the last one first

    // The walk's own.
    int64_t source;
    int64_t head;
    int64_t tail;
    int64_t level_end;
    int64_t depth;
    int64_t looked;  // looks at rows and cells
    int64_t found;   // cells in the chain
} WgOddWalk;

WgStatus wg_odd_walk_begin(WgOddWalk *walk, int64_t source);

// Goes on with about ``most`` looks.
//
// limit:      links of which the chain has fewer.
// thorough:   1 to go on to all that can be reached, and to leave ``before`` and ``skip`` as they are; else they are in
//             the end as they were.
WgStatus wg_odd_walk_advance(WgOddWalk *walk, int64_t limit, int64_t thorough, int64_t most, WgProgress *progress);

// coarse.c

// A search over free squares of whole cells. The walls must outlive it.
typedef struct WgSquares WgSquares;

// side:       of the squares, cells.
// source:     where to begin: (row + 1) (width + 2) + column + 1 of a square's first cell; goal: where to end.
WgStatus wg_squares_new(const WgWalls *walls, int64_t side, int64_t source, int64_t goal, WgSquares **made);

// Goes on with about ``most`` cells.
WgStatus wg_squares_advance(WgSquares *squares, int64_t most, WgProgress *progress);

// Number of squares from source to goal, without those in the middle of a straight line; 0 if there is no way.
int64_t wg_squares_way_length(const WgSquares *squares);

// These squares.
void wg_squares_way(const WgSquares *squares, int64_t *way);

void wg_squares_free(WgSquares *squares);

#endif

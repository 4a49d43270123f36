// The slow parts of making and measuring worlds: mazes, open ground, planting, measures of
// difficulty, foreign maps.
//
// Grids are row-major. A grid that is searched is solid on its rim, so that no step leaves it;
// functions check this and all sizes they are given. They keep no pointers.

#ifndef WG_MAKING_H
#define WG_MAKING_H

#include <stdint.h>

#include "wg_types.h"

// making/maze.c: mazes on a lattice of chambers.
//
// While a maze grows, its chambers are on a flat board of (rows + 2) x (columns + 2) places, with a
// ring of WG_OUTSIDE around them: the neighbour of `at` in a direction is at + 1, at + stride, at -
// 1 or at - stride, without a bounds check. A direction is a number of quarter turns from +x.
//
// On the board, 0 to 3 is the direction to the parent of a chamber in the maze.
enum {
    WG_ROOT = 4,     // in the maze, without a parent
    WG_OUTSIDE = 5,  // not a chamber
    WG_FREE = 8,     // not yet in the maze; Wilson's walk adds the direction by which it left
};

// Bits of a chamber's links.
enum {
    WG_EAST = 1,    // open to the neighbour in +x
    WG_NORTH = 2,   // open to the neighbour in +y
    // the pillar between this chamber and the three to its north and east was removed
    WG_CORNER = 4,
    WG_ROCK = 8,    // not a chamber
};

typedef enum WgMazeAlgorithm {
    WG_WILSON,
    WG_ALDOUS_BRODER,
    WG_BACKTRACKER,
    WG_HUNT_AND_KILL,
    WG_KRUSKAL,
    WG_PRIM,
    WG_GROWING_TREE,
    WG_ELLER,
    WG_SIDEWINDER,
    WG_BINARY_TREE,
    WG_RECURSIVE_DIVISION,
    WG_MAZE_ALGORITHMS,
} WgMazeAlgorithm;

// A growing maze: its definition, set by the caller, and its progress between calls.
typedef struct WgMaze {
    WgMazeAlgorithm algorithm;
    int64_t columns;   // chambers in x
    int64_t rows;      // chambers in y
    int64_t newest;    // growing tree: of 65536 picks, those that take the newest chamber
    int64_t oldest;    // growing tree: of 65536 picks, those that take the oldest
    int64_t left;      // chambers still to be joined; 0 when the maze is done
    int64_t at;        // position of the walk, or the beginning of the sidewinder's row
    // hunt: no free chamber comes before it. Wilson: where the current walk began
    int64_t first;
    int64_t lowest;    // hunt: no chamber of the maze comes before it
    int64_t column;    // sidewinder: chambers of its row that are done
    int64_t edge;      // Kruskal: edges examined
    int64_t head;      // growing tree: the list of active chambers begins here
    int64_t tail;      // growing tree: and ends before this
    int64_t alive;     // growing tree: entries of the list that are still active
    int64_t again;     // growing tree: 1 while the entry has to be drawn again
    int64_t waiting;   // Prim: edges in the heap. Recursive division: rectangles to be cut
} WgMaze;

// Returns the bytes of work space that a maze needs; -1 if its algorithm or its size is out of
// range.
int64_t wg_maze_work_bytes(const WgMaze *maze);

// Sets up the board and everything in a maze that the caller has not set.
//
// mask:   (rows, columns) 1 where there is a chamber; connected.
//         Algorithms that go row by row need all of them.
// number: the chamber to begin with, counted in rows.
// board:  (places,) to be filled.
// work:   (work_bytes,) work space, aligned for int64_t.
WgStatus wg_maze_begin(WgMaze *maze, const uint8_t *mask, int64_t number, int8_t *board, int64_t places, void *work,
                       int64_t work_bytes);

// Writes the keys of all edges between chambers, to be sorted for Kruskal's algorithm.
//
// words:    (places,) random bits; the low half of a chamber's word weighs its edge east,
//           the high half its edge north.
// board:    (places,) as wg_maze_begin left it.
// keys:     (2 * places,) to be filled: the weight, then the number of the edge, in 63 bits.
// returned: number of keys.
WgStatus wg_maze_edge_keys(const WgMaze *maze, const uint64_t *words, const int8_t *board, int64_t places,
                           int64_t *keys, int64_t *returned);

// Grows a maze until it is done or the words run out. Prim's and Kruskal's algorithms need the same
// words in each call and return after some hundred thousand chambers; the others need new words.
//
// words: (word_count,) random bits; for Kruskal's algorithm the sorted keys of all edges.
WgStatus wg_maze_grow(WgMaze *maze, const uint64_t *words, int64_t word_count, int8_t *board, int64_t places,
                      void *work, int64_t work_bytes);

// Draws links as cells.
//
// links:  (rows, columns) bits of each chamber.
// across: (2 * columns + 1,) widths of border, chamber, wall, chamber, ..., border.
// up:     (2 * rows + 1,) their heights.
// walls:  (cells,) to be filled, as many as the sum of across times the sum of up.
WgStatus wg_maze_cells(const int8_t *links, int64_t rows, int64_t columns, const int64_t *across, const int64_t *up,
                       uint8_t *walls, int64_t cells);

// making/ground.c: open ground. A place is the first cell of a window;
// a step moves the window by one cell.

// Marks where a box is free, at its first cell.
//
// walls:   (rows, columns) 1 is solid.
// windows: (rows, columns) to be filled.
WgStatus wg_free_windows(const uint8_t *walls, int64_t rows, int64_t columns, int64_t width, int64_t height,
                         uint8_t *windows);

// Finds a shortest path, breadth first.
//
// windows: (size,) 1 where one may be; 0 on the rim.
// came:    (size,) work space.
// path:    (size,) to be filled: the places from start to goal, including both.
// length:  number of places; 0 if there is no path.
WgStatus wg_shortest_path(const uint8_t *windows, int64_t size, int64_t stride, int64_t start, int64_t goal,
                          int32_t *came, int32_t *path, int64_t *length);

// Counts the steps from a place to every place that can be reached, breadth first.
//
// windows: (size,) 1 where one may be; 0 on the rim.
// steps:   (size,) to be filled; -1 where there is no path.
// order:   (size,) to be filled: the places reached, the nearest first.
// reached: number of places reached.
WgStatus wg_steps_from(const uint8_t *windows, int64_t size, int64_t stride, int64_t start, int32_t *steps,
                       int32_t *order, int64_t *reached);

// Numbers the components in the order of their first places.
//
// windows: (size,) 1 where one may be; 0 on the rim.
// owner:   (size,) to be filled; -1 where there is none.
// queue:   (size,) work space.
// found:   number of components.
WgStatus wg_components(const uint8_t *windows, int64_t size, int64_t stride, int32_t *owner, int32_t *queue,
                       int64_t *found);

// Lets owners grow over the grid, all at the same pace; harder places take more rounds.
//
// waits: (size,) rounds that a place takes, 0 where none may be, as on the rim; used up.
// owner: (size,) number of the place's owner, -1 if it has none; to be filled.
// came:  (size,) to be filled: the place from which each was reached; itself at the beginnings.
// depth: (size,) to be filled: rounds in which each was reached; 0 at the beginnings.
// queue: (size,) work space.
WgStatus wg_dig(uint8_t *waits, int64_t size, int64_t stride, int32_t *owner, int32_t *came, int32_t *depth,
                int32_t *queue);

// Floods every region that has a place in first .. last - 1.
typedef struct WgRegions {
    int64_t root;      // root of the largest region; -1 if there is none
    int64_t largest;   // number of places in it
    int64_t regions;   // number of regions
    int64_t places;    // number of places in all regions
} WgRegions;

// clear: (size,) 1 where one may be; 0 on the rim.
// seen:  (size,) gets stamp at every place reached; holds no place with it before.
// queue: (size,) to be filled: the places of the last region flooded,
//        in the order of steps from its root.
WgStatus wg_regions(const uint8_t *clear, int64_t size, int64_t stride, int64_t first, int64_t last, uint8_t stamp,
                    uint8_t *seen, int32_t *queue, WgRegions *found);

// making/planting.c

// Visits places in turn, and places a thing wherever none of its cells is blocked.
//
// barred:     (size,) 1 where no cell of a thing may be; grows with every thing placed.
// places:     (turns,) where to try.
// which:      (turns,) the kind of thing to try there.
// cells:      offsets of the cells of all kinds, one kind after another. cell_ends:  (kinds,) where
// each kind's offsets end.
// halos:      offsets that a thing blocks, in the same order.
// halo_ends:  (kinds,) where these end.
// stands:     (turns,) to be filled: 1 where the thing of that turn stands.
WgStatus wg_plant(uint8_t *barred, int64_t size, const int64_t *places, const int64_t *which, int64_t turns,
                  const int64_t *cells, const int64_t *cell_ends, const int64_t *halos, const int64_t *halo_ends,
                  int64_t kinds, uint8_t *stands);

// making/distances.c, by_distance.c, pockets.c, unite.c: for the measures of difficulty.

// Squared distance from each node to the nearest marked one, exactly.
//
// marked: (rows, columns) 1 where a node is marked.
// most:   squares above this may be reported as any number above it, which takes less time.
// found:  (rows, columns) to be filled; above 2^30 if none is marked,
//         or (rows + columns)^2 if that is less.
WgStatus wg_squared_distances(const uint8_t *marked, int64_t rows, int64_t columns, int64_t most, int32_t *found);

// Sorts the clear nodes by their distance from a point; nodes at the same distance keep their
// order.
//
// clear:   (rows, columns) 1 where the disc is clear.
// pitch:   from one node to the next, in the units of x and y.
// places:  (count,) to be filled: the nodes, the nearest first.
// squared: (count,) to be filled: their squared distances.
// count:   how many nodes are clear.
WgStatus wg_by_distance(const uint8_t *clear, int64_t rows, int64_t columns, int64_t pitch, int64_t x, int64_t y,
                        int64_t *places, int64_t *squared, int64_t count);

// Unites nodes in the order of their distance from the target, until the start is joined to it.
//
// places:   (count,) nodes, the nearest first; none on the rim.
// squared:  (count,) their squared distances.
// middle:   (size,) 1 where the disc is clear half a step right of and above each node.
// role:     (size,) 1 for what is at the target, 2 for what is at the start, 3 for both.
// at_start: squared distance of the start.
// top:      squared distance to which the robot must go on any path;
//           -1 if the start is never joined.
// joined:   (2 * count,) pairs of squared pass and squared bottom of the pockets
//           that joined the target's.
// pairs:    how many.
WgStatus wg_pockets(const int64_t *places, const int64_t *squared, int64_t count, const uint8_t *middle,
                    const uint8_t *role, int64_t size, int64_t stride, int64_t at_start, int64_t *top, int64_t *joined,
                    int64_t *pairs);

// Unites linked cells until a closed chain has an odd sum.
//
// ones, others: (links,) cells that are linked.
// odd:          (links,) 1 for a link that counts as odd.
// parent:       (cells,) each cell itself at first; kept between calls.
// bit:          (cells,) zeros at first; kept between calls.
// closed:       1 if such a chain was found.
WgStatus wg_unite(const int64_t *ones, const int64_t *others, const uint8_t *odd, int64_t links, int64_t *parent,
                  uint8_t *bit, int64_t cells, int64_t *closed);

#endif

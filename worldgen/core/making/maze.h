// Shared by the files of the mazes.

#ifndef WG_MAKING_MAZE_H
#define WG_MAKING_MAZE_H

#include "wg_making.h"

// What one call of wg_maze_grow gets.
typedef struct Growth {
    WgMaze *maze;
    const uint64_t *words;
    int64_t word_count;
    int8_t *board;
    int64_t stride;  // from a chamber to the one above it
    int64_t places;
    void *work;
} Growth;

// The offset of a step in a direction. It has no branch, which would be mispredicted every second
// time: Aldous and Broder's walk takes half the time.
static inline int64_t wg_maze_step(int64_t direction, int64_t stride)
{
    return (1 - (direction & 2)) * (1 + (direction & 1) * (stride - 1));
}

void wg_maze_wilson(Growth *growth);
void wg_maze_aldous_broder(Growth *growth);
void wg_maze_backtracker(Growth *growth);
void wg_maze_hunt_and_kill(Growth *growth);
WgStatus wg_maze_kruskal(Growth *growth);
WgStatus wg_maze_prim(Growth *growth);
void wg_maze_growing_tree(Growth *growth);
void wg_maze_eller(Growth *growth);
void wg_maze_sidewinder(Growth *growth);
void wg_maze_binary_tree(Growth *growth);
void wg_maze_recursive_division(Growth *growth);

#endif

// Mazes by walking: Wilson's, Aldous and Broder's, the recursive backtracker, hunt-and-kill.
//
// Each draws directions of two bits, the lowest bits of a word first, and stops when its words run
// out; called again with the next words, it continues. Unusable draws are repeated, so the choice
// stays unbiased.

#include "maze.h"

#include <stdbool.h>

enum { DRAWS_A_WORD = 32 };

static inline int64_t draw(const uint64_t *words, int64_t number)
{
    return (int64_t)(words[number >> 5] >> (2 * (number & 31))) & 3;
}

// The free neighbours of a place, a bit for each direction. The board holds no walk of Wilson's
// algorithm here, so the WG_FREE bit is sufficient.
static inline int64_t free_neighbours(const int8_t *board, int64_t at, int64_t stride)
{
    int64_t east = board[at + 1] >> 3;
    int64_t north = board[at + stride] >> 3;
    int64_t west = board[at - 1] >> 3;
    int64_t south = board[at - stride] >> 3;
    return east + (north << 1) + (west << 2) + (south << 3);
}

// Draws until one of the given directions comes up; returns 4 if the words run out first.
static inline int64_t draw_one_of(int64_t ways, const uint64_t *words, int64_t count, int64_t *used)
{
    while (*used < count) {
        int64_t direction = draw(words, *used);
        ++*used;
        if ((ways >> direction & 1) != 0) {
            return direction;
        }
    }
    return 4;
}

// Makes loop-erased random walks from each chamber to the maze so far; every spanning tree is
// equally likely. David B. Wilson, "Generating random spanning trees more quickly than the cover
// time", STOC 1996.
void wg_maze_wilson(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    const uint64_t *words = growth->words;
    int64_t stride = growth->stride;
    int64_t count = DRAWS_A_WORD * growth->word_count;
    int64_t used = 0;
    int64_t at = maze->at;
    int64_t left = maze->left;
    while (left > 0) {
        // Walk until the maze is reached. Each chamber keeps the last direction out of it, which
        // erases the loops.
        int8_t here = board[at];
        while (here >= WG_FREE) {
            if (used == count) {
                maze->at = at;
                maze->left = left;
                return;
            }
            int64_t direction = draw(words, used);
            used++;
            int64_t beyond = at + wg_maze_step(direction, stride);
            int8_t there = board[beyond];
            if (there != WG_OUTSIDE) {
                board[at] = (int8_t)(WG_FREE + direction);
                at = beyond;
                here = there;
            }
        }
        // The remaining walk becomes part of the maze.
        at = maze->first;
        while (board[at] >= WG_FREE) {
            int64_t direction = board[at] & 3;
            board[at] = (int8_t)direction;
            at += wg_maze_step(direction, stride);
            left--;
        }
        maze->first++;
        at = maze->first;
    }
    maze->left = 0;
}

// Makes one random walk; each chamber keeps the direction from which it was first entered. Every
// tree is equally likely. David J. Aldous, "The random walk construction of uniform spanning trees
// and uniform labelled trees", SIAM Journal on Discrete Mathematics, 1990; Andrei Broder,
// "Generating random spanning trees", FOCS 1989.
void wg_maze_aldous_broder(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    int64_t stride = growth->stride;
    int64_t count = DRAWS_A_WORD * growth->word_count;
    int64_t at = maze->at;
    int64_t left = maze->left;
    for (int64_t used = 0; used < count && left > 0; used++) {
        int64_t direction = draw(growth->words, used);
        int64_t beyond = at + wg_maze_step(direction, stride);
        int8_t there = board[beyond];
        at = there != WG_OUTSIDE ? beyond : at;
        if (there == WG_FREE) {
            board[at] = (int8_t)(direction ^ 2);
            left--;
        }
    }
    maze->at = at;
    maze->left = left;
}

// Digs to random free neighbours, and backtracks if there are none. That path is on the board, so
// there is neither recursion nor a stack. Robert Tarjan, "Depth-first search and linear graph
// algorithms", SIAM Journal on Computing, 1972, with a random choice of the next edge.
void wg_maze_backtracker(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    int64_t stride = growth->stride;
    int64_t count = DRAWS_A_WORD * growth->word_count;
    int64_t used = 0;
    int64_t at = maze->at;
    int64_t left = maze->left;
    while (left > 0) {
        int64_t ways = free_neighbours(board, at, stride);
        if (ways == 0) {
            at += wg_maze_step(board[at], stride);
            continue;
        }
        int64_t direction = draw_one_of(ways, growth->words, count, &used);
        if (direction == 4) {
            break;
        }
        at += wg_maze_step(direction, stride);
        board[at] = (int8_t)(direction ^ 2);
        left--;
    }
    maze->at = at;
    maze->left = left;
}

// The neighbours of a place that are in the maze, a bit for each direction.
static inline int64_t grown_neighbours(const int8_t *board, int64_t at, int64_t stride)
{
    int64_t ways = 0;
    for (int direction = 0; direction < 4; direction++) {
        if (board[at + wg_maze_step(direction, stride)] < WG_OUTSIDE) {
            ways |= 1 << direction;
        }
    }
    return ways;
}

// Digs at random until it is stuck, then hunts, row by row, for a free chamber next to the maze.
// Jamis Buck, "Mazes for Programmers", 2015, chapter 5.
void wg_maze_hunt_and_kill(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    int64_t stride = growth->stride;
    int64_t count = DRAWS_A_WORD * growth->word_count;
    int64_t used = 0;
    int64_t at = maze->at;
    int64_t left = maze->left;
    int64_t first = maze->first;
    int64_t lowest = maze->lowest;
    while (left > 0) {
        int64_t ways = free_neighbours(board, at, stride);
        bool stuck = ways == 0;
        int64_t spot = at;
        if (stuck) {
            while (board[first] != WG_FREE) {
                first++;
            }
            // A free chamber next to the maze is at most one row before the maze's first chamber.
            spot = (first > lowest - stride ? first : lowest - stride) - 1;
            while (ways == 0) {
                spot++;
                if (board[spot] == WG_FREE) {
                    ways = grown_neighbours(board, spot, stride);
                }
            }
        }
        int64_t direction = draw_one_of(ways, growth->words, count, &used);
        if (direction == 4) {
            break;  // the hunt begins again with the next words, and ends at the same chamber
        }
        if (stuck) {
            at = spot;
            board[at] = (int8_t)direction;
        } else {
            at += wg_maze_step(direction, stride);
            board[at] = (int8_t)(direction ^ 2);
        }
        lowest = lowest < at ? lowest : at;
        left--;
    }
    maze->at = at;
    maze->left = left;
    maze->first = first;
    maze->lowest = lowest;
}

// Finds a path for a square as wide as the disc, over whole cells, by breadth-first search. A
// square is named by its lower-left cell.

#include <stdlib.h>
#include <string.h>

#include "reach_internal.h"

// Values of a square's byte: not free, free, the step by which it was reached,
// or where the search began.
enum { NOT_FREE = 0, FREE = 1, FIRST_STEP = 2, BEGUN = 6 };

struct WgSquares {
    WgWalls walls;
    int64_t side;
    int64_t source;
    int64_t goal;
    uint8_t *state;    // ((height + 2) (width + 2),), with a rim of squares that are not free
    // (width,) number of free cells below each column's cell, used while squares are marked
    int32_t *heights;
    int64_t row;       // rows examined so far
    int32_t *now;      // squares reached in the current number of steps
    int32_t *after;    // and in one more step
    int64_t count;
    int64_t room;
};

WgStatus wg_squares_new(const WgWalls *walls, int64_t side, int64_t source, int64_t goal, WgSquares **made)
{
    *made = NULL;
    if (walls->height < 1 || walls->width < 1 || walls->height > 20000 || walls->width > 20000) {
        return WG_BAD_SIZE;
    }
    int64_t size = (walls->height + 2) * (walls->width + 2);
    if (side < 1 || source < 0 || source >= size || goal < 0 || goal >= size) {
        return WG_BAD_VALUE;
    }
    WgSquares *squares = calloc(1, sizeof *squares);
    if (squares == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    squares->walls = *walls;
    squares->side = side;
    squares->source = source;
    squares->goal = goal;
    squares->room = 1024;
    squares->state = calloc((size_t)size, 1);
    squares->heights = calloc((size_t)walls->width, sizeof *squares->heights);
    squares->now = malloc((size_t)squares->room * sizeof *squares->now);
    squares->after = malloc((size_t)squares->room * sizeof *squares->after);
    if (squares->state == NULL || squares->heights == NULL || squares->now == NULL || squares->after == NULL) {
        wg_squares_free(squares);
        return WG_OUT_OF_MEMORY;
    }
    *made = squares;
    return WG_OK;
}

// Marks the free squares whose last row is ``iy``.
static void mark_row(WgSquares *squares, int64_t iy)
{
    int64_t width = squares->walls.width;
    int64_t side = squares->side;
    const uint8_t *solid = squares->walls.solid + iy * width;
    // The square whose last cell is (0, iy), in the array with a rim.
    int64_t first = (iy - side + 2) * (width + 2) - side + 2;
    int64_t run = 0;
    for (int64_t ix = 0; ix < width; ix++) {
        squares->heights[ix] = solid[ix] == 0 ? squares->heights[ix] + 1 : 0;
        run = squares->heights[ix] >= side ? run + 1 : 0;
        if (run >= side) {
            squares->state[first + ix] = FREE;
        }
    }
}

static bool make_room(WgSquares *squares)
{
    if (4 * squares->count <= squares->room) {
        return true;
    }
    int64_t room = 8 * squares->count;
    int32_t *now = realloc(squares->now, (size_t)room * sizeof *now);
    if (now == NULL) {
        return false;
    }
    squares->now = now;
    int32_t *after = realloc(squares->after, (size_t)room * sizeof *after);
    if (after == NULL) {
        return false;
    }
    squares->after = after;
    squares->room = room;
    return true;
}

// Takes one step from all squares reached last.
static void take_step(WgSquares *squares)
{
    int64_t stride = squares->walls.width + 2;
    const int64_t shifts[4] = {1, stride, -1, -stride};
    int64_t found = 0;
    for (int64_t i = 0; i < squares->count; i++) {
        for (int step = 0; step < 4; step++) {
            int64_t there = squares->now[i] + shifts[step];
            if (squares->state[there] == FREE) {
                squares->state[there] = (uint8_t)(FIRST_STEP + step);
                squares->after[found++] = (int32_t)there;
            }
        }
    }
    int32_t *reached = squares->after;
    squares->after = squares->now;
    squares->now = reached;
    squares->count = found;
}

WgStatus wg_squares_advance(WgSquares *squares, int64_t most, WgProgress *progress)
{
    *progress = WG_GOING;
    // First mark all free squares, row by row.
    for (; squares->row < squares->walls.height; squares->row++) {
        if (most <= 0) {
            return WG_OK;
        }
        mark_row(squares, squares->row);
        most -= squares->walls.width;
        if (squares->row + 1 == squares->walls.height) {
            bool free_ends = squares->state[squares->source] == FREE && squares->state[squares->goal] == FREE;
            squares->now[0] = (int32_t)squares->source;
            squares->count = free_ends ? 1 : 0;
            squares->state[squares->source] = BEGUN;
        }
    }
    while (squares->count > 0 && squares->state[squares->goal] == FREE) {
        if (most <= 0) {
            return WG_OK;
        }
        if (!make_room(squares)) {
            return WG_OUT_OF_MEMORY;
        }
        most -= 4 * squares->count;
        take_step(squares);
    }
    *progress = squares->state[squares->goal] > FREE ? WG_FOUND : WG_EXHAUSTED;
    return WG_OK;
}

// Walks back along the path; fills in its corners from the last one down if ``way`` is given.
static int64_t walk_back(const WgSquares *squares, int64_t *way, int64_t count)
{
    int64_t stride = squares->walls.width + 2;
    const int64_t shifts[4] = {1, stride, -1, -stride};
    int64_t corners = 0;
    int64_t at = squares->goal;
    int step = 0;
    while (step != BEGUN) {
        if (squares->state[at] != step) {
            corners++;
            if (way != NULL) {
                way[count - corners] = at;
            }
        }
        step = squares->state[at];
        at -= step == BEGUN ? 0 : shifts[step - FIRST_STEP];
    }
    return corners;
}

int64_t wg_squares_way_length(const WgSquares *squares)
{
    return squares->state[squares->goal] > FREE ? walk_back(squares, NULL, 0) : 0;
}

void wg_squares_way(const WgSquares *squares, int64_t *way)
{
    int64_t count = wg_squares_way_length(squares);
    if (count > 0) {
        walk_back(squares, way, count);
    }
}

void wg_squares_free(WgSquares *squares)
{
    if (squares != NULL) {
        free(squares->state);
        free(squares->heights);
        free(squares->now);
        free(squares->after);
        free(squares);
    }
}

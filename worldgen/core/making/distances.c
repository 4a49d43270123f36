// Squared distances to marked nodes, exactly and in linear time.

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "wg_making.h"

enum {
    MOST_NODES = 1 << 17,  // rows and columns in all
    NARROW = 16,           // number of steps to each side to compare one by one
    FARTHEST = 40000,      // so that the square of it, and of a step, fits into 32 bits
};

// The quotient rounded down, exactly: a is below 2^35 and b below 2^18, so a quotient that isn't a
// whole number is at least 2^-18 away from one, and the rounding of the division is below 2^-18.
static int64_t floor_div(int64_t a, int64_t b)
{
    return (int64_t)floor((double)a / (double)b);
}

// A parabola of the lower envelope: the node that it belongs to,
// and the first node where it is the lowest.
typedef struct Parabola {
    int64_t node;
    int64_t begin;
} Parabola;

static int64_t height(const int32_t *beside, int64_t node, int64_t at)
{
    int64_t along = at - node;
    return along * along + (int64_t)beside[node] * beside[node];
}

// Transforms one row, from the distances in each column.
static void along_row(const int32_t *beside, int64_t count, Parabola *envelope, int32_t *found)
{
    int64_t top = 0;
    envelope[0] = (Parabola){0, 0};
    for (int64_t u = 1; u < count; u++) {
        while (top >= 0 &&
               height(beside, envelope[top].node, envelope[top].begin) > height(beside, u, envelope[top].begin)) {
            top--;
        }
        if (top < 0) {
            top = 0;
            envelope[0] = (Parabola){u, 0};
            continue;
        }
        int64_t s = envelope[top].node;
        int64_t squares = (int64_t)beside[u] * beside[u] - (int64_t)beside[s] * beside[s];
        int64_t begin = 1 + floor_div(u * u - s * s + squares, 2 * (u - s));
        if (begin < count) {
            top++;
            envelope[top] = (Parabola){u, begin};
        }
    }
    for (int64_t u = count - 1; u >= 0; u--) {
        int64_t square = height(beside, envelope[top].node, u);
        found[u] = square > INT32_MAX ? INT32_MAX : (int32_t)square;
        if (u == envelope[top].begin) {
            top--;
        }
    }
}

// Does the same if no node is far from a mark, by comparing step by step to each side, many nodes
// at a time. Returns false if some node that matters may be farther than NARROW:
// its square is not above `most`.
//
// With narrow corridors, this cuts the whole transform to a quarter of the time: 0.04 s instead of
// 0.17 s for the nodes of a maze of 2000 x 2000 cells.
//
// square: (count + 2 * NARROW,) work space.
static bool along_narrow_row(const int32_t *beside, int64_t count, int64_t most, int32_t *square, int32_t *found)
{
    for (int64_t u = 0; u < NARROW; u++) {
        square[u] = FARTHEST * FARTHEST;
        square[NARROW + count + u] = FARTHEST * FARTHEST;
    }
    int32_t *middle = square + NARROW;
    int32_t worst = 0;
    for (int64_t u = 0; u < count; u++) {
        int32_t away = beside[u] < FARTHEST ? beside[u] : FARTHEST;
        middle[u] = away * away;
        found[u] = middle[u];
        worst = middle[u] > worst ? middle[u] : worst;
    }

    // A step whose square is at least the largest distance cannot reduce any distance.
    for (int32_t step = 1; step * step < worst && step * step <= most; step++) {
        if (step > NARROW) {
            return false;
        }
        worst = 0;
        for (int64_t u = 0; u < count; u++) {
            int32_t least = middle[u - step] < middle[u + step] ? middle[u - step] : middle[u + step];
            least += step * step;
            least = least < found[u] ? least : found[u];
            found[u] = least;
            worst = least > worst ? least : worst;
        }
    }
    return true;
}

// Distances in each column to the marks below.
static void up_the_columns(const uint8_t *marked, int64_t rows, int64_t columns, int32_t *found)
{
    int32_t far = (int32_t)(rows + columns);
    for (int64_t column = 0; column < columns; column++) {
        found[column] = marked[column] != 0 ? 0 : far;
    }
    for (int64_t at = columns; at < rows * columns; at++) {
        int32_t below = found[at - columns];
        int32_t next = below < far ? below + 1 : far;
        found[at] = marked[at] != 0 ? 0 : next;
    }
}

// Arnold Meijster, Jos B. T. M. Roerdink, Wim H. Hesselink, "A General Algorithm for Computing
// Distance Transforms in Linear Time", 2000.
WgStatus wg_squared_distances(const uint8_t *marked, int64_t rows, int64_t columns, int64_t most, int32_t *found)
{
    enum { WIDE_ROWS = 16 };  // rows that pass between two checks for narrowness

    if (rows < 1 || columns < 1 || rows > MOST_NODES || columns > MOST_NODES - rows) {
        return WG_BAD_SIZE;
    }
    Parabola *envelope = malloc((size_t)(columns + 1) * sizeof *envelope);
    int32_t *beside = malloc((size_t)(2 * columns + 2 * NARROW) * sizeof *beside);
    if (envelope == NULL || beside == NULL) {
        free(envelope);
        free(beside);
        return WG_OUT_OF_MEMORY;
    }
    up_the_columns(marked, rows, columns, found);

    // Go down the rows: distances in each column to the marks above, then the lowest parabola along
    // the row.
    int64_t next_look = rows - 1;
    for (int64_t row = rows - 1; row >= 0; row--) {
        int32_t *line = found + row * columns;
        for (int64_t column = 0; column < columns; column++) {
            bool is_nearer = row < rows - 1 && beside[column] + 1 < line[column];
            beside[column] = is_nearer ? beside[column] + 1 : line[column];
        }
        if (row <= next_look) {
            if (along_narrow_row(beside, columns, most, beside + columns, line)) {
                continue;
            }
            next_look = row - WIDE_ROWS;
        }
        along_row(beside, columns, envelope, line);
    }
    free(envelope);
    free(beside);
    return WG_OK;
}

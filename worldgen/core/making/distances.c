// Squared distances to marked nodes, exactly and in linear time.

#include <math.h>
#include <stdlib.h>

#include "wg_making.h"

enum { MOST_NODES = 1 << 17 };  // rows and columns in all

// The quotient rounded down, exactly: a is below 2^35 and b below 2^18, so no quotient that is not a whole number comes
// nearer to one than 2^-18, and the rounding of the division is below 2^-18.
static int64_t floor_div(int64_t a, int64_t b)
{
    return (int64_t)floor((double)a / (double)b);
}

// A parabola of the lower envelope: the node that it belongs to, and the node from which on it is the lowest.
typedef struct Parabola {
    int64_t node;
    int64_t begin;
} Parabola;

static int64_t height(const int32_t *beside, int64_t node, int64_t at)
{
    int64_t along = at - node;
    return along * along + (int64_t)beside[node] * beside[node];
}

// Along one row, from the distances in each column.
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

// Arnold Meijster, Jos B. T. M. Roerdink, Wim H. Hesselink, "A General Algorithm for Computing Distance Transforms in
// Linear Time", 2000.
WgStatus wg_squared_distances(const uint8_t *marked, int64_t rows, int64_t columns, int32_t *found)
{
    if (rows < 1 || columns < 1 || rows > MOST_NODES || columns > MOST_NODES - rows) {
        return WG_BAD_SIZE;
    }
    Parabola *envelope = malloc((size_t)(columns + 1) * sizeof *envelope);
    int32_t *beside = malloc((size_t)columns * sizeof *beside);
    if (envelope == NULL || beside == NULL) {
        free(envelope);
        free(beside);
        return WG_OUT_OF_MEMORY;
    }
    // Distances in each column, first to what is below, then to what is above.
    int32_t far = (int32_t)(rows + columns);
    for (int64_t row = 0; row < rows; row++) {
        for (int64_t column = 0; column < columns; column++) {
            int64_t at = row * columns + column;
            int32_t below = row == 0 ? far : found[at - columns];
            int32_t next = below < far ? below + 1 : far;
            found[at] = marked[at] != 0 ? 0 : next;
        }
    }
    for (int64_t row = rows - 2; row >= 0; row--) {
        for (int64_t column = 0; column < columns; column++) {
            int64_t at = row * columns + column;
            int32_t above = found[at + columns] + 1;
            found[at] = above < found[at] ? above : found[at];
        }
    }
    // Then the lower envelope along each row.
    for (int64_t row = 0; row < rows; row++) {
        int32_t *line = found + row * columns;
        for (int64_t column = 0; column < columns; column++) {
            beside[column] = line[column];
        }
        along_row(beside, columns, envelope, line);
    }
    free(envelope);
    free(beside);
    return WG_OK;
}

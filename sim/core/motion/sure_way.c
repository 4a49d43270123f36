// Decides if the disc certainly gets to the target, by a flood over half cells that may miss a path
// but never invents one.
//
// A step of half a cell along an axis has its smallest clearance at an end, a diagonal one at an
// end or in the middle (docs/explanation/reachability.md proves it).

#include <string.h>

#include "geometry.h"

enum { HALF = WG_UNIT / 2 };  // distance of two neighbouring nodes, lattice units

typedef struct Flood {
    WgGrid grid;
    WgDisc disc;
    int64_t columns;  // columns of nodes
    int64_t rows;
    uint8_t *seen;   // (rows, columns)
    int64_t *stack;  // (rows * columns,)
    int64_t count;
} Flood;

static bool is_clear(const Flood *flood, int64_t x, int64_t y)
{
    return wg_disc_is_clear(flood->grid, WG_SOLID, flood->disc, x, y);
}

// Returns true if the disc, which is clear at both ends, may move from one to the other.
static bool goes_straight(const Flood *flood, WgSegment way)
{
    return !wg_first_not_clear(flood->grid, WG_SOLID, flood->disc, way).found;
}

static void push(Flood *flood, int64_t i, int64_t j)
{
    int64_t node = j * flood->columns + i;
    flood->seen[node] = 1;
    flood->stack[flood->count++] = node;
}

// Pushes the nodes around the start that the disc reaches in a straight line.
static void begin(Flood *flood, int64_t x, int64_t y)
{
    for (int64_t j = wg_floor_div(y, HALF); j <= wg_floor_div(y + HALF - 1, HALF); j++) {
        for (int64_t i = wg_floor_div(x, HALF); i <= wg_floor_div(x + HALF - 1, HALF); i++) {
            WgSegment way = {x, y, i * HALF, j * HALF};
            if (is_clear(flood, way.qx, way.qy) && goes_straight(flood, way)) {
                push(flood, i, j);
            }
        }
    }
}

// Pushes the neighbours of a node that the disc reaches from it.
static void spread(Flood *flood, int64_t i, int64_t j)
{
    for (int step = 0; step < 9; step++) {
        int64_t di = step % 3 - 1;
        int64_t dj = step / 3 - 1;
        int64_t column = i + di;
        int64_t row = j + dj;
        if (column < 0 || column >= flood->columns || row < 0 || row >= flood->rows) {
            continue;
        }
        uint8_t *seen = &flood->seen[row * flood->columns + column];
        if (*seen != 0) {
            continue;
        }
        if (!is_clear(flood, column * HALF, row * HALF)) {
            *seen = 1;
            continue;
        }
        bool is_straight = di * dj == 0;
        if (is_straight || is_clear(flood, i * HALF + di * (HALF / 2), j * HALF + dj * (HALF / 2))) {
            push(flood, column, row);
        }
    }
}

bool wg_surely_reaches(WgGrid grid, WgDisc disc, WgSegment way, int64_t within_sq, uint8_t *seen, int64_t *stack)
{
    Flood flood = {grid, disc, 2 * grid.width + 1, 2 * grid.height + 1, seen, stack, 0};
    memset(seen, 0, (size_t)(flood.columns * flood.rows));
    if (!is_clear(&flood, way.px, way.py)) {
        return false;
    }
    int64_t to_x = way.qx;
    int64_t to_y = way.qy;
    if ((way.px - to_x) * (way.px - to_x) + (way.py - to_y) * (way.py - to_y) <= within_sq) {
        return true;
    }
    bool target_is_clear = is_clear(&flood, to_x, to_y);
    begin(&flood, way.px, way.py);
    while (flood.count > 0) {
        int64_t node = stack[--flood.count];
        int64_t i = node % flood.columns;
        int64_t j = node / flood.columns;
        int64_t x = i * HALF;
        int64_t y = j * HALF;

        // At a node in the target's disc, or next to its centre, it has arrived.
        if ((x - to_x) * (x - to_x) + (y - to_y) * (y - to_y) <= within_sq) {
            return true;
        }
        bool is_near = target_is_clear && wg_abs(x - to_x) < HALF && wg_abs(y - to_y) < HALF;
        if (is_near && goes_straight(&flood, (WgSegment){x, y, to_x, to_y})) {
            return true;
        }
        spread(&flood, i, j);
    }
    return false;
}

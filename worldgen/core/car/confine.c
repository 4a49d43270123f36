// Finds where a car that never reverses can get: a set of boxes of poses that it cannot leave.

#include <stdbool.h>
#include <stdlib.h>

#include "wg_car.h"

typedef struct Flood {
    const WgCarFlood *asked;
    uint8_t *reached;    // (headings, rows, columns)
    int64_t *sums;       // (rows + 1, columns + 1) free boxes left of and below each corner
    int64_t *waiting;    // boxes whose successors have not been reached yet
    int64_t count;
    bool escapes;        // it has reached a box near the target
} Flood;

static void reach(Flood *flood, int64_t box)
{
    if (flood->reached[box] == 0) {
        flood->reached[box] = 1;
        flood->waiting[flood->count++] = box;
    }
}

static int64_t within(int64_t value, int64_t most)
{
    return value < 0 ? 0 : value > most ? most : value;
}

// Returns true if the car may be in one of some boxes around another one: (left, right, low, high), included.
static bool has_room(const Flood *flood, int64_t column, int64_t row, const int32_t *around)
{
    int64_t columns = flood->asked->columns;
    int64_t rows = flood->asked->rows;
    int64_t left = within(column + around[0], columns);
    int64_t right = within(column + around[1] + 1, columns);
    int64_t low = within(row + around[2], rows);
    int64_t high = within(row + around[3] + 1, rows);
    if (left >= right || low >= high) {
        return false;
    }
    const int64_t *sums = flood->sums;
    int64_t width = columns + 1;
    return sums[high * width + right] - sums[high * width + left] - sums[low * width + right] + sums[low * width + left] > 0;
}

static void reach_from(Flood *flood, int64_t box)
{
    const WgCarFlood *asked = flood->asked;
    int64_t layer = asked->rows * asked->columns;
    int64_t heading = box / layer;
    int64_t row = box % layer / asked->columns;
    int64_t column = box % asked->columns;
    int64_t turns = 2 * asked->most_turn + 1;
    for (int64_t turn = 0; turn < turns; turn++) {
        // The last of these rectangles is at the end of a step, the others are on the way.
        const int32_t *on_way = asked->steps + 4 * asked->parts * (heading * turns + turn);
        bool passes = true;
        for (int64_t part = 0; part < asked->parts && passes; part++) {
            passes = has_room(flood, column, row, on_way + 4 * part);
        }
        if (!passes) {
            continue;
        }
        const int32_t *end = on_way + 4 * (asked->parts - 1);
        int64_t next = (heading + turn - asked->most_turn + asked->headings) % asked->headings;
        int64_t right = within(column + end[1] + 1, asked->columns);
        int64_t high = within(row + end[3] + 1, asked->rows);
        for (int64_t y = within(row + end[2], asked->rows); y < high; y++) {
            for (int64_t x = within(column + end[0], asked->columns); x < right; x++) {
                uint8_t place = asked->places[y * asked->columns + x];
                flood->escapes = flood->escapes || place == WG_CAR_AT_TARGET;
                if (place != WG_CAR_IN_WALL) {
                    reach(flood, next * layer + y * asked->columns + x);
                }
            }
        }
    }
}

WgStatus wg_car_flood(const WgCarFlood *asked, uint8_t *reached, int64_t *escapes)
{
    int64_t layer = asked->rows * asked->columns;
    int64_t boxes = asked->headings * layer;
    Flood flood = {asked, reached, NULL, NULL, 0, false};
    flood.sums = calloc((size_t)((asked->rows + 1) * (asked->columns + 1)), sizeof *flood.sums);
    flood.waiting = malloc((size_t)boxes * sizeof *flood.waiting);
    if (flood.sums == NULL || flood.waiting == NULL) {
        free(flood.sums);
        free(flood.waiting);
        return WG_OUT_OF_MEMORY;
    }
    int64_t width = asked->columns + 1;
    for (int64_t y = 0; y < asked->rows; y++) {
        for (int64_t x = 0; x < asked->columns; x++) {
            int64_t *sum = &flood.sums[(y + 1) * width + x + 1];
            *sum = sum[-1] + sum[-width] - sum[-width - 1] + (asked->places[y * asked->columns + x] != WG_CAR_IN_WALL ? 1 : 0);
        }
    }
    for (int64_t box = 0; box < boxes; box++) {
        if (reached[box] != 0) {
            flood.waiting[flood.count++] = box;
        }
    }
    while (flood.count > 0 && !flood.escapes) {
        reach_from(&flood, flood.waiting[--flood.count]);
    }
    *escapes = flood.escapes ? 1 : 0;
    free(flood.sums);
    free(flood.waiting);
    return WG_OK;
}

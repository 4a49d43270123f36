// Places: points with a locally largest free disc.

#include <math.h>

#include "grid.h"
#include "wg_making.h"

WgStatus wg_largest_discs(const uint8_t *clear, const int32_t *squared, const int32_t *away, int64_t rows,
                          int64_t columns, uint8_t *found)
{
    if (!wg_rim_is_closed(clear, rows * columns, columns)) {
        return WG_BAD_SIZE;
    }
    int64_t steps[8];
    wg_eight_steps(columns, steps);
    for (int64_t at = 0; at < rows * columns; at++) {
        bool highest = clear[at] != 0 && away[at] <= 4 * (int64_t)squared[at];
        for (int direction = 0; highest && direction < 8; direction++) {
            highest = squared[at + steps[direction]] <= squared[at];
        }
        found[at] = highest;
    }
    return WG_OK;
}

// Returns the first of the places, in ascending order, that is not before a node.
static int64_t first_from(const int64_t *places, int64_t count, int64_t node)
{
    int64_t low = 0;
    int64_t high = count;
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (places[middle] < node) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

WgStatus wg_highest(const int64_t *places, const int64_t *sizes, int64_t count, int64_t stride, const int64_t *asked,
                    int64_t asked_count, uint8_t *found)
{
    if (stride < 1 || stride > INT32_MAX || count < 0 || asked_count < 0) {
        return WG_BAD_SIZE;
    }
    int64_t largest = 0;
    for (int64_t k = 0; k < count; k++) {
        bool is_sorted = places[k] >= 0 && (k == 0 || places[k - 1] < places[k]);
        if (!is_sorted || sizes[k] < 0 || sizes[k] > INT32_MAX) {
            return WG_BAD_VALUE;
        }
        largest = sizes[k] > largest ? sizes[k] : largest;
    }

    // No disc reaches farther than the largest, so go row by row through the places near each one.
    int64_t reach = (int64_t)sqrt((double)largest) + 1;
    for (int64_t n = 0; n < asked_count; n++) {
        if (asked[n] < 0 || asked[n] >= count) {
            return WG_BAD_VALUE;
        }
        int64_t x = places[asked[n]] % stride;
        int64_t y = places[asked[n]] / stride;
        int64_t own = sizes[asked[n]];
        int64_t left = x > reach ? x - reach : 0;
        int64_t right = x + reach < stride ? x + reach : stride - 1;
        bool is_highest = true;
        for (int64_t row = y > reach ? y - reach : 0; is_highest && row <= y + reach; row++) {
            int64_t k = first_from(places, count, row * stride + left);
            for (; is_highest && k < count && places[k] <= row * stride + right; k++) {
                int64_t dx = places[k] - row * stride - x;
                int64_t dy = row - y;
                is_highest = sizes[k] <= own || dx * dx + dy * dy > sizes[k];
            }
        }
        found[n] = is_highest;
    }
    return WG_OK;
}

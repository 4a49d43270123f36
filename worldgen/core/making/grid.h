// Shared by the searches over flat grids.

#ifndef WG_MAKING_GRID_H
#define WG_MAKING_GRID_H

#include <stdbool.h>
#include <stdint.h>

// Returns true if the size belongs to a grid with a rim of 0, so that no step from a nonzero place
// leaves it.
static inline bool wg_rim_is_closed(const uint8_t *grid, int64_t size, int64_t stride)
{
    if (stride < 1 || size < stride || size > INT32_MAX || size % stride != 0) {
        return false;
    }
    for (int64_t i = 0; i < stride; i++) {
        if (grid[i] != 0 || grid[size - stride + i] != 0) {
            return false;
        }
    }
    for (int64_t i = 0; i < size; i += stride) {
        if (grid[i] != 0 || grid[i + stride - 1] != 0) {
            return false;
        }
    }
    return true;
}

// The offsets of the eight steps in flat indices, the four along the axes first.
static inline void wg_eight_steps(int64_t stride, int64_t steps[8])
{
    steps[0] = 1;
    steps[1] = -1;
    steps[2] = stride;
    steps[3] = -stride;
    steps[4] = stride + 1;
    steps[5] = -stride - 1;
    steps[6] = stride - 1;
    steps[7] = 1 - stride;
}

// The offsets of the middles of the four diagonal steps; straight steps need none.
static inline void wg_eight_middles(int64_t stride, int64_t middles[8])
{
    middles[0] = 0;
    middles[1] = 0;
    middles[2] = 0;
    middles[3] = 0;
    middles[4] = 0;
    middles[5] = -stride - 1;
    middles[6] = -1;
    middles[7] = -stride;
}

#endif

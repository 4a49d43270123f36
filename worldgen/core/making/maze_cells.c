// Turns links between chambers into solid cells. Each strip of the plan is drawn once, then copied
// to all of its rows.

#include <stdlib.h>
#include <string.h>

#include "wg_making.h"

// The sum of positive lengths; -1 if one is not positive, or the sum exceeds the largest grid.
static int64_t sum_of(const int64_t *lengths, int64_t count)
{
    int64_t sum = 0;
    for (int64_t i = 0; i < count; i++) {
        if (lengths[i] < 1 || lengths[i] > INT32_MAX - sum) {
            return -1;
        }
        sum += lengths[i];
    }
    return sum;
}

// One strip of the plan, a byte for each strip across. Strips of chambers and of walls alternate;
// the one below the first chambers is solid.
static void plan_strip(const int8_t *links, int64_t columns, int64_t strip, uint8_t *plan)
{
    plan[0] = 1;
    if (strip == 0) {
        memset(plan, 1, (size_t)(2 * columns + 1));
        return;
    }
    const int8_t *row = links + (strip - 1) / 2 * columns;
    if (strip % 2 == 1) {
        for (int64_t column = 0; column < columns; column++) {
            plan[2 * column + 1] = (row[column] & WG_ROCK) != 0;
            plan[2 * column + 2] = (row[column] & WG_EAST) == 0;
        }
        return;
    }
    for (int64_t column = 0; column < columns; column++) {
        plan[2 * column + 1] = (row[column] & WG_NORTH) == 0;
        plan[2 * column + 2] = (row[column] & WG_CORNER) == 0;
    }
}

WgStatus wg_maze_cells(const int8_t *links, int64_t rows, int64_t columns, const int64_t *across, const int64_t *up,
                       uint8_t *walls, int64_t cells)
{
    if (rows < 1 || columns < 1 || rows > INT32_MAX / 4 || columns > INT32_MAX / 4) {
        return WG_BAD_SIZE;
    }
    int64_t width = sum_of(across, 2 * columns + 1);
    int64_t height = sum_of(up, 2 * rows + 1);
    if (width < 0 || height < 0) {
        return WG_BAD_VALUE;
    }
    if (cells != width * height) {
        return WG_BAD_SIZE;
    }
    uint8_t *plan = malloc((size_t)(2 * columns + 1));
    int32_t *strip_at = malloc((size_t)width * sizeof *strip_at);
    if (plan == NULL || strip_at == NULL) {
        free(plan);
        free(strip_at);
        return WG_OUT_OF_MEMORY;
    }
    int64_t end = 0;
    for (int64_t strip = 0; strip < 2 * columns + 1; strip++) {
        for (int64_t k = 0; k < across[strip]; k++) {
            strip_at[end] = (int32_t)strip;
            end++;
        }
    }
    uint8_t *line = walls;
    for (int64_t strip = 0; strip < 2 * rows + 1; strip++) {
        plan_strip(links, columns, strip, plan);
        for (int64_t x = 0; x < width; x++) {
            line[x] = plan[strip_at[x]];
        }
        for (int64_t copy = 1; copy < up[strip]; copy++) {
            memcpy(line + copy * width, line, (size_t)width);
        }
        line += up[strip] * width;
    }
    free(plan);
    free(strip_at);
    return WG_OK;
}

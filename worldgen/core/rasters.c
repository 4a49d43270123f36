// Finds where a disc is clear, for all nodes and midpoints of a graph together, by comparing rows
// of cells 16 at a time.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reach_internal.h"

enum { MOST_SIDE = 20000, MOST_K = 64 };

// Cells that a disc around one kind of point touches, in one row.
typedef struct DiscRow {
    int64_t up;     // cells up from the point's own
    int64_t first;  // first cell to the right
    int64_t count;  // how many
} DiscRow;

// The rows of every kind of point: nodes and midpoints in turn, by x and then y within a cell.
typedef struct DiscRows {
    DiscRow *rows;
    int64_t *begins;  // (2 k^2 + 1,)
    int64_t pad;      // reach of the farthest row, plus one
    int64_t longest;  // largest number of cells in a row
} DiscRows;

int64_t wg_root_floor(int64_t square)
{
    int64_t root = (int64_t)sqrt((double)square);
    while (root * root > square) {
        root--;
    }
    while ((root + 1) * (root + 1) <= square) {
        root++;
    }
    return root;
}

static bool list_rows(DiscRows *all, int64_t k, int64_t limit)
{
    int64_t m = 2 * k;
    int64_t kinds = 2 * k * k;
    int64_t reach = wg_root_floor(limit - 1);
    int64_t most = 2 * (reach / m + 2);
    all->rows = malloc((size_t)(kinds * most) * sizeof *all->rows);
    all->begins = malloc((size_t)(kinds + 1) * sizeof *all->begins);
    if (all->rows == NULL || all->begins == NULL) {
        return false;
    }
    int64_t count = 0;
    all->pad = 0;
    all->longest = 0;
    for (int64_t kind = 0; kind < kinds; kind++) {
        all->begins[kind] = count;
        int64_t b = 2 * (kind / (2 * k)) + kind % 2;
        int64_t a = 2 * (kind / 2 % k) + kind % 2;
        for (int64_t up = -((reach + m - b) / m); up <= (reach + b) / m; up++) {
            // Clear means a squared distance of at least the limit; this row's cells are nearer.
            int64_t dy = wg_max(wg_max(m * up - b, 0), b - m * up - m);
            int64_t across = wg_root_floor(limit - dy * dy - 1);
            int64_t low = -((across + m - a) / m);
            int64_t high = (across + a) / m;
            all->rows[count++] = (DiscRow){up, low, high - low + 1};
            all->longest = wg_max(all->longest, high - low + 1);
            all->pad = wg_max(all->pad, wg_max(wg_max(wg_abs(up), -low), high + 1));
        }
    }
    all->begins[kinds] = count;
    all->pad += 1;
    return true;
}

// Counts the free cells to the right of each cell, up to 255 or 65,535,
// so that many can be compared at a time.
#define COUNT_GAPS(NAME, TYPE, MOST)                                                                        \
    static void NAME(const uint8_t *solid, int64_t height, int64_t width, int64_t pad, TYPE *gaps)          \
    {                                                                                                       \
        int64_t wide = width + 2 * pad;                                                                     \
        for (int64_t j = 0; j < height; j++) {                                                              \
            TYPE *line = gaps + (pad + j) * wide + pad;                                                     \
            int64_t free_cells = 0;                                                                         \
            for (int64_t i = width - 1; i >= 0; i--) {                                                      \
                free_cells = solid[j * width + i] != 0 ? 0 : wg_min(free_cells + 1, MOST);                  \
                line[i] = (TYPE)free_cells;                                                                 \
            }                                                                                               \
        }                                                                                                   \
    }

#define COMPARE_ROW(NAME, TYPE)                                                                             \
    static void NAME(const TYPE *restrict gaps, int64_t count, int64_t columns, uint8_t *restrict line)     \
    {                                                                                                       \
        TYPE least = (TYPE)count;                                                                           \
        for (int64_t i = 0; i < columns; i++) {                                                             \
            line[i] &= gaps[i] >= least;                                                                    \
        }                                                                                                   \
    }

COUNT_GAPS(count_gaps_8, uint8_t, 255)
COUNT_GAPS(count_gaps_16, uint16_t, 65535)
COMPARE_ROW(compare_row_8, uint8_t)
COMPARE_ROW(compare_row_16, uint16_t)

// Puts the lines of one height within a cell next to each other:
// line a has the points at a/k of each cell.
static void interleave(const uint8_t *restrict lines, int64_t room, int64_t k, int64_t width, uint8_t *restrict out)
{
    // Half cells are the usual case, which the compiler vectorises to 16 at a time.
    if (k == 2) {
        for (int64_t i = 0; i < width; i++) {
            out[2 * i] = lines[i];
            out[2 * i + 1] = lines[room + i];
        }
        return;
    }
    for (int64_t a = 0; a < k; a++) {
        for (int64_t i = 0; i < width; i++) {
            out[k * i + a] = lines[a * room + i];
        }
    }
}

WgStatus wg_disc_rasters(const uint8_t *solid, int64_t height, int64_t width, int64_t k, int64_t limit,
                         uint8_t *clear, uint8_t *middle)
{
    if (height < 1 || width < 1 || height > MOST_SIDE || width > MOST_SIDE || k < 1 || k > MOST_K) {
        return WG_BAD_SIZE;
    }
    if (limit < 1 || limit > 4 * k * k * MOST_SIDE * MOST_SIDE) {
        return WG_BAD_VALUE;
    }
    DiscRows all = {NULL, NULL, 0, 0};
    WgStatus status = WG_OUT_OF_MEMORY;
    void *gaps = NULL;
    uint8_t *lines = NULL;
    if (!list_rows(&all, k, limit)) {
        goto end;
    }
    bool narrow = all.longest <= 255;
    int64_t wide = width + 2 * all.pad;
    int64_t room = width + 1;
    gaps = calloc((size_t)(wide * (height + 2 * all.pad)), narrow ? sizeof(uint8_t) : sizeof(uint16_t));
    lines = malloc((size_t)(room * k));
    if (gaps == NULL || lines == NULL) {
        goto end;
    }
    if (narrow) {
        count_gaps_8(solid, height, width, all.pad, gaps);
    } else {
        count_gaps_16(solid, height, width, all.pad, gaps);
    }

    // Go through the graph row by row: nodes, then middles.
    int64_t stride = k * width + 1;
    for (int64_t j = 0; j <= height; j++) {
        int64_t heights = j < height ? k : 1;
        for (int64_t part = 0; part < 2 * heights; part++) {
            int64_t b = part / 2;
            int64_t is_middle = part % 2;
            uint8_t *out = (is_middle != 0 ? middle : clear) + (k * j + b) * stride;
            if (j == height && is_middle != 0) {
                memset(out, 0, (size_t)stride);
                continue;
            }
            memset(lines, 1, (size_t)(room * k));
            for (int64_t a = 0; a < k; a++) {
                int64_t kind = 2 * (b * k + a) + is_middle;
                for (int64_t row = all.begins[kind]; row < all.begins[kind + 1]; row++) {
                    DiscRow touched = all.rows[row];
                    int64_t first = (all.pad + j + touched.up) * wide + all.pad + touched.first;
                    if (narrow) {
                        compare_row_8((uint8_t *)gaps + first, touched.count, width, lines + a * room);
                    } else {
                        compare_row_16((uint16_t *)gaps + first, touched.count, width, lines + a * room);
                    }
                }
            }
            interleave(lines, room, k, width, out);
            // The last column is the grid's rim, where no disc is clear.
            out[k * width] = 0;
        }
    }
    status = WG_OK;
end:
    free(all.rows);
    free(all.begins);
    free(gaps);
    free(lines);
    return status;
}

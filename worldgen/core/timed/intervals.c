// Finds when points of a raster are safe: between the spans in which nearby cells are blocked.

#include <stdlib.h>

#include "reach_internal.h"

static const int64_t FOREVER = (int64_t)1 << 60;  // a tick later than any other

// Spans around one point, sorted by their beginnings.
typedef struct Around {
    int64_t *low;
    int64_t *high;
    int64_t count;
} Around;

static bool makes_sense(const WgBlocked *blocked, int64_t from, int64_t to)
{
    int64_t k = blocked->k;
    bool sized = k >= 1 && k <= 64 && blocked->rows >= 1 && blocked->columns >= 1 && blocked->pad >= 0 &&
                 blocked->stride >= 2 * blocked->pad + 1 && blocked->most >= 0 && from >= 0 && from <= to &&
                 to <= blocked->rows * blocked->columns;
    if (!sized) {
        return false;
    }
    // No step may lead out of the cells.
    int64_t first = blocked->pad * blocked->stride + blocked->pad;
    int64_t last = ((blocked->rows - 1) / k + blocked->pad) * blocked->stride + (blocked->columns - 1) / k +
                   blocked->pad;
    for (int64_t s = 0; s < blocked->class_first[k * k]; s++) {
        if (first + blocked->steps[s] < 0 || last + blocked->steps[s] >= blocked->cells) {
            return false;
        }
    }
    return true;
}

// Collects the spans in which some cell near a point is blocked,
// sorted by insertion because there are few.
static void collect(const WgBlocked *blocked, int64_t point, Around *around)
{
    int64_t k = blocked->k;
    int64_t y = point / blocked->columns;
    int64_t x = point % blocked->columns;
    int64_t place = (y / k + blocked->pad) * blocked->stride + x / k + blocked->pad;
    int64_t kind = y % k * k + x % k;
    around->count = 0;
    for (int64_t s = blocked->class_first[kind]; s < blocked->class_first[kind + 1]; s++) {
        int64_t cell = place + blocked->steps[s];
        for (int64_t span = blocked->span_first[cell]; span < blocked->span_first[cell + 1]; span++) {
            int64_t at = around->count++;
            while (at > 0 && around->low[at - 1] > blocked->span_begin[span]) {
                around->low[at] = around->low[at - 1];
                around->high[at] = around->high[at - 1];
                at--;
            }
            around->low[at] = blocked->span_begin[span];
            around->high[at] = blocked->span_end[span];
        }
    }
}

// Writes the gaps between spans if ``begin`` is given; returns how many there are.
static int64_t list_gaps(const Around *around, int64_t *begin, int64_t *end)
{
    int64_t found = 0;
    int64_t free_from = 0;  // first tick at which nothing seen so far blocks the point
    for (int64_t i = 0; i <= around->count; i++) {
        int64_t until = i < around->count ? around->low[i] : FOREVER;
        if (until > free_from) {
            if (begin != NULL) {
                begin[found] = free_from;
                end[found] = until;
            }
            found++;
        }
        if (i < around->count) {
            free_from = wg_max(free_from, around->high[i]);
        }
    }
    return found;
}

WgStatus wg_safe_intervals(const WgBlocked *blocked, int64_t from, int64_t to, int64_t *first, int64_t *begin,
                           int64_t *end, int64_t writes)
{
    if (!makes_sense(blocked, from, to)) {
        return WG_BAD_VALUE;
    }
    Around around = {NULL, NULL, 0};
    around.low = malloc((size_t)(2 * blocked->most + 2) * sizeof *around.low);
    if (around.low == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    around.high = around.low + blocked->most + 1;
    for (int64_t point = from; point < to; point++) {
        if (blocked->clear[point] == 0) {
            continue;
        }
        collect(blocked, point, &around);
        if (writes != 0) {
            list_gaps(&around, begin + first[point], end + first[point]);
        } else {
            first[point + 1] = list_gaps(&around, NULL, NULL);
        }
    }
    free(around.low);
    return WG_OK;
}

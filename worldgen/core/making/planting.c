// Places things wherever they fit, with a minimum gap between any two.

#include <stdbool.h>

#include "wg_making.h"

// Finds the smallest and the largest of some offsets and 0.
typedef struct Span {
    int64_t low;
    int64_t high;
} Span;

static Span span_of(const int64_t *offsets, int64_t count, Span span)
{
    for (int64_t i = 0; i < count; i++) {
        span.low = offsets[i] < span.low ? offsets[i] : span.low;
        span.high = offsets[i] > span.high ? offsets[i] : span.high;
    }
    return span;
}

static bool rises(const int64_t *ends, int64_t count)
{
    int64_t before = 0;
    for (int64_t i = 0; i < count; i++) {
        if (ends[i] < before) {
            return false;
        }
        before = ends[i];
    }
    return true;
}

WgStatus wg_plant(uint8_t *barred, int64_t size, const int64_t *places, const int64_t *which, int64_t turns,
                  const int64_t *cells, const int64_t *cell_ends, const int64_t *halos, const int64_t *halo_ends,
                  int64_t kinds, uint8_t *stands)
{
    if (kinds < 1 || !rises(cell_ends, kinds) || !rises(halo_ends, kinds)) {
        return WG_BAD_VALUE;
    }
    Span span = {0, 0};
    span = span_of(cells, cell_ends[kinds - 1], span);
    span = span_of(halos, halo_ends[kinds - 1], span);
    for (int64_t turn = 0; turn < turns; turn++) {
        int64_t at = places[turn];
        int64_t kind = which[turn];
        bool inside = at >= -span.low && at < size - span.high;
        if (!inside || kind < 0 || kind >= kinds) {
            return WG_BAD_VALUE;
        }
        stands[turn] = 0;
        bool fits = barred[at] == 0;
        for (int64_t k = kind > 0 ? cell_ends[kind - 1] : 0; fits && k < cell_ends[kind]; k++) {
            fits = barred[at + cells[k]] == 0;
        }
        if (!fits) {
            continue;
        }
        stands[turn] = 1;
        for (int64_t k = kind > 0 ? halo_ends[kind - 1] : 0; k < halo_ends[kind]; k++) {
            barred[at + halos[k]] = 1;
        }
    }
    return WG_OK;
}

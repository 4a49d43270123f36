// Bounds where a robot can be, by tile and slab of time: in one slab it moves at most one tile.

#include "heap.h"
#include "reach_internal.h"

struct WgSpread {
    WgTiles tiles;
    WgHeap heap;  // (slab, state)
};

WgStatus wg_spread_new(const WgTiles *tiles, const int64_t *sources, int64_t source_count, WgSpread **made)
{
    *made = NULL;
    if (tiles->rows < 1 || tiles->columns < 1 || tiles->states < 0) {
        return WG_BAD_SIZE;
    }
    WgSpread *spread = calloc(1, sizeof *spread);
    if (spread == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    spread->tiles = *tiles;
    for (int64_t i = 0; i < source_count; i++) {
        if (sources[i] < 0 || sources[i] >= tiles->states) {
            wg_spread_free(spread);
            return WG_BAD_VALUE;
        }
        tiles->came[sources[i]] = 0;
        if (!wg_heap_push(&spread->heap, (WgEntry){0, sources[i], 0})) {
            wg_spread_free(spread);
            return WG_OUT_OF_MEMORY;
        }
    }
    *made = spread;
    return WG_OK;
}

// Steps from one state to all tiles around its own, and to later states of its own tile.
static bool go_on(WgSpread *spread, int64_t now, int64_t state)
{
    const WgTiles *tiles = &spread->tiles;
    int64_t x = tiles->tile[state] % tiles->columns;
    int64_t y = tiles->tile[state] / tiles->columns;
    for (int64_t iy = wg_max(y - 1, 0); iy < wg_min(y + 2, tiles->rows); iy++) {
        for (int64_t ix = wg_max(x - 1, 0); ix < wg_min(x + 2, tiles->columns); ix++) {
            int64_t other = iy * tiles->columns + ix;
            for (int64_t onto = tiles->first[other]; onto < tiles->first[other + 1]; onto++) {
                int64_t at = wg_max(now + 1, tiles->low[onto]);
                if (tiles->came[onto] >= 0 || at > tiles->high[onto] || at > tiles->high[state] + 1) {
                    continue;
                }
                tiles->came[onto] = at;
                if (!wg_heap_push(&spread->heap, (WgEntry){at, onto, 0})) {
                    return false;
                }
            }
        }
    }
    return true;
}

WgStatus wg_spread_advance(WgSpread *spread, int64_t most, WgProgress *progress, int64_t *slab)
{
    const WgTiles *tiles = &spread->tiles;
    *slab = -1;
    for (; spread->heap.count > 0; most--) {
        if (most <= 0) {
            *progress = WG_GOING;
            return WG_OK;
        }
        WgEntry entry = wg_heap_pop(&spread->heap);
        if (tiles->goal[tiles->tile[entry.second]] == 1) {
            *progress = WG_FOUND;
            *slab = entry.key;
            return WG_OK;
        }
        if (!go_on(spread, entry.key, entry.second)) {
            return WG_OUT_OF_MEMORY;
        }
    }
    *progress = WG_EXHAUSTED;
    return WG_OK;
}

void wg_spread_free(WgSpread *spread)
{
    if (spread != NULL) {
        free(spread->heap.entries);
        free(spread);
    }
}

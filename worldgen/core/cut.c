// Shortest closed chains of cells that wind around a pose: breadth-first over (cell, bits).
//
// Each cell that was seen is struck out from its row, so that the search never looks at a cell twice: of a wide disc's
// thousands of links from each cell, it follows those to new cells only.

#include "reach_internal.h"

// Which entry of a row is the next one that was not seen, from ``v`` on; halves the way there for later.
static inline int64_t next_unseen(int32_t *skip, int64_t v)
{
    while (skip[v] != v) {
        skip[v] = skip[skip[v]];
        v = skip[v];
    }
    return v;
}

static void see(WgOddWalk *walk, int64_t cell, int64_t layer, int64_t from)
{
    int64_t state = (cell << walk->bits) + layer;
    int64_t place = layer * (walk->cells + 1) + cell;
    walk->before[state] = (int32_t)from;
    walk->skip[place] = (int32_t)(place + 1);
    walk->order[walk->tail++] = (int32_t)state;
}

// Follows the listed links of a cell near a ray: they have bits.
static void follow_listed(WgOddWalk *walk, int64_t state, int64_t slot, int64_t layer)
{
    for (int64_t link = walk->begins[slot]; link < walk->begins[slot + 1]; link++) {
        int64_t other_layer = layer ^ walk->odd[link];
        int64_t cell = walk->ends[link];
        walk->looked++;
        if (walk->before[(cell << walk->bits) + other_layer] < 0) {
            see(walk, cell, other_layer, state);
        }
    }
}

// Follows all other cells' links, row by row, to cells that were not seen in this layer.
static void follow_rows(WgOddWalk *walk, int64_t state, int64_t cell, int64_t layer)
{
    int64_t base = layer * (walk->cells + 1);
    for (int64_t row = 0; row < walk->row_count; row++) {
        int64_t at = walk->place[cell] + walk->rows[2 * row];
        int64_t wide = walk->rows[2 * row + 1];
        int64_t last = base + walk->rank[at + wide + 1];
        int64_t v = base + walk->rank[at - wide];
        walk->looked++;
        while (v < last) {
            v = next_unseen(walk->skip, v);
            if (v >= last) {
                break;
            }
            see(walk, v - base, layer, state);
            walk->looked++;
        }
    }
}

WgStatus wg_odd_walk_begin(WgOddWalk *walk, int64_t source)
{
    if (walk->bits < 1 || walk->bits > 8 || source < 0 || source >= walk->cells || walk->row_count < 0 ||
        (walk->cells + 1) << walk->bits > INT32_MAX) {
        return WG_BAD_VALUE;
    }
    walk->source = source;
    walk->head = 0;
    walk->tail = 0;
    walk->level_end = 1;
    walk->depth = 0;
    walk->looked = 0;
    walk->found = 0;
    see(walk, source, 0, source << walk->bits);
    return WG_OK;
}

// Fills in the chain, the last cell first, and makes the arrays as they were.
static void finish(WgOddWalk *walk, int64_t goal)
{
    int64_t full = ((int64_t)1 << walk->bits) - 1;
    if (walk->before[goal] >= 0) {
        int64_t state = goal;
        while (state != walk->source << walk->bits) {
            walk->chain[walk->found++] = (int32_t)(state >> walk->bits);
            state = walk->before[state];
        }
    }
    for (int64_t i = 0; i < walk->tail; i++) {
        int64_t state = walk->order[i];
        int64_t place = (state & full) * (walk->cells + 1) + (state >> walk->bits);
        walk->before[state] = -1;
        walk->skip[place] = (int32_t)place;
    }
}

WgStatus wg_odd_walk_advance(WgOddWalk *walk, int64_t limit, int64_t thorough, int64_t most, WgProgress *progress)
{
    int64_t full = ((int64_t)1 << walk->bits) - 1;
    int64_t goal = (walk->source << walk->bits) + full;
    int64_t enough = walk->looked + most;
    while (walk->head < walk->tail && (thorough != 0 || walk->before[goal] < 0)) {
        if (walk->looked >= enough) {
            *progress = WG_GOING;
            return WG_OK;
        }
        if (walk->head == walk->level_end) {
            walk->depth++;
            walk->level_end = walk->tail;
            if (walk->depth + 1 >= limit) {
                break;
            }
        }
        int64_t state = walk->order[walk->head++];
        int64_t cell = state >> walk->bits;
        if (walk->slot[cell] >= 0) {
            follow_listed(walk, state, walk->slot[cell], state & full);
        } else {
            follow_rows(walk, state, cell, state & full);
        }
    }
    if (thorough == 0) {
        finish(walk, goal);
    }
    *progress = walk->found > 0 ? WG_FOUND : WG_EXHAUSTED;
    return WG_OK;
}

// Counts the paths that lead from a place: the parts of the ring around it that reach its outer
// circle.

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "grid.h"
#include "wg_making.h"

typedef struct Offset {
    int32_t x;
    int32_t y;
} Offset;

// The nodes from 1.5 to a little over 2 radii away from a place.
typedef struct Ring {
    Offset *offsets;
    int64_t count;
    int64_t room;
    int64_t size;      // squared radius that it was made for; -1 at first
    int64_t outer_sq;  // squared radius of its outer circle
} Ring;

// One query: a map, and work space that all places share.
typedef struct Search {
    const uint8_t *clear;
    const uint8_t *middle;
    int64_t size;
    int64_t stride;
    int64_t steps[8];
    int64_t middles[8];
    // the role of a node for the current place; values with the number of an earlier place are
    // stale
    int32_t *mark;
    int32_t *queue;
} Search;

enum { IN_DISC = 1, IN_RING = 2, IN_PART = 3 };  // added to four times the number of the place

static bool ring_make(Ring *ring, int64_t size)
{
    if (ring->size == size) {
        return true;
    }
    int64_t outer = (int64_t)sqrt((double)(4 * size));
    while (outer * outer > 4 * size) {
        outer--;
    }
    while ((outer + 1) * (outer + 1) <= 4 * size) {
        outer++;
    }
    outer += 2;
    int64_t most = (2 * outer + 1) * (2 * outer + 1);
    if (most > ring->room) {
        Offset *offsets = realloc(ring->offsets, (size_t)most * sizeof *offsets);
        if (offsets == NULL) {
            return false;
        }
        ring->offsets = offsets;
        ring->room = most;
    }
    assert(ring->offsets != NULL);
    ring->count = 0;
    ring->size = size;
    ring->outer_sq = outer * outer;
    for (int64_t x = -outer; x <= outer; x++) {
        for (int64_t y = -outer; y <= outer; y++) {
            int64_t squared = x * x + y * y;
            if (4 * squared >= 9 * size && squared <= ring->outer_sq) {
                ring->offsets[ring->count++] = (Offset){(int32_t)x, (int32_t)y};
            }
        }
    }
    return true;
}

// The node at an offset from a place; -1 outside the grid.
static int64_t node_at(const Search *search, int64_t place, Offset offset)
{
    int64_t x = place % search->stride + offset.x;
    int64_t y = place / search->stride + offset.y;
    if (x < 0 || x >= search->stride || y < 0 || y * search->stride + x >= search->size) {
        return -1;
    }
    return y * search->stride + x;
}

static int64_t squared_between(const Search *search, int64_t place, int64_t node)
{
    int64_t dx = node % search->stride - place % search->stride;
    int64_t dy = node / search->stride - place / search->stride;
    return dx * dx + dy * dy;
}

static bool step_is_clear(const Search *search, int64_t node, int direction)
{
    return direction <= 3 || search->middle[node + search->middles[direction]] != 0;
}

// Marks what the robot can reach from a place within the outer circle.
static void flood_disc(Search *search, int64_t place, int64_t outer_sq, int32_t stamp)
{
    int32_t *mark = search->mark;
    int32_t *queue = search->queue;
    mark[place] = stamp + IN_DISC;
    queue[0] = (int32_t)place;
    int64_t tail = 1;
    for (int64_t head = 0; head < tail; head++) {
        int64_t node = queue[head];
        for (int direction = 0; direction < 8; direction++) {
            int64_t other = node + search->steps[direction];
            if (search->clear[other] == 0 || mark[other] == stamp + IN_DISC) {
                continue;
            }
            if (step_is_clear(search, node, direction) && squared_between(search, place, other) <= outer_sq) {
                mark[other] = stamp + IN_DISC;
                queue[tail] = (int32_t)other;
                tail++;
            }
        }
    }
}

// Floods one part of the ring; returns true if it reaches two radii of the place's disc.
static bool flood_part(Search *search, int64_t place, int64_t size, int64_t begin, int32_t stamp)
{
    int32_t *mark = search->mark;
    int32_t *queue = search->queue;
    mark[begin] = stamp + IN_PART;
    queue[0] = (int32_t)begin;
    int64_t tail = 1;
    bool leads_on = false;
    for (int64_t head = 0; head < tail; head++) {
        int64_t node = queue[head];
        leads_on = leads_on || squared_between(search, place, node) >= 4 * size;
        for (int direction = 0; direction < 8; direction++) {
            int64_t other = node + search->steps[direction];
            assert(other >= 0 && other < search->size);  // the nodes of the rim are not clear
            if (mark[other] == stamp + IN_RING && step_is_clear(search, node, direction)) {
                mark[other] = stamp + IN_PART;
                queue[tail] = (int32_t)other;
                tail++;
            }
        }
    }
    return leads_on;
}

// Counts the parts of a place's ring that lead outwards: all of them, or only those that a flood
// from the place reaches.
static int64_t count_parts(Search *search, const Ring *ring, int64_t place, int32_t stamp, bool only_reached)
{
    for (int64_t r = 0; r < ring->count; r++) {
        int64_t node = node_at(search, place, ring->offsets[r]);
        if (node >= 0 && search->clear[node] != 0 && (!only_reached || search->mark[node] == stamp + IN_DISC)) {
            search->mark[node] = stamp + IN_RING;
        }
    }
    int64_t parts = 0;
    for (int64_t r = 0; r < ring->count; r++) {
        int64_t node = node_at(search, place, ring->offsets[r]);
        if (node >= 0 && search->mark[node] == stamp + IN_RING) {
            parts += flood_part(search, place, ring->size, node, stamp) ? 1 : 0;
        }
    }
    return parts;
}

WgStatus wg_openings(const uint8_t *clear, const uint8_t *middle, int64_t size, int64_t stride, const int64_t *places,
                     const int64_t *sizes, int64_t count, int64_t *found)
{
    if (!wg_rim_is_closed(clear, size, stride) || count > INT32_MAX / 8) {
        return WG_BAD_SIZE;
    }
    for (int64_t k = 0; k < count; k++) {
        bool inside = places[k] >= 0 && places[k] < size && clear[places[k]] != 0;
        if (!inside || sizes[k] < 0 || sizes[k] > 4 * size) {
            return WG_BAD_VALUE;
        }
    }
    Search search = {.clear = clear, .middle = middle, .size = size, .stride = stride};
    wg_eight_steps(stride, search.steps);
    wg_eight_middles(stride, search.middles);
    search.mark = calloc((size_t)size, sizeof *search.mark);
    search.queue = malloc((size_t)size * sizeof *search.queue);
    Ring ring = {NULL, 0, 0, -1, 0};
    bool has_memory = search.mark != NULL && search.queue != NULL;
    for (int64_t k = 0; has_memory && k < count; k++) {
        int32_t stamp = (int32_t)(4 * (k + 1));
        has_memory = ring_make(&ring, sizes[k]);
        if (!has_memory) {
            break;
        }
        // Counting all parts of the ring is cheap and decides most places; only those with three or
        // more need the flood.
        found[k] = count_parts(&search, &ring, places[k], stamp, false);
        if (found[k] >= 3) {
            flood_disc(&search, places[k], ring.outer_sq, stamp);
            found[k] = count_parts(&search, &ring, places[k], stamp, true);
        }
    }
    free(search.mark);
    free(search.queue);
    free(ring.offsets);
    return has_memory ? WG_OK : WG_OUT_OF_MEMORY;
}

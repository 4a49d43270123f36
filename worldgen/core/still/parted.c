// Decides whether chains separate the start from poses: cells are united link by link, and each
// link has a bit for each pose.
//
// A chain separates a pose if its links' bits for that pose add up to an odd number. So every cell
// stores the sum of the bits from itself to the first cell of its group; a link within a group
// closes a chain whose sum is then known, and every chain is composed of such chains. Links without
// bits need not be examined one by one: cells joined only by these are united first, row by row.
//
// Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm" (1975).

#include <stdlib.h>

#include "parted.h"

// Groups of cells.
typedef struct Groups {
    int32_t *parent;  // (cells,)
    uint64_t *bits;   // (cells,) sum of the bits from it to the parent
    int32_t *skip;    // (cells + 1,) link to the next unseen cell
    int32_t *waiting;
} Groups;

// Unites the cells joined by links without bits, starting from one of them.
static void unite_plain(const WgLinks *links, Groups *groups, int32_t first)
{
    int64_t count = 1;
    groups->waiting[0] = first;
    groups->skip[first] = first + 1;
    while (count > 0) {
        int32_t cell = groups->waiting[--count];
        for (int64_t row = 0; row <= 2 * links->reach; row++) {
            int64_t at = links->place[cell] + links->shift[row];
            int32_t last = links->rank[at + links->wide[row] + 1];
            int64_t v = wg_next_unseen(groups->skip, links->rank[at - links->wide[row]]);
            while (v < last) {
                groups->skip[v] = (int32_t)(v + 1);
                groups->parent[v] = first;
                groups->waiting[count++] = (int32_t)v;
                v = wg_next_unseen(groups->skip, v + 1);
            }
        }
    }
}

// Returns the first cell of a cell's group; bits receives the sum on the way there.
static int32_t find(Groups *groups, int32_t cell, uint64_t *bits)
{
    int32_t root = cell;
    uint64_t sum = 0;
    while (groups->parent[root] != root) {
        sum ^= groups->bits[root];
        root = groups->parent[root];
    }
    *bits = sum;
    // Shorten the path for the next call.
    while (groups->parent[cell] != root && cell != root) {
        int32_t next = groups->parent[cell];
        uint64_t own = groups->bits[cell];
        groups->parent[cell] = root;
        groups->bits[cell] = sum;
        sum ^= own;
        cell = next;
    }
    return root;
}

// Examines the links that have bits, and all other links of their cells;
// returns the bits of all chains together.
static uint64_t close_chains(const WgLinks *links, Groups *groups)
{
    uint64_t found = 0;
    for (int32_t cell = 0; cell < links->cells; cell++) {
        if (links->slot[cell] < 0) {
            continue;
        }
        for (int64_t link = links->begins[links->slot[cell]]; link < links->begins[links->slot[cell] + 1]; link++) {
            uint64_t here;
            uint64_t there;
            int32_t one = find(groups, cell, &here);
            int32_t other = find(groups, links->ends[link], &there);
            uint64_t sum = here ^ there ^ links->odd[link];
            if (one == other) {
                found |= sum;
            } else {
                groups->parent[other] = one;
                groups->bits[other] = sum;
            }
        }
    }
    return found;
}

WgStatus wg_all_parted(const WgWalls *walls, int64_t limit, const WgFinePose *poses, int64_t count, bool *parted)
{
    WgLinks links;
    WgStatus status = wg_links_make(&links, walls, limit, poses, count);
    if (status != WG_OK) {
        wg_links_free(&links);
        return status;
    }
    size_t room = (size_t)(links.cells + 1);
    Groups groups = {0};
    groups.parent = malloc(3 * room * sizeof *groups.parent);
    groups.bits = calloc(room, sizeof *groups.bits);
    if (groups.parent == NULL || groups.bits == NULL) {
        status = WG_OUT_OF_MEMORY;
    } else {
        groups.skip = groups.parent + room;
        groups.waiting = groups.skip + room;
        // At first, cells whose links have bits are skipped.
        for (int32_t cell = 0; cell <= links.cells; cell++) {
            groups.parent[cell] = cell;
            groups.skip[cell] = cell < links.cells && links.slot[cell] >= 0 ? cell + 1 : cell;
        }
        for (int32_t cell = 0; cell < links.cells; cell++) {
            if (groups.skip[cell] == cell) {
                unite_plain(&links, &groups, cell);
            }
        }
        *parted = close_chains(&links, &groups) == UINT64_MAX >> (65 - count);
    }
    free(groups.parent);
    free(groups.bits);
    wg_links_free(&links);
    return status;
}

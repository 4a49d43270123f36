// Unites cells that gaps link; a closed chain with an odd sum separates start from target.

#include "wg_making.h"

// Returns the root of a cell, and adds the sum of the links on the path to it to *total.
static int64_t find_root(int64_t *parent, uint8_t *bit, int64_t at, uint8_t *total)
{
    while (parent[at] != at) {
        bit[at] ^= bit[parent[at]];
        parent[at] = parent[parent[at]];
        *total ^= bit[at];
        at = parent[at];
    }
    return at;
}

WgStatus wg_unite(const int64_t *ones, const int64_t *others, const uint8_t *odd, int64_t links, int64_t *parent,
                  uint8_t *bit, int64_t cells, int64_t *closed)
{
    *closed = 0;
    for (int64_t k = 0; k < links; k++) {
        if (ones[k] < 0 || ones[k] >= cells || others[k] < 0 || others[k] >= cells) {
            return WG_BAD_VALUE;
        }
        uint8_t total = odd[k];
        int64_t one = find_root(parent, bit, ones[k], &total);
        int64_t other = find_root(parent, bit, others[k], &total);
        if (one != other) {
            parent[other] = one;
            bit[other] = total;
        } else if (total == 1) {
            *closed = 1;
            return WG_OK;
        }
    }
    return WG_OK;
}

// Nodes in the order of their distance from a point.

#include <stdlib.h>

#include "wg_making.h"

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

typedef struct Node {
    int64_t squared;
    int64_t place;
} Node;

// Sorts by squared distance, nodes of the same in their order; returns which of the two arrays holds the result.
static Node *sort_nodes(Node *nodes, Node *spare, int64_t count, int64_t largest)
{
    for (int shift = 0; shift < 63 && largest >> shift != 0; shift += DIGIT_BITS) {
        int64_t begins[DIGITS + 1] = {0};
        for (int64_t i = 0; i < count; i++) {
            begins[(nodes[i].squared >> shift & (DIGITS - 1)) + 1]++;
        }
        for (int digit = 0; digit < DIGITS; digit++) {
            begins[digit + 1] += begins[digit];
        }
        for (int64_t i = 0; i < count; i++) {
            int64_t digit = nodes[i].squared >> shift & (DIGITS - 1);
            spare[begins[digit]] = nodes[i];
            begins[digit]++;
        }
        Node *sorted = spare;
        spare = nodes;
        nodes = sorted;
    }
    return nodes;
}

WgStatus wg_by_distance(const uint8_t *clear, int64_t rows, int64_t columns, int64_t pitch, int64_t x, int64_t y,
                        int64_t *places, int64_t *squared, int64_t count)
{
    if (rows < 1 || columns < 1 || rows > INT32_MAX / columns || count < 0 || count > rows * columns) {
        return WG_BAD_SIZE;
    }
    int64_t most = (int64_t)1 << 30;  // so that a sum of two squares fits
    if (pitch < 1 || pitch > most / (rows + columns) || x < -most || x > most || y < -most || y > most) {
        return WG_BAD_VALUE;
    }
    Node *nodes = malloc((size_t)(2 * count + 1) * sizeof *nodes);
    if (nodes == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t found = 0;
    int64_t largest = 0;
    for (int64_t row = 0; row < rows; row++) {
        int64_t dy = row * pitch - y;
        for (int64_t column = 0; column < columns && found < count; column++) {
            if (clear[row * columns + column] == 0) {
                continue;
            }
            int64_t dx = column * pitch - x;
            nodes[found] = (Node){dx * dx + dy * dy, row * columns + column};
            largest = nodes[found].squared > largest ? nodes[found].squared : largest;
            found++;
        }
    }
    if (found < count) {
        free(nodes);
        return WG_BAD_SIZE;
    }
    const Node *sorted = sort_nodes(nodes, nodes + count, count, largest);
    for (int64_t i = 0; i < count; i++) {
        places[i] = sorted[i].place;
        squared[i] = sorted[i].squared;
    }
    free(nodes);
    return WG_OK;
}

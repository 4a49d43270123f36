// Proofs of reachability.
//
// Arrays are row-major. Functions check the sizes that they are given; none keeps a pointer.

#ifndef WG_REACH_H
#define WG_REACH_H

#include <stdint.h>

#include "wg_types.h"

// flood.c

// Marks every node of a graph that a source leads to by steps to its eight neighbours.
//
// clear:      (nodes,) 1 where the disc is clear; 0 on the rim of the grid.
// middle:     (nodes,) 1 where it is clear half a step right of and above each node.
// stride:     nodes in a row.
// sources:    (source_count,) clear nodes.
// seen:       (nodes,) zeros; 1 for what is reached.
WgStatus wg_flood(const uint8_t *clear, const uint8_t *middle, int64_t nodes, int64_t stride,
                  const int64_t *sources, int64_t source_count, uint8_t *seen);

#endif

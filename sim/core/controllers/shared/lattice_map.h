// A small map: a square window of the plane in nodes of a grid, with a bit for each edge found to
// be blocked.
//
// A node has eight neighbours and four bits: its edges to the east, north-east, north and
// north-west; the others are its neighbours'. Twelve nodes are packed into one number of a
// controller's memory. The window moves with the robot and forgets everything outside it. A* plans
// the path as if everything not known to be blocked were free.
//
// Sources: P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic
// determination of minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4
// (1968); for planning as if the unknown were free, A. Zelinsky, "A mobile robot exploration
// algorithm", IEEE Transactions on Robotics and Automation 8 (1992).

#ifndef WG_LATTICE_MAP_H
#define WG_LATTICE_MAP_H

#include <stdbool.h>
#include <stdint.h>

#include "wg_controllers.h"

typedef struct WgNode {
    int64_t x;
    int64_t y;
} WgNode;

typedef enum WgPlanned { WG_NO_PATH, WG_PLANNED, WG_NO_MEMORY } WgPlanned;

// The node that a move leads to: 0 is east, and then counter-clockwise by eighths of a turn.
WgNode wg_neighbour(WgNode node, int64_t move);

// Marks the edge of a move from a node as blocked; the plan is dropped.
void wg_map_block(WgMapperMemory *map, WgNode node, int64_t move);

// Marks all edges that pass within a radius of a point as blocked; both in nodes. The plan is
// dropped if one of them was open.
void wg_map_block_near(WgMapperMemory *map, double x, double y, double radius);

// Marks the path from a node to the target as blocked.
void wg_map_block_door(WgMapperMemory *map, WgNode node);

// Number of the map's own numbers: twelve nodes are in each.
int64_t wg_map_words(const WgMapperMemory *map);

// Clears the map.
void wg_map_forget(WgMapperMemory *map);

// Moves the window so that a node has a quarter of it on each side, and forgets everything outside.
void wg_map_move_window(WgMapperMemory *map, WgNode node);

// Returns the next move of the plan and marks it as done; -1 if there is none.
int64_t wg_map_next_move(WgMapperMemory *map);

// Plans the path from a node, which must be inside the window, to a node next to the target or to
// an exit of the window. The plan may have no moves.
WgPlanned wg_map_plan(WgMapperMemory *map, WgNode from);

#endif

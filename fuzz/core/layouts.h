// Layout bytes to worlds as the simulator takes them, and whether a robot can surely reach the target.
//
// A row of cells is one word here: bit ix + WG_MARGIN of row iy + WG_MARGIN is 1 where the cell is solid, and all around
// a world is solid. fuzz/search/features.py fixes what the bytes mean, the same bit for bit.

#ifndef WG_LAYOUTS_H
#define WG_LAYOUTS_H

#include <stdbool.h>
#include <stdint.h>

#include "wg_sim.h"

enum {
    WG_MOST_FEATURES = 8,
    WG_FEATURE_BYTES = 6,  // kind, x, y, length, depth, turn and thickness
    WG_HEAD_BYTES = 8,     // width, height, start x, y, heading, target x, y, number of features
    WG_LAYOUT_BYTES = 56,  // head and features
    WG_SCENE_BYTES = 59,   // a layout, then radius, target's radius and finer heading
    WG_LAYOUT_HEADINGS = 16,
    WG_FINER_HEADINGS = 16,  // of a scene, for each of a layout's

    WG_SMALLEST_SIDE = 8,  // cells
    WG_SIDES = 21,         // so many sizes: 8 to 28
    WG_FREE_AROUND = 1,    // cells around start and target that are free
    WG_MARGIN = 2,         // solid cells around a world: as many as the simulator's masks see
    WG_ROWS = WG_SMALLEST_SIDE + WG_SIDES - 1 + 2 * WG_MARGIN,
    WG_MOST_CELLS = (WG_SMALLEST_SIDE + WG_SIDES - 1) * (WG_SMALLEST_SIDE + WG_SIDES - 1),
};

// Cells of start and target.
typedef struct WgPlaces {
    int64_t width;
    int64_t height;
    int64_t start_x;
    int64_t start_y;
    int64_t target_x;
    int64_t target_y;
} WgPlaces;

// Size of a layout's world, and its start and target.
WgPlaces wg_layout_places(const uint8_t *layout);

// Draws a layout's cells as rows of bits.
void wg_layout_draw(const uint8_t *layout, uint64_t solid[WG_ROWS]);

// Writes cells and masks of a drawn world into an arena of its size, and clears where a robot has been. Returns the
// number of solid cells.
int64_t wg_layout_fill(const uint64_t solid[WG_ROWS], WgArena *arena);

// Counts the steps of one cell from a corner of the start's cell to one of the target's, along corners of four free
// cells; -1 if there is no such path.
//
// A disc whose radius is at most a cell, and that fits into start and target, can follow them: no solid cell is nearer
// to them than a whole cell.
int64_t wg_layout_distance(const WgPlaces *places, const uint64_t solid[WG_ROWS]);

#endif

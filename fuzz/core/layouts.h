// Converts layout bytes to worlds for the simulator, and determines whether a robot can certainly
// reach the target.
//
// A row of cells is one word: bit ix + WG_MARGIN of row iy + WG_MARGIN is 1 if the cell is solid.
// Everything around a world is solid. fuzz/layouts/features.py defines the meaning of the bytes;
// both agree bit for bit.

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
    WG_FINER_HEADINGS = 16,  // headings of a scene per heading of a layout

    WG_SMALLEST_SIDE = 8,  // cells
    WG_SIDES = 21,         // number of sizes: 8 to 28 cells
    WG_FREE_AROUND = 1,    // free cells around start and target
    // reach of the widest disc that fits at start and target, lattice units
    WG_WIDEST = WG_UNIT * WG_FREE_AROUND + WG_UNIT / 2,
    WG_MARGIN = 2,         // solid cells around a world: as far as the simulator's masks see
    WG_ROWS = WG_SMALLEST_SIDE + WG_SIDES - 1 + 2 * WG_MARGIN,
    WG_MOST_CELLS = (WG_SMALLEST_SIDE + WG_SIDES - 1) * (WG_SMALLEST_SIDE + WG_SIDES - 1),
};

// Size of a world, and cells of start and target.
typedef struct WgPlaces {
    int64_t width;
    int64_t height;
    int64_t start_x;
    int64_t start_y;
    int64_t target_x;
    int64_t target_y;
} WgPlaces;

// Returns the size of a layout's world and its start and target.
WgPlaces wg_layout_places(const uint8_t *layout);

// Draws a layout's cells as rows of bits.
void wg_layout_draw(const uint8_t *layout, uint64_t solid[WG_ROWS]);

// Writes cells and masks of a drawn world into an arena of its size, and clears the record of
// visited cells. Returns the number of solid cells.
int64_t wg_layout_fill(const uint64_t solid[WG_ROWS], WgArena *arena);

// Returns the number of steps of one cell along a path from start to target that a disc of this
// reach (lattice units, at most WG_WIDEST) can certainly follow; -1 if there is no such path.
//
// If its radius is at most one cell, the path leads along corners of four free cells, from a corner
// of the start's cell to one of the target's: no solid cell is nearer to it than a whole cell. For a
// wider disc it leads along middles of cells that are free with the eight cells around them.
int64_t wg_layout_distance(const WgPlaces *places, const uint64_t solid[WG_ROWS], int64_t reach);

#endif

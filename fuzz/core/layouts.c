// Draws layouts and floods them.

#include "layouts.h"

#include "wg_parts.h"

_Static_assert((int)WG_MARGIN == (int)WG_NEAR, "a world's margin is what the masks see");

// Kinds of features.
enum { BOX, WALL, CUP, CORNER, GATE, DIAGONAL, COMB, KINDS };

// A feature as its bytes describe it, before it is turned.
typedef struct Feature {
    int kind;
    int length;
    int depth;
    int thickness;
    int rows;
    int columns;
} Feature;

static int least(int a, int b)
{
    return a < b ? a : b;
}

WgPlaces wg_layout_places(const uint8_t *layout)
{
    WgPlaces places;
    places.width = WG_SMALLEST_SIDE + layout[0] % WG_SIDES;
    places.height = WG_SMALLEST_SIDE + layout[1] % WG_SIDES;
    places.start_x = 2 + layout[2] % (places.width - 4);
    places.start_y = 2 + layout[3] % (places.height - 4);
    places.target_x = places.width - 3 - layout[5] % (places.width - 4);
    places.target_y = places.height - 3 - layout[6] % (places.height - 4);
    return places;
}

static void measure(Feature *feature)
{
    int length = feature->length;
    int depth = feature->depth;
    int thickness = feature->thickness;
    switch (feature->kind) {
    case BOX:
        feature->rows = depth;
        feature->columns = length;
        break;
    case WALL:
        feature->rows = thickness;
        feature->columns = length + depth;
        break;
    case CUP:
        feature->rows = depth + thickness;
        feature->columns = length + 2 * thickness;
        break;
    case CORNER:
        feature->rows = depth + thickness;
        feature->columns = length + thickness;
        break;
    case GATE:
        feature->rows = thickness;
        feature->columns = length + depth + 2;
        break;
    case DIAGONAL:
        feature->rows = length + depth;
        feature->columns = length + depth;
        break;
    default:
        feature->rows = depth + thickness;
        feature->columns = 3 * (1 + length / 3) + 1;
        break;
    }
}

// Returns true if row i, column j of a feature is solid.
static bool is_solid(const Feature *feature, int i, int j)
{
    int length = feature->length;
    int thickness = feature->thickness;
    switch (feature->kind) {
    case CUP:
        return i >= feature->depth || j < thickness || j >= thickness + length;
    case CORNER:
        return i < thickness || j < thickness;
    case GATE:
        return j < length || j >= length + 2;
    case DIAGONAL:
        return j == i || (thickness > 1 && j == i + 1);
    case COMB:
        return i < thickness || j % 3 == 0;
    default:
        return true;
    }
}

// Draws one feature; parts outside the world are cut off.
static void draw_feature(const uint8_t bytes[WG_FEATURE_BYTES], const WgPlaces *places, uint64_t solid[WG_ROWS])
{
    int width = (int)places->width;
    int height = (int)places->height;
    int form = bytes[5];
    int turn = form % 4;
    Feature feature = {
        .kind = bytes[0] % KINDS,
        .length = 1 + bytes[3] % 12,
        .depth = 1 + bytes[4] % 8,
        .thickness = 1 + form / 4 % 2,
    };
    measure(&feature);
    int x = 1 + bytes[1] % (width - 2);
    int y = 1 + bytes[2] % (height - 2);
    int rows = feature.rows;
    int columns = feature.columns;
    int high = least(turn % 2 == 1 ? columns : rows, height - y);
    int wide = least(turn % 2 == 1 ? rows : columns, width - x);
    for (int i = 0; i < high; i++) {
        for (int j = 0; j < wide; j++) {
            // Row and column of the feature before it was turned by quarters.
            int row = turn == 0 ? i : turn == 1 ? j : turn == 2 ? rows - 1 - i : rows - 1 - j;
            int column = turn == 0 ? j : turn == 1 ? columns - 1 - i : turn == 2 ? columns - 1 - j : i;
            if (is_solid(&feature, row, column)) {
                solid[y + i + WG_MARGIN] |= (uint64_t)1 << (x + j + WG_MARGIN);
            }
        }
    }
}

void wg_layout_draw(const uint8_t *layout, uint64_t solid[WG_ROWS])
{
    WgPlaces places = wg_layout_places(layout);
    int64_t rows = places.height + 2 * WG_MARGIN;
    for (int64_t iy = 0; iy < rows; iy++) {
        solid[iy] = 0;
    }
    int features = layout[7] % (WG_MOST_FEATURES + 1);
    for (int k = 0; k < features; k++) {
        draw_feature(layout + WG_HEAD_BYTES + k * WG_FEATURE_BYTES, &places, solid);
    }

    // Start and target are free, with the cells around them.
    uint64_t block = ((uint64_t)1 << (2 * WG_FREE_AROUND + 1)) - 1;
    for (int64_t d = -WG_FREE_AROUND; d <= WG_FREE_AROUND; d++) {
        solid[places.start_y + d + WG_MARGIN] &= ~(block << (places.start_x - WG_FREE_AROUND + WG_MARGIN));
        solid[places.target_y + d + WG_MARGIN] &= ~(block << (places.target_x - WG_FREE_AROUND + WG_MARGIN));
    }

    // The border, and everything outside, is solid.
    uint64_t border = ~((((uint64_t)1 << (places.width - 2)) - 1) << (1 + WG_MARGIN));
    for (int64_t iy = 0; iy < rows; iy++) {
        bool is_border = iy <= WG_MARGIN || iy >= places.height - 1 + WG_MARGIN;
        solid[iy] = is_border ? ~(uint64_t)0 : solid[iy] | border;
    }
}

int64_t wg_layout_fill(const uint64_t solid[WG_ROWS], WgArena *arena)
{
    enum { WINDOW = 2 * WG_NEAR + 1 };
    const uint64_t one_row = ((uint64_t)1 << WINDOW) - 1;
    int64_t count = 0;
    for (int64_t iy = 0; iy < arena->height; iy++) {
        int64_t first = iy * arena->width;
        for (int64_t ix = 0; ix < arena->width; ix++) {
            uint64_t near = 0;
            for (int k = 0; k < WINDOW; k++) {
                near |= ((solid[iy + k] >> ix) & one_row) << (WINDOW * k);
            }
            uint8_t taken = (uint8_t)((solid[iy + WG_MARGIN] >> (ix + WG_MARGIN)) & 1);
            arena->cells[first + ix] = taken;
            arena->near[first + ix] = (int32_t)near;
            arena->visited[first + ix] = 0;
            count += taken;
        }
    }
    return count;
}

// Returns the places of one row that can be reached in one more step.
static uint64_t joined(uint64_t clear, uint64_t row, uint64_t below, uint64_t above, uint64_t seen)
{
    return (row | row << 1 | row >> 1 | below | above) & clear & ~seen;
}

// Marks the corners of four free cells. A corner has the bit and the row of the cell above and to
// the right of it.
static void mark_corners(const uint64_t solid[WG_ROWS], int64_t rows, uint64_t clear[WG_ROWS])
{
    for (int64_t iy = 1; iy < rows; iy++) {
        uint64_t free = ~(solid[iy] | solid[iy - 1]);
        clear[iy] = free & (free << 1);
    }
}

// Marks the cells that are free with the eight cells around them.
static void mark_middles(const uint64_t solid[WG_ROWS], int64_t rows, uint64_t clear[WG_ROWS])
{
    for (int64_t iy = 1; iy < rows - 1; iy++) {
        uint64_t free = ~(solid[iy - 1] | solid[iy] | solid[iy + 1]);
        clear[iy] = free & (free << 1) & (free >> 1);
    }
}

int64_t wg_layout_distance(const WgPlaces *places, const uint64_t solid[WG_ROWS], int64_t reach)
{
    // Rows of places: clear ones, reached ones, and those reached by the last step.
    uint64_t clear[WG_ROWS] = {0};
    uint64_t reached[WG_ROWS] = {0};
    uint64_t latest[WG_ROWS] = {0};
    int64_t rows = places->height + 2 * WG_MARGIN;
    bool narrow = reach <= WG_UNIT;
    if (narrow) {
        mark_corners(solid, rows, clear);
    } else {
        mark_middles(solid, rows, clear);
    }
    // A cell has its four corners, or its middle.
    uint64_t own = narrow ? 3 : 1;
    int64_t more_rows = narrow ? 1 : 0;
    int64_t low = places->start_y + WG_MARGIN;
    int64_t high = low + more_rows;
    uint64_t begun = own << (places->start_x + WG_MARGIN);
    reached[low] = latest[low] = begun;
    reached[high] = latest[high] = begun;

    uint64_t goal = own << (places->target_x + WG_MARGIN);
    int64_t goal_row = places->target_y + WG_MARGIN;

    // Flood all places one step at a time; only rows `low` to `high` changed last time.
    for (int64_t steps = 0; low <= high; steps++) {
        if (((reached[goal_row] | reached[goal_row + more_rows]) & goal) != 0) {
            return steps;
        }
        int64_t first = high + 2;
        int64_t last = low - 2;
        int64_t begin = low > 2 ? low - 1 : 1;
        int64_t end = high + 1 < rows - 2 ? high + 1 : rows - 2;
        uint64_t before = 0;
        for (int64_t iy = begin; iy <= end; iy++) {
            uint64_t row = latest[iy];
            uint64_t fresh = joined(clear[iy], row, before, latest[iy + 1], reached[iy]);
            before = row;
            latest[iy] = fresh;
            if (fresh != 0) {
                reached[iy] |= fresh;
                first = iy < first ? iy : first;
                last = iy > last ? iy : last;
            }
        }
        low = first;
        high = last;
    }
    return -1;
}

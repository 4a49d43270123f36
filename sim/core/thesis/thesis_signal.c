// The thesis's light: the noise filter, and how the robot reads the signal.
//
// It also has the features that its author proposed as future work: a sensor that looks in only one
// direction, or has errors; walls that weaken or block the light behind them;
// a robot with a coarser map than the world.
//
// Source: the thesis's listing, simWorldCreator.noiseMapGen, simGuiExp.scanMultipleCells and
// calcHeading.

#include "fdlibm.h"
#include "random_draw.h"
#include "thesis_parts.h"

static const double DARK =
    1073741824.0;  // 2^30, the reading if no light arrives: weaker than any signal

enum {
    MOST_HALVINGS = 30,  // walls that weaken the light; behind more of them it is equally dark
    NOISE_REACH = 2,    // cells around a wall whose signal the filter changes
};

typedef struct Cell {
    int64_t x;
    int64_t y;
} Cell;

WgStatus wg_thesis_add_noise(int32_t *cells, const int32_t *light, int64_t width, int64_t height)
{
    if (width < 1 || height < 1 || width > INT32_MAX || height > INT32_MAX) {
        return WG_BAD_SIZE;
    }
    for (int64_t wall_y = 1; wall_y < height - 1; wall_y++) {
        for (int64_t wall_x = 1; wall_x < width - 1; wall_x++) {
            if (cells[wall_x * height + wall_y] != WG_THESIS_WALL) {
                continue;
            }
            int32_t at_wall = light[wall_x * height + wall_y];
            int64_t last_x = wg_least(wall_x + NOISE_REACH, width - 2);
            int64_t last_y = wg_least(wall_y + NOISE_REACH, height - 2);
            for (int64_t y = wg_most(wall_y - NOISE_REACH, 1); y <= last_y; y++) {
                for (int64_t x = wg_most(wall_x - NOISE_REACH, 1); x <= last_x; x++) {
                    int64_t cell = x * height + y;
                    if (cells[cell] <= 0) {
                        continue;
                    }
                    // The undisturbed value is multiplied, so the last wall that sees a cell
                    // decides.
                    double factor = cells[cell] > at_wall ? 1.5 : 0.9;
                    int32_t value = (int32_t)(factor * light[cell]);
                    if (factor > 1.0 || value != 0) {
                        cells[cell] = value;
                    }
                }
            }
        }
    }
    return WG_OK;
}

// Heading of a vector, in the listing's own four quadrants; can be -0.0, and 2 pi is 0.
static double bearing(double dx, double dy)
{
    double heading = 0.0;
    if (dx != 0.0) {
        heading = wg_atan(dy / dx);
    } else {
        heading = dy > 0.0 ? 1.5 * THESIS_PI : THESIS_PI / 2.0;
    }
    if (dx >= 0.0 && dy <= 0.0) {
        return heading <= 0.0 ? THESIS_PI + heading : heading;
    }
    if (dx <= 0.0 && dy <= 0.0) {
        return heading;
    }
    if (dx <= 0.0) {
        return heading <= 0.0 ? THESIS_TWO_PI + heading : heading;
    }
    return heading >= 0.0 ? THESIS_PI + heading : heading;
}

// Heading to the centre of a cell of the world, or of a block of `side` px.
static double bearing_to(Cell cell, double side, double x, double y)
{
    return bearing(((double)cell.x + 0.5) * side - x, ((double)cell.y + 0.5) * side - y);
}

// Returns the cell with the best signal within `sense` cells; the first wins a tie.
//
// In a wall, the robot's own cell has the lowest value, so the robot then seeks the middle of
// that wall.
static Cell brightest(const ThesisGrid *grid, double x, double y, int64_t sense)
{
    const Cell own = {thesis_cell_of(x), thesis_cell_of(y)};
    Cell best = own;
    int32_t lowest = thesis_value(grid, own.x, own.y);
    int64_t first_x = wg_most(own.x - sense, 1);
    int64_t last_x = wg_least(own.x + sense, grid->width - 2);
    int64_t last_y = wg_least(own.y + sense, grid->height - 2);
    for (int64_t cell_y = wg_most(own.y - sense, 1); cell_y <= last_y; cell_y++) {
        for (int64_t cell_x = first_x; cell_x <= last_x; cell_x++) {
            int32_t value = thesis_value(grid, cell_x, cell_y);
            if (value >= 0 && value < lowest) {
                lowest = value;
                best.x = cell_x;
                best.y = cell_y;
            }
        }
    }
    return best;
}

// Number of walls between two cells' centres, without the two cells.
//
// John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics
// 1987; here in integers.
static int64_t walls_between(const ThesisGrid *grid, Cell from, Cell to)
{
    int64_t path_x = to.x > from.x ? to.x - from.x : from.x - to.x;
    int64_t path_y = to.y > from.y ? to.y - from.y : from.y - to.y;
    int64_t step_x = to.x > from.x ? 1 : -1;
    int64_t step_y = to.y > from.y ? 1 : -1;
    int64_t gone_x = 0;
    int64_t gone_y = 0;
    int64_t walls = 0;
    while (gone_x < path_x || gone_y < path_y) {
        // If negative, the next edge crossed is vertical; if 0, it is a corner.
        int64_t ahead = (1 + 2 * gone_x) * path_y - (1 + 2 * gone_y) * path_x;
        if (ahead <= 0) {
            gone_x++;
        }
        if (ahead >= 0) {
            gone_y++;
        }
        const Cell on = {from.x + step_x * gone_x, from.y + step_y * gone_y};
        bool at_end = on.x == to.x && on.y == to.y;
        if (!at_end && thesis_value(grid, on.x, on.y) == WG_THESIS_WALL) {
            walls++;
        }
    }
    return walls;
}

// Signal of a cell after passing the walls; negative if there is none.
static double reading_of(const ThesisGrid *grid, Cell cell, const WgThesisSettings *settings)
{
    double value = thesis_value(grid, cell.x, cell.y);
    if (value <= 0.0 || settings->signal == WG_SIGNAL_OPEN) {
        return value;
    }
    const Cell target = {settings->target_x, settings->target_y};
    int64_t walls = walls_between(grid, cell, target);
    if (walls == 0) {
        return value;
    }
    if (settings->signal == WG_SIGNAL_BLOCKED || walls > MOST_HALVINGS) {
        return DARK;
    }
    double weakened = value * (double)((int64_t)1 << walls);
    return weakened < DARK ? weakened : DARK;
}

// Best signal in a block of the robot's map; -1 if it has none, as in a block of walls.
static double reading_of_block(const ThesisGrid *grid, Cell block, const WgThesisSettings *settings)
{
    int64_t scale = settings->map_scale;
    int64_t end_x = wg_least((block.x + 1) * scale, grid->width - 1);
    int64_t end_y = wg_least((block.y + 1) * scale, grid->height - 1);
    double best = -1.0;
    for (int64_t y = block.y * scale; y < end_y; y++) {
        for (int64_t x = block.x * scale; x < end_x; x++) {
            const Cell cell = {x, y};
            double value = reading_of(grid, cell, settings);
            if (value >= 0.0 && (best < 0.0 || value < best)) {
                best = value;
            }
        }
    }
    return best;
}

// The sensor's reading of a cell, or of a block of the robot's map.
static double noisy_reading(const ThesisGrid *grid, Cell cell, const WgThesisSettings *settings,
                            int64_t scale, int64_t draw)
{
    double value =
        scale == 1 ? reading_of(grid, cell, settings) : reading_of_block(grid, cell, settings);
    if (value > 0.0 && settings->sensor_noise > 0.0) {
        value *= 1.0 + settings->sensor_noise * (2.0 * wg_random_draw(settings->seed, draw) - 1.0);
    }
    return value;
}

// Returns true if a place is in the sensor's field of view.
static bool in_field(double dx, double dy, double looking, double field)
{
    if (field == 0.0) {
        return true;
    }
    double off = fabs(thesis_wrap(bearing(dx, dy) - looking));
    double around = THESIS_TWO_PI - off;
    return (around < off ? around : off) <= field / 2.0;
}

// Cell, or block of `scale` cells, with the best reading in reach; the first wins a tie, and the
// robot's own cell wins over all others.
static Cell best_of(const ThesisGrid *grid, const WgThesisSettings *settings, double x, double y,
                    double looking, int64_t step, int64_t scale)
{
    double side = THESIS_CELL * (double)scale;
    const Cell own = {(int64_t)(x / side), (int64_t)(y / side)};
    int64_t first = scale == 1 ? 1 : 0;
    int64_t first_x = wg_most(own.x - settings->sense, first);
    int64_t last_x = wg_least(own.x + settings->sense, (grid->width - 2) / scale);
    int64_t last_y = wg_least(own.y + settings->sense, (grid->height - 2) / scale);
    int64_t draw = step * THESIS_READINGS;
    int64_t count = 0;
    Cell best = own;
    double lowest = noisy_reading(grid, own, settings, scale, draw);
    for (int64_t cell_y = wg_most(own.y - settings->sense, first); cell_y <= last_y; cell_y++) {
        for (int64_t cell_x = first_x; cell_x <= last_x; cell_x++) {
            count++;
            const Cell cell = {cell_x, cell_y};
            double dx = ((double)cell_x + 0.5) * side - x;
            double dy = ((double)cell_y + 0.5) * side - y;
            if (!in_field(dx, dy, looking, settings->sensor_field)) {
                continue;
            }
            double value =
                noisy_reading(grid, cell, settings, scale, draw + count % (THESIS_READINGS - 1));
            if (value >= 0.0 && value < lowest) {
                lowest = value;
                best = cell;
            }
        }
    }
    return best;
}

double thesis_sensed(const ThesisGrid *grid, const WgThesisSettings *settings, double x, double y,
                     double looking, int64_t step)
{
    bool plain = settings->signal == WG_SIGNAL_OPEN && settings->sensor_field == 0.0 &&
                 settings->sensor_noise == 0.0 && settings->map_scale == 1;
    if (plain) {
        return bearing_to(brightest(grid, x, y, settings->sense), THESIS_CELL, x, y);
    }
    // Within the best block, the robot uses single cells.
    if (settings->map_scale > 1) {
        Cell block = best_of(grid, settings, x, y, looking, step, settings->map_scale);
        double side = THESIS_CELL * (double)settings->map_scale;
        if (block.x != (int64_t)(x / side) || block.y != (int64_t)(y / side)) {
            return bearing_to(block, side, x, y);
        }
    }
    return bearing_to(best_of(grid, settings, x, y, looking, step, 1), THESIS_CELL, x, y);
}

bool thesis_can_sense(const ThesisGrid *grid, const WgThesisSettings *settings)
{
    const int64_t most = 1 << 20;
    bool target = settings->target_x >= 0 && settings->target_x < grid->width &&
                  settings->target_y >= 0 && settings->target_y < grid->height;
    bool sensor = settings->sense >= 0 && settings->sense <= most && settings->map_scale >= 1 &&
                  settings->map_scale <= most;
    return target && sensor;
}

WgStatus wg_thesis_sense(const int32_t *cells, int64_t width, int64_t height,
                         const WgThesisSettings *settings, double x, double y, double looking,
                         int64_t step, double *heading)
{
    const ThesisGrid grid = {cells, width, height};
    if (!thesis_fits(width, height, settings->radius, x, y) || !thesis_can_sense(&grid, settings)) {
        return WG_BAD_VALUE;
    }
    *heading = thesis_sensed(&grid, settings, x, y, looking, step);
    return WG_OK;
}

WgStatus wg_thesis_walls_between(const int32_t *cells, int64_t width, int64_t height, int64_t x,
                                 int64_t y, int64_t to_x, int64_t to_y, int64_t *walls)
{
    bool inside = x >= 0 && y >= 0 && x < width && y < height && to_x >= 0 && to_y >= 0 &&
                  to_x < width && to_y < height;
    if (!inside) {
        return WG_BAD_VALUE;
    }
    const ThesisGrid grid = {cells, width, height};
    const Cell from = {x, y};
    const Cell to = {to_x, to_y};
    *walls = walls_between(&grid, from, to);
    return WG_OK;
}

// Straight lines through the cells of a world; see rays.h.

#include "rays.h"

// Distance along a ray from a coordinate to the side of its cell that the ray heads for.
static double next_line(int64_t place, int64_t cell, double direction)
{
    if (direction > 0.0) {
        return (double)((cell + 1) * WG_UNIT - place) / direction;
    }
    if (direction < 0.0) {
        return (double)(cell * WG_UNIT - place) / direction;
    }
    return 1e300;
}

static bool is_solid(WgGrid grid, int64_t ix, int64_t iy)
{
    return wg_cell_state(grid, ix, iy) == WG_SOLID;
}

double wg_ray_distance(WgGrid grid, const int64_t *headings, int64_t x, int64_t y, int64_t heading, double longest)
{
    double along = wg_cosine(headings, heading);
    double across = wg_sine(headings, heading);
    int64_t ix = wg_cell_of(x) - (along < 0.0 && (x & (WG_UNIT - 1)) == 0);
    int64_t iy = wg_cell_of(y) - (across < 0.0 && (y & (WG_UNIT - 1)) == 0);
    int64_t step_x = along > 0.0 ? 1 : -1;
    int64_t step_y = across > 0.0 ? 1 : -1;
    double to_x = next_line(x, ix, along);
    double to_y = next_line(y, iy, across);
    for (;;) {
        double at = wg_lower(to_x, to_y);
        if (at >= longest) {
            return longest;
        }
        if (to_x == to_y) {
            // At a corner: two walls that touch there block the ray.
            bool both = is_solid(grid, ix + step_x, iy) && is_solid(grid, ix, iy + step_y);
            ix += step_x;
            iy += step_y;
            if (both || is_solid(grid, ix, iy)) {
                return at;
            }
            to_x = next_line(x, ix, along);
            to_y = next_line(y, iy, across);
        } else if (to_x < to_y) {
            ix += step_x;
            if (is_solid(grid, ix, iy)) {
                return at;
            }
            to_x = next_line(x, ix, along);
        } else {
            iy += step_y;
            if (is_solid(grid, ix, iy)) {
                return at;
            }
            to_y = next_line(y, iy, across);
        }
    }
}

// A straight line between two places, cell by cell, decided in integers.
typedef struct Line {
    int64_t x;  // where it begins
    int64_t y;
    int64_t length_x;
    int64_t length_y;
    int64_t step_x;
    int64_t step_y;
    int64_t ix;  // its current cell
    int64_t iy;
    int64_t last_ix;
    int64_t last_iy;
} Line;

static Line line_between(int64_t x, int64_t y, int64_t to_x, int64_t to_y)
{
    return (Line){
        .x = x,
        .y = y,
        .length_x = wg_abs(to_x - x),
        .length_y = wg_abs(to_y - y),
        .step_x = to_x > x ? 1 : -1,
        .step_y = to_y > y ? 1 : -1,
        .ix = wg_cell_of(x),
        .iy = wg_cell_of(y),
        .last_ix = wg_cell_of(to_x),
        .last_iy = wg_cell_of(to_y),
    };
}

static bool has_arrived(const Line *line)
{
    return line->ix == line->last_ix && line->iy == line->last_iy;
}

// Moves to the next cell. It crosses the nearer of the lines to the next column and the next row;
// if both are equally near, the line passes through the corner.
static void follow(Line *line)
{
    int64_t to_column = line->step_x > 0 ? (line->ix + 1) * WG_UNIT - line->x : line->x - line->ix * WG_UNIT;
    int64_t to_row = line->step_y > 0 ? (line->iy + 1) * WG_UNIT - line->y : line->y - line->iy * WG_UNIT;
    // The distance of each along the line, times both lengths.
    int64_t first_x = to_column * line->length_y;
    int64_t first_y = to_row * line->length_x;
    if (line->iy == line->last_iy || (line->ix != line->last_ix && first_x <= first_y)) {
        line->ix += line->step_x;
        if (first_x == first_y && line->iy != line->last_iy) {
            line->iy += line->step_y;
        }
    } else {
        line->iy += line->step_y;
    }
}

int64_t wg_walls_on_the_way(WgGrid grid, int64_t x, int64_t y, int64_t to_x, int64_t to_y)
{
    Line line = line_between(x, y, to_x, to_y);
    int64_t count = 0;
    while (!has_arrived(&line)) {
        follow(&line);
        count += !has_arrived(&line) && is_solid(grid, line.ix, line.iy);
    }
    return count;
}

// Returns true if a cell, or one within the reach of smoke around it, burns.
static bool is_in_smoke(WgGrid grid, int64_t ix, int64_t iy, int64_t reach)
{
    int64_t top = wg_least(iy + reach, grid.height - 1);
    int64_t right = wg_least(ix + reach, grid.width - 1);
    for (int64_t jy = wg_most(iy - reach, 0); jy <= top; jy++) {
        for (int64_t jx = wg_most(ix - reach, 0); jx <= right; jx++) {
            if (grid.cells[jy * grid.width + jx] == WG_BURNING) {
                return true;
            }
        }
    }
    return false;
}

int64_t wg_smoke_on_the_way(WgGrid grid, int64_t x, int64_t y, int64_t to_x, int64_t to_y, int64_t reach)
{
    Line line = line_between(x, y, to_x, to_y);
    int64_t count = is_in_smoke(grid, line.ix, line.iy, reach);
    while (!has_arrived(&line)) {
        follow(&line);
        count += is_in_smoke(grid, line.ix, line.iy, reach);
    }
    return count;
}

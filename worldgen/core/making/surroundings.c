// Measures the surroundings of points of a path: the nearest wall, and the length of sixteen rays.
//
// Points are in cells, multiples of a power of two that is at least 2^-23, so every sum, difference
// and comparison here is exact, and a rotated or mirrored world gives the same numbers to the last
// bit.

#include <math.h>
#include <stdbool.h>

#include "wg_making.h"

typedef struct Walls {
    const uint8_t *solid;
    int64_t rows;
    int64_t columns;
} Walls;

// Everything outside is solid.
static bool is_solid(const Walls *walls, int64_t column, int64_t row)
{
    bool inside = column >= 0 && column < walls->columns && row >= 0 && row < walls->rows;
    return !inside || walls->solid[row * walls->columns + column] != 0;
}

static bool is_inside(const Walls *walls, double x, double y)
{
    return x >= 0.0 && x <= (double)walls->columns && y >= 0.0 && y <= (double)walls->rows;
}

// Returns the smaller of best and the squared distance from a point to the solid cells of one row.
// A cell farther along the row cannot matter, so the search ends there.
static double nearest_in_row(const Walls *walls, int64_t row, double x, double y, double best)
{
    double above = (double)row - y;
    double below = y - (double)(row + 1);
    double up = fmax(fmax(above, below), 0.0);
    double left_over = best - up * up;
    for (int side = -1; side <= 1; side += 2) {
        int64_t column = (int64_t)floor(x);
        for (;;) {
            double low = (double)column - x;
            double high = x - (double)(column + 1);
            double across = fmax(fmax(low, high), 0.0);
            if (across * across >= left_over) {
                break;
            }
            if (is_solid(walls, column, row)) {
                best = fmin(best, across * across + up * up);
                break;
            }
            column += side;
        }
    }
    return best;
}

WgStatus wg_nearest_walls(const uint8_t *solid, int64_t rows, int64_t columns, const double *x, const double *y,
                          int64_t count, double *found)
{
    Walls walls = {solid, rows, columns};
    for (int64_t k = 0; k < count; k++) {
        if (!is_inside(&walls, x[k], y[k])) {
            return WG_BAD_VALUE;
        }
        int64_t row = (int64_t)floor(y[k]);
        double best = nearest_in_row(&walls, row, x[k], y[k], INFINITY);
        for (int64_t step = 1; (double)((step - 1) * (step - 1)) < best; step++) {
            best = nearest_in_row(&walls, row - step, x[k], y[k], best);
            best = nearest_in_row(&walls, row + step, x[k], y[k], best);
        }
        found[k] = sqrt(best);
    }
    return WG_OK;
}

// A ray to the upper right; the world is mirrored to fit it.
typedef struct Ray {
    const Walls *walls;
    bool mirrored_x;
    bool mirrored_y;
} Ray;

static bool ray_meets(const Ray *ray, int64_t column, int64_t row)
{
    int64_t i = ray->mirrored_x ? ray->walls->columns - 1 - column : column;
    int64_t j = ray->mirrored_y ? ray->walls->rows - 1 - row : row;
    return is_solid(ray->walls, i, j);
}

// Returns how far a ray gets before it touches a solid cell, in steps of its direction; infinity
// beyond `most`. Cells are
// closed: a ray that touches a corner or runs along a wall ends there.
static double ray_length(const Walls *walls, double x, double y, int64_t dx, int64_t dy, double most)
{
    Ray ray = {walls, dx < 0, dy < 0};
    double a = fabs((double)dx);
    double b = fabs((double)dy);
    double px = ray.mirrored_x ? (double)walls->columns - x : x;
    double py = ray.mirrored_y ? (double)walls->rows - y : y;
    int64_t i = (int64_t)floor(px);
    int64_t j = (int64_t)floor(py);
    bool at_x = (double)i == px;  // on the line between two columns
    bool at_y = (double)j == py;  // or two rows

    // The point itself may touch a wall.
    bool here = ray_meets(&ray, i, j) || (at_x && ray_meets(&ray, i - 1, j)) || (at_y && ray_meets(&ray, i, j - 1)) ||
                (at_x && at_y && ray_meets(&ray, i - 1, j - 1));
    if (here) {
        return 0.0;
    }
    bool along_x = at_x && dx == 0;
    bool along_y = at_y && dy == 0;
    for (;;) {
        // Go to the next line between columns or rows, or to the corner where both meet.
        double tx = dx == 0 ? INFINITY : ((double)(i + 1) - px) / a;
        double ty = dy == 0 ? INFINITY : ((double)(j + 1) - py) / b;
        double t = tx < ty ? tx : ty;
        bool right = tx <= ty;
        bool up = ty <= tx;
        bool touched = (right && ray_meets(&ray, i + 1, j)) || (up && ray_meets(&ray, i, j + 1)) ||
                       (right && up && ray_meets(&ray, i + 1, j + 1)) ||
                       (up && along_x && ray_meets(&ray, i - 1, j + 1)) ||
                       (right && along_y && ray_meets(&ray, i + 1, j - 1));
        if (touched) {
            return t;
        }
        if (t > most) {
            return INFINITY;
        }
        i += right ? 1 : 0;
        j += up ? 1 : 0;
    }
}

WgStatus wg_rays(const uint8_t *solid, int64_t rows, int64_t columns, const double *x, const double *y, int64_t count,
                 const int64_t *directions, int64_t rays, double reach, double *far)
{
    Walls walls = {solid, rows, columns};
    for (int64_t r = 0; r < rays; r++) {
        if (directions[2 * r] == 0 && directions[2 * r + 1] == 0) {
            return WG_BAD_VALUE;
        }
    }
    for (int64_t k = 0; k < count; k++) {
        if (!is_inside(&walls, x[k], y[k])) {
            return WG_BAD_VALUE;
        }
        for (int64_t r = 0; r < rays; r++) {
            int64_t dx = directions[2 * r];
            int64_t dy = directions[2 * r + 1];
            double a = fabs((double)dx);
            double b = fabs((double)dy);
            bool is_slanted = a + b > 2.0;
            double most = is_slanted ? reach / fmax(a, b) : INFINITY;
            far[k * rays + r] = ray_length(&walls, x[k], y[k], dx, dy, most);
        }
    }
    return WG_OK;
}

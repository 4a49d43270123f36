// Shared by the files of the thesis's simulator.

#ifndef WG_THESIS_PARTS_H
#define WG_THESIS_PARTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "numbers.h"
#include "wg_thesis.h"

static const double THESIS_CELL = 10.0; // px per cell; the listing's `length`
static const double THESIS_PI = 3.14159265358979323846;
static const double THESIS_TWO_PI = 6.28318530717958647692;

// Number of cells around its own that a disc can touch: its radius is at most one cell.
enum { THESIS_REACH = 1 };

// Random numbers of one tick. The last is the slip's, the others are the sensor's.
enum { THESIS_READINGS = 1 << 16, THESIS_SLIP = THESIS_READINGS - 1 };

// The signal, with its size.
typedef struct ThesisGrid {
    const int32_t *cells;
    int64_t width;
    int64_t height;
} ThesisGrid;

typedef struct ThesisPoint {
    double x;
    double y;
} ThesisPoint;

// The column or row of a coordinate, as Java's cast truncates.
static inline int64_t thesis_cell_of(double place)
{
    return (int64_t)(place / THESIS_CELL);
}

static inline int32_t thesis_value(const ThesisGrid *grid, int64_t x, int64_t y)
{
    return grid->cells[x * grid->height + y];
}

// fmod(angle, 2 pi), as Java's % on doubles: headings may be negative.
static inline double thesis_wrap(double angle)
{
    return fabs(angle) < THESIS_TWO_PI ? angle : fmod(angle, THESIS_TWO_PI);
}

// Keeps the disc one cell away from the edge of the grid.
static inline void thesis_clamp(const ThesisGrid *grid, double radius, double *x, double *y)
{
    double low = radius + THESIS_CELL;
    double high_x = (double)grid->width * THESIS_CELL - radius - THESIS_CELL;
    double high_y = (double)grid->height * THESIS_CELL - radius - THESIS_CELL;
    double right = *x < low ? low : *x;
    double down = *y < low ? low : *y;
    *x = right > high_x ? high_x : right;
    *y = down > high_y ? high_y : down;
}

// Returns true if a grid and a disc in it satisfy the assumptions of these files.
static inline bool thesis_fits(int64_t width, int64_t height, double radius, double x, double y)
{
    const int64_t most = 1 << 24;
    bool grid = width >= 3 && height >= 3 && width <= most && height <= most;
    bool disc = radius > 0.0 && radius <= THESIS_CELL;
    bool inside =
        x >= 0.0 && y >= 0.0 && x < (double)width * THESIS_CELL && y < (double)height * THESIS_CELL;
    return grid && disc && inside;
}

// thesis_motion.c

// Moves the disc towards a goal; see wg_thesis_move.
WgThesisMove thesis_advance(const ThesisGrid *grid, double x, double y, double goal_x,
                            double goal_y, double radius, int64_t repairs, double wall_friction);

// thesis_signal.c

// Returns the heading to the best signal by the sensor of the settings; see wg_thesis_sense.
double thesis_sensed(const ThesisGrid *grid, const WgThesisSettings *settings, double x, double y,
                     double looking, int64_t step);

// Returns true if the settings satisfy the assumptions of these functions.
bool thesis_can_sense(const ThesisGrid *grid, const WgThesisSettings *settings);

#endif

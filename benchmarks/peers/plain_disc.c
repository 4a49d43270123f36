// A disc that drives through a grid of cells, in the plainest possible C: only floating point, no
// lattice, no verdict, no search for loops. The simulator's extra cost is the price of its
// guarantees.
//
// Lengths are cells, x runs right, y up; cells are stored row by row, nonzero where solid.

#include <math.h>
#include <stdint.h>

typedef struct Grid {
    const uint8_t *cells;
    int64_t width;
    int64_t height;
} Grid;

typedef struct Disc {
    double x;
    double y;
    double radius;
} Disc;

typedef struct Move {
    double dx;
    double dy;
} Move;

static uint64_t next_random(uint64_t *state)
{
    *state += 0x9E3779B97F4A7C15u;
    uint64_t z = *state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double clamp(double value, double low, double high)
{
    if (value < low) {
        return low;
    }
    return value > high ? high : value;
}

// Narrows [enter, leave] to the part where a coordinate is between two bounds;
// returns 0 if that part is empty.
static int clip(double place, double way, double low, double high, double *enter, double *leave)
{
    if (way == 0.0) {
        return place > low && place < high;
    }
    double inverse = 1.0 / way;
    double first = (low - place) * inverse;
    double last = (high - place) * inverse;
    double earlier = first < last ? first : last;
    double later = first < last ? last : first;
    if (earlier > *enter) {
        *enter = earlier;
    }
    if (later < *leave) {
        *leave = later;
    }
    return *enter <= *leave;
}

// Share of the move at which the disc meets the cell; 2 if it does not.
//
// A moving disc against a box: Ericson, Real-Time Collision Detection (2005), 5.5.7.
static double meets_cell(Disc disc, Move move, int64_t ix, int64_t iy)
{
    double left = (double)ix;
    double low = (double)iy;
    double off_x = disc.x - clamp(disc.x, left, left + 1.0);
    double off_y = disc.y - clamp(disc.y, low, low + 1.0);

    // Touching already: only a move that leads away is free.
    if (off_x * off_x + off_y * off_y <= disc.radius * disc.radius) {
        int approaches = off_x * move.dx + off_y * move.dy < 0.0;
        return approaches || (off_x == 0.0 && off_y == 0.0) ? 0.0 : 2.0;
    }

    // The box, grown by the radius.
    double enter = 0.0;
    double leave = 1.0;
    if (!clip(disc.x, move.dx, left - disc.radius, left + 1.0 + disc.radius, &enter, &leave) ||
        !clip(disc.y, move.dy, low - disc.radius, low + 1.0 + disc.radius, &enter, &leave)) {
        return 2.0;
    }

    // Beyond a corner of the cell the grown box is round.
    double x = disc.x + enter * move.dx;
    double y = disc.y + enter * move.dy;
    double corner_x = clamp(x, left, left + 1.0);
    double corner_y = clamp(y, low, low + 1.0);
    if (corner_x == x || corner_y == y) {
        return enter;
    }
    double from_x = disc.x - corner_x;
    double from_y = disc.y - corner_y;
    double a = move.dx * move.dx + move.dy * move.dy;
    double b = from_x * move.dx + from_y * move.dy;
    double c = from_x * from_x + from_y * from_y - disc.radius * disc.radius;
    double square = b * b - a * c;
    if (b >= 0.0 || square < 0.0) {
        return 2.0;
    }
    double time = (-b - sqrt(square)) / a;
    return time >= 0.0 && time <= 1.0 ? time : 2.0;
}

// Share of the move at which the disc meets the first solid cell; more than 1 if it meets none.
static double sweep(Grid grid, Disc disc, Move move)
{
    double end_x = disc.x + move.dx;
    double end_y = disc.y + move.dy;
    int64_t first_x = (int64_t)floor((disc.x < end_x ? disc.x : end_x) - disc.radius);
    int64_t last_x = (int64_t)floor((disc.x > end_x ? disc.x : end_x) + disc.radius);
    int64_t first_y = (int64_t)floor((disc.y < end_y ? disc.y : end_y) - disc.radius);
    int64_t last_y = (int64_t)floor((disc.y > end_y ? disc.y : end_y) + disc.radius);
    double best = 2.0;
    for (int64_t iy = first_y; iy <= last_y; iy++) {
        for (int64_t ix = first_x; ix <= last_x; ix++) {
            int inside = ix >= 0 && iy >= 0 && ix < grid.width && iy < grid.height;
            if (inside && grid.cells[iy * grid.width + ix] == 0) {
                continue;
            }
            double time = meets_cell(disc, move, ix, iy);
            if (time < best) {
                best = time;
            }
        }
    }
    return best;
}

// Moves the disc by one step; returns whether it hit a wall, where it then stops.
static int drive(Grid grid, Disc *disc, Move move)
{
    double time = sweep(grid, *disc, move);
    if (time > 1.0) {
        disc->x += move.dx;
        disc->y += move.dy;
        return 0;
    }
    double before = time > 1e-3 ? time - 1e-3 : 0.0;
    disc->x += before * move.dx;
    disc->y += before * move.dy;
    return 1;
}

// Drives straight ahead, and after a bump turns on the spot for 5 to 24 steps. Returns where the
// disc ends, so that the compiler cannot drop the work.
double bounce(const uint8_t *cells, int64_t width, int64_t height, double x, double y,
              double radius, double step, double turn, uint64_t seed, int64_t steps)
{
    const Grid grid = {cells, width, height};
    Disc disc = {x, y, radius};
    double heading = 0.0;
    Move move = {step, 0.0};
    int64_t rest = 0;
    for (int64_t k = 0; k < steps; k++) {
        if (rest > 0) {
            rest--;
            heading += turn;
            move = (Move){step * cos(heading), step * sin(heading)};
        } else if (drive(grid, &disc, move)) {
            rest = 5 + (int64_t)(next_random(&seed) % 20u);
        }
    }
    return disc.x + disc.y;
}

// Always moving: the heading leans towards the current mark, and turns by a right angle at walls.
//
// marks: (mark_count, 2) places; a random one is next whenever the last one is reached.
double wander(const uint8_t *cells, int64_t width, int64_t height, double x, double y,
              double radius, double step, const double *marks, int64_t mark_count, uint64_t seed,
              int64_t steps)
{
    const Grid grid = {cells, width, height};
    Disc disc = {x, y, radius};
    const double *mark = marks;
    Move heading = {1.0, 0.0};
    int64_t patience = 0;
    for (int64_t k = 0; k < steps; k++) {
        double to_x = mark[0] - disc.x;
        double to_y = mark[1] - disc.y;
        if (to_x * to_x + to_y * to_y < 1.0) {
            mark = marks + 2 * (int64_t)(next_random(&seed) % (uint64_t)mark_count);
        } else if (patience == 0) {
            double lean = 0.3 / sqrt(to_x * to_x + to_y * to_y);
            heading.dx += to_x * lean;
            heading.dy += to_y * lean;
            double length = sqrt(heading.dx * heading.dx + heading.dy * heading.dy + 1e-300);
            heading.dx /= length;
            heading.dy /= length;
        }
        patience -= patience > 0;
        const Move move = {heading.dx * step, heading.dy * step};
        if (drive(grid, &disc, move)) {
            uint64_t drawn = next_random(&seed);
            const Move turned = {drawn & 1 ? -heading.dy : heading.dy,
                                 drawn & 1 ? heading.dx : -heading.dx};
            heading = turned;
            patience = 4 + (int64_t)((drawn >> 8) & 31u);
        }
    }
    return disc.x + disc.y;
}

// GESTALT: keeps a small grid of how well the ground around it can be driven on, scores arcs by it,
// and drives the best one for a fixed length before it looks again.
//
// Source: Steven B. Goldberg, Mark W. Maimone and Larry Matthies, "Stereo vision and rover
// navigation software for planetary exploration", IEEE Aerospace Conference (2002), section 4:
// goodness of cells, votes for arcs, and their merging with votes for the waypoint. Departures:
// cells are judged by range beams and by touch instead of by stereo, and the robot may begin an arc
// in any of 17 directions, because it turns on the spot.

#include <stdbool.h>

#include "directions.h"
#include "library.h"

enum {
    CELLS_A_WORD = 12,  // 4 bits each: 48 bits, which a double holds exactly
    MOST_DEGREE = 15,   // highest degree of goodness; 0 is unknown
    BAD = 4,            // an arc ends before a cell of this degree or lower
    UNKNOWN_IS = 6,     // degree that counts for an unknown cell
    FIRST_IS = 8,       // degree of a cell before its first observation
    HIT = 8,            // degrees that a beam's end takes from a cell
    PASS = 1,           // degrees that a beam gives to a cell that it passes
    HEADINGS = 16,      // directions of the world in which an arc can begin, besides the target's
};

static const double ARC = 5.0;            // radii of the robot: length of an arc
static const double CELL = 0.5;           // same: side of a cell
// same: cells nearer than this to the middle are under the robot
static const double FOOT = 0.75;
static const double BEND = 0.78539816339744830962;  // rad: turn along a bent arc
static const double TO_GOOD = 1.0;        // weight of the mean goodness along an arc
static const double TO_TARGET = 0.4;     // weight of the progress towards the target

typedef struct Arc {
    double heading;  // rad, at its beginning
    double bend;     // rad/m
    double length;   // m
} Arc;

// The cell's number in the grid; -1 outside the window.
static int64_t number_of(const WgGestaltMemory *own, int64_t column, int64_t row)
{
    int64_t side = (int64_t)own->side;
    int64_t low_x = (int64_t)own->window_x;
    int64_t low_y = (int64_t)own->window_y;
    if (column < low_x || column >= low_x + side || row < low_y || row >= low_y + side) {
        return -1;
    }
    return wg_floor_mod(row, side) * side + wg_floor_mod(column, side);
}

static int64_t degree_at(const WgGestaltMemory *own, int64_t number)
{
    return ((int64_t)own->cells[number / CELLS_A_WORD] >> (4 * (number % CELLS_A_WORD))) & MOST_DEGREE;
}

static void set_degree(WgGestaltMemory *own, int64_t number, int64_t degree)
{
    double *word = &own->cells[number / CELLS_A_WORD];
    int64_t shift = 4 * (number % CELLS_A_WORD);
    *word = (double)(((int64_t)*word & ~((int64_t)MOST_DEGREE << shift)) | (degree << shift));
}

// Changes the degree of the cell at a place, within 1 to MOST_DEGREE.
static void judge(WgGestaltMemory *own, double x, double y, int64_t change)
{
    int64_t number = number_of(own, wg_floor(x / own->pitch), wg_floor(y / own->pitch));
    if (number < 0) {
        return;
    }
    int64_t degree = degree_at(own, number);
    int64_t changed = (degree == 0 ? FIRST_IS : degree) + change;
    set_degree(own, number, wg_least(wg_most(changed, 1), MOST_DEGREE));
}

static void forget_line(WgGestaltMemory *own, int64_t place, bool is_column)
{
    int64_t side = (int64_t)own->side;
    int64_t at = wg_floor_mod(place, side);
    for (int64_t k = 0; k < side; k++) {
        set_degree(own, is_column ? k * side + at : at * side + k, 0);
    }
}

// Moves the window along an axis so that it begins at a place, and forgets the cells that leave it.
static void move_along(WgGestaltMemory *own, double *low, int64_t place, bool columns)
{
    int64_t before = (int64_t)*low;
    int64_t first = wg_least(before, place);
    // A window that moves further than its own side forgets every line once.
    int64_t last = first + wg_least(wg_abs(place - before), (int64_t)own->side);
    for (int64_t line = first; line < last; line++) {
        forget_line(own, line, columns);
    }
    *low = (double)place;
}

// Lays the grid in the first step, and keeps the robot in the middle of its window.
static void move_window(const WgObservation *seen, WgGestaltMemory *own)
{
    bool begins = own->pitch == 0.0;
    if (begins) {
        own->pitch = CELL * seen->radius;
    }
    int64_t half = (int64_t)own->side / 2;
    int64_t low_x = wg_floor(seen->x / own->pitch) - half;
    int64_t low_y = wg_floor(seen->y / own->pitch) - half;
    if (begins) {
        own->window_x = (double)low_x;
        own->window_y = (double)low_y;
    }
    move_along(own, &own->window_x, low_x, true);
    move_along(own, &own->window_y, low_y, false);
}

// Judges the cells that the beams pass, and those where they end. A beam that ends beyond the
// window hits nothing inside it.
static void look(const WgObservation *seen, WgGestaltMemory *own)
{
    double window = 0.5 * own->side * own->pitch;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        double angle = seen->heading + wg_bearing_of(beam, seen->beam_count);
        double along_x = wg_cos(angle);
        double along_y = wg_sin(angle);
        double distance = seen->beams[beam];
        double last = wg_lower(distance - own->pitch, window);
        for (double at = 0.0; at < last; at += own->pitch) {
            judge(own, seen->x + at * along_x, seen->y + at * along_y, PASS);
        }
        if (distance < window) {
            judge(own, seen->x + distance * along_x, seen->y + distance * along_y, -HIT);
        }
    }
}

// Marks the ground as bad where the robot touched something,
// if the robot would cover that spot when it drives there.
static void feel(const WgObservation *seen, WgGestaltMemory *own)
{
    double touched = seen->heading + seen->bump_bearing;
    double at = FOOT * seen->radius;
    judge(own, seen->x + at * wg_cos(touched), seen->y + at * wg_sin(touched), -MOST_DEGREE);
}

// The least degree of the cells under a robot at a place.
static int64_t degree_under(const WgGestaltMemory *own, double x, double y, double reach)
{
    int64_t least = MOST_DEGREE;
    for (int64_t row = wg_floor((y - reach) / own->pitch); row <= wg_floor((y + reach) / own->pitch); row++) {
        for (int64_t column = wg_floor((x - reach) / own->pitch); column <= wg_floor((x + reach) / own->pitch);
             column++) {
            double middle_x = ((double)column + 0.5) * own->pitch;
            double middle_y = ((double)row + 0.5) * own->pitch;
            int64_t number = number_of(own, column, row);
            if (number >= 0 && wg_distance(x, y, middle_x, middle_y) < reach) {
                int64_t degree = degree_at(own, number);
                least = wg_least(least, degree == 0 ? UNKNOWN_IS : degree);
            }
        }
    }
    return least;
}

// Returns how good an arc is: the mean goodness along it plus the progress that it makes, or
// -INFINITY if it starts with a bad cell. The arc ends before its first bad cell.
static double score(const WgObservation *seen, const WgGestaltMemory *own, Arc *arc)
{
    double target_x = seen->x + seen->target_distance * wg_cos(seen->target_heading);
    double target_y = seen->y + seen->target_distance * wg_sin(seen->target_heading);
    double x = seen->x;
    double y = seen->y;
    double heading = arc->heading;
    double driven = 0.0;
    double sum = 0.0;
    while (driven < arc->length) {
        double piece = wg_lower(own->pitch, arc->length - driven);
        double next_x = x + piece * wg_cos(heading);
        double next_y = y + piece * wg_sin(heading);
        int64_t degree = degree_under(own, next_x, next_y, FOOT * seen->radius);
        if (degree <= BAD) {
            break;
        }
        x = next_x;
        y = next_y;
        heading += arc->bend * piece;
        driven += piece;
        sum += piece * (double)degree;
    }
    if (driven < own->pitch && driven < arc->length) {
        return -INFINITY;
    }
    double whole = ARC * seen->radius;
    double progress = seen->target_distance - wg_distance(x, y, target_x, target_y);
    arc->length = driven;
    return TO_GOOD * sum / (double)MOST_DEGREE / whole + TO_TARGET * progress / whole;
}

// Chooses the best arc; if all are bad, forgets the grid and takes the direction after the last
// one.
static void choose(const WgObservation *seen, WgGestaltMemory *own)
{
    double whole = ARC * seen->radius;
    double best = -INFINITY;
    for (int64_t k = 0; k <= HEADINGS; k++) {
        for (int64_t side = 0; side < 3; side++) {
            // The straight arc to the target comes first, because ties go to the first.
            double bend = side == 0 ? 0.0 : (side == 1 ? BEND : -BEND) / whole;
            double heading = WG_WHOLE_TURN * (double)(k - 1) / (double)HEADINGS;
            Arc arc = {k == 0 ? seen->target_heading : wg_wrap(heading), bend, wg_lower(whole, seen->target_distance)};
            double found = score(seen, own, &arc);
            if (found > best) {
                best = found;
                own->heading = arc.heading;
                own->bend = arc.bend;
                own->left = arc.length;
            }
        }
    }
    if (best > -INFINITY) {
        return;
    }
    int64_t words = ((int64_t)own->side * (int64_t)own->side + CELLS_A_WORD - 1) / CELLS_A_WORD;
    for (int64_t word = 0; word < words; word++) {
        own->cells[word] = 0.0;
    }
    own->heading = wg_wrap(own->heading + WG_WHOLE_TURN / (double)HEADINGS);
    own->bend = 0.0;
    own->left = own->pitch;
}

void wg_gestalt_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgGestaltMemory *own = (WgGestaltMemory *)memory;
    move_window(seen, own);
    bool touches = seen->bump != 0.0;
    if (touches || own->left <= 0.0) {
        look(seen, own);
        if (touches) {
            // after the beams, because they cannot see an obstacle that the robot touches
            feel(seen, own);
        }
        choose(seen, own);
    }

    // Drive the next piece of the arc.
    double length = wg_lower(seen->top_speed * seen->time_step, own->left);
    wg_steer(seen, command, wg_wrap(own->heading - seen->heading), length / seen->time_step);
    own->heading = wg_wrap(own->heading + own->bend * length);
    own->left -= length;
}

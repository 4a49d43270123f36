// How scans are matched with a map of points; scan_map.h describes it.

#include "scan_map.h"

#include <math.h>
#include <stdbool.h>

#include "directions.h"

enum {
    CELLS_A_WORD = 3,  // 17 bits each: 51 bits, which a double holds exactly
    BITS = 17,
    PARTS = 256,       // a point's place in its cell is kept to this fraction of a side
    ROUNDS = 10,       // of Gauss and Newton; most scans need three
};

static const double FAR = 2.5;       // m: a longer beam counts as one without an end
static const double GATE = 0.6;      // cells: a point of the map further from an end is another one
static const double APART = 0.1;     // cells: two points nearer than this give no line
// cells: distance from its line at which an end's weight is a quarter, in the first round and, after
// halving in each round, at last; so ends that belong to no line, as at corners, lose their weight
static const double SOFT = 0.4;
static const double STRICT = 0.025;
static const double HOLD = 0.1;      // weight of the pose from the wheels, in ends of beams
static const double ARM = 0.5;       // m: its heading counts like a residual at this distance
static const double STILL = 1e-4;    // m and rad: a smaller correction is the last
static const double TURN = 0.08;     // rad: step of the search over headings

// The ends of a scan's beams in the robot's frame, m.
typedef struct Ends {
    double x[WG_MOST_BEAMS];
    double y[WG_MOST_BEAMS];
    int64_t count;
} Ends;

// Two points of the map near a place; the nearest first.
typedef struct Pair {
    double x[2];
    double y[2];
    double away_sq[2];  // m2; infinite for a point that is missing
} Pair;

// Finds the ends of beams that met something: those that are shorter than the scan's longest.
static void ends_of(const WgObservation *seen, Ends *ends)
{
    double longest = 0.0;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        longest = wg_higher(longest, seen->beams[beam]);
    }
    longest = wg_lower(longest, FAR);
    ends->count = 0;
    for (int64_t beam = 0; beam < wg_least(seen->beam_count, WG_MOST_BEAMS); beam++) {
        if (seen->beams[beam] >= longest) {
            continue;
        }
        double bearing = wg_bearing_of(beam, seen->beam_count);
        ends->x[ends->count] = seen->beams[beam] * wg_cos(bearing);
        ends->y[ends->count] = seen->beams[beam] * wg_sin(bearing);
        ends->count++;
    }
}

// Returns the place of a cell's entry among those of the window, which is a ring in both directions.
static int64_t number_of(int64_t column, int64_t row)
{
    return (row & (WG_SCAN_SIDE - 1)) * WG_SCAN_SIDE + (column & (WG_SCAN_SIDE - 1));
}

// Returns true if a cell is in the window, and so far from its border that its neighbours are, too.
static bool is_inside(const WgScanMap *map, int64_t column, int64_t row)
{
    int64_t i = column - (int64_t)map->window_x;
    int64_t j = row - (int64_t)map->window_y;
    return 0 < i && i < WG_SCAN_SIDE - 1 && 0 < j && j < WG_SCAN_SIDE - 1;
}

// Returns a cell's entry: 0 if it has no point, else 1 more than the point's place in it.
static int64_t entry_of(const WgScanMap *map, int64_t number)
{
    int64_t word = (int64_t)map->cells[number / CELLS_A_WORD];
    return (word >> (BITS * (number % CELLS_A_WORD))) & ((1 << BITS) - 1);
}

static void set_entry(WgScanMap *map, int64_t number, int64_t entry)
{
    double *word = &map->cells[number / CELLS_A_WORD];
    int64_t shift = BITS * (number % CELLS_A_WORD);
    int64_t others = (int64_t)*word & ~((int64_t)((1 << BITS) - 1) << shift);
    *word = (double)(others | (entry << shift));
}

// Finds the two points of the map that are nearest to a place, among those of the nine cells around
// it.
static Pair points_near(const WgScanMap *map, double x, double y)
{
    Pair pair = {.away_sq = {INFINITY, INFINITY}};
    int64_t column = wg_floor(x / map->pitch);
    int64_t row = wg_floor(y / map->pitch);
    if (!is_inside(map, column, row)) {
        return pair;
    }
    for (int64_t j = row - 1; j <= row + 1; j++) {
        for (int64_t i = column - 1; i <= column + 1; i++) {
            int64_t entry = entry_of(map, number_of(i, j));
            if (entry == 0) {
                continue;
            }
            double at_x = ((double)i + ((double)((entry - 1) % PARTS) + 0.5) / PARTS) * map->pitch;
            double at_y = ((double)j + ((double)((entry - 1) / PARTS) + 0.5) / PARTS) * map->pitch;
            double away_sq = (at_x - x) * (at_x - x) + (at_y - y) * (at_y - y);
            int slot = away_sq < pair.away_sq[0] ? 0 : 1;
            if (away_sq >= pair.away_sq[slot]) {
                continue;
            }
            if (slot == 0) {
                pair.x[1] = pair.x[0];
                pair.y[1] = pair.y[0];
                pair.away_sq[1] = pair.away_sq[0];
            }
            pair.x[slot] = at_x;
            pair.y[slot] = at_y;
            pair.away_sq[slot] = away_sq;
        }
    }
    return pair;
}

// Returns the heading, among those within the doubt, at which most ends are near points of the map.
static double likely_heading(const WgScanMap *map, const Ends *ends, WgMapPose pose, double doubt)
{
    double gate_sq = GATE * GATE * map->pitch * map->pitch;
    double best = -1.0;
    double found = pose.heading;
    int64_t turns = wg_floor(doubt / TURN);
    // From the likely heading outwards, so that it wins a tie.
    for (int64_t k = 0; k <= 2 * turns; k++) {
        double heading = pose.heading + TURN * (double)((k + 1) / 2) * (k % 2 != 0 ? 1.0 : -1.0);
        double along = wg_cos(heading);
        double across = wg_sin(heading);
        double score = 0.0;
        for (int64_t end = 0; end < ends->count; end++) {
            double x = pose.x + along * ends->x[end] - across * ends->y[end];
            double y = pose.y + across * ends->x[end] + along * ends->y[end];
            double away_sq = points_near(map, x, y).away_sq[0];
            score += away_sq < gate_sq ? 1.0 - away_sq / gate_sq : 0.0;
        }
        if (score > best) {
            best = score;
            found = heading;
        }
    }
    return found;
}

// Solves three linear equations with a symmetric matrix, whose diagonal is positive, by Cholesky's
// method.
static void solve(double m[3][3], double b[3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j <= i; j++) {
            double rest = m[i][j];
            for (int k = 0; k < j; k++) {
                rest -= m[i][k] * m[j][k];
            }
            m[i][j] = i == j ? sqrt(rest) : rest / m[j][j];
        }
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < i; k++) {
            b[i] -= m[i][k] * b[k];
        }
        b[i] /= m[i][i];
    }
    for (int i = 2; i >= 0; i--) {
        for (int k = i + 1; k < 3; k++) {
            b[i] -= m[k][i] * b[k];
        }
        b[i] /= m[i][i];
    }
}

// One round of Gauss and Newton: returns the corrections of x, y and heading.
static WgMapPose correction(const WgScanMap *map, const Ends *ends, WgMapPose pose, WgMapPose likely, double soft)
{
    // The wheels hold the pose, with a weight that matters only where the scan leaves it open.
    double hold[3] = {HOLD, HOLD, HOLD * ARM * ARM};
    double off[3] = {likely.x - pose.x, likely.y - pose.y, likely.heading - pose.heading};
    double matrix[3][3] = {{0.0}};
    double right[3];
    for (int k = 0; k < 3; k++) {
        matrix[k][k] = hold[k];
        right[k] = hold[k] * off[k];
    }

    double along = wg_cos(pose.heading);
    double across = wg_sin(pose.heading);
    double gate = GATE * map->pitch;
    for (int64_t end = 0; end < ends->count; end++) {
        double arm_x = along * ends->x[end] - across * ends->y[end];
        double arm_y = across * ends->x[end] + along * ends->y[end];
        Pair pair = points_near(map, pose.x + arm_x, pose.y + arm_y);
        double line_x = pair.x[1] - pair.x[0];
        double line_y = pair.y[1] - pair.y[0];
        double length = sqrt(line_x * line_x + line_y * line_y);
        if (!(pair.away_sq[0] < gate * gate) || pair.away_sq[1] == INFINITY || length < APART * map->pitch) {
            continue;
        }

        // The distance from the line, and how it grows with x, y and heading.
        double normal_x = -line_y / length;
        double normal_y = line_x / length;
        double residual = normal_x * (pose.x + arm_x - pair.x[0]) + normal_y * (pose.y + arm_y - pair.y[0]);
        double grows[3] = {normal_x, normal_y, normal_y * arm_x - normal_x * arm_y};
        double fit = 1.0 / (1.0 + (residual / soft) * (residual / soft));
        double weight = fit * fit;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j <= i; j++) {
                matrix[i][j] += weight * grows[i] * grows[j];
            }
            right[i] -= weight * grows[i] * residual;
        }
    }
    solve(matrix, right);
    return (WgMapPose){right[0], right[1], right[2]};
}

WgMapPose wg_match_scan(const WgScanMap *map, const WgObservation *seen, WgMapPose likely, double doubt)
{
    Ends ends;
    ends_of(seen, &ends);
    if (doubt >= TURN) {
        likely.heading = likely_heading(map, &ends, likely, doubt);
    }
    WgMapPose pose = likely;
    double soft = SOFT;
    for (int round = 0; round < ROUNDS; round++) {
        WgMapPose change = correction(map, &ends, pose, likely, soft * map->pitch);
        pose.x += change.x;
        pose.y += change.y;
        pose.heading += change.heading;
        bool strict = soft == STRICT;
        soft = wg_higher(0.5 * soft, STRICT);
        if (strict && fabs(change.x) < STILL && fabs(change.y) < STILL && fabs(change.heading) < STILL) {
            break;
        }
    }
    pose.heading = wg_wrap(pose.heading);
    return pose;
}

// Moves the window along an axis until a cell has a quarter of it on each side, and forgets the
// points that leave it.
static void move_along(WgScanMap *map, double *low, int64_t place, bool columns)
{
    enum { QUARTER = WG_SCAN_SIDE / 4 };
    int64_t before = (int64_t)*low;
    int64_t after = wg_most(wg_least(before, place - QUARTER), place - WG_SCAN_SIDE + 1 + QUARTER);
    int64_t first = wg_least(before, after);
    // A window that moves further than its own side forgets every line once.
    int64_t last = first + wg_least(wg_abs(after - before), WG_SCAN_SIDE);
    for (int64_t line = first; line < last; line++) {
        for (int64_t k = 0; k < WG_SCAN_SIDE; k++) {
            set_entry(map, columns ? number_of(line, k) : number_of(k, line), 0);
        }
    }
    *low = (double)after;
}

int64_t wg_add_scan(WgScanMap *map, const WgObservation *seen, WgMapPose at, double told[][2])
{
    move_along(map, &map->window_x, wg_floor(at.x / map->pitch), true);
    move_along(map, &map->window_y, wg_floor(at.y / map->pitch), false);
    Ends ends;
    ends_of(seen, &ends);
    double along = wg_cos(at.heading);
    double across = wg_sin(at.heading);
    int64_t count = 0;
    for (int64_t end = 0; end < ends.count; end++) {
        double x = at.x + along * ends.x[end] - across * ends.y[end];
        double y = at.y + across * ends.x[end] + along * ends.y[end];
        int64_t column = wg_floor(x / map->pitch);
        int64_t row = wg_floor(y / map->pitch);
        int64_t number = number_of(column, row);
        if (!is_inside(map, column, row) || entry_of(map, number) != 0) {
            continue;
        }
        int64_t part_x = wg_least(wg_floor((x / map->pitch - (double)column) * PARTS), PARTS - 1);
        int64_t part_y = wg_least(wg_floor((y / map->pitch - (double)row) * PARTS), PARTS - 1);
        set_entry(map, number, 1 + part_y * PARTS + part_x);
        told[count][0] = x;
        told[count][1] = y;
        count++;
    }
    return count;
}

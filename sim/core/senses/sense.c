// Senses that few steps need, or that are slow; see sense.h.

#include "sense.h"

#include "fdlibm.h"
#include "rays.h"

static const double PER_RADIAN = (double)WG_TURN / (2.0 * 3.141592653589793);

// A place whose signal may be read: the middle of a cell, or the target in its own cell.
typedef struct Place {
    int64_t x;
    int64_t y;
} Place;

int64_t wg_heading_of(int64_t dx, int64_t dy, int64_t otherwise)
{
    int64_t ax = wg_abs(dx);
    int64_t ay = wg_abs(dy);
    if (ax == 0 && ay == 0) {
        return otherwise;
    }
    // Reduced to the first eighth of a turn, so that it has every mirror symmetry exactly.
    int64_t units = 0;
    if (ay <= ax) {
        units = wg_floor(wg_atan((double)ay / (double)ax) * PER_RADIAN + 0.5);
    } else {
        units = WG_TURN / 4 - wg_floor(wg_atan((double)ax / (double)ay) * PER_RADIAN + 0.5);
    }
    if (dx < 0) {
        units = WG_TURN / 2 - units;
    }
    if (dy < 0) {
        units = -units;
    }
    return wg_reduced_heading(units);
}

void wg_heading_table(int64_t *table)
{
    enum { EIGHTH = WG_TURN / 8, HALF = WG_TURN / 2 };
    const double scale = 0x1p30;

    // The first quarter turn: sines and cosines of the first eighth, and their rounding errors.
    for (int64_t k = 0; k <= EIGHTH; k++) {
        double angle = (double)k / PER_RADIAN;
        double values[2] = {wg_sin(angle), wg_cos(angle)};
        int64_t places[2] = {2 * EIGHTH - k, k};
        for (int which = 1; which >= 0; which--) {
            int64_t coarse = wg_floor(values[which] * scale + 0.5);
            table[places[which]] = coarse;
            table[WG_TURN + places[which]] =
                wg_floor((values[which] - (double)coarse / scale) * scale * scale + 0.5);
        }
    }
    // The second quarter is the first one's mirror image, and the second half the first one's.
    for (int64_t part = 0; part <= WG_TURN; part += WG_TURN) {
        int64_t *cosines = table + part;
        for (int64_t k = 0; k < 2 * EIGHTH; k++) {
            cosines[HALF - k] = -cosines[k];
        }
        for (int64_t k = 1; k < HALF; k++) {
            cosines[WG_TURN - k] = cosines[k];
        }
    }
}

// Returns true if a direction from the robot is in the sensor's field, which extends equally to
// both sides of the heading.
static bool is_in_field(const WgSettings *settings, Place shift, int64_t heading)
{
    if (settings->sensor_field >= (double)(WG_TURN / 2)) {
        return true;
    }
    int64_t off = wg_abs(wg_turn_towards(heading, wg_heading_of(shift.x, shift.y, heading)));
    return (double)off <= settings->sensor_field;
}

// Returns the signal of a source of strength 1 at a place: 1 / (1 + squared distance in cells),
// minus the loss in walls and smoke on the way; 0 beyond the sensor's range.
static double sent(const WgArena *arena, const WgSettings *settings, Place source, Place place)
{
    enum { MOST_HALVINGS = 1000 };

    int64_t dx = source.x - place.x;
    int64_t dy = source.y - place.y;
    double away_sq = (double)(dx * dx + dy * dy);
    if (away_sq > settings->sensor_range * settings->sensor_range) {
        return 0.0;
    }
    double value = 1.0 / (1.0 + away_sq / (double)(WG_UNIT * WG_UNIT));
    WgGrid grid = wg_grid(arena);
    if (settings->signal != WG_SIGNAL_OPEN) {
        int64_t walls = wg_walls_on_the_way(grid, place.x, place.y, source.x, source.y);
        if (walls > 0) {
            bool is_lost = settings->signal == WG_SIGNAL_BLOCKED || walls > MOST_HALVINGS;
            value = is_lost ? 0.0 : ldexp(value, -(int)walls);
        }
    }
    if (settings->smoke > 0.0) {
        int64_t cells = wg_smoke_on_the_way(grid, place.x, place.y, source.x, source.y, settings->smoke_reach);
        for (int64_t k = 0; k < cells; k++) {
            value *= 1.0 - settings->smoke;
        }
    }
    return value;
}

// Returns the same as the sensor reads it, with a relative error.
//
// draw:  number of the random draw of the noise.
static double with_noise(const WgSettings *settings, double value, int64_t draw)
{
    if (settings->sensor_noise == 0.0) {
        return value;
    }
    return value * (1.0 + settings->sensor_noise * (2.0 * wg_noise_draw(settings, draw) - 1.0));
}

double wg_signal_here(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step)
{
    const WgState *state = &robot->body->state;
    // The sensor adds up the signals of the sources in its field.
    Place here = {state->x, state->y};
    double value = 0.0;
    for (int64_t k = -1; k < settings->decoy_count; k++) {
        const WgDecoy *decoy = k < 0 ? NULL : &settings->decoys[k];
        Place source = {robot->goal->x, robot->goal->y};
        if (decoy != NULL) {
            source = (Place){decoy->x, decoy->y};
        }
        Place shift = {source.x - here.x, source.y - here.y};
        if (is_in_field(settings, shift, state->heading)) {
            value += (decoy != NULL ? decoy->strength : 1.0) * sent(arena, settings, source, here);
        }
    }
    return with_noise(settings, value, wg_noise_channel(step, WG_NOISE_SIGNAL));
}

// Returns the strength of the signal that the sensor reads for a place near the robot,
// 0 if there is none.
//
// draw:  number of the random draw of the noise.
static double reading(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, Place place, int64_t draw)
{
    const WgState *state = &robot->body->state;
    Place shift = {place.x - state->x, place.y - state->y};
    if (!is_in_field(settings, shift, state->heading)) {
        return 0.0;
    }
    Place target = {robot->goal->x, robot->goal->y};
    double value = sent(arena, settings, target, place);
    for (int64_t k = 0; k < settings->decoy_count; k++) {
        const WgDecoy *decoy = &settings->decoys[k];
        value += decoy->strength * sent(arena, settings, (Place){decoy->x, decoy->y}, place);
    }
    return with_noise(settings, value, draw);
}

// Finds the cell, of the nine around (ix, iy), that wg_signal_heading points to.
static Place strongest_of_nine(WgGrid grid, int64_t ix, int64_t iy, int64_t target_x, int64_t target_y)
{
    const int64_t middle = WG_UNIT / 2;

    // If the target's cell isn't among the nine, the nearest of them is the answer if it is free.
    int64_t away_x = ix * WG_UNIT + middle - target_x;
    int64_t away_y = iy * WG_UNIT + middle - target_y;
    bool is_far = wg_most(wg_abs(away_x), wg_abs(away_y)) > 2 * WG_UNIT;
    if (is_far && wg_abs(away_x) != middle && wg_abs(away_y) != middle) {
        int64_t near_x = ix - (away_x > middle) + (away_x < -middle);
        int64_t near_y = iy - (away_y > middle) + (away_y < -middle);
        if (wg_cell_state(grid, near_x, near_y) == WG_FREE) {
            return (Place){near_x, near_y};
        }
    }

    // Start with the robot's own cell; another must be strictly stronger.
    Place best = {ix, iy};
    int64_t least = -1;
    for (int64_t place = -1; place < 9; place++) {
        int64_t jx = place < 0 ? ix : ix + place % 3 - 1;
        int64_t jy = place < 0 ? iy : iy + 1 - place / 3;
        int64_t dx = jx * WG_UNIT + middle - target_x;
        int64_t dy = jy * WG_UNIT + middle - target_y;
        int64_t distance = dx * dx + dy * dy;
        if (jx == wg_cell_of(target_x) && jy == wg_cell_of(target_y)) {
            distance = 0;  // as in the thesis: nothing is stronger than the target's own cell
        }
        if (least < 0 || (distance < least && wg_cell_state(grid, jx, jy) == WG_FREE)) {
            least = distance;
            best = (Place){jx, jy};
        }
    }
    return best;
}

int64_t wg_signal_heading(WgGrid grid, int64_t x, int64_t y, int64_t target_x, int64_t target_y, int64_t heading)
{
    Place best = strongest_of_nine(grid, wg_cell_of(x), wg_cell_of(y), target_x, target_y);
    if (best.x == wg_cell_of(target_x) && best.y == wg_cell_of(target_y)) {
        return wg_heading_of(target_x - x, target_y - y, heading);
    }
    int64_t middle = WG_UNIT / 2;
    return wg_heading_of(best.x * WG_UNIT + middle - x, best.y * WG_UNIT + middle - y, heading);
}

// Like wg_signal_heading, but for a sensor with other limits;
// returns the robot's heading if it sees nothing.
static int64_t strongest_cell(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step)
{
    const WgState *state = &robot->body->state;
    WgGrid grid = wg_grid(arena);
    Place own = {wg_cell_of(state->x), wg_cell_of(state->y)};
    Place home = {wg_cell_of(robot->goal->x), wg_cell_of(robot->goal->y)};
    int64_t side = 2 * settings->sensor_cells + 1;
    Place strongest = {state->x, state->y};
    double most = 0.0;
    for (int64_t place = -1; place < side * side; place++) {
        // The robot's own cell comes first, then rows from the top, columns from the left.
        Place cell = own;
        if (place >= 0) {
            cell.x += place % side - settings->sensor_cells;
            cell.y += settings->sensor_cells - place / side;
        }
        bool again = place >= 0 && cell.x == own.x && cell.y == own.y;
        if (again || wg_cell_state(grid, cell.x, cell.y) != WG_FREE) {
            continue;
        }
        Place at = {cell.x * WG_UNIT + WG_UNIT / 2, cell.y * WG_UNIT + WG_UNIT / 2};
        if (cell.x == home.x && cell.y == home.y) {
            at = (Place){robot->goal->x, robot->goal->y};
        }
        int64_t draw = wg_noise_channel(step, WG_NOISE_SIGNAL + 2 + place);
        double value = reading(arena, settings, robot, at, draw);
        if (value > most) {
            most = value;
            strongest = at;
        }
    }
    return wg_heading_of(strongest.x - state->x, strongest.y - state->y, state->heading);
}

int64_t wg_strongest_heading(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step)
{
    if (settings->plain_sensor == 0) {
        return strongest_cell(arena, settings, robot, step);
    }
    const WgState *state = &robot->body->state;
    return wg_signal_heading(wg_grid(arena), state->x, state->y, robot->goal->x, robot->goal->y, state->heading);
}

void wg_sense_more(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step,
                   WgObservation *observation, double *beams)
{
    const WgState *state = &robot->body->state;
    WgNormal contact = robot->contact;
    double radians = settings->radians;
    double metres = settings->metres;
    int64_t senses = settings->senses;

    if ((senses & WG_SENSE_BUMP_BEARING) != 0) {
        observation->bump_bearing = 0.0;
        if (wg_is_contact(contact)) {
            int64_t wall =
                wg_heading_of((int64_t)(-contact.x * 1024.0), (int64_t)(-contact.y * 1024.0), state->heading);
            observation->bump_bearing = (double)wg_turn_towards(state->heading, wall) * radians;
        }
    }

    // The target and its signal.
    int64_t dx = robot->goal->x - state->x;
    int64_t dy = robot->goal->y - state->y;
    if ((senses & WG_SENSE_TARGET_DISTANCE) != 0) {
        observation->target_distance = sqrt((double)(dx * dx + dy * dy)) * metres;
    }
    if ((senses & WG_SENSE_TARGET_HEADING) != 0) {
        observation->target_heading = (double)wg_turn_towards(0, wg_heading_of(dx, dy, state->heading)) * radians;
    }
    if ((senses & WG_SENSE_SIGNAL) != 0) {
        observation->signal = wg_signal_here(arena, settings, robot, step);
    }
    if ((senses & WG_SENSE_SIGNAL_HEADING) != 0) {
        int64_t strongest = wg_strongest_heading(arena, settings, robot, step);
        observation->signal_heading = (double)wg_turn_towards(0, strongest) * radians;
    }

    // The clock.
    if ((senses & WG_SENSE_TIME) != 0) {
        observation->time = (double)step * settings->time_step;
    }

    // The position measured by the wheels: the true one, if they have no noise
    // and nothing pushes the robot.
    if ((senses & WG_SENSE_ODOMETRY) != 0) {
        if (settings->measures != 0) {
            observation->odometry_x = robot->odometry.x * metres;
            observation->odometry_y = robot->odometry.y * metres;
            observation->odometry_heading = (double)wg_turn_towards(0, wg_floor(robot->odometry.heading + 0.5)) * radians;
        } else {
            observation->odometry_x = observation->x;
            observation->odometry_y = observation->y;
            observation->odometry_heading = observation->heading;
        }
    }
    if ((senses & WG_SENSE_BEAMS) != 0) {
        wg_sense_beams(arena, settings, state, step, beams);
    }
}

void wg_sense_tilt(const WgSettings *settings, WgObservation *observation)
{
    double x = (double)settings->drift_x;
    double y = (double)settings->drift_y;
    observation->tilt = sqrt(x * x + y * y) * settings->metres / settings->time_step;
    int64_t heading = wg_heading_of(settings->drift_x, settings->drift_y, 0);
    observation->tilt_heading = (double)wg_turn_towards(0, heading) * settings->radians;
}

// Three layers: one that reacts, one that supervises progress, and one that plans ahead.
//
// Sources: Erann Gat, "On three-layer architectures", in Artificial Intelligence and Mobile Robots
// (1998); R. Peter Bonasso, R. James Firby, Erann Gat, David Kortenkamp, David P. Miller and Marc
// G. Slack, "Experiences with an architecture for intelligent, reactive agents", Journal of
// Experimental & Theoretical Artificial Intelligence 9 (1997). The map, the plan and the steering
// are our own, as simple as they can be.

#include <stdbool.h>
#include <string.h>

#include "directions.h"
#include "library.h"

enum { SIDE = 48 };  // cells of the map per side; a row's bits must fit into the 53 of a double

static const uint64_t ALL = ((uint64_t)1 << SIDE) - 1;
static const double MOST_FORGOTTEN = 7.0;  // if this number grew forever, no state would recur

const WgThreeLayer wg_three_layer_default = {
    .margin = 0.002,
    .pitch = 20.0 / 7.0,
    .reach = 1.6,
    .look = 0.03,
    .patience = 40.0,
};

// Bits of a row of the map.
static uint64_t bits_of(double row)
{
    return (uint64_t)(int64_t)row;
}

static bool has_bit(uint64_t row, int64_t column)
{
    return ((row >> column) & 1) != 0;
}

static bool is_same(WgMapCell one, WgMapCell other)
{
    return one.column == other.column && one.row == other.row;
}

static int64_t within_side(int64_t place)
{
    if (place < 0) {
        return 0;
    }
    return place < SIDE ? place : SIDE - 1;
}

// Places the map around the middle between start and target, with the target in the middle of its
// cell.
static void lay(const WgObservation *seen, WgThreeLayerMemory *own, const WgThreeLayer *tuned)
{
    double far = seen->target_distance;
    double pitch = wg_higher(tuned->pitch * seen->radius, tuned->reach * far / (double)SIDE);
    double to_x = far * wg_cos(seen->target_heading);
    double to_y = far * wg_sin(seen->target_heading);
    double column = (double)(SIDE / 2 + wg_floor(0.5 * to_x / pitch));
    double row = (double)(SIDE / 2 + wg_floor(0.5 * to_y / pitch));
    own->pitch = pitch;
    own->laid = 1.0;
    own->to_x = -1.0;
    own->target_x = column;
    own->target_y = row;
    own->corner_x = seen->x + to_x - (column + 0.5) * pitch;
    own->corner_y = seen->y + to_y - (row + 0.5) * pitch;
}

// The map's cell at a place; the nearest for one outside.
static WgMapCell cell_at(const WgThreeLayerMemory *own, double x, double y)
{
    int64_t column = wg_floor((x - own->corner_x) / own->pitch);
    int64_t row = wg_floor((y - own->corner_y) / own->pitch);
    return (WgMapCell){within_side(column), within_side(row)};
}

// Makes one round of the flood: adds the cells next to `flooded`; returns true if there were any.
static bool spread(const WgThreeLayerMemory *own, uint64_t *flooded)
{
    uint64_t wave[SIDE];
    bool grown = false;
    for (int row = 0; row < SIDE; row++) {
        uint64_t closed = bits_of(own->right[row]);
        uint64_t cells = flooded[row];
        uint64_t new = cells | ((cells & ~closed) << 1) | ((cells >> 1) & ~closed);
        if (row > 0) {
            new |= flooded[row - 1] & ~bits_of(own->up[row - 1]);
        }
        if (row < SIDE - 1) {
            new |= flooded[row + 1] & ~bits_of(own->up[row]);
        }
        wave[row] = new & ALL;
        grown = grown || wave[row] != cells;
    }
    memcpy(flooded, wave, sizeof wave);
    return grown;
}

// Makes the deliberator's plan: floods the map from the target, a whole row of cells at a time,
// until the flood is next to the robot's cell.
WgMapCell wg_next_cell(const WgThreeLayerMemory *own, WgMapCell here, WgMapCell target)
{
    int64_t column = here.column;
    int64_t row = here.row;
    uint64_t flooded[SIDE] = {0};
    flooded[target.row] = (uint64_t)1 << target.column;
    for (int64_t round = 0; round < SIDE * SIDE; round++) {
        uint64_t closed = bits_of(own->right[row]);
        if (column < SIDE - 1 && has_bit(flooded[row], column + 1) && !has_bit(closed, column)) {
            return (WgMapCell){column + 1, row};
        }
        if (column > 0 && has_bit(flooded[row], column - 1) && !has_bit(closed, column - 1)) {
            return (WgMapCell){column - 1, row};
        }
        if (row < SIDE - 1 && has_bit(flooded[row + 1], column) && !has_bit(bits_of(own->up[row]), column)) {
            return (WgMapCell){column, row + 1};
        }
        if (row > 0 && has_bit(flooded[row - 1], column) && !has_bit(bits_of(own->up[row - 1]), column)) {
            return (WgMapCell){column, row - 1};
        }
        if (!spread(own, flooded)) {
            break;
        }
    }
    return (WgMapCell){-1, -1};
}

// Columns and rows between two cells.
static int64_t steps_between(WgMapCell here, WgMapCell there)
{
    return wg_abs(there.column - here.column) + wg_abs(there.row - here.row);
}

// Marks the border between two cells as closed, if they are neighbours.
static void close_border(WgThreeLayerMemory *own, WgMapCell here, WgMapCell there)
{
    if (steps_between(here, there) != 1) {
        return;
    }
    int64_t column = here.column < there.column ? here.column : there.column;
    int64_t row = here.row < there.row ? here.row : there.row;
    double *bits = here.row == there.row ? &own->right[row] : &own->up[row];
    *bits = (double)(bits_of(*bits) | ((uint64_t)1 << column));
}

// Opens the whole map again.
static void forget(WgThreeLayerMemory *own)
{
    for (int row = 0; row < SIDE; row++) {
        own->right[row] = 0.0;
        own->up[row] = 0.0;
    }
    own->forgotten = wg_lower(own->forgotten + 1.0, MOST_FORGOTTEN);
}

static void set_waypoint(WgThreeLayerMemory *own, WgMapCell there)
{
    own->to_x = (double)there.column;
    own->to_y = (double)there.row;
}

// Runs the sequencer: checks if the waypoint is reached or abandoned,
// and asks the deliberator for the next one.
static void sequence(const WgObservation *seen, WgThreeLayerMemory *own, const WgThreeLayer *tuned)
{
    WgMapCell here = cell_at(own, seen->x, seen->y);
    WgMapCell target = {(int64_t)own->target_x, (int64_t)own->target_y};
    WgMapCell before = {(int64_t)own->here_x, (int64_t)own->here_y};
    if (!is_same(here, before)) {
        own->from_x = own->here_x;
        own->from_y = own->here_y;
        own->here_x = (double)here.column;
        own->here_y = (double)here.row;
    }

    // While the robot is on its way to the waypoint, or to the target in its cell, there is nothing
    // to decide.
    WgMapCell there = {(int64_t)own->to_x, (int64_t)own->to_y};
    own->waited += 1.0;
    bool late = own->waited > tuned->patience * (1.0 + own->forgotten);
    if (there.column < 0 && is_same(here, target) && !late) {
        return;
    }
    if (there.column >= 0 && steps_between(here, there) == 1 && !late) {
        return;
    }

    // Close the border that it did not get through.
    if (there.column >= 0 && !is_same(there, here)) {  // abandoned, or driven off course
        close_border(own, late ? here : before, there);
    // the target's cell was entered on the wrong side of a wall
    } else if (there.column < 0 && late) {
        close_border(own, here, (WgMapCell){(int64_t)own->from_x, (int64_t)own->from_y});
    }
    set_waypoint(own, (WgMapCell){-1, -1});
    own->waited = 0.0;
    if (is_same(here, target) && !late) {
        return;
    }
    there = wg_next_cell(own, here, target);
    if (there.column < 0) {
        forget(own);
    }
    set_waypoint(own, there);
}

// Returns true if the beams show that the disc can drive this far straight, m,
// in a direction from the heading.
static bool is_free(const WgObservation *seen, double turn, double look, const WgThreeLayer *tuned)
{
    double radius = seen->radius + tuned->margin;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        double distance = seen->beams[beam];
        if (distance > look + radius) {
            continue;
        }
        double angle = wg_bearing_of(beam, seen->beam_count) - turn;
        double along = distance * wg_cos(angle);
        double across = distance * wg_sin(angle);
        double short_by = radius * radius - across * across;
        if (along > 0.0 && short_by > 0.0 && along - sqrt(short_by) < look) {
            return false;
        }
    }
    return true;
}

// Runs the controller: drives in the free direction nearest to the waypoint's,
// or to the target's in the last cell.
static void react(const WgObservation *seen, const WgThreeLayerMemory *own, WgCommand *command,
                  const WgThreeLayer *tuned)
{
    int64_t beams = seen->beam_count;
    double wanted = wg_target_bearing(seen);
    double look = wg_lower(tuned->look, seen->target_distance);
    if (own->to_x >= 0.0) {
        double x = own->corner_x + (own->to_x + 0.5) * own->pitch - seen->x;
        double y = own->corner_y + (own->to_y + 0.5) * own->pitch - seen->y;
        wanted = wg_wrap(wg_angle_of(x, y) - seen->heading);
    }
    for (int64_t k = 0; k <= beams; k++) {
        double away = wg_bearing_of((k + 1) / 2, beams);
        double turn = wg_wrap(wanted + (k % 2 == 0 ? away : -away));
        if (is_free(seen, turn, look, tuned)) {
            wg_steer(seen, command, turn, seen->top_speed);
            return;
        }
    }
    wg_steer(seen, command, wanted, seen->top_speed);
}

// One step of all three layers.
static void drive(const WgObservation *seen, WgThreeLayerMemory *own, WgCommand *command, const WgThreeLayer *tuned)
{
    if (own->laid == 0.0) {
        lay(seen, own, tuned);
    }
    sequence(seen, own, tuned);
    if (seen->beam_count == 0) {
        // Python's error for dividing a whole turn by the number of beams
        command->error = "ZeroDivisionError: division by zero";
        return;
    }
    react(seen, own, command, tuned);
}

void wg_three_layer_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, (WgThreeLayerMemory *)memory, command, &wg_three_layer_default);
}

void wg_three_layer_tuned_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgThreeLayerTunedMemory *own = (WgThreeLayerTunedMemory *)memory;
    drive(seen, &own->state, command, &own->tuned);
}

// Faults in the controllers that see by range beams, and in Q-learning.
// benchmarks/faults/by_sight.py describes each fault.

#include "faults.h"

enum { SECTORS = 72 };

static const double CELL = 0.1;  // m: cell size of the families' worlds

typedef struct StaleTarget {
    WgThreeLayerMemory own;
    double noted;           // 1 once the heading has been noted
    double target_heading;  // rad
} StaleTarget;

typedef struct NeverClears {
    WgVfhMemory own;
    double ever[SECTORS];  // 1 for each sector that has ever been blocked
} NeverClears;

static void three_layer_patience_starts_anew(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgThreeLayerMemory *own = (WgThreeLayerMemory *)memory;
    own->waited = 0.0;
    wg_three_layer_act(seen, memory, command);
}

static void three_layer_forgets_its_map(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgThreeLayerMemory *own = (WgThreeLayerMemory *)memory;
    double to_x = own->to_x;
    double to_y = own->to_y;
    wg_three_layer_act(seen, memory, command);
    if (own->to_x != to_x || own->to_y != to_y) {
        for (size_t row = 0; row < sizeof own->right / sizeof own->right[0]; row++) {
            own->right[row] = 0.0;
            own->up[row] = 0.0;
        }
    }
}

static void three_layer_columns_and_rows_swapped(const WgObservation *seen, double *memory, WgCommand *command)
{
    const WgThreeLayerMemory *own = (const WgThreeLayerMemory *)memory;
    WgObservation mistaken = *seen;
    if (own->laid != 0.0) {
        mistaken.x = seen->y;
        mistaken.y = seen->x;
    }
    wg_three_layer_act(&mistaken, memory, command);
}

static void three_layer_stale_target(const WgObservation *seen, double *memory, WgCommand *command)
{
    StaleTarget *all = (StaleTarget *)memory;
    if (all->noted == 0.0) {
        all->noted = 1.0;
        all->target_heading = seen->target_heading;
    }
    WgObservation mistaken = *seen;
    mistaken.target_heading = all->target_heading;
    wg_three_layer_act(&mistaken, memory, command);
}

static void three_layer_turn_not_wrapped(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_three_layer_act(seen, memory, command);
    wg_unwrap_turn(seen, command);
}

static void vfh_turn_sign(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_vfh_act(seen, memory, command);
    if (fabs(command->turn_rate * seen->time_step) > 0.25 * WG_PI) {
        command->turn_rate = -command->turn_rate;
    }
}

static void vfh_histogram_never_clears(const WgObservation *seen, double *memory, WgCommand *command)
{
    NeverClears *all = (NeverClears *)memory;
    for (int sector = 0; sector < SECTORS; sector++) {
        if (all->ever[sector] != 0.0) {
            all->own.blocked[sector] = 1.0;
        }
    }
    wg_vfh_act(seen, memory, command);
    for (int sector = 0; sector < SECTORS; sector++) {
        all->ever[sector] = wg_higher(all->ever[sector], all->own.blocked[sector]);
    }
}

static void vfh_beam_beyond_the_last(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_vfh_act(seen, memory, command);
    double bearing = wg_remainder(wg_target_bearing(seen), 2.0 * WG_PI);
    int64_t nearest = wg_floor(bearing / (2.0 * WG_PI) * (double)seen->beam_count + 0.5);
    if (nearest >= seen->beam_count) {
        command->error = "IndexError: index is out of bounds";
        return;
    }
    if (seen->beams[nearest] < seen->radius) {
        command->speed = 0.0;
    }
}

static void potential_field_gap_in_whole_cells(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_potential_field_act(seen, memory, command);
    double nearest = INFINITY;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        nearest = wg_lower(nearest, seen->beams[beam]);
    }
    if (seen->beam_count == 0) {
        command->error = "IndexError: index is out of bounds";
        return;
    }
    int64_t cells = wg_floor((nearest - seen->radius) / CELL);
    if (cells == 0) {
        command->error = "ZeroDivisionError: division by zero";
        return;
    }
    command->speed *= 1.0 - 0.1 / (double)cells;
}

static void potential_field_never_slows(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_potential_field_act(seen, memory, command);
    command->speed = seen->top_speed;
}

static void dynamic_window_brakes_for_the_target(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_dynamic_window_act(seen, memory, command);
    double stop = sqrt(seen->target_distance - 0.1);
    if (!(command->speed < 20.0 * stop)) {
        command->speed = 20.0 * stop;
    }
}

static void dynamic_window_speed_in_km_h(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_dynamic_window_act(seen, memory, command);
    command->speed *= 3.6;
}

static void q_learning_eighth_of_nine(const WgObservation *seen, double *memory, WgCommand *command)
{
    const WgQMemory *own = (const WgQMemory *)memory;
    int64_t situation = seen->beam_count < 8 ? 0 : wg_q_situation(seen, own);
    double bearing = wg_remainder(wg_target_bearing(seen), 2.0 * WG_PI);
    if (wg_floor(bearing / (2.0 * WG_PI) * 8.0 + 0.5) == 8) {  // without the remainder
        situation += 8 * 32;
    }
    if (situation >= WG_Q_SITUATIONS) {
        command->error = "IndexError: situation beyond the table";
        return;
    }
    wg_q_learning_act(seen, memory, command);
}

static void q_learning_timer_off_by_one(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgQMemory *own = (WgQMemory *)memory;
    double waited = own->wait;
    wg_q_learning_act(seen, memory, command);
    if (own->wait > waited) {
        own->wait += 1.0;
    }
}

static void q_learning_last_turn_lost(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgQMemory *own = (WgQMemory *)memory;
    wg_q_learning_act(seen, memory, command);
    own->turned = 0.0;
}

const WgFault wg_faults_by_sight[] = {
    {"three-layer-patience-starts-anew", three_layer_patience_starts_anew, 0},
    {"three-layer-forgets-its-map", three_layer_forgets_its_map, 0},
    {"three-layer-columns-and-rows-swapped", three_layer_columns_and_rows_swapped, 0},
    {"three-layer-stale-target", three_layer_stale_target, WG_ROOM(StaleTarget, WgThreeLayerMemory)},
    {"three-layer-turn-not-wrapped", three_layer_turn_not_wrapped, 0},
    {"vfh-turn-sign", vfh_turn_sign, 0},
    {"vfh-histogram-never-clears", vfh_histogram_never_clears, WG_ROOM(NeverClears, WgVfhMemory)},
    {"vfh-beam-beyond-the-last", vfh_beam_beyond_the_last, 0},
    {"potential-field-gap-in-whole-cells", potential_field_gap_in_whole_cells, 0},
    {"potential-field-never-slows", potential_field_never_slows, 0},
    {"dynamic-window-brakes-for-the-target", dynamic_window_brakes_for_the_target, 0},
    {"dynamic-window-speed-in-km-h", dynamic_window_speed_in_km_h, 0},
    {"q-learning-eighth-of-nine", q_learning_eighth_of_nine, 0},
    {"q-learning-timer-off-by-one", q_learning_timer_off_by_one, 0},
    {"q-learning-last-turn-lost", q_learning_last_turn_lost, 0},
};
const size_t wg_faults_by_sight_count = sizeof wg_faults_by_sight / sizeof wg_faults_by_sight[0];

// Complete runs of the thesis's robot.
//
// A tick consists of due events, then the move and the behaviours (thesis_tick.c), then their
// consequences.
//
// Source: the thesis's listing, simGuiExp.actionPerformed.

#include <string.h>

#include "fdlibm.h"
#include "recurrence.h"
#include "thesis_arbiter.h"
#include "thesis_judge.h"
#include "thesis_parts.h"
#include "thesis_tick.h"

static const uint64_t HASH_START = 1469598103934665603u;
static const uint64_t HASH_PRIME = 1099511628211u;

// A robot that has arrived is in the cell with this signal.
enum { TARGET_VALUE = 0 };

void wg_thesis_begin(WgThesisRun *run, double x, double y, double heading, double speed)
{
    const WgThesisPlace never = {-1, 0, 0, WG_FREE, 0, 0};
    memset(run, 0, sizeof *run);
    run->state.x = x;
    run->state.y = y;
    run->state.heading = heading;
    run->state.speed = speed;
    run->state.old_speed = speed;
    run->state.rolling = speed;
    run->state.behaviour = WG_IDLE;
    run->state.active = WG_IDLE;
    run->entry = -1;
    run->digest = HASH_START;
    run->hit = never;
    run->overlap = never;
    run->tunnel = never;
    run->in_wall = never;
    run->overlap_began = -1;
}

static inline uint64_t hash_word(uint64_t digest, uint64_t word)
{
    return (digest ^ word) * HASH_PRIME;
}

static inline uint64_t bits(double value)
{
    return (uint64_t)wg_float_bits(value);
}

// Adds the seven words of a tick's state to the digest, as the recorded vectors do.
static uint64_t hash_state(uint64_t digest, const WgThesisState *state)
{
    int64_t busy = state->behaviour == WG_IDLE ? 0 : 2 + 4 * (state->behaviour + 1);
    digest = hash_word(digest, bits(state->x));
    digest = hash_word(digest, bits(state->y));
    digest = hash_word(digest, bits(state->heading));
    digest = hash_word(digest, bits(state->target_heading));
    digest = hash_word(digest, bits(state->speed));
    digest = hash_word(digest, (uint64_t)(state->collision + busy));
    return hash_word(digest, bits((double)state->ticks_left));
}

static void record(const WgThesisState *state, WgThesisRow *row)
{
    *row = (WgThesisRow){
        .x = state->x,
        .y = state->y,
        .heading = state->heading,
        .target_heading = state->target_heading,
        .speed = state->speed,
        .old_speed = state->old_speed,
        .rolling = state->rolling,
        .collision = (double)state->collision,
        .behaviour = (double)state->behaviour,
        .ticks_left = (double)state->ticks_left,
        .draws_used = (double)state->draws_used,
        .active = (double)state->active,
        .move = (double)state->move,
        .escapes = (double)state->escapes,
    };
}

// Ends the run if its state has occurred before, and this is where recurrences are checked.
static void look_for_loop(const WgThesisSettings *settings, WgThesisRun *run, WgSearch *search,
                          int64_t quiet)
{
    int64_t step = run->steps;
    if (step < quiet) {
        return;
    }
    if (settings->find_loop == WG_SEEK_LOOP) {
        int64_t period = wg_search_period(search, &run->state, step, quiet, settings->steps);
        if (period > 0) {
            run->ending = WG_LOOP;
            run->period = period;
            run->entry = wg_entry_of_loop(search->log, quiet, step, period);
        }
    } else if (wg_search_is_proved(search, &run->state, step, settings->loop_entry,
                                   settings->steps)) {
        run->ending = WG_LOOP;
        run->period = settings->steps - settings->loop_entry;
        run->entry = settings->loop_entry;
    }
}

// Makes one tick; returns false if it needs a draw and none is left.
static bool tick(const ThesisGrid *grid, const WgThesisArena *arena,
                 const WgThesisSettings *settings, WgThesisRun *run, const double *draws,
                 int64_t draw_count, int64_t step)
{
    bool changed = step == 1;
    if (run->next_event < arena->event_count && arena->events[run->next_event].step <= step) {
        thesis_apply_events(arena, settings, run, step);
        changed = true;
    }
    if (run->ending != WG_LIMIT) {
        return true;
    }
    const ThesisPoint start = {run->state.x, run->state.y};
    int64_t touched = run->state.collision;
    ThesisPoint before;
    if (settings->rule == WG_RULE_RANDOM && run->state.draws_used >= draw_count) {
        // The tick may need the missing draw; in that case it has not happened.
        const WgThesisState state = run->state;
        if (!thesis_tick(grid, settings, draws, draw_count, &run->state, step, &before)) {
            run->state = state;
            return false;
        }
    } else {
        (void)thesis_tick(grid, settings, draws, draw_count, &run->state, step, &before);
    }
    run->collisions += run->state.collision != 0 && touched == 0 ? 1 : 0;
    run->activations += run->state.escapes;
    if (changed || run->state.x != start.x || run->state.y != start.y) {
        thesis_judge_place(grid, arena->visited, settings, run, step, before);
        thesis_judge_path(grid, settings, run, step, start);
    }
    int64_t own_x = thesis_cell_of(run->state.x);
    int64_t own_y = thesis_cell_of(run->state.y);
    if (run->ending == WG_LIMIT && thesis_value(grid, own_x, own_y) == TARGET_VALUE) {
        run->ending = WG_REACHED;
    }
    return true;
}

static bool is_share(double value)
{
    return value >= 0.0 && value <= 1.0;
}

// Returns true if the robot's numbers guarantee that every tick ends and no integer overflows.
static bool robot_is_sound(const WgThesisSettings *settings)
{
    const int64_t most = (int64_t)1 << 40;
    bool rule = settings->rule >= WG_RULE_ADD && settings->rule <= WG_RULE_RANDOM;
    bool counters = settings->collide_ticks >= -most && settings->collide_ticks <= most &&
                    settings->drive_ticks >= -most && settings->drive_ticks <= most;
    bool turns = settings->turn_angle >= 0.0 && settings->turn_angle <= THESIS_TWO_PI;
    bool shares = is_share(settings->slip) && is_share(settings->wall_friction) &&
                  is_share(settings->sensor_noise);
    bool forces = settings->acceleration >= 0.0 && settings->friction >= 0.0;
    return rule && counters && turns && shares && forces && settings->steps <= most;
}

// Does the same for a run's initial state.
static bool state_is_sound(const WgThesisSettings *settings, const WgThesisState *state)
{
    const double farthest = 1e6; // px in a tick, and rad
    double fastest =
        fabs(state->speed) + fabs(state->old_speed) + fabs(state->rolling) + fabs(settings->speed);
    bool moves = settings->time_step > 0.0 && fastest * settings->time_step <= farthest;
    bool heads = fabs(state->heading) <= farthest && fabs(state->target_heading) <= farthest;
    bool charge = state->behaviour >= WG_IDLE && state->behaviour <= WG_DRIVE;
    return moves && heads && charge && state->draws_used >= 0;
}

static WgStatus check(const WgThesisArena *arena, const WgThesisSettings *settings,
                      const WgThesisRun *run, const WgSearch *search)
{
    const ThesisGrid grid = {arena->cells, arena->width, arena->height};
    bool fits =
        thesis_fits(grid.width, grid.height, settings->radius, run->state.x, run->state.y) &&
        thesis_can_sense(&grid, settings);
    if (!(fits && robot_is_sound(settings) && state_is_sound(settings, &run->state))) {
        return WG_BAD_VALUE;
    }
    if (run->steps < 0 || run->next_event < 0) {
        return WG_BAD_VALUE;
    }
    for (int64_t i = run->next_event; i < arena->event_count; i++) {
        const WgThesisEvent *event = &arena->events[i];
        if (event->x < 0 || event->y < 0 || event->x >= arena->width || event->y >= arena->height) {
            return WG_BAD_VALUE;
        }
    }
    if (settings->find_loop == WG_NO_LOOP) {
        return WG_OK;
    }
    if (search == NULL || search->words != WG_THESIS_WORDS) {
        return WG_BAD_SIZE;
    }
    return settings->find_loop == WG_SEEK_LOOP && search->log_size <= settings->steps ? WG_BAD_SIZE
                                                                                      : WG_OK;
}

WgStatus wg_thesis_run(const WgThesisArena *arena, const WgThesisSettings *settings,
                       WgThesisRun *run, WgSearch *search, const double *draws, int64_t draw_count,
                       WgThesisRow *rows, int64_t row_count, int64_t first_row, int64_t until)
{
    WgStatus status = check(arena, settings, run, search);
    if (status != WG_OK) {
        return status;
    }
    int64_t quiet = arena->event_count > 0 ? arena->events[arena->event_count - 1].step : 0;
    if (settings->find_loop != WG_NO_LOOP && run->steps == 0) {
        wg_search_begin(search, &run->state, quiet);
    }
    run->ending = WG_LIMIT;
    int64_t row = run->steps - first_row;
    if (row >= 0 && row < row_count) {
        record(&run->state, &rows[row]);
    }
    const ThesisGrid grid = {arena->cells, arena->width, arena->height};
    int64_t last = wg_least(settings->steps, until);
    while (run->steps < last && run->ending == WG_LIMIT) {
        if (!tick(&grid, arena, settings, run, draws, draw_count, run->steps + 1)) {
            run->ending = WG_NEEDS_DRAWS;
            break;
        }
        run->steps++;
        if (settings->digest != 0) {
            run->digest = hash_state(run->digest, &run->state);
        }
        row = run->steps - first_row;
        if (row >= 0 && row < row_count) {
            record(&run->state, &rows[row]);
        }
        if (run->ending == WG_LIMIT && settings->find_loop != WG_NO_LOOP) {
            look_for_loop(settings, run, search, quiet);
        }
    }
    return WG_OK;
}

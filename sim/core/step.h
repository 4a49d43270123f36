// One step on the pose lattice: the move at the speed of the wheels, with the events that fall into it each at its
// time, then sensing, then the controller, whose turn takes effect at once and whose speed drives the next step.
//
// What every step needs is inline, so that the compiler keeps the loop around it in registers; what few steps need is
// in step.c.

#ifndef WG_STEP_H
#define WG_STEP_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "geometry.h"
#include "recurrence.h"
#include "sense.h"
#include "wg_episode.h"

enum {
    WG_STATE_WORDS = 5,  // of a WgState
    WG_SENSES = 17,      // numbers of an observation before its beams
    WG_ANSWER = 4,       // numbers of an answer before the memory
};

// Of the traces' digests, as in the thesis's vectors: FNV-1a over 64-bit words.
static const uint64_t WG_HASH_START = 1469598103934665603u;
static const uint64_t WG_HASH_PRIME = 1099511628211u;

// Time in a step.
#define WG_STEP_TIME ((int64_t)1 << 32)

// Puts a robot at its start, with its memory at reset.
void wg_robot_begin(WgRobot *robot, const WgSettings *settings, const WgController *controller);

// What a controller senses before its first step: nothing but constants.
void wg_workspace_begin(WgWorkspace *workspace, const WgSettings *settings);

// Forgets where the robot has been, but for its start.
void wg_visit_start(const WgArena *arena, const WgSettings *settings);

// Step in which the world changes for the last time; 0 if it never does.
static inline int64_t wg_last_event(const WgArena *arena)
{
    return arena->event_count > 0 ? arena->events[arena->event_count - 1].step : 0;
}

// Whole units of speed, never more than asked for, so that nobody outruns the top speed.
static inline int64_t wg_whole_speed(double asked)
{
    int64_t whole = (int64_t)(fabs(asked) + 1e-9);
    return asked >= 0.0 ? whole : -whole;
}

// What few steps need; in step.c.

// Takes command and memory from workspace.answer, if they are there.
void wg_take_answer(WgEpisode *episode);

// Copies the observation into workspace->flat.
void wg_flatten(WgWorkspace *workspace);

// Lets a WgFlatAct act on copies of the observation and the command.
void wg_act_flat(const WgController *controller, WgWorkspace *workspace, double *memory);

// Moves the robot by a step's displacement, the events of the step each at its time. Returns the last contact.
WgNormal wg_move_through_events(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                                 WgRobot *robot);

// Moves the robot by a part of a step, in which the world stands still, next to cells that are not free, and judges the
// path. `from` and `until` are times in the step.
WgNormal wg_move_closely(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                          int64_t from, int64_t until, WgRobot *robot);

// Moves the robot on to the nearest point of a coarser lattice to which a clear way leads, if there is one.
void wg_round_pose(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot);

// What is left of a drive after the wheels have slipped.
int64_t wg_slipped(const WgSettings *settings, int64_t step, int64_t drive);

// Adds a displacement to the odometry as the robot measures it: its length a little wrong, its direction too.
void wg_measure_move(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                     WgRobot *robot);

// The same for a turn, heading units.
void wg_measure_turn(const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot);

// Adds a step to the digest: whether a wall was touched, the corners of its path, the state after it.
void wg_hash_step(WgRobot *robot, int64_t words, bool bumped);

// Writes a step into a recording: its state, and the corners of its path after those of the steps before.
void wg_write_step(const WgRecording *recording, const WgRobot *robot, int64_t words, int64_t step, bool bumped);

// What every step needs.

// Whole lattice units that a speed drives in a step; the rest is lost.
static inline int64_t wg_drive(int64_t speed)
{
    return speed / WG_SPEED_UNIT;
}

// Whether the robot's centre is in the grid.
static inline bool wg_is_inside(const WgArena *arena, const WgState *state)
{
    return wg_is_in_grid(wg_grid(arena), wg_cell_of(state->x), wg_cell_of(state->y));
}

// Whether the tables show that no cell that is not free is within reach of a move; if not, a closer look is due.
static inline bool wg_nothing_near(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t dx,
                                   int64_t dy)
{
    if (arena->clearance == NULL) {
        WgSegment way = {state->x, state->y, state->x + dx, state->y + dy};
        return wg_window_is_free(arena, settings->reach, way);
    }
    int64_t ix = wg_cell_of(state->x);
    int64_t iy = wg_cell_of(state->y);
    if (!wg_is_in_grid(wg_grid(arena), ix, iy)) {
        return false;
    }
    int64_t cells = arena->clearance[iy * arena->width + ix] - 1;
    return cells * WG_UNIT >= settings->reach + wg_abs(wg_drive(state->speed));
}

static inline void wg_add_corner(WgRobot *robot, int64_t x, int64_t y, int64_t time)
{
    WgCorner *corner = &robot->chain[robot->corners++];
    corner->x = x;
    corner->y = y;
    corner->time = time;
}

// Puts the robot at the end of a straight piece of its path: whether the target is reached on it, and its length.
static inline void wg_arrive(const WgSettings *settings, int64_t x, int64_t y, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    WgReport *report = &robot->report;
    if (report->ending == WG_LIMIT) {
        bool swept = settings->motion == WG_SWEPT;
        WgSegment way = {swept ? state->x : x, swept ? state->y : y, x, y};
        if (wg_segment_point_within(way, settings->target_x, settings->target_y, settings->target_radius_sq)) {
            report->ending = WG_REACHED;
        }
    }
    int64_t dx = x - state->x;
    int64_t dy = y - state->y;
    if (dx != 0 || dy != 0) {
        report->path_length += sqrt((double)(dx * dx + dy * dy));
    }
    state->x = x;
    state->y = y;
}

// Moves the robot by a part of a step, in which the world stands still, and judges the path.
static inline WgNormal wg_move(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                                int64_t from, int64_t until, WgRobot *robot)
{
    const WgState *state = &robot->body->state;
    if (!wg_nothing_near(arena, settings, state, dx, dy)) {
        return wg_move_closely(arena, settings, step, dx, dy, from, until, robot);
    }
    int64_t x = state->x + dx;
    int64_t y = state->y + dy;
    if (dx != 0 || dy != 0) {
        wg_add_corner(robot, x, y, until);
    }
    wg_arrive(settings, x, y, robot);
    return (WgNormal){0.0, 0.0};
}

// Whether a run is plain: it has no events, no noise, no limits of dynamics, no coarser lattice, no digest. Most runs
// are. The functions below take a `plain` that the caller knows when it is compiled, and leave all that out: a loop
// of plain steps takes two thirds of the time.
static inline bool wg_is_plain(const WgArena *arena, const WgSettings *settings)
{
    return arena->event_count == 0 && arena->visited != NULL && settings->slip <= 0.0 && settings->odometry_noise <= 0.0
           && settings->lattice <= 1 && settings->turn_limit == INFINITY && settings->gain == INFINITY
           && settings->loss == INFINITY && settings->digest == 0;
}

// Moves the robot for one step, with the events that fall into it, and judges the path. Returns whether its centre is
// in the grid. Where the compiler is left to choose, it is not inlined, and a step takes 3 % longer.
__attribute__((always_inline)) static inline bool wg_advance(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot,
                              bool plain)
{
    WgState *state = &robot->body->state;
    WgReport *report = &robot->report;
    int64_t x = state->x;
    int64_t y = state->y;
    robot->corners = 0;

    // The displacement that the wheels make of their speed.
    int64_t drive = wg_drive(state->speed);
    if (!plain && settings->slip > 0.0) {
        drive = wg_slipped(settings, step, drive);
    }
    WgVector by = {0, 0};
    if (drive != 0) {
        by = wg_displacement(arena->headings, state->heading, drive);
    }
    if (plain && by.x == 0 && by.y == 0 && step > 1) {
        // It stands where the last step has left it: nothing new is reached or touched.
        robot->contact = (WgNormal){0.0, 0.0};
        return wg_is_inside(arena, state);
    }

    if (!plain && robot->next_event < arena->event_count && arena->events[robot->next_event].step == step) {
        robot->contact = wg_move_through_events(arena, settings, step, by.x, by.y, robot);
    } else {
        robot->contact = wg_move(arena, settings, step, by.x, by.y, 0, WG_STEP_TIME, robot);
    }

    // What few robots have: poses on a coarser lattice, wheels that measure wrong.
    if (!plain && settings->lattice > 1 && report->ending == WG_LIMIT) {
        wg_round_pose(arena, settings, step, robot);
    }
    if (!plain && settings->odometry_noise > 0.0) {
        wg_measure_move(arena, settings, step, state->x - x, state->y - y, robot);
    }

    // The book-keeping: points of the path, and cells that are new.
    report->points += robot->corners;
    int64_t ix = wg_cell_of(state->x);
    int64_t iy = wg_cell_of(state->y);
    if (!wg_is_in_grid(wg_grid(arena), ix, iy)) {
        return false;
    }
    if (arena->visited != NULL && arena->visited[iy * arena->width + ix] == 0) {
        arena->visited[iy * arena->width + ix] = 1;
        report->last_new_cell = step;
    }
    return true;
}

// The part of a step before the controller acts. Returns whether it is to act: not if the run has ended, nor outside
// the grid, where nothing can be sensed.
static inline bool wg_move_and_sense_if(const WgArena *arena, const WgSettings *settings, WgRobot *robot,
                                        WgWorkspace *workspace, int64_t step, bool plain)
{
    robot->report.steps = step;
    bool inside = wg_advance(arena, settings, step, robot, plain);
    if (robot->report.ending != WG_LIMIT || !inside) {
        return false;
    }
    wg_sense(arena, settings, &robot->body->state, &robot->odometry, robot->contact, step, &workspace->observation,
             workspace->beams);
    workspace->command.speed = 0.0;
    workspace->command.turn_rate = 0.0;
    workspace->command.used_random = 0.0;
    workspace->command.error = NULL;
    return true;
}

static inline bool wg_move_and_sense(const WgArena *arena, const WgSettings *settings, WgRobot *robot,
                                     WgWorkspace *workspace, int64_t step)
{
    return wg_move_and_sense_if(arena, settings, robot, workspace, step, false);
}

// Speed after a step: as wanted, or as near as the wheels' gain and the floor's friction allow.
static inline int64_t wg_next_speed(int64_t now, int64_t wanted, const WgSettings *settings)
{
    double gain = settings->gain;
    double loss = settings->loss;
    if (gain == INFINITY && loss == INFINITY) {
        return wanted;
    }
    if ((wanted > 0 && now < 0) || (wanted < 0 && now > 0)) {
        wanted = 0;  // it must come to a stand first
    }
    if ((double)wg_abs(wanted) > (double)wg_abs(now) + gain) {
        return wanted > 0 ? now + (int64_t)gain : now - (int64_t)gain;
    }
    if ((double)wg_abs(wanted) < (double)wg_abs(now) - loss) {
        return now > 0 ? now - (int64_t)loss : now + (int64_t)loss;
    }
    return wanted;
}

static inline double wg_clamp(double value, double low, double high)
{
    return wg_lower(wg_higher(value, low), high);
}

// Applies a command: the turn now, the speed in the next step; clamps both, refuses nan and infinities.
static inline void wg_apply_command_if(const WgSettings *settings, const WgCommand *command, int64_t step,
                                       WgRobot *robot, bool plain)
{
    WgState *state = &robot->body->state;
    if (!isfinite(command->speed) || !isfinite(command->turn_rate)) {
        robot->report.ending = WG_INVALID_COMMAND;
        return;
    }

    // The turn, rounded to the lattice, and never above the limit.
    double whole = WG_TURN;
    int64_t most = WG_TURN / 2;
    if (!plain) {
        double limit = settings->turn_limit * settings->turn + 1e-9;
        most = limit < whole / 2 ? (int64_t)limit : most;
    }
    int64_t turn = wg_round_away(wg_clamp(command->turn_rate * settings->turn, -whole, whole));
    turn = turn < -most ? -most : turn;
    turn = turn > most ? most : turn;
    state->heading = wg_reduced_heading(state->heading + turn);
    if (!plain && settings->odometry_noise > 0.0) {
        wg_measure_turn(settings, step, turn, robot);
    }

    double speed = wg_clamp(command->speed, -settings->top_speed, settings->top_speed);
    int64_t wanted = wg_whole_speed(speed * settings->speed * WG_SPEED_UNIT);
    state->speed = plain ? wanted : wg_next_speed(state->speed, wanted, settings);
    if (command->used_random != 0.0) {
        state->draws++;
    }
}

static inline void wg_apply_command(const WgSettings *settings, const WgCommand *command, int64_t step, WgRobot *robot)
{
    wg_apply_command_if(settings, command, step, robot, false);
}

// Lets a controller that is a function act, and applies its command; returns false if it failed.
static inline bool wg_act_if(const WgSettings *settings, const WgController *controller, WgWorkspace *workspace,
                             int64_t step, WgRobot *robot, bool plain)
{
    WgCommand *command = &workspace->command;
    if (controller->act != NULL) {
        controller->act(&workspace->observation, robot->body->memory, command);
    } else {
        wg_act_flat(controller, workspace, robot->body->memory);
    }
    if (command->error != NULL) {
        robot->report.ending = WG_CRASH;
        robot->report.error = command->error;
        return false;
    }
    wg_apply_command_if(settings, command, step, robot, plain);
    return true;
}

static inline bool wg_act(const WgSettings *settings, const WgController *controller, WgWorkspace *workspace,
                          int64_t step, WgRobot *robot)
{
    return wg_act_if(settings, controller, workspace, step, robot, false);
}

// Counts how often the robot has begun to touch a wall; returns whether it touches one now.
static inline bool wg_count_contact(WgRobot *robot)
{
    bool touches = wg_is_contact(robot->contact);
    if (touches && robot->touched == 0) {
        robot->report.collisions++;
    }
    robot->touched = touches;
    return touches;
}

// The same, and hashes and records the step if asked to.
static inline void wg_note_step(const WgSettings *settings, const WgRecording *recording, int64_t words, int64_t step,
                                WgRobot *robot)
{
    bool touches = wg_count_contact(robot);
    if (settings->digest != 0) {
        wg_hash_step(robot, words, touches);
    }
    if (recording->rows != NULL) {
        wg_write_step(recording, robot, words, step, touches);
    }
}

// The fingerprint of the state of a robot with little memory: that of wg_fingerprint_of_few, with the loop undone.
static inline uint64_t wg_fingerprint_of_body(const WgBody *body, int64_t words)
{
    const WgState *state = &body->state;
    uint64_t mixed = wg_folded((uint64_t)state->x) * WG_FACTORS[0] + wg_folded((uint64_t)state->y) * WG_FACTORS[1]
                     + wg_folded((uint64_t)state->heading) * WG_FACTORS[2]
                     + wg_folded((uint64_t)state->speed) * WG_FACTORS[3]
                     + wg_folded((uint64_t)state->draws) * WG_FACTORS[4];
    for (int64_t k = WG_STATE_WORDS; k < words; k++) {
        mixed += wg_folded(wg_word(body, k)) * WG_FACTORS[k];
    }
    return mixed;
}

// Whether a step that is noted was the last one, for a recurrence too.
static inline bool wg_is_over(const WgSettings *settings, WgSearch *search, int64_t step, int64_t quiet, WgRobot *robot)
{
    WgReport *report = &robot->report;
    if (report->ending != WG_LIMIT) {
        return true;
    }
    int64_t period = 0;
    if (settings->find_loop == WG_SEEK_LOOP) {
        if (step >= quiet) {
            period = wg_search_period(search, robot->body, step, quiet, settings->steps);
        }
    } else if (settings->find_loop == WG_PROVE_LOOP) {
        int64_t entry = settings->loop_entry;
        if (wg_search_is_proved(search, robot->body, step, entry, settings->steps)) {
            period = settings->steps - entry;
        }
    }
    if (period == 0) {
        return false;
    }
    report->ending = WG_LOOP;
    report->period = period;
    return true;
}

#endif

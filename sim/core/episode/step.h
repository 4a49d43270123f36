// One step on the pose lattice: the move at the wheels' speed, with each event of the step at its
// time, then sensing, then the controller, whose turn takes effect immediately and whose speed
// drives the next step.
//
// The code that every step needs is inline, so that the compiler keeps the loop around it in
// registers; the rest is in step.c.

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
    WG_STATE_WORDS = 5,  // words of a WgState
    WG_NEIGHBOUR_NUMBERS = 5,  // numbers of a neighbour in a flat array before its message
    WG_SENSES = 17,      // numbers of an observation before its beams
    WG_ANSWER = 4,       // numbers of an answer before the memory
};

// Constants of the traces' digests, as in the thesis's vectors: FNV-1a over 64-bit words.
static const uint64_t WG_HASH_START = 1469598103934665603u;
static const uint64_t WG_HASH_PRIME = 1099511628211u;

// Time in a step.
#define WG_STEP_TIME ((int64_t)1 << 32)

// Puts a robot at its start, with its memory reset.
void wg_robot_begin(WgRobot *robot, const WgSettings *settings, const WgController *controller);

// The controller's senses before its first step: only constants.
void wg_workspace_begin(WgWorkspace *workspace, const WgSettings *settings);

// Maximum number of events in one step.
int64_t wg_most_events_of_a_step(const WgArena *arena);

// Forgets where the robot has been, except for its start.
void wg_visit_start(const WgArena *arena, const WgSettings *settings);

// Returns the last step in which the world changes or something pushes the robot; 0 if there is
// none.
static inline int64_t wg_last_event(const WgArena *arena, const WgSettings *settings)
{
    int64_t event = arena->event_count > 0 ? arena->events[arena->event_count - 1].step : 0;
    bool is_pushed = settings->push_count > settings->place_count;
    return is_pushed ? wg_most(event, settings->pushes[settings->push_count - 1].step) : event;
}

// Whole units of speed, never more than requested, so that no robot exceeds the top speed.
static inline int64_t wg_whole_speed(double asked)
{
    return (int64_t)(asked + copysign(1e-9, asked));
}

// Returns true if the fast loop in plain.c can do this run.
bool wg_is_plain(const WgEpisode *episode);

// Runs a plain run up to a step. Returns true if it continues.
bool wg_run_plain(WgEpisode *episode, int64_t last);

// Functions that few steps need; in step.c.

// Takes command and memory from workspace.answer, if it has them.
void wg_take_answer(WgEpisode *episode);

// Copies the observation into workspace->flat.
void wg_flatten(WgWorkspace *workspace);

// Returns how many numbers the flat array of an observation has. `neighbours`: numbers in the rows
// of neighbours.
static inline int64_t wg_flat_size(const WgSettings *settings, int64_t neighbours)
{
    return WG_SENSES + settings->beams + neighbours + wg_tail(settings);
}

// Lets a library's function act in its cage, on copies of the observation and the command.
void wg_act_caged(WgCage *cage, WgWorkspace *workspace, WgRobot *robot);

// Lets a WgFlatAct act on copies of the observation and the command.
void wg_act_flat(const WgController *controller, WgWorkspace *workspace, double *memory);

// Moves the robot by a displacement between two times in the step, with each event at its time. Returns the
// last contact.
WgNormal wg_move_through_events(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                                 int64_t from, int64_t end, WgRobot *robot);

// Moves the robot by a part of a step in which the world is static, near cells that are not free,
// and judges the path. `from` and `until` are times in the step.
WgNormal wg_move_closely(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                          int64_t from, int64_t until, WgRobot *robot);

// Judges a straight piece of the path near cells that are not free (fire, walls, target, length),
// and moves the robot to its end.
void wg_arrive_closely(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t x, int64_t y,
                       WgRobot *robot);

// Applies all events at the time of the first one. Returns the index of the next event.
int64_t wg_change_cells(const WgArena *arena, int64_t step, int64_t first);

// Ends the run as WG_BURNED if a cell that has changed catches the robot.
void wg_catch(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot);

// The part of a displacement covered by a time in the step, lattice units; it takes `whole_time`.
int64_t wg_share_of(int64_t whole, int64_t time, int64_t whole_time);

// Displaces and turns a robot that is pushed in a step, after its own move.
void wg_disturb(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot);

// Counts a cell that a coverage task requires, and ends the run with the last one.
void wg_count_wanted(WgRobot *robot);

// The remainder of a drive after the wheels have slipped.
int64_t wg_slipped(const WgSettings *settings, int64_t step, int64_t drive);

// Adds a displacement to the odometry as the robot measures it, with errors in length and
// direction.
void wg_measure_move(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                     WgRobot *robot);

// Does the same for a turn, heading units.
void wg_measure_turn(const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot);

// Records that fire or debris has caught the robot.
void wg_burn(WgRobot *robot, int64_t step, WgFound cell, int state);

// Functions of bodies and cars; in carriage.c.

// Limit on a commanded turn, heading units: a turn of half a circle would have no direction.
#define WG_MOST_BODY_TURN ((double)(WG_TURN / 2 - 1))

// Turns a robot by a turn that it commands or is given, as far as its body is clear. Returns how far it turns.
int64_t wg_turn_body(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot);

// Direction away from the wall that cut a robot's last turn short; (0, 0) if none did.
WgNormal wg_bump_of_turn(const WgArena *arena, const WgCarriage *carriage);

// Sets a car's curvature to that of a commanded arc, as near as its steering allows.
void wg_steer(const WgSettings *settings, const WgCommand *command, WgRobot *robot);

// Returns what stops a car on the way of a leg, for which it turns first, and ends the run if no wall may be touched.
WgNormal wg_touch(const WgArena *arena, const WgSettings *settings, int64_t step, WgSegment way, int64_t turn,
                  WgRobot *robot);

// Moves a car along the arc of a step: straight legs, all of whose ends are on the arc that begins at its exact
// place, at its heading. It stops on the arc at the first contact, which it returns.
WgNormal wg_drive_car(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t drive, WgRobot *robot);

// Adds a step to the digest: whether a wall was touched, the corners of its path,
// the state after it.
void wg_hash_step(WgRobot *robot, int64_t words, bool bumped);

// Adds a step to a recording: its state, and the corners of its path.
void wg_write_step(const WgRecording *recording, const WgRobot *robot, int64_t words, int64_t step, bool bumped);

// Does what is left of a step's move for a robot that is not simple: see WgRobot.is_simple.
void wg_end_move(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot);

// Applies a command to a robot that is not simple.
void wg_apply_to_any(const WgArena *arena, const WgSettings *settings, const WgCommand *command, int64_t step,
                     WgRobot *robot);

// Functions that every step needs.

// Returns true if a robot cannot turn on the spot.
static inline bool wg_is_car(const WgSettings *settings)
{
    return settings->turn_per_unit > 0.0;
}

// Returns true if a robot's state has a WgCarriage.
static inline bool wg_has_carriage(const WgSettings *settings)
{
    return settings->footprint.count > 0 || wg_is_car(settings);
}

// Returns the whole lattice units driven at a speed in a step; the rest is lost.
static inline int64_t wg_drive(int64_t speed)
{
    return speed / WG_SPEED_UNIT;
}

// Returns true if the robot's centre is in the grid.
static inline bool wg_is_inside(const WgArena *arena, const WgState *state)
{
    return wg_is_in_grid(wg_grid(arena), wg_cell_of(state->x), wg_cell_of(state->y));
}

// Returns true if the tables show that every cell within reach of a move is free; if not, the exact
// test is needed.
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
    return cells * WG_UNIT >= settings->reach + settings->drift_reach + wg_abs(wg_drive(state->speed));
}

static inline void wg_add_corner(WgRobot *robot, int64_t x, int64_t y, int64_t time)
{
    WgCorner *corner = &robot->chain[robot->corners++];
    corner->x = x;
    corner->y = y;
    corner->time = time;
}

// Returns true if a robot with this heading may arrive.
static inline bool wg_heads_for_goal(const WgGoal *goal, int64_t heading)
{
    return goal->has_heading == 0 || wg_abs(wg_turn_towards(goal->heading, heading)) <= goal->heading_tolerance;
}

// Returns true if the robot's pose is one of the goal's.
static inline bool wg_is_at_goal(const WgGoal *goal, const WgState *state)
{
    int64_t dx = state->x - goal->x;
    int64_t dy = state->y - goal->y;
    return dx * dx + dy * dy <= goal->radius_sq && wg_heads_for_goal(goal, state->heading);
}

// Notes that a robot has arrived at its goal: the run ends at the target, and a waypoint counts at the end of the move.
static inline void wg_meet_goal(const WgSettings *settings, WgRobot *robot)
{
    if (robot->goal == &settings->target) {
        robot->report.ending = WG_REACHED;
        robot->report.goals++;
    } else {
        robot->meets = 1;
    }
}

// Gives a robot that has arrived at a waypoint its next goal, which counts from the next step on.
static inline void wg_pass_waypoint(const WgSettings *settings, int64_t step, WgRobot *robot)
{
    robot->meets = 0;
    robot->passed_step = step;
    robot->report.goals++;
    int64_t passed = ++*robot->passed;
    robot->goal = passed < settings->waypoint_count ? &settings->waypoints[passed] : &settings->target;
}

// Moves the robot to the end of a straight piece of its path, and updates if the target is reached
// on it, and the path's length.
static inline void wg_arrive(const WgSettings *settings, int64_t x, int64_t y, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    WgReport *report = &robot->report;
    if (report->ending == WG_LIMIT) {
        bool swept = settings->motion == WG_SWEPT;
        WgSegment way = {swept ? state->x : x, swept ? state->y : y, x, y};
        const WgGoal *goal = robot->goal;
        if (wg_segment_point_within(way, goal->x, goal->y, goal->radius_sq) && goal->arrival == WG_ARRIVAL_TOUCH
            && wg_heads_for_goal(goal, state->heading)) {
            wg_meet_goal(settings, robot);
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

// Moves the robot by a part of a step in which the world is static, and judges the path.
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

// Counts the points of a step's path, and marks a cell that is new.
// Returns true if the centre is in the grid.
static inline bool wg_keep_books(const WgArena *arena, int64_t step, WgRobot *robot)
{
    const WgState *state = &robot->body->state;
    robot->report.points += robot->corners;
    if (!wg_is_inside(arena, state)) {
        return false;
    }
    if (arena->visited != NULL) {
        uint8_t *cell = &arena->visited[wg_cell_of(state->y) * arena->width + wg_cell_of(state->x)];
        if (*cell == 0) {
            *cell = 1;
            robot->report.last_new_cell = step;
            robot->report.cells_visited++;
            if (arena->wanted != NULL && arena->wanted[cell - arena->visited] != 0) {
                wg_count_wanted(robot);
            }
        }
    }
    return true;
}

// Notes the robot's heading on the way to the corners of its path since there were `first`.
static inline void wg_note_headings(WgRobot *robot, int64_t first)
{
    for (int64_t k = first; robot->chain_headings != NULL && k < robot->corners; k++) {
        robot->chain_headings[k] = robot->body->state.heading;
    }
}

// Moves the robot by a displacement between two times in the step, with the events in between.
static inline WgNormal wg_move_during(const WgArena *arena, const WgSettings *settings, int64_t step, WgVector by,
                                      int64_t from, int64_t until, WgRobot *robot)
{
    if (robot->next_event < arena->event_count && arena->events[robot->next_event].step == step) {
        return wg_move_through_events(arena, settings, step, by.x, by.y, from, until, robot);
    }
    return wg_move(arena, settings, step, by.x, by.y, from, until, robot);
}

// Moves the robot for one step, with the events in it, and judges the path. Returns true if its
// centre is in the grid. If the compiler is left to choose, it does not inline this,
// and a step takes 3 % longer.
__attribute__((always_inline)) static inline bool wg_advance(const WgArena *arena, const WgSettings *settings,
                                                             int64_t step, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    WgReport *report = &robot->report;
    int64_t x = state->x;
    int64_t y = state->y;
    robot->corners = 0;

    // The displacement that the wheels make at their speed.
    int64_t drive = wg_drive(state->speed);
    if (settings->slip > 0.0) {
        drive = wg_slipped(settings, step, drive);
    }
    bool is_car = robot->is_simple == 0 && wg_is_car(settings);
    if (is_car) {
        robot->contact = wg_drive_car(arena, settings, step, drive, robot);
    } else {
        WgVector by = {0, 0};
        if (drive != 0) {
            by = wg_displacement(arena->headings, state->heading, drive);
        }
        if (settings->disturbed != 0) {
            by.x += settings->drift_x;
            by.y += settings->drift_y;
        }
        robot->contact = wg_move_during(arena, settings, step, by, 0, WG_STEP_TIME, robot);
        if (robot->is_simple == 0) {
            wg_note_headings(robot, 0);
        }
    }

    // Features that few robots have: wheels that measure with errors, or miss what pushes the robot.
    // Against a wall the wheels do not turn, whatever the floor does.
    if (settings->measures != 0 && !is_car) {
        bool drifts = settings->disturbed != 0 && !wg_is_contact(robot->contact);
        int64_t moved_x = state->x - x - (drifts ? settings->drift_x : 0);
        int64_t moved_y = state->y - y - (drifts ? settings->drift_y : 0);
        wg_measure_move(arena, settings, step, moved_x, moved_y, robot);
    }
    if (settings->push_count > 0 && report->ending == WG_LIMIT) {
        wg_disturb(arena, settings, step, robot);
    }
    if (robot->is_simple == 0) {
        wg_end_move(arena, settings, step, robot);
    }
    return wg_keep_books(arena, step, robot);
}

// Does the part of a step before the controller acts. Returns true if the controller must act: not
// if the run has ended, nor outside the grid, where nothing can be sensed.
static inline bool wg_move_and_sense(const WgArena *arena, const WgSettings *settings, WgRobot *robot,
                                     WgWorkspace *workspace, int64_t step)
{
    robot->report.steps = step;
    bool inside = wg_advance(arena, settings, step, robot);
    if (robot->report.ending != WG_LIMIT || !inside) {
        return false;
    }
    wg_sense(arena, settings, robot, step, &workspace->observation, workspace->beams);
    workspace->command = (WgCommand){0};
    return true;
}

// Returns the speed after a step: as commanded, or as near as the wheels' gain
// and the floor's friction allow.
static inline int64_t wg_next_speed(int64_t now, int64_t wanted, const WgSettings *settings)
{
    double gain = settings->gain;
    double loss = settings->loss;
    if (gain == INFINITY && loss == INFINITY) {
        return wanted;
    }
    if ((wanted > 0 && now < 0) || (wanted < 0 && now > 0)) {
        wanted = 0;  // it must stop first
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

// Returns true if two numbers are finite: times zero, all finite numbers are zero. One test per
// number would take twice the instructions.
static inline bool wg_are_finite(double one, double two)
{
    return one * 0.0 + two * 0.0 == 0.0;
}

// Returns true if a number is anything but zero, including NaN: without its sign, zero has no bits.
static inline bool wg_is_nonzero(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits << 1 != 0;
}

// The turn that a command requests, heading units; `most` is the limit, whole.
static inline int64_t wg_commanded_turn(const WgSettings *settings, const WgCommand *command, double most)
{
    return wg_round_away(wg_clamp(command->turn_rate * settings->turn, -most, most));
}

// The speed that a command requests, units of speed.
static inline int64_t wg_commanded_speed(const WgSettings *settings, const WgCommand *command)
{
    double speed = wg_clamp(command->speed, -settings->top_speed, settings->top_speed);
    return wg_whole_speed(speed * settings->speed * (double)WG_SPEED_UNIT);
}

// Applies a command: the turn now, the speed in the next step; clamps both, and refuses NaN and
// infinities. A robot that then stands at its goal may have arrived.
__attribute__((always_inline)) static inline void wg_apply(const WgArena *arena, const WgSettings *settings,
                                                           const WgCommand *command, int64_t step, bool is_simple,
                                                           WgRobot *robot)
{
    WgState *state = &robot->body->state;
    if (!wg_are_finite(command->speed, command->turn_rate)) {
        robot->report.ending = WG_INVALID_COMMAND;
        return;
    }
    bool is_body = !is_simple && wg_has_carriage(settings);
    double most = is_body ? WG_MOST_BODY_TURN : WG_TURN / 2;
    double limit = settings->turn_limit * settings->turn + 1e-9;
    int64_t turn = wg_commanded_turn(settings, command, limit < most ? (double)(int64_t)limit : most);
    int64_t speed = wg_commanded_speed(settings, command);
    if (is_body && wg_is_car(settings)) {
        // It will turn on its next step's arc.
        turn = 0;
        wg_steer(settings, command, robot);
        speed = settings->reverse != 0 ? speed : wg_most(speed, 0);
    }
    if (is_body) {
        turn = wg_turn_body(arena, settings, step, turn, robot);
    } else {
        state->heading = wg_reduced_heading(state->heading + turn);
    }
    if (settings->measures != 0) {
        wg_measure_turn(settings, step, turn, robot);
    }
    state->speed = wg_next_speed(state->speed, speed, settings);
    if (wg_is_nonzero(command->used_random)) {
        state->draws++;
    }
    const WgGoal *goal = robot->goal;
    if (!is_simple && goal->arrival == WG_ARRIVAL_STOP) {
        if (!wg_is_car(settings)) {
            robot->turned = turn;
        }
        // A turn that a wall cut short, or that swept over fire, may have ended the run before.
        if (robot->report.ending == WG_LIMIT && robot->passed_step != step
            && wg_abs(state->speed) <= goal->arrival_speed && wg_abs(robot->turned) <= goal->arrival_turn
            && wg_is_at_goal(goal, state)) {
            wg_meet_goal(settings, robot);
            if (robot->meets != 0) {
                wg_pass_waypoint(settings, step, robot);
            }
        }
    }
}

static inline void wg_apply_command(const WgArena *arena, const WgSettings *settings, const WgCommand *command,
                                    int64_t step, WgRobot *robot)
{
    if (robot->is_simple != 0) {
        wg_apply(arena, settings, command, step, true, robot);
    } else {
        wg_apply_to_any(arena, settings, command, step, robot);
    }
}

// Lets a controller that is a function act; returns false if it failed.
static inline bool wg_call(const WgController *controller, WgWorkspace *workspace, WgRobot *robot)
{
    WgCommand *command = &workspace->command;
    if (controller->act != NULL) {
        controller->act(&workspace->observation, robot->body->memory, command);
    } else if (controller->cage != NULL) {
        wg_act_caged(controller->cage, workspace, robot);
    } else {
        wg_act_flat(controller, workspace, robot->body->memory);
    }
    if (command->error != NULL) {
        robot->report.ending = WG_CRASH;
        robot->report.error = command->error;
        return false;
    }
    return true;
}

// Does the same, and applies its command.
static inline bool wg_act(const WgArena *arena, const WgSettings *settings, const WgController *controller,
                          WgWorkspace *workspace, int64_t step, WgRobot *robot)
{
    if (!wg_call(controller, workspace, robot)) {
        return false;
    }
    wg_apply_command(arena, settings, &workspace->command, step, robot);
    return true;
}

// Counts how often the robot has begun to touch a wall.
static inline void wg_count_contact(WgRobot *robot, bool touches)
{
    robot->report.collisions += touches && robot->touched == 0;
    robot->touched = touches;
}

// Counts a contact, and hashes and records the step if requested.
static inline void wg_note_step(const WgSettings *settings, const WgRecording *recording, int64_t words, int64_t step,
                                WgRobot *robot)
{
    bool touches = wg_is_contact(robot->contact);
    wg_count_contact(robot, touches);
    if (settings->digest != 0) {
        wg_hash_step(robot, words, touches);
    }
    if (recording->rows != NULL) {
        wg_write_step(recording, robot, words, step, touches);
    }
}

// Returns true if a recorded step was the last one, considering a recurrence too.
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

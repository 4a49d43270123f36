// Makes a fleet's step: all move, then all sense, then all act; and decides what ends its run.

#include <string.h>

#include "fleet.h"
#include "stopwatch.h"

enum { LONGEST_PORTION = 1 << 8 };  // steps between two looks at the clock

static bool has_parked(const WgEpisode *member)
{
    return member->robot.report.ending == WG_REACHED;
}

static bool is_outside_the_core(const WgEpisode *member)
{
    const WgController *controller = &member->controller;
    return controller->act == NULL && controller->flat == NULL && controller->cage == NULL;
}

// Moves all robots at the speed of their wheels.
static void move_robots(WgFleet *fleet, int64_t step)
{
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        WgRobot *robot = &member->robot;
        const WgState *state = &robot->body->state;
        robot->corners = 0;
        robot->contact = (WgNormal){0.0, 0.0};
        fleet->by[k] = (WgVector){0, 0};
        if (has_parked(member)) {
            continue;
        }
        robot->report.steps = step;
        int64_t drive = wg_drive(state->speed);
        if (member->settings->slip > 0.0) {
            drive = wg_slipped(member->settings, step, drive);
        }
        if (drive != 0) {
            fleet->by[k] = wg_displacement(member->arena->headings, state->heading, drive);
        }
        if (member->settings->disturbed != 0) {
            fleet->by[k].x += member->settings->drift_x;
            fleet->by[k].y += member->settings->drift_y;
        }
    }
    wg_fleet_move(fleet, fleet->by);
}

void wg_fleet_move(WgFleet *fleet, const WgVector *by)
{
    int64_t step = fleet->step;
    for (int64_t k = 0; k < fleet->count; k++) {
        const WgState *state = &fleet->members[k]->robot.body->state;
        fleet->before[k] = (WgVector){state->x, state->y};
    }
    wg_move_fleet(fleet, step, by);
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        WgRobot *robot = &member->robot;
        const WgState *state = &robot->body->state;
        WgVector before = fleet->before[k];
        WgVector at = before;
        for (int64_t c = 0; c < robot->corners; c++) {
            if (robot->chain[c].x != at.x || robot->chain[c].y != at.y) {
                fleet->moved[k] = step;
            }
            at = (WgVector){robot->chain[c].x, robot->chain[c].y};
        }
        // A robot that parked before has had no step.
        if (robot->report.steps == step) {
            if (member->settings->measures != 0) {
                bool drifts = member->settings->disturbed != 0 && !wg_is_contact(robot->contact);
                int64_t moved_x = state->x - before.x - (drifts ? member->settings->drift_x : 0);
                int64_t moved_y = state->y - before.y - (drifts ? member->settings->drift_y : 0);
                wg_measure_move(member->arena, member->settings, step, moved_x, moved_y, robot);
            }
            fleet->is_inside[k] = wg_keep_books(member->arena, step, robot);
        }
    }
}

// Lets all driving robots sense their new places and the robots there.
static void sense(WgFleet *fleet)
{
    if (fleet->senses_others != 0) {
        wg_ready_senses(fleet);
    }
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        fleet->acts[k] = member->robot.report.ending == WG_LIMIT && fleet->is_inside[k] != 0;
        if (fleet->acts[k] != 0) {
            if (fleet->senses_others != 0) {
                wg_sense_others(fleet, k);
            }
            wg_sense(member->arena, member->settings, &member->robot, fleet->step, &member->workspace.observation,
                     member->workspace.beams);
            member->workspace.command = (WgCommand){0};
        }
    }
}

// Ends the run of a robot that sends a number that is not finite.
static void check_message(WgFleet *fleet, int64_t k)
{
    WgEpisode *member = fleet->members[k];
    const double *message = wg_message_of(fleet, k);
    for (int64_t n = 0; n < fleet->settings->message; n++) {
        if (member->robot.report.ending == WG_LIMIT && !wg_are_finite(message[n], 0.0)) {
            member->robot.report.ending = WG_INVALID_COMMAND;
        }
    }
}

// Lets the controllers in the core act. Returns true if others must act.
static bool act(WgFleet *fleet)
{
    bool waits = false;
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        if (fleet->acts[k] == 0) {
            continue;
        }
        // All have sensed, so the messages of the previous step are no longer needed.
        if (fleet->settings->message > 0) {
            double *message = wg_message_of(fleet, k);
            memset(message, 0, (size_t)fleet->settings->message * sizeof *message);
            member->workspace.command.message = message;
        }
        if (is_outside_the_core(member)) {
            wg_flatten(&member->workspace);
            member->waits = 1;
            waits = true;
        } else {
            wg_act(member->arena, member->settings, &member->controller, &member->workspace, fleet->step, &member->robot);
            check_message(fleet, k);
        }
    }
    return waits;
}

// Takes the answers of the controllers that had to act.
static void take_answers(WgFleet *fleet)
{
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        if (member->waits != 0) {
            member->waits = 0;
            wg_take_answer(member);
            wg_apply_command(member->arena, member->settings, &member->workspace.command, fleet->step, &member->robot);
            check_message(fleet, k);
        }
    }
}

// Ends the run if a robot has done something that ends it; of several,
// the gravest ending and the first robot count.
static bool is_ended_by_robots(WgFleet *fleet)
{
    static const int64_t GRAVEST_FIRST[] = {WG_CRASH, WG_INVALID_COMMAND, WG_TUNNEL, WG_BURNED};
    for (size_t which = 0; which < sizeof GRAVEST_FIRST / sizeof *GRAVEST_FIRST; which++) {
        for (int64_t k = 0; k < fleet->count; k++) {
            if (fleet->members[k]->robot.report.ending == GRAVEST_FIRST[which]) {
                fleet->report.ending = GRAVEST_FIRST[which];
                fleet->report.robot = k;
                fleet->report.other = -1;
                return true;
            }
        }
    }
    return fleet->report.ending != WG_LIMIT;
}

// Parks the robots that have reached their targets in this step.
static void park(WgFleet *fleet)
{
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        uint64_t *parked = wg_parked_word(fleet, k);
        if (has_parked(member) && *parked == 0) {
            *parked = 1;
            member->robot.body->state.speed = 0;
            fleet->report.parked++;
        }
    }
    if (fleet->report.parked == fleet->count) {
        fleet->report.ending = WG_REACHED;
    }
}

// Looks for a recurrence of the complete state.
static void look_for_loop(WgFleet *fleet)
{
    const WgFleetSettings *settings = fleet->settings;
    int64_t step = fleet->step;
    int64_t period = 0;
    if (settings->find_loop == WG_SEEK_LOOP) {
        if (step >= fleet->quiet) {
            period = wg_search_period(&fleet->search, fleet->state, step, fleet->quiet, settings->steps);
        }
        if (period > 0) {
            fleet->report.entry = wg_entry_of_loop(fleet->search.log, fleet->quiet, step, period);
        }
    } else if (settings->find_loop == WG_PROVE_LOOP &&
               wg_search_is_proved(&fleet->search, fleet->state, step, settings->loop_entry, settings->steps)) {
        period = settings->steps - settings->loop_entry;
        fleet->report.entry = settings->loop_entry;
    }
    if (period > 0) {
        fleet->report.ending = WG_LOOP;
        fleet->report.period = period;
    }
}

// Judges and records a finished step. Returns true if it was the last one.
static bool finish_step(WgFleet *fleet)
{
    fleet->report.steps = fleet->step;
    bool is_ended = is_ended_by_robots(fleet);
    if (fleet->report.ending == WG_CRASH) {
        return true;  // the step in which a controller fails is not recorded
    }
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        if (member->robot.report.steps == fleet->step) {
            wg_note_step(member->settings, &member->recording, member->search.words, fleet->step, &member->robot);
        }
    }
    if (is_ended) {
        return true;
    }
    park(fleet);
    if (fleet->report.ending == WG_LIMIT) {
        look_for_loop(fleet);
    }
    return fleet->report.ending != WG_LIMIT || fleet->step >= fleet->settings->steps;
}

int64_t wg_fleet_run(WgFleet *fleet, int64_t most_steps)
{
    if (fleet->over != 0) {
        return WG_OVER;
    }
    if (fleet->waits != 0) {
        fleet->waits = 0;
        take_answers(fleet);
        fleet->over = finish_step(fleet);
    }
    int64_t last = wg_least(fleet->settings->steps, fleet->step + most_steps);
    WgStopwatch watch = wg_stopwatch();
    int64_t next_look = fleet->step + 1;
    while (fleet->over == 0 && fleet->step < last) {
        if (fleet->step == next_look) {
            if (wg_is_late(&watch)) {
                break;
            }
            next_look += wg_least(watch.portion, LONGEST_PORTION);
        }
        fleet->step++;
        move_robots(fleet, fleet->step);
        sense(fleet);
        if (act(fleet)) {
            fleet->waits = 1;
            return WG_ACTS;
        }
        fleet->over = finish_step(fleet);
    }
    fleet->over = fleet->over != 0 || fleet->step >= fleet->settings->steps;
    return fleet->over != 0 ? WG_OVER : WG_GOES_ON;
}

void wg_fleet_fail(WgFleet *fleet, int64_t robot)
{
    wg_episode_fail(fleet->members[robot]);
    fleet->report.steps = fleet->step;
    fleet->report.ending = WG_CRASH;
    fleet->report.robot = robot;
    fleet->over = 1;
}

// Plain runs: no events, disturbances, noise, dynamic limits, digest or recording,
// little memory, a target that only has to be touched, and a search for loops. Most runs are plain, and a specialised loop takes less
// than two thirds of the time.
//
// The steps are those of step.h without the features that a plain run lacks, and without
// recomputing what a step leaves unchanged: a robot that turns on the spot neither moves nor
// touches anything, and an unused random number is still the next one.

#include "step.h"

// The loop's local state.
typedef struct Plain {
    const WgArena *arena;
    const WgSettings *settings;
    const WgController *controller;
    WgRobot *robot;
    WgWorkspace *workspace;
    int64_t words;      // words of a state
    bool is_inside;     // 1 if the centre is in the grid
    bool knows_random;  // 1 if the observation has the next random number
    // contribution to the fingerprint of the words that the last step did not change
    uint64_t constant;
} Plain;

bool wg_is_plain(const WgEpisode *episode)
{
    const WgArena *arena = episode->arena;
    const WgSettings *settings = episode->settings;
    return arena->event_count == 0 && !wg_has_carriage(settings) && settings->target.arrival == WG_ARRIVAL_TOUCH
           && settings->target.has_heading == 0 && settings->waypoint_count == 0 && settings->slip <= 0.0 && settings->measures == 0
           && settings->disturbed == 0 && settings->turn_limit == INFINITY && settings->gain == INFINITY
           && settings->loss == INFINITY && settings->digest == 0 && settings->find_loop == WG_SEEK_LOOP
           && episode->search.words <= WG_FEW_WORDS && episode->recording.rows == NULL;
}

// The contribution of position and random numbers to the fingerprint: of wg_fingerprint_of_few, the
// words that rarely change.
static uint64_t seldom_words(const WgState *state)
{
    return wg_folded((uint64_t)state->x) * WG_FACTORS[0] + wg_folded((uint64_t)state->y) * WG_FACTORS[1]
           + wg_folded((uint64_t)state->draws) * WG_FACTORS[4];
}

// The fingerprint of the state, equal to wg_fingerprint_of_few's.
static inline uint64_t fingerprint(const Plain *plain)
{
    const WgBody *body = plain->robot->body;
    uint64_t mixed = plain->constant + wg_folded((uint64_t)body->state.heading) * WG_FACTORS[2]
                     + wg_folded((uint64_t)body->state.speed) * WG_FACTORS[3];
    for (int64_t k = WG_STATE_WORDS; k < plain->words; k++) {
        mixed += wg_folded(wg_word(body, k)) * WG_FACTORS[k];
    }
    return mixed;
}

// Moves the robot, and senses at its new place.
static inline void move(Plain *plain, int64_t drive, int64_t step)
{
    const WgSettings *settings = plain->settings;
    WgRobot *robot = plain->robot;
    const WgState *state = &robot->body->state;
    WgVector by = wg_displacement(plain->arena->headings, state->heading, drive);
    robot->contact = wg_move(plain->arena, settings, step, by.x, by.y, 0, WG_STEP_TIME, robot);
    plain->is_inside = wg_keep_books(plain->arena, step, robot);
    plain->constant = seldom_words(state);

    WgObservation *observation = &plain->workspace->observation;
    observation->x = (double)state->x * settings->metres;
    observation->y = (double)state->y * settings->metres;
}

// Senses everything that changes without a move, and lets the controller act.
// Returns false if it failed.
static inline bool act(Plain *plain, bool touches, int64_t step)
{
    const WgSettings *settings = plain->settings;
    WgRobot *robot = plain->robot;
    WgState *state = &robot->body->state;
    WgWorkspace *workspace = plain->workspace;
    WgObservation *observation = &workspace->observation;
    observation->bump = touches ? 1.0 : 0.0;
    observation->heading = wg_sensed_heading(settings, state);
    if (!plain->knows_random && (settings->senses & WG_SENSE_RANDOM) != 0) {
        observation->random = wg_sensed_random(settings, state);
        plain->knows_random = true;
    }
    if (wg_senses_more(settings)) {
        wg_sense_more(plain->arena, settings, robot, step, observation, workspace->beams);
    }

    WgCommand *command = &workspace->command;
    *command = (WgCommand){0};
    if (!wg_call(plain->controller, workspace, robot)) {
        return false;
    }
    if (!wg_are_finite(command->speed, command->turn_rate)) {
        robot->report.ending = WG_INVALID_COMMAND;
        return true;
    }
    state->heading = wg_reduced_heading(state->heading + wg_commanded_turn(settings, command, WG_TURN / 2));
    state->speed = wg_commanded_speed(settings, command);
    wg_prefetch_displacement(plain->arena->headings, state->heading);
    if (wg_is_nonzero(command->used_random)) {
        state->draws++;
        plain->constant = seldom_words(state);
        plain->knows_random = false;
    }
    return true;
}

// Runs the steps from `first` to `last` and logs their states.
// Returns the step that ended the run; 0 if none did.
static int64_t run_steps(Plain *kept, uint64_t *log, int64_t first, int64_t last)
{
    Plain plain = *kept;
    WgRobot *robot = plain.robot;
    int64_t ended = 0;
    for (int64_t step = first; step <= last; step++) {
        int64_t drive = wg_drive(robot->body->state.speed);
        bool touches = false;
        robot->report.steps = step;  // if the controller kills the process, its owner reads this
        robot->corners = 0;
        robot->contact = (WgNormal){0.0, 0.0};
        if (drive != 0 || step == 1) {
            move(&plain, drive, step);
            touches = wg_is_contact(robot->contact);
        }
        bool is_to_act = plain.is_inside && robot->report.ending == WG_LIMIT;
        if (is_to_act && !act(&plain, touches, step)) {
            ended = step;
            break;
        }
        wg_count_contact(robot, touches);
        if (robot->report.ending != WG_LIMIT) {
            ended = step;
            break;
        }
        log[step] = fingerprint(&plain);
    }
    *kept = plain;
    return ended;
}

bool wg_run_plain(WgEpisode *episode, int64_t last)
{
    WgSearch *search = &episode->search;
    WgRobot *robot = &episode->robot;
    Plain plain = {
        .arena = episode->arena,
        .settings = episode->settings,
        .controller = &episode->controller,
        .robot = robot,
        .workspace = &episode->workspace,
        .words = search->words,
        .is_inside = wg_is_inside(episode->arena, &robot->body->state),
        .constant = seldom_words(&robot->body->state),
    };

    // Go from one look-up of the search to the next.
    for (int64_t step = episode->step + 1; step <= last; step++) {
        int64_t end = wg_least(last, wg_most(search->next, step));
        int64_t ended = run_steps(&plain, search->log, step, end);
        step = ended > 0 ? ended : end;
        episode->step = step;
        if (ended > 0) {
            return false;
        }
        if (end < search->next && end < episode->settings->steps) {
            break;
        }
        int64_t period = wg_search_look_up(search, end, 0);
        if (period > 0) {
            robot->report.ending = WG_LOOP;
            robot->report.period = period;
            return false;
        }
    }
    return true;
}

// Creates episodes, sized for the controller, the sensors and the events.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "recurrence.h"
#include "step.h"

enum {
    // limit on a controller's memory; a log may have 16 times as many steps
    MOST_NUMBERS = 1 << 28,
    MOST_BEAMS = 1 << 20,
    MOST_PUSHES = 1 << 20,
};

int64_t wg_carriage_words(const WgSettings *settings)
{
    enum { OF_A_BODY = 2 };

    if (wg_is_car(settings)) {
        return (int64_t)(sizeof(WgCarriage) / sizeof(uint64_t));
    }
    return wg_has_carriage(settings) ? OF_A_BODY : 0;
}

int64_t wg_words_after_memory(const WgSettings *settings)
{
    return (settings->waypoint_count > 0) + wg_carriage_words(settings);
}

int64_t wg_most_events_of_a_step(const WgArena *arena)
{
    int64_t most = 0;
    int64_t run = 0;
    for (int64_t k = 0; k < arena->event_count; k++) {
        run = k > 0 && arena->events[k].step == arena->events[k - 1].step ? run + 1 : 1;
        most = run > most ? run : most;
    }
    return most;
}

// Returns a part of the allocation; everything in it consists of 64-bit words.
static void *take(uint64_t **rest, int64_t words)
{
    void *part = *rest;
    *rest += words;
    return part;
}

// The parts of an episode after its struct, in words.
typedef struct Parts {
    int64_t state;  // with the controller's memory
    int64_t corners;
    int64_t headings;
    int64_t beams;
    int64_t flat;
    int64_t answer;
    int64_t prints;
    int64_t log;  // a separate block
} Parts;

// Computes the sizes of the parts; returns false if a size is out of its range.
static bool measure(const WgArena *arena, const WgSettings *settings, const WgController *controller,
                    int64_t log_steps, Parts *parts)
{
    int64_t memory = controller->memory_size;
    int64_t beams = settings->beams;
    if (memory < 0 || memory > MOST_NUMBERS || beams < 0 || beams > MOST_BEAMS || log_steps < 0
        || log_steps > (int64_t)16 * MOST_NUMBERS) {
        return false;
    }
    int64_t pushes = settings->push_count;
    if (pushes < 0 || pushes > MOST_PUSHES || settings->place_count > pushes) {
        return false;
    }
    int64_t corners = WG_MOST_CORNERS * (wg_most_events_of_a_step(arena) + wg_most_legs(settings) + pushes);
    parts->state = WG_STATE_WORDS + memory + wg_words_after_memory(settings);
    parts->headings = wg_has_carriage(settings) ? corners : 0;
    parts->corners = corners * (int64_t)(sizeof(WgCorner) / sizeof(uint64_t));
    parts->beams = beams;
    parts->flat = wg_flat_size(settings, 0);
    parts->answer = WG_ANSWER + memory;
    parts->prints = wg_blocks(parts->state) + 1;
    parts->log = log_steps > 0 ? log_steps + 1 : 0;
    return true;
}

WgStatus wg_episode_sizes(const WgArena *arena, const WgSettings *settings, const WgController *controller,
                          int64_t log_steps, int64_t sizes[2])
{
    Parts parts;
    if (!measure(arena, settings, controller, log_steps, &parts)) {
        return WG_BAD_SIZE;
    }
    int64_t words = 2 * parts.state + parts.corners + parts.headings + parts.beams + parts.flat + parts.answer + parts.prints;
    sizes[0] = (int64_t)sizeof(WgEpisode) + words * (int64_t)sizeof(uint64_t);
    sizes[1] = parts.log * (int64_t)sizeof(uint64_t);
    return WG_OK;
}

WgEpisode *wg_episode_place(void *block, void *log, const WgArena *arena, const WgSettings *settings,
                            const WgController *controller, int64_t log_steps)
{
    Parts parts;
    if (!measure(arena, settings, controller, log_steps, &parts)) {
        return NULL;
    }
    WgEpisode *episode = block;
    uint64_t *rest = (uint64_t *)(episode + 1);
    episode->arena = arena;
    episode->settings = settings;
    episode->controller = *controller;
    episode->robot.body = take(&rest, parts.state);
    episode->robot.chain = take(&rest, parts.corners);
    int64_t *headings = take(&rest, parts.headings);
    episode->workspace.beams = take(&rest, parts.beams);
    if (controller->cage != NULL) {
        // What a library's function uses in every step is where it acts. Nothing may follow its memory there.
        if (wg_words_after_memory(settings) == 0) {
            episode->robot.body = (WgBody *)(controller->cage->memory - WG_STATE_WORDS);
        }
        episode->workspace.beams = controller->cage->beams;
    }
    int64_t *after = (int64_t *)(episode->robot.body->memory + controller->memory_size);
    if (settings->waypoint_count > 0) {
        episode->robot.passed = after++;
    }
    if (parts.headings > 0) {
        episode->robot.carriage = (WgCarriage *)after;
        episode->robot.chain_headings = headings;
    }
    episode->workspace.flat = take(&rest, parts.flat);
    episode->workspace.answer = take(&rest, parts.answer);
    episode->search.prints = take(&rest, parts.prints);
    episode->search.known = take(&rest, parts.state);
    episode->search.log = log;
    episode->search.log_size = parts.log;
    episode->search.words = parts.state;
    return episode;
}

WgStatus wg_episode_new(const WgArena *arena, const WgSettings *settings, const WgController *controller,
                        int64_t log_steps, WgEpisode **made)
{
    *made = NULL;
    int64_t sizes[2];
    WgStatus status = wg_episode_sizes(arena, settings, controller, log_steps, sizes);
    if (status != WG_OK) {
        return status;
    }

    // The log is not cleared: a long one takes memory only as the run progresses,
    // and no entry is read before it is written.
    void *block = calloc(1, (size_t)sizes[0]);
    void *log = sizes[1] > 0 ? malloc((size_t)sizes[1]) : NULL;
    if (block == NULL || (sizes[1] > 0 && log == NULL)) {
        free(block);
        free(log);
        return WG_OUT_OF_MEMORY;
    }
    *made = wg_episode_place(block, log, arena, settings, controller, log_steps);
    return WG_OK;
}

void wg_episode_free(WgEpisode *episode)
{
    if (episode != NULL) {
        free(episode->search.log);
        free(episode);
    }
}

void wg_episode_fail(WgEpisode *episode)
{
    WgReport *report = &episode->robot.report;
    report->ending = WG_CRASH;
    report->error = NULL;
    episode->step = report->steps;
    episode->over = 1;
}

// Cells that a coverage task requires, without those already visited: the start's.
static int64_t count_unvisited(const WgArena *arena)
{
    int64_t count = 0;
    int64_t cells = arena->wanted != NULL ? arena->width * arena->height : 0;
    for (int64_t k = 0; k < cells; k++) {
        count += arena->wanted[k] != 0 && arena->visited[k] == 0;
    }
    return count;
}

WgStatus wg_episode_begin(WgEpisode *episode)
{
    const WgSettings *settings = episode->settings;
    if (settings->find_loop == WG_SEEK_LOOP && episode->search.log_size <= settings->steps) {
        return WG_BAD_SIZE;  // the log is shorter than the run
    }
    wg_robot_begin(&episode->robot, settings, &episode->controller);
    wg_workspace_begin(&episode->workspace, settings);
    memset(&episode->recording, 0, sizeof episode->recording);
    episode->step = 0;
    episode->robot.report.cells_left = count_unvisited(episode->arena);
    episode->quiet = wg_last_event(episode->arena, settings);
    episode->waits = 0;
    episode->over = 0;
    episode->workspace.answer[0] = 0.0;
    if (settings->find_loop != WG_NO_LOOP) {
        wg_search_begin(&episode->search, episode->robot.body, episode->quiet);
    }
    return WG_OK;
}

void wg_robot_begin(WgRobot *robot, const WgSettings *settings, const WgController *controller)
{
    WgState *state = &robot->body->state;
    state->x = settings->start_x;
    state->y = settings->start_y;
    state->heading = settings->start_heading;
    state->speed = wg_whole_speed(settings->start_speed * settings->speed * (double)WG_SPEED_UNIT);
    state->draws = 0;
    if (controller->memory_size > 0) {
        memcpy(robot->body->memory, controller->memory, (size_t)controller->memory_size * sizeof(double));
    }
    if (wg_has_carriage(settings)) {
        memset(robot->carriage, 0, (size_t)wg_carriage_words(settings) * sizeof(int64_t));
    }
    if (robot->passed != NULL) {
        *robot->passed = 0;
    }
    robot->goal = settings->waypoint_count > 0 ? settings->waypoints : &settings->target;
    robot->is_simple = !wg_has_carriage(settings) && settings->waypoint_count == 0
                       && settings->target.arrival == WG_ARRIVAL_TOUCH;
    robot->meets = 0;
    robot->passed_step = 0;
    robot->odometry.x = (double)state->x;
    robot->odometry.y = (double)state->y;
    robot->odometry.heading = (double)state->heading;
    robot->corners = 0;
    robot->turned = 0;
    robot->contact = (WgNormal){0.0, 0.0};
    robot->touched = 0;
    robot->next_event = 0;
    robot->next_push = settings->place_count;
    memset(&robot->report, 0, sizeof robot->report);
    robot->report.hit_step = -1;
    robot->report.overlap_step = -1;
    robot->report.cells_visited = 1;
    robot->report.digest = WG_HASH_START;
}

void wg_workspace_begin(WgWorkspace *workspace, const WgSettings *settings)
{
    WgObservation *seen = &workspace->observation;
    double *numbers = (double *)seen;
    for (int64_t k = 0; k < WG_SENSES; k++) {
        numbers[k] = NAN;
    }
    seen->time_step = settings->time_step;
    seen->top_speed = settings->top_speed;
    seen->radius = settings->radius;
    seen->goal_heading = wg_sensed_goal_heading(settings, settings->waypoint_count > 0 ? settings->waypoints : &settings->target);
    wg_sense_tilt(settings, seen);
    workspace->tail = wg_tail(settings);
    seen->beams = workspace->beams;
    seen->beam_count = settings->beams;
    for (int64_t k = 0; k < settings->beams; k++) {
        workspace->beams[k] = NAN;
    }
    memset(&workspace->command, 0, sizeof workspace->command);
}

void wg_visit_start(const WgArena *arena, const WgSettings *settings)
{
    memset(arena->visited, 0, (size_t)(arena->width * arena->height));
    int64_t ix = wg_least(wg_cell_of(settings->start_x), arena->width - 1);
    int64_t iy = wg_least(wg_cell_of(settings->start_y), arena->height - 1);
    arena->visited[iy * arena->width + ix] = 1;
}

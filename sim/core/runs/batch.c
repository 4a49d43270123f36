// Runs from their start to their verdict, one after another.

#include "step.h"
#include "stopwatch.h"
#include "wg_runs.h"

enum { MOST_TIME = 250000000 };  // ns that a call takes, about, so that its caller notices Ctrl-C

// Sets the arena back to its state before the first event, and the robot to its start.
static WgStatus begin_pass(const WgRun *run)
{
    const WgArena *arena = run->episode->arena;
    size_t cells = (size_t)(arena->width * arena->height);
    if (arena->event_count > 0) {
        memcpy(arena->cells, run->fresh->cells, cells * sizeof *arena->cells);
        memcpy(arena->near, run->fresh->near, cells * sizeof *arena->near);
    }
    wg_visit_start(arena, run->settings);
    return wg_episode_begin(run->episode);
}

WgStatus wg_run_begin(const WgRun *run)
{
    const WgArena *arena = run->episode->arena;
    if (run->settings != run->episode->settings || run->fresh->width != arena->width
        || run->fresh->height != arena->height) {
        return WG_BAD_VALUE;
    }
    run->settings->steps = run->budget;
    run->settings->find_loop = run->find_loop;
    return begin_pass(run);
}

bool wg_run_goes_on(const WgRun *run)
{
    WgSettings *settings = run->settings;
    const WgReport *report = &run->episode->robot.report;
    if (settings->find_loop == WG_SEEK_LOOP && report->ending == WG_LOOP) {
        settings->loop_entry = wg_episode_entry(run->episode);
        settings->steps = settings->loop_entry + report->period;
        settings->find_loop = WG_PROVE_LOOP;
    } else if (settings->find_loop == WG_PROVE_LOOP && report->ending == WG_LIMIT) {
        settings->steps = run->budget;
        settings->find_loop = WG_NO_LOOP;
    } else {
        return false;
    }
    return begin_pass(run) == WG_OK;
}

static WgStatus begin_next(WgBatch *batch)
{
    const WgStart *start = &batch->starts[batch->at];
    WgSettings *settings = batch->run.settings;
    settings->start_x = start->x;
    settings->start_y = start->y;
    settings->start_heading = start->heading;
    settings->seed = batch->seeds[batch->at];
    return wg_run_begin(&batch->run);
}

int64_t wg_batch_run(WgBatch *batch, int64_t most_steps)
{
    WgEpisode *episode = batch->run.episode;
    int64_t began = wg_now();
    int64_t left = most_steps;
    while (left > 0 && wg_now() - began < MOST_TIME) {
        if (batch->running == 0) {
            batch->status = batch->at < batch->count ? begin_next(batch) : WG_OK;
            if (batch->at >= batch->count || batch->status != WG_OK) {
                return WG_OVER;
            }
            batch->running = 1;
        }

        int64_t earlier = episode->step;
        bool is_over = wg_episode_run(episode, left) == WG_OVER;
        left -= episode->step - earlier + 1;
        if (is_over && !wg_run_goes_on(&batch->run)) {
            batch->reports[batch->at++] = episode->robot.report;
            batch->running = 0;
            if (episode->robot.report.ending == WG_CRASH) {
                return WG_OVER;
            }
        }
    }
    return WG_GOES_ON;
}

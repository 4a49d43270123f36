// Many episodes of one controller in one world, in one call.

#include "step.h"
#include "wg_runs.h"

enum { PORTION = 1 << 20 };  // most steps between two checks for a stop

// Sets an arena back to its state before the first event, with the robot's cell visited.
static void renew(const WgArena *arena, const WgArena *fresh, const WgSettings *settings)
{
    size_t cells = (size_t)(arena->width * arena->height);
    if (arena->event_count > 0) {
        memcpy(arena->cells, fresh->cells, cells * sizeof *arena->cells);
        memcpy(arena->near, fresh->near, cells * sizeof *arena->near);
    }
    wg_visit_start(arena, settings);
}

// Another thread writes it.
static bool is_stopped(const int64_t *stop)
{
    return *(const volatile int64_t *)stop != 0;
}

static WgStatus run_again(WgEpisode *episode, const WgArena *fresh, const int64_t *stop)
{
    renew(episode->arena, fresh, episode->settings);
    WgStatus status = wg_episode_begin(episode);
    if (status == WG_OK) {
        while (wg_episode_run(episode, PORTION) == WG_GOES_ON && !is_stopped(stop)) {
        }
    }
    return status;
}

// Runs once and proves a loop.
static WgStatus run_one(WgEpisode *episode, WgSettings *settings, const WgArena *fresh, const int64_t *stop)
{
    WgStatus status = run_again(episode, fresh, stop);
    const WgReport *report = &episode->robot.report;
    if (status != WG_OK || report->ending != WG_LOOP) {
        return status;
    }

    // Run a loop again, up to the end of its first period, which also proves it.
    int64_t steps = settings->steps;
    settings->loop_entry = wg_episode_entry(episode);
    settings->steps = settings->loop_entry + report->period;
    settings->find_loop = WG_PROVE_LOOP;
    status = run_again(episode, fresh, stop);

    // If two different states had the same fingerprint, run to the end of the budget.
    if (status == WG_OK && report->ending == WG_LIMIT) {
        settings->steps = steps;
        settings->find_loop = WG_NO_LOOP;
        status = run_again(episode, fresh, stop);
    }
    return status;
}

WgStatus wg_run_many(WgEpisode *episode, WgSettings *settings, const WgArena *fresh, const WgStart *starts,
                     const uint64_t *seeds, int64_t count, const int64_t *stop, WgReport *reports)
{
    const WgArena *arena = episode->arena;
    if (settings != episode->settings || fresh->width != arena->width || fresh->height != arena->height) {
        return WG_BAD_VALUE;
    }
    int64_t steps = settings->steps;
    int64_t find_loop = settings->find_loop;
    for (int64_t n = 0; n < count && !is_stopped(stop); n++) {
        settings->start_x = starts[n].x;
        settings->start_y = starts[n].y;
        settings->start_heading = starts[n].heading;
        settings->seed = seeds[n];
        WgStatus status = run_one(episode, settings, fresh, stop);
        settings->steps = steps;
        settings->find_loop = find_loop;
        if (status != WG_OK) {
            return status;
        }
        reports[n] = episode->robot.report;
    }
    return WG_OK;
}

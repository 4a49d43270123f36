// Many robots in lockstep: all continue until their controller acts, then one call of it acts for
// all of them.

#include <string.h>

#include "step.h"
#include "wg_runs.h"

WgStatus wg_lockstep_new(const WgArena *arenas, const WgController *controller, WgRun *runs, int64_t count)
{
    for (int64_t k = 0; k < count; k++) {
        WgRun *run = &runs[k];
        int64_t log_steps = run->find_loop == WG_SEEK_LOOP ? run->budget : 0;
        WgStatus status = wg_episode_new(&arenas[k], run->settings, controller, log_steps, &run->episode);
        if (status == WG_OK) {
            status = wg_run_begin(run);
        }
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

void wg_lockstep_free(WgRun *runs, int64_t count)
{
    for (int64_t k = 0; k < count; k++) {
        wg_episode_free(runs[k].episode);
        runs[k].episode = NULL;
    }
}

int64_t wg_lockstep_step(WgRun **slots, int64_t count, const double *commands, const double *after,
                         double *observations, double *memories)
{
    int64_t acting = 0;
    for (int64_t slot = 0; slot < count; slot++) {
        WgRun *run = slots[slot];
        WgEpisode *episode = run->episode;
        int64_t size = episode->controller.memory_size;
        size_t bytes = (size_t)size * sizeof(double);
        if (episode->waits != 0) {
            WgCommand *command = &episode->workspace.command;
            command->speed = commands[3 * slot];
            command->turn_rate = commands[3 * slot + 1];
            command->used_random = commands[3 * slot + 2];
            memcpy(episode->robot.body->memory, after + size * slot, bytes);
        }

        // The rows written here belong to slots that have been read.
        episode->workspace.flat = observations + wg_flat_size(episode->settings, 0) * acting;
        int64_t state = wg_episode_step(episode);
        while (state == WG_OVER && wg_run_goes_on(run)) {
            state = wg_episode_step(episode);
        }
        if (state == WG_ACTS) {
            memcpy(memories + size * acting, episode->robot.body->memory, bytes);
            slots[acting++] = run;
        }
    }
    return acting;
}

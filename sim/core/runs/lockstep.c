// Many robots in lockstep: all continue until their controller acts, then one call of it acts for
// all of them.

#include <string.h>

#include "step.h"
#include "wg_runs.h"

WgStatus wg_lockstep_new(const WgArena *arenas, const WgSettings *settings, const WgController *controller,
                      const int64_t *log_steps, int64_t count, WgEpisode **episodes)
{
    for (int64_t k = 0; k < count; k++) {
        episodes[k] = NULL;
    }
    for (int64_t k = 0; k < count; k++) {
        WgStatus status = wg_episode_new(&arenas[k], &settings[k], controller, log_steps[k], &episodes[k]);
        if (status == WG_OK) {
            status = wg_episode_begin(episodes[k]);
        }
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

void wg_lockstep_free(WgEpisode **episodes, int64_t count)
{
    for (int64_t k = 0; k < count; k++) {
        wg_episode_free(episodes[k]);
        episodes[k] = NULL;
    }
}

int64_t wg_lockstep_step(WgEpisode **slots, int64_t count, const double *commands, const double *after,
                      double *observations, double *memories)
{
    int64_t acting = 0;
    for (int64_t slot = 0; slot < count; slot++) {
        WgEpisode *episode = slots[slot];
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
        episode->workspace.flat = observations + (WG_SENSES + episode->settings->beams) * acting;
        if (wg_episode_step(episode) == WG_ACTS) {
            memcpy(memories + size * acting, episode->robot.body->memory, bytes);
            slots[acting++] = episode;
        }
    }
    return acting;
}

void wg_lockstep_reports(WgEpisode *const *episodes, int64_t count, WgReport *reports, int64_t *entries)
{
    for (int64_t k = 0; k < count; k++) {
        reports[k] = episodes[k]->robot.report;
        entries[k] = wg_episode_entry(episodes[k]);
    }
}

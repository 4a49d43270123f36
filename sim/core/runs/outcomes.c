// Computes the outcomes of one step from many states, for every value that a random number may
// have, and the observations there.

#include "step.h"
#include "wg_runs.h"

WgStatus wg_outcomes(WgEpisode *episode, const int64_t *states, const int64_t *faces, int64_t count, int64_t *after,
                     int64_t *endings, int64_t *drew)
{
    const WgArena *arena = episode->arena;
    const WgSettings *settings = episode->settings;
    WgRobot *robot = &episode->robot;
    WgWorkspace *workspace = &episode->workspace;
    int64_t words = episode->search.words;
    size_t size = (size_t)words * sizeof *states;
    bool draws = (settings->senses & WG_SENSE_RANDOM) != 0;
    if (draws && settings->coin < 1) {
        return WG_BAD_VALUE;
    }
    WgStatus status = wg_episode_begin(episode);
    if (status != WG_OK) {
        return status;
    }
    for (int64_t n = 0; n < count; n++) {
        memcpy(robot->body, states + n * words, size);
        robot->body->state.draws = 0;
        robot->report.ending = WG_LIMIT;
        if (wg_move_and_sense(arena, settings, robot, workspace, 1)) {
            if (draws) {
                workspace->observation.random = (double)faces[n] / (double)settings->coin;
            }
            wg_act(settings, &episode->controller, workspace, 1, robot);
        }
        endings[n] = robot->report.ending;
        if (endings[n] == WG_CRASH) {
            // a controller's partial work is ignored
            memcpy(robot->body, states + n * words, size);
            robot->body->state.draws = 0;
        }
        drew[n] = robot->body->state.draws;
        robot->body->state.draws = 0;
        memcpy(after + n * words, robot->body, size);
    }
    return WG_OK;
}

WgStatus wg_sensed_of_walls(const WgArena *arena, const WgSettings *settings, const WgStart *poses, int64_t count,
                            double *seen)
{
    if (settings->beams < 0) {
        return WG_BAD_SIZE;
    }
    WgOdometry nowhere = {0.0, 0.0, 0.0};
    WgNormal untouched = {0.0, 0.0};
    for (int64_t n = 0; n < count; n++) {
        double *row = seen + n * (WG_SENSES + settings->beams);
        WgState state = {poses[n].x, poses[n].y, poses[n].heading, 0, 0};
        if (!wg_is_inside(arena, &state)) {
            return WG_BAD_VALUE;
        }
        WgObservation observation;
        memset(&observation, 0, sizeof observation);
        wg_sense(arena, settings, &state, &nowhere, untouched, 0, &observation, row + WG_SENSES);
        memcpy(row, &observation, WG_SENSES * sizeof *row);
    }
    return WG_OK;
}

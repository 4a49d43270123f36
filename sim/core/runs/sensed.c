// Computes what robots sense of the walls at many poses.

#include "step.h"
#include "wg_runs.h"

WgStatus wg_sensed_of_walls(const WgArena *arena, const WgSettings *settings, const WgStart *poses, int64_t count,
                            double *seen)
{
    if (settings->beams < 0) {
        return WG_BAD_SIZE;
    }
    WgState state;
    WgRobot robot = {.body = (WgBody *)&state, .goal = &settings->target};
    for (int64_t n = 0; n < count; n++) {
        double *row = seen + n * (WG_SENSES + settings->beams);
        state = (WgState){poses[n].x, poses[n].y, poses[n].heading, 0, 0};
        if (!wg_is_inside(arena, &state)) {
            return WG_BAD_VALUE;
        }
        WgObservation observation;
        memset(&observation, 0, sizeof observation);
        wg_sense(arena, settings, &robot, 0, &observation, row + WG_SENSES);
        memcpy(row, &observation, WG_SENSES * sizeof *row);
    }
    return WG_OK;
}

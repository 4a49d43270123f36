// Inline functions of internal headers, for callers outside of C.

#include "rays.h"
#include "sense.h"

WgVector wg_drive_displacement(const int64_t *headings, int64_t heading, int64_t distance)
{
    return wg_displacement(headings, heading, distance);
}

bool wg_box_of_path_is_free(const WgArena *arena, int64_t reach, WgSegment way)
{
    return wg_window_is_free(arena, reach, way);
}

double wg_draw_of_stream(uint64_t seed, int64_t index)
{
    return wg_random_draw(seed, index);
}

int64_t wg_heading_of_beam(int64_t heading, int64_t beam, int64_t beams, double field)
{
    return wg_beam_heading(heading, beam, beams, field);
}

void wg_sense_at(const WgArena *arena, const WgSettings *settings, const WgState *state, const WgOdometry *odometry,
                 WgNormal contact, int64_t step, WgObservation *observation, double *beams)
{
    WgState body = *state;
    WgRobot robot = {.body = (WgBody *)&body, .odometry = *odometry, .goal = &settings->target, .contact = contact};
    wg_sense(arena, settings, &robot, step, observation, beams);
}

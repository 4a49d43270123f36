// Straight lines through the cells of a world: range beams,
// and walls between a place and the target.

#ifndef WG_RAYS_H
#define WG_RAYS_H

#include <stdint.h>

#include "geometry.h"

// The cosine of a heading, correct to the last bits: the table stores it as two integers.
static inline double wg_cosine(const int64_t *headings, int64_t heading)
{
    int64_t place = heading & (WG_TURN - 1);
    return (double)headings[place] / 0x1p30 + (double)headings[WG_TURN + place] / 0x1p60;
}

static inline double wg_sine(const int64_t *headings, int64_t heading)
{
    return wg_cosine(headings, heading - WG_TURN / 4);
}

// World heading of a beam: spread evenly over `field` around the robot's heading, or over a full
// turn from it.
static inline int64_t wg_beam_heading(int64_t heading, int64_t beam, int64_t beams, double field)
{
    if (field >= (double)WG_TURN) {
        return heading + wg_floor((double)beam * (double)WG_TURN / (double)beams + 0.5);
    }
    if (beams == 1) {
        return heading;
    }
    return heading + wg_floor(((double)beam / (double)(beams - 1) - 0.5) * field + 0.5);
}

#endif

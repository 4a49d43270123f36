// fdlibm's functions for arrays; see fdlibm.h.

#include "fdlibm.h"

#include "wg_sim.h"

void wg_trigonometry(const double *x, int64_t count, double *sines, double *cosines, double *arc_tangents)
{
    for (int64_t k = 0; k < count; k++) {
        sines[k] = wg_sin(x[k]);
        cosines[k] = wg_cos(x[k]);
        arc_tangents[k] = wg_atan(x[k]);
    }
}

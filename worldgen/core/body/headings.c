// The cosines of all headings.

#include <math.h>

#include "body.h"

// The sum of x^k / k! with alternating signs, for every second k from ``first`` on; |x| is below 0.8.
static double alternating_series(double x, int first)
{
    double sum = 0.0;
    // The terms left out are below 2^-60.
    for (int k = first + 16; k >= first; k -= 2) {
        double step = k > first ? x * x / (double)(k * (k - 1)) : 1.0;
        sum = step * (1.0 - sum);
    }
    return first == 1 ? x * sum : sum;
}

void wg_body_cosines(int64_t *cosines)
{
    const double unit = 6.283185307179586477 / (double)WG_TURN;
    // Sines and cosines of an eighth are the first quarter, and the others are its mirror images.
    for (int64_t k = 0; k <= WG_EIGHTH; k++) {
        double angle = (double)k * unit;
        cosines[k] = (int64_t)floor(alternating_series(angle, 0) * WG_ONE + 0.5);
        cosines[2 * WG_EIGHTH - k] = (int64_t)floor(alternating_series(angle, 1) * WG_ONE + 0.5);
    }
    for (int64_t k = 0; k < 2 * WG_EIGHTH; k++) {
        cosines[4 * WG_EIGHTH - k] = -cosines[k];
    }
    for (int64_t k = 1; k < 4 * WG_EIGHTH; k++) {
        cosines[WG_TURN - k] = cosines[k];
    }
}

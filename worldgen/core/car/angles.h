// Sine, cosine and arc tangent from + - * / and square roots alone, so that a car's path has the
// same bits on every machine. Errors are below 1e-15.

#ifndef WG_ANGLES_H
#define WG_ANGLES_H

#include <math.h>

static const double WG_CAR_PI = 3.14159265358979323846;

typedef struct WgAngle {
    double cosine;
    double sine;
} WgAngle;

// Reduces an angle to (-pi, pi].
static inline double wg_car_wrap(double angle)
{
    double turn = 2.0 * WG_CAR_PI;
    double wrapped = angle - turn * floor(angle / turn + 0.5);
    return wrapped <= -WG_CAR_PI ? wrapped + turn : wrapped;
}

// Cosine and sine by their Taylor series, after a reduction to the quarter turn around 0.
static inline WgAngle wg_car_angle(double angle)
{
    double quarter = floor(angle / (0.5 * WG_CAR_PI) + 0.5);
    double x = (angle - quarter * 1.57079632679489655800) - quarter * 6.12323399573676603587e-17;
    double z = x * x;
    double sine = 1.0;
    double cosine = 1.0;
    for (int k = 18; k >= 2; k -= 2) {
        sine = 1.0 - z * (1.0 / (double)(k * (k + 1))) * sine;
        cosine = 1.0 - z * (1.0 / (double)(k * (k - 1))) * cosine;
    }
    sine *= x;
    int part = (int)(quarter - 4.0 * floor(quarter / 4.0));
    switch (part) {
        case 0:
            return (WgAngle){cosine, sine};
        case 1:
            return (WgAngle){-sine, cosine};
        case 2:
            return (WgAngle){-cosine, -sine};
        default:
            return (WgAngle){sine, -cosine};
    }
}

// The angle of a vector, rad, in (-pi, pi]; 0 for none.
static inline double wg_car_atan2(double y, double x)
{
    double ax = fabs(x);
    double ay = fabs(y);
    if (ax == 0.0 && ay == 0.0) {
        return 0.0;
    }
    double t = ay <= ax ? ay / ax : ax / ay;
    // Two halvings of the angle, after which the series needs few terms.
    t = t / (1.0 + sqrt(1.0 + t * t));
    t = t / (1.0 + sqrt(1.0 + t * t));
    double z = t * t;
    double series = 0.0;
    for (int k = 27; k >= 1; k -= 2) {
        series = 1.0 / (double)k - z * series;
    }
    double angle = 4.0 * t * series;
    angle = ay <= ax ? angle : 0.5 * WG_CAR_PI - angle;
    angle = x < 0.0 ? WG_CAR_PI - angle : angle;
    return y < 0.0 ? -angle : angle;
}

// Arc cosine and arc sine of a number from -1 to 1.
static inline double wg_car_acos(double x)
{
    return wg_car_atan2(sqrt(fmax(0.0, (1.0 - x) * (1.0 + x))), x);
}

static inline double wg_car_asin(double x)
{
    return wg_car_atan2(x, sqrt(fmax(0.0, (1.0 - x) * (1.0 + x))));
}

#endif

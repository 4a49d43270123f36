// How floating point rounds, as far as a program can change it for the double numbers of this core.

#if defined(__SSE2__)
#include <xmmintrin.h>
#elif !defined(__aarch64__)
#include <fenv.h>
#endif

#include "wg_episode.h"

#if defined(__SSE2__)

int64_t wg_rounding(void)
{
    // Without the bits that tell what has happened.
    return (int64_t)(_mm_getcsr() & ~(unsigned int)_MM_EXCEPT_MASK);
}

static void set(int64_t rounding)
{
    _mm_setcsr((unsigned int)rounding);
}

#elif defined(__aarch64__)

int64_t wg_rounding(void)
{
    int64_t control;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    return control;
}

static void set(int64_t rounding)
{
    __asm__ volatile("msr fpcr, %0" : : "r"(rounding));
}

#else

int64_t wg_rounding(void)
{
    return fegetround();
}

static void set(int64_t rounding)
{
    (void)fesetround((int)rounding);
}

#endif

void wg_set_rounding(int64_t rounding)
{
    if (wg_rounding() != rounding) {
        set(rounding);
    }
}

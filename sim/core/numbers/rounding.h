// How floating point rounds in this thread, in the processor's own form. A function from a library
// may change it, and all arithmetic after it would give other numbers.

#ifndef WG_ROUNDING_H
#define WG_ROUNDING_H

#include <stdint.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#elif !defined(__aarch64__)
#include <fenv.h>
#endif

#if defined(__SSE2__)

static inline int64_t wg_rounding_now(void)
{
    // Without the bits that tell what has happened.
    return (int64_t)(_mm_getcsr() & ~(unsigned int)_MM_EXCEPT_MASK);
}

static inline void wg_round(int64_t rounding)
{
    _mm_setcsr((unsigned int)rounding);
    // Functions of <fenv.h> change x87 arithmetic, too. An exception that it had long before, and that they
    // have unmasked, would end the process at its next instruction, so it is cleared. The default control
    // word masks all exceptions.
    const uint16_t control = 0x37F;
    __asm__ volatile("fnclex\n\tfldcw %0" : : "m"(control));
}

#elif defined(__aarch64__)

static inline int64_t wg_rounding_now(void)
{
    int64_t control;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    return control;
}

static inline void wg_round(int64_t rounding)
{
    __asm__ volatile("msr fpcr, %0" : : "r"(rounding));
}

#else

static inline int64_t wg_rounding_now(void)
{
    return fegetround();
}

static inline void wg_round(int64_t rounding)
{
    (void)fesetround((int)rounding);
}

#endif

// Reading takes less than writing, which is rarely needed.
static inline void wg_round_again(int64_t rounding)
{
    if (wg_rounding_now() != rounding) {
        wg_round(rounding);
    }
}

#endif

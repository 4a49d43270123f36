// A limit on the time of a call, so that its caller can notice Ctrl-C. A call that takes too long
// returns early, and the next one continues; how the work is divided changes no result.

#ifndef WG_STOPWATCH_H
#define WG_STOPWATCH_H

#include <stdbool.h>
#include <stdint.h>
#include <time.h>

enum { WG_MOST_PORTION = 1 << 20 };

typedef struct WgStopwatch {
    int64_t began;     // ns
    int64_t last;      // ns, when it was last read
    int64_t portion;   // steps until it is read again
} WgStopwatch;

static inline int64_t wg_now(void)
{
    struct timespec now = {0, 0};
    (void)timespec_get(&now, TIME_UTC);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

// Begins with few steps, as each may take milliseconds: 1000 beams across a large map do.
static inline WgStopwatch wg_stopwatch(void)
{
    int64_t now = wg_now();
    return (WgStopwatch){.began = now, .last = now, .portion = 32};
}

// Returns true if a tenth of a second has passed. Otherwise sets the next portion: reading the
// clock takes 25 ns, so portions of a millisecond cost nothing.
static inline bool wg_is_late(WgStopwatch *watch)
{
    int64_t now = wg_now();
    int64_t took = now - watch->last;
    watch->last = now;
    if (took < 1000000 && watch->portion < WG_MOST_PORTION) {
        watch->portion *= 2;
    } else if (took > 10000000 && watch->portion > 1) {
        watch->portion /= 2;
    }
    // A clock that is set back must not make the call endless.
    return now - watch->began > 100000000 || took < 0;
}

#endif

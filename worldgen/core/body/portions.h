// The portions that a box of poses is split into.

#ifndef WG_PORTIONS_H
#define WG_PORTIONS_H

#include "boxes.h"

enum { WG_MOST_PORTIONS = 128 };

// A part of a box along one axis.
typedef struct WgPortion {
    WgRange range;
    WgBoxKind kind;
} WgPortion;

typedef struct WgPortions {
    WgPortion all[WG_MOST_PORTIONS];
    int64_t count;
    double decided;  // share of the box that is free or full
} WgPortions;

// Splits a mixed box into portions; none if it is too small.
WgStatus wg_portions_of(WgBoxes *boxes, const WgBox *box, WgPortions *portions);

#endif

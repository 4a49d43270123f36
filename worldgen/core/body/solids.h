// The solid cells as rectangles: every largest one that holds all of a row's or a column's run.

#ifndef WG_SOLIDS_H
#define WG_SOLIDS_H

#include "body.h"

// A rectangle of solid cells, lu; by axis: x, then y.
typedef struct WgSolid {
    int64_t low[2];
    int64_t high[2];
    bool in_cover;  // the rectangles with this mark cover all solid cells
} WgSolid;

typedef struct WgSolids {
    WgSolid *all;
    int64_t count;
    int64_t room;
} WgSolids;

// Lists them; the outside counts as solid as far as a body can reach. Call wg_solids_free whatever this
// returns.
WgStatus wg_solids_make(WgSolids *solids, const WgWalls *walls);

void wg_solids_free(WgSolids *solids);

#endif

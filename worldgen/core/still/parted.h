// Decides whether chains of cells separate the start from poses, without constructing the chains.

#ifndef WG_PARTED_H
#define WG_PARTED_H

#include "links.h"

// Decides for each of some poses whether a chain separates it from the start.
//
// limit:      least squared gap, cells, at which two cells are not linked.
// poses:      (count,) the start, then at most 64 others.
WgStatus wg_all_parted(const WgWalls *walls, int64_t limit, const WgFinePose *poses, int64_t count, bool *parted);

// Coordinates of a listed pose, rounded to 1/1024 cell.
void wg_poses_round(const WgPoses *poses, int64_t index, int64_t *x, int64_t *y);

#endif

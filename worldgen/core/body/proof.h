// What follows a decision about a body: its path, or its cut.

#ifndef WG_PROOF_H
#define WG_PROOF_H

#include "boxes.h"

enum { WG_FROM_START = 0, WG_FROM_GOAL = 1 };

// Adds boxes in which the body just fits, without any clearance: at headings at which its sides can be
// parallel to walls, and on lines through the start, whose box and pose are given.
WgStatus wg_add_exact_fits(WgBoxes *boxes, int32_t start, WgBodyPose pose);

// Writes a path through free boxes from the start's, which is known to exist.
WgStatus wg_write_path(WgBoxes *boxes, int32_t start, WgBodyQuery *query);

// Writes the full boxes around those on one side.
//
// side:       the boxes that can be reached from the start, or from the target.
WgStatus wg_write_cut(WgBoxes *boxes, const WgNumbers *side, bool from_goal, WgBodyQuery *query);

#endif

// Judging a tick of the thesis's robot.

#ifndef WG_THESIS_JUDGE_H
#define WG_THESIS_JUDGE_H

#include "thesis_parts.h"

// Applies the events due at a step; one that hits the robot ends the run as WG_BURNED.
void thesis_apply_events(const WgThesisArena *arena, const WgThesisSettings *settings,
                         WgThesisRun *run, int64_t step);

// Records what the robot touches where the tick ends: walls, flames, newly visited cells.
//
// visited: (width, height) 1 where the centre has been.
// before:  the centre before a wall changed the tick's move.
void thesis_judge_place(const ThesisGrid *grid, uint8_t *visited, const WgThesisSettings *settings,
                        WgThesisRun *run, int64_t step, ThesisPoint before);

// Adds the tick's straight path to the length, and records the first wall that it enters.
void thesis_judge_path(const ThesisGrid *grid, const WgThesisSettings *settings, WgThesisRun *run,
                       int64_t step, ThesisPoint start);

#endif

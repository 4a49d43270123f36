// Runs edited copies of a world, one after another, to find the first that ends as requested.

#include <stdlib.h>

#include "step.h"
#include "wg_runs.h"

// Working memory for one edit, in addition to the episode's.
typedef struct Scratch {
    uint8_t *ever;   // (height, width) cells that are ever not free
    uint8_t *seen;   // (2 height + 1, 2 width + 1)
    int64_t *stack;  // as many
} Scratch;

// Returns true if an edit frees the cell (ix, iy), the `solid`th solid one in order of rows.
static bool frees(const WgEdit *edit, int64_t ix, int64_t iy, int64_t solid, int64_t width, int64_t height)
{
    switch (edit->kind) {
    case WG_FREE_BOX:
        return ix >= edit->a && ix < edit->a + edit->c && iy >= edit->b && iy < edit->b + edit->d;
    case WG_FREE_RUN:
        return solid >= edit->a && solid < edit->a + edit->b;
    case WG_FREE_RIM:
        return ix == 0 || iy == 0 || ix == width - 1 || iy == height - 1;
    default:
        return false;
    }
}

// Writes the edited cells; returns true if any of them changed.
static bool edit_cells(WgGrid old, const WgArena *arena, const WgEdit *edit)
{
    bool changed = edit->kind >= WG_DROP_ROWS;
    int64_t solid = 0;
    for (int64_t iy = 0; iy < arena->height; iy++) {
        for (int64_t ix = 0; ix < arena->width; ix++) {
            int64_t jy = edit->kind == WG_DROP_ROWS && iy >= edit->a ? iy + edit->b : iy;
            int64_t jx = edit->kind == WG_DROP_COLUMNS && ix >= edit->a ? ix + edit->b : ix;
            uint8_t state = old.cells[jy * old.width + jx];
            if (state == WG_SOLID) {
                if (frees(edit, ix, iy, solid, arena->width, arena->height)) {
                    state = WG_FREE;
                    changed = true;
                }
                solid++;
            }
            arena->cells[iy * arena->width + ix] = state;
        }
    }
    return changed;
}

// Returns true if an edit turns the old grid into one of the arena's shape.
static bool fits(WgGrid old, const WgArena *arena, const WgEdit *edit)
{
    if (edit->kind < WG_DROP_ROWS) {
        return edit->kind >= WG_FREE_BOX && old.width == arena->width && old.height == arena->height;
    }
    if (edit->a < 0 || edit->b < 0) {
        return false;
    }
    if (edit->kind == WG_DROP_ROWS) {
        return old.width == arena->width && old.height == arena->height + edit->b;
    }
    return edit->kind == WG_DROP_COLUMNS && old.height == arena->height && old.width == arena->width + edit->b;
}

// Returns a coordinate after `count` rows or columns starting at `first` have been removed.
static int64_t moved(int64_t coordinate, const WgEdit *edit)
{
    return coordinate >= (edit->a + edit->b) * WG_UNIT ? coordinate - edit->b * WG_UNIT : coordinate;
}

// Returns goal `k` of a run; the last one is the target.
static WgGoal *goal_of(WgSettings *settings, int64_t k)
{
    return k < settings->waypoint_count ? &settings->waypoints[k] : &settings->target;
}

// Moves the start and the goals with the cells that an edit moves; returns false if a goal is no longer in the grid.
static bool move_ends(const WgArena *arena, WgSettings *settings, const WgEdit *edit)
{
    if (edit->kind == WG_DROP_ROWS) {
        settings->start_y = moved(settings->start_y, edit);
    } else if (edit->kind == WG_DROP_COLUMNS) {
        settings->start_x = moved(settings->start_x, edit);
    }
    bool inside = true;
    for (int64_t k = 0; k <= settings->waypoint_count; k++) {
        WgGoal *goal = goal_of(settings, k);
        if (edit->kind == WG_DROP_ROWS) {
            goal->y = moved(goal->y, edit);
        } else if (edit->kind == WG_DROP_COLUMNS) {
            goal->x = moved(goal->x, edit);
        }
        inside = inside && goal->x <= arena->width * WG_UNIT && goal->y <= arena->height * WG_UNIT;
    }
    return inside;
}

// Moves the start to the nearest clear point of the nine around it, as in every run;
// returns false if there is none.
static bool stand(const WgArena *arena, WgSettings *settings)
{
    int64_t x = settings->start_x;
    int64_t y = settings->start_y;
    for (int64_t away = 0; away < 3; away++) {  // squared distance
        for (int64_t dx = -1; dx <= 1; dx++) {
            for (int64_t dy = -1; dy <= 1; dy++) {
                if (dx * dx + dy * dy == away
                    && wg_robot_is_clear(wg_grid(arena), WG_SOLID, arena->headings, settings, x + dx, y + dy,
                                         settings->start_heading)) {
                    settings->start_x = x + dx;
                    settings->start_y = y + dy;
                    return true;
                }
            }
        }
    }
    return false;
}

// Returns true if each goal is certainly reached without touching a cell that is ever not free.
static bool has_way(const WgArena *arena, WgSettings *settings, const Scratch *scratch)
{
    memcpy(scratch->ever, arena->cells, (size_t)(arena->width * arena->height));
    for (int64_t k = 0; k < arena->event_count; k++) {
        const WgEvent *event = &arena->events[k];
        if (event->state != WG_FREE) {
            scratch->ever[event->iy * arena->width + event->ix] = WG_SOLID;
        }
    }
    WgGrid ever = {scratch->ever, arena->width, arena->height};
    for (int64_t k = 0; k <= settings->waypoint_count; k++) {
        const WgGoal *goal = goal_of(settings, k);
        WgSegment ends = {settings->start_x, settings->start_y, goal->x, goal->y};
        if (!wg_surely_reaches(ever, wg_disc(settings), ends, goal->radius_sq, scratch->seen, scratch->stack)) {
            return false;
        }
    }
    return true;
}

// Fills the tables that an episode looks up.
static void survey(const WgArena *arena, const WgSettings *settings, const Scratch *scratch)
{
    wg_near_masks(wg_grid(arena), arena->near);
    wg_visit_start(arena, settings);
    if (arena->clearance == NULL) {
        return;
    }
    memcpy(scratch->ever, arena->cells, (size_t)(arena->width * arena->height));
    for (int64_t k = 0; k < arena->event_count; k++) {
        const WgEvent *event = &arena->events[k];
        uint8_t *cell = &scratch->ever[event->iy * arena->width + event->ix];
        *cell = (uint8_t)wg_most(*cell, event->state);
    }
    WgGrid ever = {scratch->ever, arena->width, arena->height};
    wg_chessboard_clearance(ever, arena->clearance);
}

// Returns true if a run has ended as requested.
static bool is_wanted(const WgReport *report, const WgWanted *wanted)
{
    bool overlaps = report->overlap_step >= 0;
    if (wanted->overlap >= 0 && overlaps != (wanted->overlap == 1)) {
        return false;
    }
    if (wanted->ending == WG_ANY_ENDING) {
        return report->ending == WG_LIMIT || report->ending == WG_REACHED || report->ending == WG_LOOP;
    }
    return report->ending == wanted->ending;
}

// Makes an edit, and prepares its run; returns true if the edit is possible.
static bool prepare(const WgArena *arena, WgSettings *settings, const WgSettings *before, WgGrid old,
                    const WgEdit *edit, bool by_way, const Scratch *scratch)
{
    if (!edit_cells(old, arena, edit)) {
        return false;
    }
    *settings = *before;
    if (!move_ends(arena, settings, edit) || !stand(arena, settings)) {
        return false;
    }
    if (edit->kind >= WG_DROP_ROWS && by_way && !has_way(arena, settings, scratch)) {
        return false;
    }
    survey(arena, settings, scratch);
    return true;
}

// Makes the next edit, and begins its run if the edit is possible.
static WgStatus begin_run(WgEpisode *episode, WgSettings *settings, const WgSettings *before, WgGrid old,
                          const WgEdit *edits, const WgWanted *wanted, const Scratch *scratch, WgTried *tried)
{
    const WgEdit *edit = &edits[tried->next++];
    if (!prepare(episode->arena, settings, before, old, edit, wanted->by_way != 0, scratch)) {
        return WG_OK;
    }
    tried->runs++;
    tried->running = 1;
    return wg_episode_begin(episode);
}

static WgStatus try_edits(WgEpisode *episode, WgSettings *settings, const WgSettings *before, WgGrid old,
                          const WgEdit *edits, int64_t count, const WgWanted *wanted, const Scratch *scratch,
                          WgTried *tried)
{
    int64_t left = wanted->steps;
    while (left > 0 && (tried->running != 0 || tried->next < count)) {
        if (tried->running == 0) {
            WgStatus status = begin_run(episode, settings, before, old, edits, wanted, scratch, tried);
            if (status != WG_OK) {
                return status;
            }
            continue;
        }

        // A run that is longer than the remaining steps continues in the next call.
        int64_t earlier = episode->step;
        bool goes_on = wg_episode_run(episode, left) == WG_GOES_ON;
        left -= episode->step - earlier;
        if (goes_on) {
            break;
        }
        tried->running = 0;
        if (is_wanted(&episode->robot.report, wanted)) {
            tried->found = 1;
            break;
        }
    }
    return WG_OK;
}

WgStatus wg_first_edit(WgEpisode *episode, WgSettings *settings, const WgSettings *before, WgGrid old,
                       const WgEdit *edits, int64_t count, const WgWanted *wanted, WgTried *tried)
{
    const WgArena *arena = episode->arena;
    if (settings != episode->settings || tried->next < 0) {
        return WG_BAD_VALUE;
    }
    for (int64_t k = 0; k < count; k++) {
        if (!fits(old, arena, &edits[k])) {
            return WG_BAD_SIZE;
        }
    }
    size_t cells = (size_t)(arena->width * arena->height);
    size_t nodes = (size_t)((2 * arena->width + 1) * (2 * arena->height + 1));
    Scratch scratch = {malloc(cells), malloc(nodes), malloc(nodes * sizeof(int64_t))};
    WgStatus status = WG_OUT_OF_MEMORY;
    if (scratch.ever != NULL && scratch.seen != NULL && scratch.stack != NULL) {
        status = try_edits(episode, settings, before, old, edits, count, wanted, &scratch, tried);
    }
    free(scratch.ever);
    free(scratch.seen);
    free(scratch.stack);
    return status;
}

// Judges a tick of the thesis's robot: walls and flames that it touches, paths through walls, new
// cells.

#include "thesis_judge.h"

static const double LEAST_CROSSING =
    1e-6;  // px; a shorter path through a wall is rounding error that no checker could confirm

// Distance from a point to a cell, px; 0 inside.
static inline double gap(ThesisPoint centre, int64_t cell_x, int64_t cell_y)
{
    double left = (double)cell_x * THESIS_CELL - centre.x;
    double right = centre.x - (double)(cell_x + 1) * THESIS_CELL;
    double above = (double)cell_y * THESIS_CELL - centre.y;
    double below = centre.y - (double)(cell_y + 1) * THESIS_CELL;
    double dx = wg_higher(wg_higher(left, 0.0), right);
    double dy = wg_higher(wg_higher(above, 0.0), below);
    return sqrt(dx * dx + dy * dy);
}

// Returns whether the disc cuts a wall by more than rounding.
static bool overlaps(const ThesisGrid *grid, ThesisPoint centre, double radius)
{
    int64_t own_x = thesis_cell_of(centre.x);
    int64_t own_y = thesis_cell_of(centre.y);
    int64_t last_x = wg_least(own_x + THESIS_REACH, grid->width - 1);
    int64_t last_y = wg_least(own_y + THESIS_REACH, grid->height - 1);
    for (int64_t cell_y = wg_most(own_y - THESIS_REACH, 0); cell_y <= last_y; cell_y++) {
        for (int64_t cell_x = wg_most(own_x - THESIS_REACH, 0); cell_x <= last_x; cell_x++) {
            bool wall = thesis_value(grid, cell_x, cell_y) == WG_THESIS_WALL;
            if (wall && radius - gap(centre, cell_x, cell_y) > LEAST_CROSSING) {
                return true;
            }
        }
    }
    return false;
}

// Ends the run in the flame, or under the debris, of a cell.
static void burn(WgThesisRun *run, int64_t step, int64_t x, int64_t y, int64_t state)
{
    run->ending = WG_BURNED;
    run->hit = (WgThesisPlace){step, x, y, state, -1, 0};
}

void thesis_apply_events(const WgThesisArena *arena, const WgThesisSettings *settings,
                         WgThesisRun *run, int64_t step)
{
    while (run->next_event < arena->event_count && arena->events[run->next_event].step <= step) {
        const WgThesisEvent *event = &arena->events[run->next_event++];
        int64_t cell = event->x * arena->height + event->y;
        int32_t value = arena->light[cell];
        if (event->state == WG_SOLID) {
            value = WG_THESIS_WALL;
        } else if (event->state == WG_BURNING) {
            value = WG_THESIS_FLAME;
        }
        // In the thesis's program, neither a wall that lands on the robot nor one
        // that it enters ends the run.
        bool harms = event->state != WG_SOLID || settings->stop_at_tunnel != 0;
        bool falls = harms && value < 0 && value != arena->cells[cell] && run->ending == WG_LIMIT;
        arena->cells[cell] = value;
        ThesisPoint centre = {run->state.x, run->state.y};
        if (falls && gap(centre, event->x, event->y) < settings->radius) {
            burn(run, step, event->x, event->y, event->state);
        }
    }
}

// Finds what the disc touches at the end of a tick: the deepest cut into a wall, and the first
// flame, which ends the run.
static WgThesisPlace deepest_cut(const ThesisGrid *grid, double radius, WgThesisRun *run,
                                 int64_t step, double *depth)
{
    const ThesisPoint centre = {run->state.x, run->state.y};
    WgThesisPlace deepest = {step, -1, -1, WG_SOLID, -1, 0};
    *depth = 0.0;
    int64_t own_x = thesis_cell_of(centre.x);
    int64_t own_y = thesis_cell_of(centre.y);
    int64_t last_x = wg_least(own_x + THESIS_REACH, grid->width - 1);
    int64_t last_y = wg_least(own_y + THESIS_REACH, grid->height - 1);
    for (int64_t cell_y = wg_most(own_y - THESIS_REACH, 0); cell_y <= last_y; cell_y++) {
        for (int64_t cell_x = wg_most(own_x - THESIS_REACH, 0); cell_x <= last_x; cell_x++) {
            int32_t value = thesis_value(grid, cell_x, cell_y);
            if (value >= 0) {
                continue;
            }
            double cut = radius - gap(centre, cell_x, cell_y);
            if (value == WG_THESIS_WALL) {
                if (cut > *depth) {
                    *depth = cut;
                    deepest.x = cell_x;
                    deepest.y = cell_y;
                }
            } else if (cut > 0.0 && run->ending == WG_LIMIT) {
                burn(run, step, cell_x, cell_y, WG_BURNING);
            }
        }
    }
    return deepest;
}

void thesis_judge_place(const ThesisGrid *grid, uint8_t *visited, const WgThesisSettings *settings,
                        WgThesisRun *run, int64_t step, ThesisPoint before)
{
    double depth = 0.0;
    WgThesisPlace deepest = deepest_cut(grid, settings->radius, run, step, &depth);
    run->deepest = wg_higher(run->deepest, depth);

    // An overlap begins with the move that let the robot in. If the move was not changed by a wall,
    // a corner let it in.
    if (depth <= LEAST_CROSSING) {
        run->overlap_began = -1;
    } else if (run->overlap_began < 0) {
        run->overlap_began = step;
        run->overlap_cause = overlaps(grid, before, settings->radius) ? WG_CORNER : run->state.move;
    }
    if (depth > settings->tolerance && run->overlap.step < 0) {
        deepest.began = run->overlap_began;
        deepest.cause = run->overlap_cause;
        run->overlap = deepest;
    }

    // The centre's own cell: a wall, or newly visited.
    int64_t own_x = thesis_cell_of(run->state.x);
    int64_t own_y = thesis_cell_of(run->state.y);
    if (thesis_value(grid, own_x, own_y) == WG_THESIS_WALL && run->in_wall.step < 0) {
        run->in_wall =
            (WgThesisPlace){step, own_x, own_y, WG_SOLID, run->overlap_began, run->overlap_cause};
    }
    uint8_t *seen = &visited[own_x * grid->height + own_y];
    if (*seen == 0) {
        *seen = 1;
        run->last_new_cell = step;
        run->visited++;
    }
}

// Narrows [enter, leave], shares of a path, to the part between two edges of a cell;
// returns false if there is none.
//
// low: the first edge from the path's start, px; along: length of the path on this axis, px.
static bool clip(double low, double along, double *enter, double *leave)
{
    if (along == 0.0) {
        return low < 0.0 && 0.0 < low + THESIS_CELL;
    }
    double first = low / along;
    double last = (low + THESIS_CELL) / along;
    double earlier = last < first ? last : first;
    double later = last > first ? last : first;
    *enter = wg_higher(*enter, earlier);
    *leave = later < *leave ? later : *leave;
    return true;
}

// Returns the share, 0 to 1, of a straight path that is inside a cell.
//
// Slab test: Ericson, Real-Time Collision Detection (2005), 5.3.3.
static double share_inside(ThesisPoint start, ThesisPoint path, int64_t cell_x, int64_t cell_y)
{
    double enter = 0.0;
    double leave = 1.0;
    bool crosses = clip((double)cell_x * THESIS_CELL - start.x, path.x, &enter, &leave) &&
                   clip((double)cell_y * THESIS_CELL - start.y, path.y, &enter, &leave);
    return crosses ? wg_higher(leave - enter, 0.0) : 0.0;
}

// Finds the first wall that the straight path enters, row by row; step -1 if there is none.
static WgThesisPlace entered_wall(const ThesisGrid *grid, ThesisPoint start, ThesisPoint path,
                                  double length, const WgThesisRun *run, int64_t step)
{
    int64_t own_x = thesis_cell_of(start.x);
    int64_t own_y = thesis_cell_of(start.y);
    int64_t end_x = thesis_cell_of(run->state.x);
    int64_t end_y = thesis_cell_of(run->state.y);
    for (int64_t cell_y = wg_least(own_y, end_y); cell_y <= wg_most(own_y, end_y); cell_y++) {
        for (int64_t cell_x = wg_least(own_x, end_x); cell_x <= wg_most(own_x, end_x); cell_x++) {
            if (thesis_value(grid, cell_x, cell_y) != WG_THESIS_WALL) {
                continue;
            }
            if (share_inside(start, path, cell_x, cell_y) * length > LEAST_CROSSING) {
                return (WgThesisPlace){
                    step, cell_x, cell_y, WG_SOLID, run->overlap_began, run->overlap_cause};
            }
        }
    }
    return (WgThesisPlace){-1, 0, 0, WG_FREE, -1, 0};
}

void thesis_judge_path(const ThesisGrid *grid, const WgThesisSettings *settings, WgThesisRun *run,
                       int64_t step, ThesisPoint start)
{
    const ThesisPoint path = {run->state.x - start.x, run->state.y - start.y};
    double length = sqrt(path.x * path.x + path.y * path.y);
    run->path_length += length;
    if (run->tunnel.step >= 0) {
        return;
    }
    run->tunnel = entered_wall(grid, start, path, length, run, step);
    if (settings->stop_at_tunnel != 0 && run->tunnel.step >= 0 && run->ending == WG_LIMIT) {
        run->ending = WG_TUNNEL;
    }
}

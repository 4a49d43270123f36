// What a seat does in addition to running a controller; looks.h describes it.

#include "looks.h"

#include <string.h>

#include "step.h"

enum {
    SLACK = 20, // lattice units: a wall at most this far beyond the disc's edge counts as touched
    NEXT = 0x39CE << (2 * WG_NEAR + 1), // bits of a mask: a cell and the eight cells around it
};

// Returns an upper bound of a step's length, lattice units.
static int64_t fastest(const WgSettings *settings)
{
    return (int64_t)(settings->top_speed * settings->speed) + 1;
}

// Returns the number of the robot's radius: a scene sets it, a layout has only one.
static int64_t radius_of(const WgLooks *looks, const uint8_t *bytes)
{
    return looks->layout_bytes == WG_SCENE_BYTES ? bytes[WG_LAYOUT_BYTES] % looks->radius_count : 0;
}

// Fills in the settings of a run, without its budget.
static void set_up(const WgLooks *looks, const WgPlaces *places, int64_t run, WgSettings *settings)
{
    const uint8_t *bytes = looks->layouts + run * looks->layout_bytes;
    *settings = looks->settings[looks->kinds[run]];
    settings->start_x = places->start_x * WG_UNIT + WG_UNIT / 2;
    settings->start_y = places->start_y * WG_UNIT + WG_UNIT / 2;
    settings->target.x = places->target_x * WG_UNIT + WG_UNIT / 2;
    settings->target.y = places->target_y * WG_UNIT + WG_UNIT / 2;

    // A scene also sets the target's radius and a finer heading.
    int64_t heading = (int64_t)WG_FINER_HEADINGS * (bytes[4] % WG_LAYOUT_HEADINGS);
    int64_t radius = radius_of(looks, bytes);
    int64_t target = 0;
    if (looks->layout_bytes == WG_SCENE_BYTES) {
        target = bytes[WG_LAYOUT_BYTES + 1] % looks->target_count;
        heading += bytes[WG_LAYOUT_BYTES + 2] % WG_FINER_HEADINGS;
    }
    settings->start_heading = heading * (WG_TURN / (WG_LAYOUT_HEADINGS * WG_FINER_HEADINGS));
    // All scenes of a body are about that body.
    if (settings->footprint.count == 0) {
        settings->clear_sq = looks->discs[radius].clear_sq;
        settings->reach = looks->discs[radius].reach;
        settings->radius = looks->radii[radius];
    }
    settings->target.radius_sq = looks->targets[target];
    settings->seed = looks->seeds[run];
}

// Returns the reach of the disc for which the path of a run must be wide enough.
static int64_t flood_reach(const WgLooks *looks, const uint8_t *bytes)
{
    return looks->flood_reach > 0 ? looks->flood_reach : looks->discs[radius_of(looks, bytes)].reach;
}

static int64_t own_budget(const WgPatience *patience, const WgSettings *settings, int64_t distance)
{
    int64_t by_path = patience->multiple * distance * WG_UNIT / fastest(settings);
    return wg_least(wg_most(by_path, patience->fewest), patience->most);
}

// Draws a layout, and notes everything about its world that does not need a run, for a robot of
// this reach.
static WgPlaces note_world(const uint8_t *layout, int64_t reach, uint64_t solid[WG_ROWS], WgLook *look)
{
    WgPlaces places = wg_layout_places(layout);
    wg_layout_draw(layout, solid);
    memset(look, 0, sizeof *look);
    look->report.ending = WG_NOT_RUN;
    look->report.hit_step = -1;
    look->report.overlap_step = -1;
    look->around = -1;
    int64_t dx = places.target_x - places.start_x;
    int64_t dy = places.target_y - places.start_y;
    look->straight_sq = dx * dx + dy * dy;
    look->width = places.width;
    look->height = places.height;
    int64_t length = wg_layout_distance(&places, solid, reach);
    look->distance = length >= 0 ? length + 2 : -1;
    return places;
}

bool wg_look_open(WgSeat *seat, int64_t run)
{
    const WgLooks *looks = seat->looks;
    WgSettings *settings = seat->settings;
    WgArena *arena = seat->arena;
    WgLook *look = &looks->looks[run];
    uint64_t solid[WG_ROWS];
    const uint8_t *bytes = looks->layouts + run * looks->layout_bytes;
    WgPlaces places = note_world(bytes, flood_reach(looks, bytes), solid, look);
    if (look->distance < 0) {
        return false;
    }
    set_up(looks, &places, run, settings);
    int64_t budget = looks->budgets[run];
    settings->steps = budget > 0 ? budget : own_budget(&looks->patience, settings, look->distance);
    look->budget = settings->steps;
    arena->width = places.width;
    arena->height = places.height;
    look->solid = wg_layout_fill(solid, arena);
    if (settings->footprint.count > 0
        && !wg_robot_is_clear(wg_grid(arena), WG_SOLID, arena->headings, settings, settings->start_x,
                              settings->start_y, settings->start_heading)) {
        look->distance = -1;
        return false;
    }
    arena->visited[places.start_y * places.width + places.start_x] = 1;

    // If the masks reach as far as a step, a run needs no table of distances.
    arena->clearance = NULL;
    if (settings->reach + fastest(settings) > (int64_t)WG_NEAR * WG_UNIT) {
        wg_chessboard_clearance(wg_grid(arena), seat->clearance);
        arena->clearance = seat->clearance;
    }

    // A table lets beams skip free cells: screening with 36 beams takes a quarter less time.
    arena->runs = NULL;
    if (settings->senses & WG_SENSE_BEAMS) {
        wg_beam_spread(settings->beams, settings->beam_field, seat->spread);
        wg_free_runs(wg_grid(arena), seat->runs); // cannot fail, because a layout is small
        arena->spread = seat->spread;
        arena->runs = seat->runs;
    }
    return true;
}

// Counts the cells that the robot visited, and adds up how close they are to solid ones.
static void note_path(const WgArena *arena, WgLook *look)
{
    for (int64_t cell = 0; cell < arena->width * arena->height; cell++) {
        if (arena->visited[cell] == 0) {
            continue;
        }
        int32_t mask = arena->near[cell];
        int64_t clearance = WG_FAR;
        if (mask != 0) {
            clearance = (mask & NEXT) != 0 ? 1 : 2;
        }
        look->visited++;
        look->clearances += clearance;
    }
}

// Returns the number of solid cells among the four that share an edge with a cell.
static int64_t solid_beside(WgGrid grid, int64_t ix, int64_t iy)
{
    return (wg_cell_state(grid, ix + 1, iy) == WG_SOLID) + (wg_cell_state(grid, ix - 1, iy) == WG_SOLID) +
           (wg_cell_state(grid, ix, iy + 1) == WG_SOLID) + (wg_cell_state(grid, ix, iy - 1) == WG_SOLID);
}

// Notes the kind of wall that the robot went through or into, or touched although it may not.
static void note_wall(const WgArena *arena, WgLook *look)
{
    const WgReport *report = &look->report;
    if (report->ending == WG_TUNNEL || report->ending == WG_CONTACT) {
        look->around = solid_beside(wg_grid(arena), report->hit_ix, report->hit_iy);
    } else if (report->overlap_step >= 0) {
        look->around = solid_beside(wg_grid(arena), report->overlap_ix, report->overlap_iy);
    }
}

void wg_look_close(WgSeat *seat)
{
    WgLook *look = &seat->looks->looks[seat->run];
    look->report = seat->episode->robot.report;
    note_path(seat->arena, look);
    note_wall(seat->arena, look);
}

// Returns the kind of wall that a robot touches, judging by the solid cells next to it.
static int64_t contact_of(const WgArena *arena, const WgSettings *settings, const WgState *state)
{
    WgGrid grid = wg_grid(arena);
    int64_t reach = settings->reach;
    int64_t x = state->x;
    int64_t y = state->y;
    int64_t farthest = (reach + SLACK) * (reach + SLACK);
    int across = 0; // bits: right, left
    int along = 0;  // bits: above, below
    bool aslant = false;
    int64_t fewest = 4;
    for (int64_t iy = wg_cell_of(y - reach - SLACK); iy <= wg_cell_of(y + reach + SLACK); iy++) {
        for (int64_t ix = wg_cell_of(x - reach - SLACK); ix <= wg_cell_of(x + reach + SLACK); ix++) {
            bool touches = wg_cell_state(grid, ix, iy) == WG_SOLID &&
                           wg_point_box_distance_sq(x, y, ix, iy) <= farthest &&
                           (settings->footprint.count == 0 ||
                            wg_body_gap(arena->headings, &settings->footprint, x, y, state->heading, ix, iy) <= SLACK);
            if (!touches) {
                continue;
            }
            fewest = wg_least(fewest, solid_beside(grid, ix, iy));
            bool beside_x = ix * WG_UNIT > x || (ix + 1) * WG_UNIT < x;
            bool beside_y = iy * WG_UNIT > y || (iy + 1) * WG_UNIT < y;
            if (beside_x && beside_y) {
                aslant = true;
            } else if (beside_x) {
                across |= ix * WG_UNIT > x ? 1 : 2;
            } else {
                along |= iy * WG_UNIT > y ? 1 : 2;
            }
        }
    }
    if ((across != 0 && along != 0) || across == 3 || along == 3) {
        return WG_NOOK;
    }
    if (fewest <= 1) {
        return fewest == 0 ? WG_POST : WG_END;
    }
    return aslant && across == 0 && along == 0 ? WG_EDGE : WG_FACE;
}

void wg_look_watch(WgSeat *seat)
{
    WgLook *look = &seat->looks->looks[seat->run];
    WgRobot *robot = &seat->episode->robot;
    const WgState *state = &robot->body->state;
    look->left = state->x;
    look->right = state->x;
    look->low = state->y;
    look->high = state->y;
    look->contact = WG_NO_CONTACT;
    robot->report.ending = WG_LIMIT;
    seat->touched = robot->touched;
    bool loops = look->report.ending == WG_LOOP;
    seat->watch = loops ? look->report.period : seat->looks->patience.watched;
}

bool wg_look_goes_on(WgSeat *seat)
{
    const WgLook *look = &seat->looks->looks[seat->run];
    const WgRobot *robot = &seat->episode->robot;
    seat->heading = robot->body->state.heading;
    return look->watched < seat->watch && robot->report.ending == WG_LIMIT &&
           wg_is_inside(seat->arena, &robot->body->state);
}

void wg_look_note_step(WgSeat *seat)
{
    WgLook *look = &seat->looks->looks[seat->run];
    const WgSettings *settings = seat->settings;
    const WgState *state = &seat->episode->robot.body->state;
    look->watched++;
    bool touches = seat->episode->workspace.observation.bump != 0.0;
    if (touches && seat->touched == 0) {
        look->bumps++;
        int64_t contact = contact_of(seat->arena, settings, state);
        look->contact = wg_least(look->contact, contact);
    }
    seat->touched = touches;
    int64_t dx = state->x - settings->target.x;
    int64_t dy = state->y - settings->target.y;
    if (dx * dx + dy * dy < look->straight_sq * WG_UNIT * WG_UNIT) {
        look->closer = 1;
    }
    look->turned += wg_turn_towards(seat->heading, state->heading);
    look->left = wg_least(look->left, state->x);
    look->right = wg_most(look->right, state->x);
    look->low = wg_least(look->low, state->y);
    look->high = wg_most(look->high, state->y);
}

int64_t wg_look_draw(const uint8_t *layout, WgSeat *seat, WgLook *look)
{
    uint64_t solid[WG_ROWS];
    WgPlaces places = note_world(layout, seat->looks->discs[0].reach, solid, look);
    seat->arena->width = places.width;
    seat->arena->height = places.height;
    return wg_layout_fill(solid, seat->arena);
}

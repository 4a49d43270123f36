// Range beams: many rays from one place, in a world that does not change.
//
// Amanatides and Woo's walk visits every cell. Here a ray moves from lane to lane: along rows of
// cells if it runs more along x than along y, otherwise along columns. A table gives how far the
// lane is free beyond the ray's entry, so the ray either leaves the lane before that, or hits the
// face there. All rays of an eighth of a turn share their first lane, and a second table holds the
// directions. In a maze this takes 10 ns per beam; the walk takes 30.
//
// The result equals the walk's to the last bit: the distance is the same exact difference divided
// by the same direction. The point where a ray leaves its lane is known to 1/32 of a lattice unit,
// so a ray that passes a corner that closely is left to the walk.

#include <math.h>
#include <string.h>

#include "rays.h"
#include "sense.h"

enum {
    PORTION = 64,        // beams that are processed together
    FRACTION_BITS = 32,  // fractional bits of a place along a lane, in lattice units
    CELL_BITS = FRACTION_BITS + WG_UNIT_BITS,
    MOST_CELLS = 65535,  // limit on a side of the grid
    EIGHTH = WG_TURN / 8,
};

// What follows a cell in a table of wg_free_runs.
enum { RIGHT = 0, LEFT = 1, UP = 2, DOWN = 3, DIRECTIONS = 4 };

// How far a ray may pass a corner, and the exit of a ray that never leaves its lane.
static const int64_t CLOSE = INT64_C(1) << (FRACTION_BITS - 5);
static const int64_t NEVER = (INT64_C(1) << 60) + (INT64_C(1) << (CELL_BITS - 1));

// The origin of the rays, on one axis as seen in one direction. An origin on the line between two
// cells belongs to the cell ahead.
typedef struct Side {
    int64_t cell;  // its cell's index in the table
    int64_t past;  // lattice units from the near side of that cell to the place
    int64_t step;  // from a cell to the next one, in the table
} Side;

// Values shared by the rays of an eighth of a turn; they run more along their lane than across it.
typedef struct Octant {
    const uint16_t *lane;  // where they begin, in the table
    int64_t run;           // the table's entry there
    int64_t ahead;         // to the next cell of the lane
    int64_t aside;         // to the next lane
    // lattice units from the near sides of the first cell to the place: along the lane, across it
    int64_t past[2];
} Octant;

// A distance, not yet divided.
typedef struct Hit {
    int64_t length;  // along the lane or across it, lattice units; -1 if the walk must decide
    int which;       // index into WgRay.share: the direction on that axis
} Hit;

void wg_ray_table(const int64_t *headings, WgRay *rays)
{
    for (int64_t k = 0; k <= EIGHTH; k++) {
        double along = wg_cosine(headings, k);
        double across = wg_sine(headings, k);
        int64_t slope = k == 0 ? 0 : (int64_t)(along / across * 0x1p32);
        rays[k] = (WgRay){{along, across}, slope};
    }
}

void wg_beam_spread(int64_t beams, double field, int64_t *spread)
{
    for (int64_t beam = 0; beam < beams; beam++) {
        spread[beam] = wg_beam_heading(0, beam, beams, field);
    }
}

WgStatus wg_free_runs(WgGrid grid, uint16_t *runs)
{
    if (grid.width > MOST_CELLS || grid.height > MOST_CELLS) {
        return WG_BAD_SIZE;
    }
    int64_t stride = (grid.width + 2) * DIRECTIONS;
    memset(runs, 0, (size_t)(stride * (grid.height + 2)) * sizeof *runs);
    for (int64_t iy = 0; iy < grid.height; iy++) {
        for (int64_t ix = 0; ix < grid.width; ix++) {
            uint16_t *at = runs + (iy + 1) * stride + (ix + 1) * DIRECTIONS;
            if (grid.cells[iy * grid.width + ix] != WG_SOLID) {
                at[LEFT] = (uint16_t)(at[LEFT - DIRECTIONS] + 1);
                at[DOWN] = (uint16_t)(at[DOWN - stride] + 1);
            }
        }
    }
    for (int64_t iy = grid.height - 1; iy >= 0; iy--) {
        for (int64_t ix = grid.width - 1; ix >= 0; ix--) {
            uint16_t *at = runs + (iy + 1) * stride + (ix + 1) * DIRECTIONS;
            if (grid.cells[iy * grid.width + ix] != WG_SOLID) {
                at[RIGHT] = (uint16_t)(at[RIGHT + DIRECTIONS] + 1);
                at[UP] = (uint16_t)(at[UP + stride] + 1);
            }
        }
    }
    return WG_OK;
}

// One axis as seen by rays towards greater coordinates (mirror 0) or lesser ones (-1).
static Side seen_from(int64_t place, int64_t mirror, int64_t step)
{
    int64_t mirrored = (place ^ mirror) - mirror;
    return (Side){
        .cell = ((wg_cell_of(mirrored) ^ mirror) + 1) * step,
        .past = mirrored & (WG_UNIT - 1),
        .step = (step ^ mirror) - mirror,
    };
}

// The eight octants of a place, counter-clockwise from the x axis.
static void fill_octants(const WgArena *arena, const WgState *state, Octant *octants)
{
    static const int lanes[8] = {RIGHT, UP, UP, LEFT, LEFT, DOWN, DOWN, RIGHT};
    static const int asides[8] = {UP, RIGHT, LEFT, UP, DOWN, LEFT, RIGHT, DOWN};

    int64_t stride = (arena->width + 2) * DIRECTIONS;
    Side sides[DIRECTIONS];
    sides[RIGHT] = seen_from(state->x, 0, DIRECTIONS);
    sides[LEFT] = seen_from(state->x, -1, DIRECTIONS);
    sides[UP] = seen_from(state->y, 0, stride);
    sides[DOWN] = seen_from(state->y, -1, stride);
    for (int k = 0; k < 8; k++) {
        Side ahead = sides[lanes[k]];
        Side aside = sides[asides[k]];
        const uint16_t *lane = arena->runs + ahead.cell + aside.cell + lanes[k];
        octants[k] = (Octant){lane, *lane, ahead.step, aside.step, {ahead.past, aside.past}};
    }
}

// Returns where a ray hits something, or after how many cells of its lane it exceeds its range.
static inline Hit follow(const Octant *octant, int64_t slope, int64_t most)
{
    const Hit unsure = {-1, 0};
    const int64_t cell_mask = (INT64_C(1) << CELL_BITS) - 1;

    int64_t position = (octant->past[0] << FRACTION_BITS) + (WG_UNIT - octant->past[1]) * slope;
    if (slope == 0) {
        position = NEVER;
    }
    const uint16_t *lane = octant->lane;
    int64_t wall = wg_least(octant->run, most);
    for (int64_t lanes = 1;; lanes++) {
        if (((position + CLOSE) & cell_mask) <= 2 * CLOSE) {
            return unsure;
        }
        // Check the end of the lane first; the walk handles a first cell that is itself solid.
        int64_t cell = position >> CELL_BITS;
        if (cell >= wall) {
            return wall == 0 ? unsure : (Hit){wall * WG_UNIT - octant->past[0], 0};
        }
        // Enter the next lane, which may have a wall at the ray's entry.
        lane += octant->aside;
        int64_t run = lane[cell * octant->ahead];
        if (run == 0) {
            return (Hit){lanes * WG_UNIT - octant->past[1], 1};
        }
        wall = wg_least(cell + run, most);
        position += slope << WG_UNIT_BITS;
    }
}

// Returns the eighth of a turn that contains a heading. An axis belongs to the octant that sees the
// other axis unmirrored, as in the walk.
static inline int64_t octant_of(int64_t heading)
{
    bool is_below_last_axis = 0 < heading && heading < 6 * EIGHTH;
    return (heading - is_below_last_axis) / EIGHTH;
}

// Fills the distances of `count` beams starting at `first`, lattice units.
static void measure(const WgArena *arena, const WgSettings *settings, const WgState *state, const Octant *octants,
                    int64_t first, int64_t count, double *distances)
{
    int64_t headings[PORTION];
    double lengths[PORTION];
    double shares[PORTION];
    double longest = settings->beam_range;
    const double unit = WG_UNIT;
    int64_t most = wg_ceil(wg_lower(longest, (double)MOST_CELLS * unit) / unit) + 2;

    for (int64_t k = 0; k < count; k++) {
        headings[k] = state->heading + arena->spread[first + k];
    }
    for (int64_t k = 0; k < count; k++) {
        int64_t heading = wg_reduced_heading(headings[k]);
        int64_t eighth = octant_of(heading);
        int64_t angle = (eighth & 1) != 0 ? (eighth + 1) * EIGHTH - heading : heading - eighth * EIGHTH;
        const WgRay *ray = &arena->rays[angle];
        Hit hit = follow(&octants[eighth], ray->slope, most);
        lengths[k] = (double)hit.length;
        shares[k] = ray->share[hit.which];
    }
    // These divisions do not depend on each other.
    for (int64_t k = 0; k < count; k++) {
        distances[k] = lengths[k] < 0.0 ? wg_ray_distance(wg_grid(arena), arena->headings, state->x, state->y,
                                                          headings[k], longest)
                                        : wg_lower(lengths[k] / shares[k], longest);
    }
}

// Shortens the beams that hit other robots.
//
// Source: ray against sphere, Ericson, Real-Time Collision Detection (2005), 5.3.2.
static void meet_others(const WgArena *arena, const WgSettings *settings, const WgState *state, double *beams)
{
    const WgOthers *others = arena->others;
    for (int64_t beam = 0; beam < settings->beams; beam++) {
        int64_t heading = wg_beam_heading(state->heading, beam, settings->beams, settings->beam_field);
        double along = wg_cosine(arena->headings, heading);
        double across = wg_sine(arena->headings, heading);
        for (int64_t k = 0; k < others->count; k++) {
            const WgOther *other = &others->robots[k];
            double dx = (double)(other->x - state->x);
            double dy = (double)(other->y - state->y);
            double ahead = dx * along + dy * across;
            double inside = ahead * ahead - (dx * dx + dy * dy - other->radius * other->radius);
            if (ahead > 0.0 && inside >= 0.0) {
                beams[beam] = wg_lower(beams[beam], wg_higher(0.0, ahead - sqrt(inside)));
            }
        }
    }
}

// Applies noise to a distance.
static double disturbed(const WgSettings *settings, int64_t step, int64_t beam, double distance)
{
    if (settings->beam_noise > 0.0) {
        double wrong = 2.0 * wg_noise_draw(settings, wg_noise_channel(step, WG_NOISE_BEAMS + beam)) - 1.0;
        distance = wg_lower(distance * (1.0 + settings->beam_noise * wrong), settings->beam_range);
    }
    if (settings->beam_dropout > 0.0) {
        double drawn = wg_noise_draw(settings, wg_noise_channel(step, 2 * WG_NOISE_BEAMS + beam));
        if (drawn < settings->beam_dropout) {
            distance = settings->beam_range;
        }
    }
    return distance;
}

void wg_sense_beams(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t step,
                    double *beams)
{
    // The tables cover places in the grid, including its border.
    bool is_inside = 0 <= state->x && state->x <= arena->width * WG_UNIT && 0 <= state->y &&
                     state->y <= arena->height * WG_UNIT;
    if (arena->runs != NULL && is_inside) {
        Octant octants[8];
        fill_octants(arena, state, octants);
        for (int64_t first = 0; first < settings->beams; first += PORTION) {
            int64_t count = wg_least(settings->beams - first, PORTION);
            measure(arena, settings, state, octants, first, count, beams + first);
        }
    } else {
        for (int64_t beam = 0; beam < settings->beams; beam++) {
            int64_t heading = wg_beam_heading(state->heading, beam, settings->beams, settings->beam_field);
            beams[beam] = wg_ray_distance(wg_grid(arena), arena->headings, state->x, state->y, heading,
                                          settings->beam_range);
        }
    }
    if (arena->others != NULL) {
        meet_others(arena, settings, state, beams);
    }
    if (settings->beam_noise > 0.0 || settings->beam_dropout > 0.0) {
        for (int64_t beam = 0; beam < settings->beams; beam++) {
            beams[beam] = disturbed(settings, step, beam, beams[beam]);
        }
    }
    for (int64_t beam = 0; beam < settings->beams; beam++) {
        beams[beam] *= settings->metres;
    }
}

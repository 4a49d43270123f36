// The parts of a step on the lattice, and the tables it looks up, for tests and for callers that
// need one part alone. Sizes are not checked here: the callers in Python check them.
//
// Coordinates are lattice units. Cells outside the grid are solid.

#ifndef WG_PARTS_H
#define WG_PARTS_H

#include <stdbool.h>
#include <stdint.h>

#include "wg_episode.h"
#include "wg_sim.h"

typedef struct WgGrid {
    const uint8_t *cells;  // (height, width) WG_FREE, WG_SOLID or WG_BURNING
    int64_t width;
    int64_t height;
} WgGrid;

typedef struct WgDisc {
    int64_t clear_sq;  // squared distance to keep
    int64_t reach;     // its root, rounded up
} WgDisc;

// A straight piece of a path, from p to q.
typedef struct WgSegment {
    int64_t px;
    int64_t py;
    int64_t qx;
    int64_t qy;
} WgSegment;

typedef struct WgVector {
    int64_t x;
    int64_t y;
} WgVector;

// A cell found by a search.
typedef struct WgFound {
    bool found;
    int64_t ix;
    int64_t iy;
} WgFound;

// What stops a turn: a cell, and the direction away from it.
typedef struct WgStopped {
    WgFound cell;
    WgNormal away;
} WgStopped;

// The progress of a move.
typedef struct WgMoved {
    int64_t count;  // corners of the path then
    WgNormal contact;
} WgMoved;

// geometry.c

// Fills `near` with the cells that are not free among the 25 around each cell: bits in rows from
// the lowest.
void wg_near_masks(WgGrid grid, int32_t *near);

// Updates the masks of the cells around a cell with its new state.
void wg_mark_near(WgGrid grid, int32_t *near, int64_t ix, int64_t iy);

// Fills `clearance` with the chessboard distance, in cells,
// from each cell to the nearest one that is not free.
//
// A point in a cell with distance D is at least D - 1 cells away from every such cell, so most
// steps need no test of their path. It needs two passes: Rosenfeld and Pfaltz, "Sequential
// operations in digital picture processing" (1966).
void wg_chessboard_clearance(WgGrid grid, int32_t *clearance);

// Returns true if the disc at (x, y) is clear of every cell in `state`.
bool wg_disc_is_clear(WgGrid grid, int state, WgDisc disc, int64_t x, int64_t y);

// The first cell in `state`, in row order, that the disc cuts along a segment whose first end is
// assumed to be clear.
WgFound wg_first_not_clear(WgGrid grid, int state, WgDisc disc, WgSegment way);

// Returns true if a segment, or a point if p = q, meets the open inside of a cell.
bool wg_segment_crosses_box(WgSegment way, int64_t ix, int64_t iy);

// Returns how deep a disc of a radius cuts a cell along a segment; 0 if it does not. If the centre
// is inside the cell, the cut is the whole radius deep.
double wg_segment_box_depth(double radius, WgSegment way, int64_t ix, int64_t iy);

// polygon.c

// Returns true if a body at a pose is clear of every cell in `state`: its inside meets the inside of
// none.
bool wg_body_is_clear(WgGrid grid, int state, const int64_t *headings, const WgFootprint *footprint, int64_t x,
                      int64_t y, int64_t heading);

// The first cell in `state`, in row order, that a body cuts while it moves along a segment at a
// heading.
WgFound wg_body_first_not_clear(WgGrid grid, int state, const int64_t *headings, const WgFootprint *footprint,
                                WgSegment way, int64_t heading);

// The solid cell that stops a body at (x, y): of those that it would cut on a way, the nearest.
WgFound wg_body_stopping_cell(WgGrid grid, const int64_t *headings, const WgFootprint *footprint, int64_t x, int64_t y,
                              WgSegment way, int64_t heading);

// Returns the widest gap between a body at a pose and a cell along an axis that may separate them, lattice units:
// at most their distance; negative if they overlap.
double wg_body_gap(const int64_t *headings, const WgFootprint *footprint, int64_t x, int64_t y, int64_t heading,
                   int64_t ix, int64_t iy);

// Returns how deep a body cuts a cell while it moves along a segment at a heading, lattice units: the
// shortest way in which the hull of the move could be shifted out of the cell. 0 if it does not.
double wg_body_depth(const int64_t *headings, const WgFootprint *footprint, WgSegment way, int64_t heading, int64_t ix,
                     int64_t iy);

// Turns a body on the spot, through every heading on the way, as far as it is clear of every cell in `state`.
//
// heading:  the body is clear there.
// turn:     heading units, less than half a turn.
// stopped:  the cell that stops it, and the direction away from it, if one does.
//
// Returns how far it turns.
int64_t wg_clear_turn(WgGrid grid, int state, const int64_t *headings, const WgFootprint *footprint, int64_t x,
                      int64_t y, int64_t heading, int64_t turn, WgStopped *stopped);

// Returns true if a robot, a disc or a body, is clear of every cell in `state` at a pose.
bool wg_robot_is_clear(WgGrid grid, int state, const int64_t *headings, const WgSettings *settings, int64_t x,
                       int64_t y, int64_t heading);

// The first cell in `state`, in row order, that a robot cuts along a segment whose first end is assumed to be
// clear.
WgFound wg_robot_first_not_clear(WgGrid grid, int state, const int64_t *headings, const WgSettings *settings,
                                 WgSegment way, int64_t heading);

// motion.c

// Moves a body, stopping at walls and sliding along them, like wg_swept_move().
WgMoved wg_swept_body_move(WgGrid grid, const int64_t *headings, const WgFootprint *footprint, int64_t heading,
                           WgSegment way, double begin, double end, double wall_friction, WgCorner *chain,
                           int64_t count);

// Moves a disc, stopping at walls and sliding along them.
//
// way:            p is a clear pose; q is where the move leads if there is no obstacle.
// begin, end: when the move begins and ends, as fractions of the step. wall_friction: fraction of a
// slide that is lost to the wall, 0 to 1.
// chain:          the clear lattice points of the path after its start follow
//                 from `count` on, WG_MOST_CORNERS at most.
WgMoved wg_swept_move(WgGrid grid, WgDisc disc, WgSegment way, double begin, double end, double wall_friction,
                      WgCorner *chain, int64_t count);

// Moves a disc if it is clear at the end of the move, otherwise not at all. Everything in between
// is ignored, as in most small simulators: a fast robot passes through walls.
WgMoved wg_endpoint_move(WgGrid grid, WgDisc disc, WgSegment way, WgCorner *chain, int64_t count);

// The same for a body.
WgMoved wg_endpoint_body_move(WgGrid grid, const int64_t *headings, const WgFootprint *footprint, int64_t heading,
                              WgSegment way, WgCorner *chain, int64_t count);

// rays.c

// Returns the distance from a place to the first solid cell in a direction;
// `longest` if that is nearer.
//
// A ray that runs along a face, or past a single corner, continues; between two cells that touch at
// a corner it does not. Each distance is one exact difference divided by a direction,
// so errors do not add up.
//
// headings:  the table of wg_heading_table.
//
// Source: John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing",
// Eurographics 1987.
double wg_ray_distance(WgGrid grid, const int64_t *headings, int64_t x, int64_t y, int64_t heading, double longest);

// Returns the number of solid cells that the straight line between two places passes through, not
// counting its ends' cells.
int64_t wg_walls_on_the_way(WgGrid grid, int64_t x, int64_t y, int64_t to_x, int64_t to_y);

// Returns the number of cells on the straight line between two places that are in smoke, including
// its ends' cells. Smoke fills `reach` cells around a burning one.
int64_t wg_smoke_on_the_way(WgGrid grid, int64_t x, int64_t y, int64_t to_x, int64_t to_y, int64_t reach);

// beams.c: tables that range beams look up in a world that does not change

// Fills (8193,): the directions of the first eighth of a turn.
void wg_ray_table(const int64_t *headings, WgRay *rays);

// Fills (beams,): the direction of each beam, relative to the robot's heading. It saves a tenth of
// a beam's time.
void wg_beam_spread(int64_t beams, double field, int64_t *spread);

// Fills (height + 2, width + 2, 4): the number of consecutive cells, starting with this one, that
// are not solid, to the right, to the left, upwards and downwards; a ring of zeros surrounds the
// grid. No side may be above 65535.
WgStatus wg_free_runs(WgGrid grid, uint16_t *runs);

// sense.c

// Fills (2 * WG_TURN,): the cosine of every heading times 2^30, rounded, exactly symmetric under
// quarter turns and mirrors; then what this rounding left over, times 2^60. No value is near enough
// to a half for two good mathematics libraries to round it differently.
void wg_heading_table(int64_t *table);

// Heading, in units, of the vector (dx, dy); `otherwise` for the zero vector.
// It has every mirror symmetry exactly.
int64_t wg_heading_of(int64_t dx, int64_t dy, int64_t otherwise);

// Heading to the strongest of the nine cells around the robot: to its centre,
// or to the target in it.
//
// This is the thesis's sensor: a cell's strength falls with the squared distance of its centre from
// the target (the target's own cell is the strongest), walls and flames carry none, and the first
// wins a tie, rows from the top, columns from the left. In the thesis the target is a cell's
// centre; here it may be anywhere.
int64_t wg_signal_heading(WgGrid grid, int64_t x, int64_t y, int64_t target_x, int64_t target_y, int64_t heading);

// sure_way.c

// Returns true if a flood over half cells gets from the start into the target's disc. False proves
// nothing.
//
// grid:       WG_SOLID where the robot never goes.
// way:        p is the start, q the target.
// within_sq:  squared radius of the target.
// seen:       (2 height + 1, 2 width + 1), used; stack: as many numbers, used.
bool wg_surely_reaches(WgGrid grid, WgDisc disc, WgSegment way, int64_t within_sq, uint8_t *seen, int64_t *stack);

// parts.c: functions of internal headers

// Displacement of a drive, rounded to the nearest lattice point, halves away from zero.
WgVector wg_drive_displacement(const int64_t *headings, int64_t heading, int64_t distance);

// Returns true if the masks of an arena show that every cell in the box around a disc's path is
// free; false proves nothing.
bool wg_box_of_path_is_free(const WgArena *arena, int64_t reach, WgSegment way);

// Draw number `index`, from 0, of the stream of a seed, in [0, 1).
double wg_draw_of_stream(uint64_t seed, int64_t index);

// World heading of a beam.
int64_t wg_heading_of_beam(int64_t heading, int64_t beam, int64_t beams, double field);

// Fills the senses in WgSettings.senses, and those that are always there; not the constants.
//
// contact:  normal of the robot's last contact.
// step:     its number.
// beams:    (settings->beams,), filled if they are among the senses.
void wg_sense_at(const WgArena *arena, const WgSettings *settings, const WgState *state, const WgOdometry *odometry,
                 WgNormal contact, int64_t step, WgObservation *observation, double *beams);

#endif

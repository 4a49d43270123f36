// The motion model `stepped`: the thesis's own simulator.
//
// Its frame: pixels, y down, ten pixels per cell; heading 0 is -x, pi/2 is -y (up), and headings
// grow clockwise on the screen; milliseconds. Cells are stored column by column: cells[x * height +
// y]. The border must be WG_THESIS_WALL. Arrays belong to the caller, and no function keeps an
// address after it returns.

#ifndef WG_THESIS_H
#define WG_THESIS_H

#include <stdint.h>

#include "wg_episode.h"
#include "wg_sim.h"

// Cells that carry no signal. The others hold the squared distance in cells to the target's cell,
// which has 0, as modified by the noise filter.
enum {
    WG_THESIS_WALL = -2,  // as in the thesis's map files
    WG_THESIS_FLAME = -3, // does not stop the robot; the thesis has no fire
};

// An ending in addition to those of wg_sim.h: the draws ran out; append some and call again.
enum { WG_NEEDS_DRAWS = 6 };

// Rules: how the robot turns after a collision.
enum { WG_RULE_ADD = 1, WG_RULE_SUBTRACT = 2, WG_RULE_RANDOM = 3 };

// How a tick's move ends: as it began; sliding; backing off, or staying in place if that is
// repaired; and, in place of WG_STRAIGHT, having continued past a corner that it touched.
enum { WG_STRAIGHT = 0, WG_SLIDE = 1, WG_BACK_OFF = 2, WG_CORNER = 3 };

// Faults of the motion that can be repaired: bits of WgThesisSettings.repairs.
enum { WG_REPAIR_SLIDE = 1, WG_REPAIR_BACK_OFF = 2, WG_REPAIR_CORNER = 4 };

// The robot, and the settings of the run.
typedef struct WgThesisSettings {
    int64_t rule;           // WG_RULE_ADD, ...
    int64_t sense;          // reach of the signal sensor, cells
    int64_t collide_ticks;  // counter of the collide behaviour: 5 drives 6 ticks
    int64_t drive_ticks;    // counter of the drive behaviour: 2 drives 3 ticks
    int64_t steps;          // budget, ticks
    int64_t find_loop;      // WG_NO_LOOP, WG_SEEK_LOOP or WG_PROVE_LOOP
    int64_t loop_entry;     // for WG_PROVE_LOOP
    int64_t digest;         // 1: the digest of the trace is computed
    int64_t stop_at_tunnel; // 1: the run ends when the path of the centre enters a wall
    int64_t reading;        // how the arbiter works: thesis_arbiter.h
    int64_t repairs;        // WG_REPAIR_ bits
    int64_t signal;         // WG_SIGNAL_OPEN, ...
    int64_t map_scale;      // side of a cell of the robot's map, cells
    int64_t target_x;       // column of the target's cell
    int64_t target_y;       // its row
    uint64_t seed;          // seed of slip and sensor noise
    double time_step;       // ms per tick
    double turn_angle;      // turn of the first two rules, rad
    double radius;          // px
    double speed;           // px/ms
    double tolerance;       // overlap with a wall that is not reported, px
    double acceleration;    // largest gain of px/ms per ms; 0: unlimited
    double friction;        // px/ms lost per ms by a coasting robot; 0: stops immediately
    double wall_friction;   // share of a slide that is lost to friction
    double slip;            // largest share of a tick's path that is lost
    double sensor_field;    // angle that the sensor looks into, rad; 0: all around
    double sensor_noise;    // largest share by which a reading is wrong
} WgThesisSettings;

// A change of one cell at the beginning of a tick. As rows of (n, 4) int64 in Python.
typedef struct WgThesisEvent {
    int64_t step;
    int64_t x;
    int64_t y;
    int64_t state; // WG_FREE, WG_SOLID or WG_BURNING
} WgThesisEvent;

// The robot's surroundings. `cells` and `visited` change during an episode.
typedef struct WgThesisArena {
    int64_t width; // cells
    int64_t height;
    int32_t *cells;              // (width, height) the signal now
    const int32_t *light;        // (width, height) the signal of a cell that becomes free
    const WgThesisEvent *events; // sorted by step
    int64_t event_count;
    uint8_t *visited; // (width, height) 1 where the centre has been at the end of a tick
} WgThesisArena;

// The number of leading words of a WgThesisState that decide the robot's future: what a recurrence
// must repeat.
enum { WG_THESIS_WORDS = 11 };

// The robot after a tick.
typedef struct WgThesisState {
    double x; // px
    double y;
    double heading;        // rad
    double target_heading; // rad
    double speed;          // px/ms, wanted
    double old_speed;      // px/ms, commanded before the collision
    double rolling;        // px/ms, at which the robot moves: `speed` without inertia and friction
    int64_t collision;     // 1 if the last move hit a wall
    int64_t behaviour;     // in control: WG_COLLIDE, ...
    int64_t ticks_left;    // 0 unless collide or drive is in control
    int64_t draws_used;
    int64_t active;  // behaviour that acted in the last tick
    int64_t move;    // how the last tick's move ended: WG_STRAIGHT, ...
    int64_t escapes; // 1 if collide took control in the last tick
} WgThesisState;

// A row of a trace: WgThesisState as numbers of one kind.
typedef struct WgThesisRow {
    double x;
    double y;
    double heading;
    double target_heading;
    double speed;
    double old_speed;
    double rolling;
    double collision;
    double behaviour;
    double ticks_left;
    double draws_used;
    double active;
    double move;
    double escapes;
} WgThesisRow;

// First occurrence of something, and the move that let the robot into the wall.
typedef struct WgThesisPlace {
    int64_t step; // -1: never
    int64_t x;    // cell
    int64_t y;
    int64_t state; // WG_SOLID (debris) or WG_BURNING, of a hit
    int64_t began; // step in which the overlap at that time began; -1 if there was none
    int64_t cause; // the move of that step
} WgThesisPlace;

// A run: where it is, and its results. An episode that ran out of ticks or draws continues from
// here.
typedef struct WgThesisRun {
    WgThesisState state;
    int64_t ending; // WG_LIMIT, ... or WG_NEEDS_DRAWS
    int64_t steps;
    int64_t period; // period of a WG_LOOP
    int64_t entry;  // where the loop begins; -1
    int64_t collisions;
    int64_t activations;   // times that the collide behaviour took control
    int64_t last_new_cell; // last step that ended in a cell for the first time
    int64_t visited;       // cells that the centre was in after a tick
    uint64_t digest;       // rolling FNV-1a hash of seven words a tick
    WgThesisPlace hit;     // for WG_BURNED: the cell that burns
    WgThesisPlace overlap; // first tick that ends deeper in a wall than tolerated
    WgThesisPlace tunnel;  // first tick whose straight path enters a wall
    WgThesisPlace in_wall; // first tick that ends with the centre in a wall
    double path_length;    // px
    double deepest;        // overlap at the end of a tick, px
    int64_t next_event;
    int64_t overlap_began; // first step of the current overlap; -1 if there is none
    int64_t overlap_cause; // its move
} WgThesisRun;

// Where a move ended.
typedef struct WgThesisMove {
    double x;  // px
    double y;
    int64_t collision; // the listing's flag
    int64_t ending;    // WG_STRAIGHT, ...
    double before_x;   // the centre before a wall changed the move; x and y if none did
    double before_y;
} WgThesisMove;

// thesis_episode.c

// Begins a run with a moving robot that aims at heading 0, no behaviour in control, as in the
// thesis.
//
// x, y in px, heading in rad, speed in px/ms.
void wg_thesis_begin(WgThesisRun *run, double x, double y, double heading, double speed);

// Runs until the outcome is decided, settings->steps ticks are done, or tick `until` is.
//
// A run that ended as WG_LIMIT or WG_NEEDS_DRAWS continues where it stopped if called again with
// the same arena, and with more steps or draws; the earlier draws stay at the front.
//
// run:     begun or stopped.
// search:  for a recurrence of the complete state after the last event;
//          NULL if find_loop is WG_NO_LOOP.
// draws:   (draw_count,) random numbers in [0, 1) for WG_RULE_RANDOM, in order.
// rows:    (row_count,) row k receives the state after step first_row + k.
//
// Of several endings in one tick the first counts: WG_BURNED, WG_TUNNEL, WG_REACHED, WG_LOOP.
WgStatus wg_thesis_run(const WgThesisArena *arena, const WgThesisSettings *settings,
                       WgThesisRun *run, WgSearch *search, const double *draws, int64_t draw_count,
                       WgThesisRow *rows, int64_t row_count, int64_t first_row, int64_t until);

// thesis_motion.c

// Moves the disc towards a goal, pixel by pixel, with those of the thesis's faults that are not
// repaired.
//
// cells:          (width, height).
// settings:       radius, repairs and wall friction.
// x, y:           centre, px, in the grid.
// goal_x, goal_y: where the tick's motion would lead, px.
WgStatus wg_thesis_move(const int32_t *cells, int64_t width, int64_t height,
                        const WgThesisSettings *settings, double x, double y, double goal_x,
                        double goal_y, WgThesisMove *move);

// thesis_signal.c

// Weakens or strengthens the signal of cells near inner walls, in place; the order of the walls
// matters.
//
// cells: (width, height) the signal with every wall drawn.
// light: (width, height) the undisturbed signal.
WgStatus wg_thesis_add_noise(int32_t *cells, const int32_t *light, int64_t width, int64_t height);

// Sets `heading` to the direction, rad, of the best signal by the sensor in the settings.
//
// x, y:     centre, px, in the grid.
// looking:  the robot's heading, rad.
// step:     number of the tick, which picks the sensor's errors.
WgStatus wg_thesis_sense(const int32_t *cells, int64_t width, int64_t height,
                         const WgThesisSettings *settings, double x, double y, double looking,
                         int64_t step, double *heading);

// Counts the walls whose inside the straight line between the centres of two cells crosses, without
// these two cells.
//
// A line exactly through a corner crosses neither of the two cells next to it.
WgStatus wg_thesis_walls_between(const int32_t *cells, int64_t width, int64_t height, int64_t x,
                                 int64_t y, int64_t to_x, int64_t to_y, int64_t *walls);

#endif

// The controllers of the library, and the layout of their memories.
//
// A memory is an array of float64; each struct here describes its layout, so that fields have names
// in C and in Python. The numbers are part of the state that a loop repeats and a digest covers,
// so their order never changes.

#ifndef WG_CONTROLLERS_H
#define WG_CONTROLLERS_H

#include <stdint.h>

#include "worldgen_behaviours.h"
#include "worldgen_controller.h"

// Returns the act of a controller of the library, or of one with a planted fault, by name; NULL if
// there is none.
WgAct wg_library_act(const char *name);

// State of wall following by touch. The memory of such a controller begins with it.
typedef struct WgWallBody {
    double x;       // m: position before the last step
    double y;
    double step;    // m: length requested in the last step
    double hand;    // side of the wall: 1 left, -1 right
    double wall;    // rad: direction from the robot to its wall
    double phase;   // WG_ADVANCE or WG_PRESS
    double stuck;   // consecutive times that it touched its wall and did not move
    double lost;    // steps since it touched a wall
    double smooth;  // consecutive times that its wall had not turned, at most FLAT_AFTER
} WgWallBody;

typedef struct WgWallMemory {
    WgWallBody body;
    double mode;  // 0 to the target, 1 along the wall
} WgWallMemory;

// A place on a wall that Bug1 remembers.
typedef struct WgWallPlace {
    double x;     // m
    double y;
    double wall;    // rad: direction of the wall there
} WgWallPlace;

typedef struct WgBug1Memory {
    WgWallBody body;
    double mode;  // 0 start, 1 to the target, 2 meets a wall, 3 around it, 4 to the leave point
    double far;         // m: distance to the target before the step
    WgWallPlace hit;    // where a wall stopped it
    WgWallPlace leave;  // where the wall was nearest to the target
    double leave_far;   // m: distance of that place to the target; infinity if there is none
    double path;        // m: driven since the hit
    double leave_path;  // m: driven from the hit to the leave point
    double away;        // 0 near the hit point, 1 away from it, 2 back at it
} WgBug1Memory;

typedef struct WgBug2Memory {
    WgWallBody body;
    double mode;  // 0 start, 1 to the target, 2 around the obstacle, 3 to the line
    double far;      // m: distance to the target before the step
    double hit_x;    // m
    double hit_y;
    double hit_far;  // m: distance of the hit point to the target; infinity if there is none
    double line_x;   // direction of the line, a unit vector
    double line_y;
    double leave_x;  // m: the leave point
    double leave_y;
} WgBug2Memory;

typedef struct WgTangentBugMemory {
    WgWallBody body;
    double mode;      // 0 to the target, 1 by an end, 2 along the wall, 3 leaves the wall
    double best;      // m: shortest path so far
    double since;     // steps since then
    double wall_far;  // m: smallest distance of the wall to the target
    double far;       // m: distance to the target before the step
    double leave_x;   // m: the place for which it leaves the wall
    double leave_y;
} WgTangentBugMemory;

typedef struct WgOrcaMemory {
    double speed;  // m/s: commanded in the step before
} WgOrcaMemory;

typedef struct WgRandomWalkMemory {
    double left;  // m: remainder of the leg
} WgRandomWalkMemory;

enum {
    WG_MOST_PARTS = 16,       // limit on the parts of a composition
    WG_PART_OPTIONS = 4,      // limit on the tuning numbers of a part
    WG_VOTE_DIRECTIONS = 32,  // among which parts vote
};

// How an arbiter composes its parts: WgComposition.arbiter.
enum { WG_BY_PRIORITY = 0, WG_BY_VOTE = 1, WG_BY_LEARNING = 2 };

// Conditions that a learning arbiter distinguishes: whether the robot touches a wall now, and
// whether it did recently.
enum { WG_CONDITIONS = 4 };

// How often something has recently happened in a condition, for a learning arbiter. All are
// integers; a share of WG_WHOLE_SHARE means always.
enum { WG_WHOLE_SHARE = 65536 };

typedef struct WgFeedback {
    double trials;  // steps in which the part acted, counted until its value is known
    double acted;   // share of steps in which it acted
    double good;    // share of steps in which it acted and got positive feedback: a stronger signal
    double bad;     // same, negative feedback: a wall was touched
} WgFeedback;

// A part in a memory.
typedef struct WgStoredPart {
    // index of its behaviour: wg_behaviour_at; negative: one of the user's own
    double kind;
    double priority;
    double duration;       // steps
    double interruptible;
    double options[4];     // WG_PART_OPTIONS
} WgStoredPart;

// A composition's memory. Behind it are the parts (WgStoredPart[count]); then, for a vote, the
// steps that each part has left; then, if the arbiter learns, WgLearning, and
// WgFeedback[WG_CONDITIONS] of all steps and of each part; then the parts' own states,
// in their order.
typedef struct WgComposition {
    WgShared shared;
    double acted;    // the part that acted in the last step; -1: none
    double arbiter;  // WG_BY_PRIORITY, ...
    double count;    // number of parts
} WgComposition;

typedef struct WgLearning {
    double condition;  // in which the part in charge was chosen
    double lately;     // steps for which a touch still counts as recent
    double signal;     // after the last step
} WgLearning;

// A controller with tuned numbers has two acts: one uses the numbers named here as `..._default`,
// the other has the user's numbers in its memory, after the state.

typedef struct WgPotentialField {
    double pull;        // force per metre of distance from the target
    // m: distance beyond which the attraction stops growing, which limits the speed
    double far;
    double push;        // gain of the walls' repulsion
    double influence;   // m: gap beyond which a wall does not repel
    // force at which the robot drives at its top speed; below it, proportionally slower
    double full_force;
} WgPotentialField;

typedef struct WgVfh {
    double safety;          // widening of obstacles in addition to the robot's radius, in radii
    double window;          // distance, in radii of the robot, beyond which obstacles do not count
    double low;             // density, 0 to 1, below which a blocked sector becomes free
    double high;            // density above which a free sector becomes blocked
    // sectors of an opening that is passed along its side instead of through its middle
    double wide;
    double to_target;       // cost of a sector between a direction and the target's
    double to_heading;      // cost of a sector between it and the heading
    double to_last;         // cost of a sector between it and the direction chosen last
    double turning_radius;  // m, of a robot that cannot turn on the spot; 0 masks no directions
    double slowest;         // share of the top speed that remains in the densest direction
} WgVfh;

typedef struct WgVfhMemory {
    double blocked[72];  // 1 for each blocked sector
    double last;         // last chosen heading, sectors; negative: none yet
} WgVfhMemory;

typedef struct WgVfhTunedMemory {
    WgVfhMemory state;
    WgVfh tuned;
} WgVfhTunedMemory;

typedef struct WgDynamicWindow {
    double margin;        // m: added to the robot's radius
    double gain;          // m/s2: largest change of speed, up or down
    double turn_gain;     // rad/s2: largest change of turn rate
    double fastest_turn;  // rad/s
    // number of speeds tried, from the slowest to the fastest within the window
    double speeds;
    double turns;         // number of turn rates tried; an odd number includes the current one
    double ahead;         // s after which an arc's heading is compared with the target's direction
    double least;         // m: free path that an arc must have
    double far;           // m: a longer free path makes no difference
    double to_target;     // weight of the heading
    double to_free;       // weight of the free path
    double to_speed;      // weight of the speed
} WgDynamicWindow;

typedef struct WgDynamicWindowMemory {
    double speed;      // m/s, commanded last
    double turn_rate;  // rad/s, same
} WgDynamicWindowMemory;

typedef struct WgDynamicWindowTunedMemory {
    WgDynamicWindowMemory state;
    WgDynamicWindow tuned;
} WgDynamicWindowTunedMemory;

typedef struct WgThreeLayer {
    double margin;        // m: added to the robot's radius
    // side of a cell of the map, in radii of the robot; larger if the map would not reach the
    // target
    double pitch;
    double reach;     // minimum side of the map, times the distance from start to target
    double look;      // m: free path that the controller requires in its direction
    // steps after which a waypoint is abandoned, times one more than the map has been forgotten
    double patience;
} WgThreeLayer;

typedef struct WgThreeLayerMemory {
    double laid;       // 1 if the map has been placed
    double corner_x;   // m: its corner
    double corner_y;
    double pitch;      // m: side of its cells
    double to_x;       // the waypoint's cell; -1: none
    double to_y;
    double waited;     // steps since the waypoint was set
    double forgotten;  // number of times that the map was forgotten
    double here_x;     // the robot's cell
    double here_y;
    double from_x;     // the previous one
    double from_y;
    double target_x;   // the target's
    double target_y;
    // a number for each row, a bit for each closed border between a cell and its right neighbour
    double right[48];
    double up[48];     // same, and its upper neighbour
} WgThreeLayerMemory;

typedef struct WgThreeLayerTunedMemory {
    WgThreeLayerMemory state;
    WgThreeLayer tuned;
} WgThreeLayerTunedMemory;

enum {
    WG_Q_SITUATIONS = 768,  // situations that the Q-learning robot distinguishes
    WG_Q_TURNS = 6,         // turns that it chooses from
    WG_Q_DRIVEN = 4,        // steps between two decisions, unless a bump comes first
};

// Eighths of a turn, counter-clockwise; the first wins a tie.
extern const int wg_q_turn_of[6];

typedef struct WgQMemory {
    double wait;    // steps until the next decision
    double turned;  // last turn: 0 none or back, 1 left, 2 right
} WgQMemory;

typedef struct WgQTunedMemory {
    WgQMemory state;
    double best[768];  // the turn to take in each situation: its index among the six turns
} WgQTunedMemory;

// Estimates of a controller that does not know its place or the target's. The memory of the
// controller that drives by it follows.
typedef struct WgReckoning {
    double known;       // 1 once the target's place has been estimated
    double x;           // m: where the robot believes itself to be
    double y;
    double target_x;    // m: where it believes the target to be
    double target_y;
    // m: the odometry of the step before; with distances, the place where `far` was measured
    double odometry_x;
    double odometry_y;
    double far;         // m: distance to the target there
    double cell;        // m: distance at which the signal has fallen to a half; 0: unknown
    double search;      // directions in which it has searched for a signal
    double turned;      // rad: its heading after the previous step minus the odometry's
} WgReckoning;

typedef struct WgQLearnerMemory {
    WgQMemory state;
    double situation;     // situation of the last decision; -1: there was none
    double choice;        // its turn, a number among the six
    double far;           // mm: distance to the target then
    double explore;       // random decisions in thousandths; 0 uses no random numbers
    // value of each turn in each situation, in thousandths: 16 bits each, three to a number
    double values[1536];
} WgQLearnerMemory;

typedef struct WgMapperMemory {
    // The map; places are in nodes from the start.
    double side;         // nodes of the window along a side
    double window_x;     // its lowest node
    double window_y;
    double target_x;     // place of the target, not rounded
    double target_y;
    // bits of the nodes next to the target from which the path to it was blocked
    double doors;
    double plan_at;      // moves that have been made
    double plan_length;  // all moves of the plan
    double plan[64];     // 16 moves in each number

    // The controller.
    double mode;  // 0 start, 1 go, 2 to the target, 3 probe for the wall, 4 back
    double from_x;     // the node that it came from
    double from_y;
    double move;     // from that node: 0 is east, then counter-clockwise by eighths of a turn
    double start_x;  // m
    double start_y;
    double grid;     // m: distance of two nodes
    double x;        // m: position before the step
    double y;
    double step;     // m: length of the step
    double tries;    // failed returns
    // share of the robot's radius: within this of a place that it probed, there is no room for it;
    // 0 if it does not probe for walls
    double no_room;

    double nodes[];  // 4 bits for each node of the window, 12 nodes in each number
} WgMapperMemory;

enum { WG_SCAN_SIDE = 64 };  // cells of the window along a side of a map of scans; a power of two

// The map of a robot that corrects its odometry by its scans. It follows the memory of the
// controller that drives.
typedef struct WgScanMap {
    double pitch;         // m: side of a cell
    double window_x;      // lowest column in the window
    double window_y;      // lowest row
    // m: what is added to the measured position, after a turn by WgReckoning.turned
    double shift_x;
    double shift_y;
    double scan_x;        // m: measured position at the last scan that was matched
    double scan_y;
    double scan_heading;  // rad: measured heading there
    // a point in each cell of the window, 17 bits: 0, or 1 + 256 * its row + its column in the
    // cell, both in 1/256 of a side; 3 cells in each number
    double cells[(WG_SCAN_SIDE * WG_SCAN_SIDE + 2) / 3];
} WgScanMap;

enum { WG_TEAM_POINTS = 128 };  // points of walls that a robot of a team remembers to tell others

// What a robot of a team knows and tells. The mapper's memory follows.
typedef struct WgTeamMemory {
    double count;  // points so far
    double next;   // index at which the next point is stored, in place of the oldest
    double next_sent;  // index of the point to send next
    double points[WG_TEAM_POINTS][2];  // m
} WgTeamMemory;

typedef struct WgGestaltMemory {
    double side;      // cells of the window along a side
    double pitch;     // m: side of a cell; 0 before the first step
    double window_x;  // lowest column in the window
    double window_y;  // lowest row
    double heading;   // rad: direction of the chosen arc where the robot is
    double bend;      // rad/m: its curvature
    double left;      // m: its remaining length
    // degrees of goodness, 4 bits for each cell of the window, 12 cells in each number
    double cells[];
} WgGestaltMemory;

// A place of a topological map.
typedef struct WgMapPlace {
    double x;      // m
    double y;
    double exits;  // bits of the exits that are open and lead somewhere new
    double links;  // 10 bits for each of five neighbours: its number, and 1
} WgMapPlace;

typedef struct WgTopologicalMemory {
    double most;     // places that there is room for
    double mode;     // 0 start, 1 explore, 2 travel along the map
    double level;    // how fine the map is: 0 to 2
    double count;    // places
    double next;     // the number that the next place gets when there is room for no more
    double here;     // the place that it left last
    double to;       // the place that it travels to
    double heading;  // rad: direction of the step
    double x;        // m: position before the step
    double y;
    double step;     // m: length of the step
    double exit;     // the exit that it explores
    double open;     // bits of the exits that were open before the step
    WgMapPlace places[];
} WgTopologicalMemory;

extern const WgPotentialField wg_potential_field_default;
extern const WgVfh wg_vfh_default;
extern const WgDynamicWindow wg_dynamic_window_default;
extern const WgThreeLayer wg_three_layer_default;

// Length of an arc until a disc meets a point, m; infinity if it never does.
//
// x, y:       of the point, m, ahead of the robot and to its left. A point inside the disc counts
//             as met immediately if it is ahead.
// speed:      m/s, positive.
// turn_rate:  rad/s.
// radius:     of the disc, m.
double wg_arc_to_contact(double x, double y, double speed, double turn_rate, double radius);

// The library's behaviours, in order of their index.
int64_t wg_behaviour_count(void);
const WgBehaviour *wg_behaviour_at(int64_t index);

// Lets a composition act.
//
// others: the user's own behaviours, for parts whose kind is negative: -1 is the first.
//         NULL if there are none.
void wg_compose(const WgBehaviour *others, const WgObservation *seen, double *memory, WgCommand *command);

// The number of the situation that the Q-learning robot sees, below WG_Q_SITUATIONS.
// It needs 8 beams.
int64_t wg_q_situation(const WgObservation *seen, const WgQMemory *own);

// The value, in thousandths, that the shipped table gives a turn in a situation.
int64_t wg_q_value(int64_t situation, int64_t turn);

// Fills the memory of a learner that begins with the shipped table; it must be all zero.
void wg_q_learner_reset(double *memory);

// Tells a learner, after a run, that its last decision led to a reward, in thousandths.
void wg_q_learner_arrives(double *memory, double reward);

// A cell of the map of three-layer.
typedef struct WgMapCell {
    int64_t column;
    int64_t row;
} WgMapCell;

// Returns the cell after `here` on a shortest path through the map to `target`; (-1, -1) if there
// is none.
WgMapCell wg_next_cell(const WgThreeLayerMemory *own, WgMapCell here, WgMapCell target);

#endif

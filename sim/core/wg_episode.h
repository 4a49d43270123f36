// Episodes on the pose lattice: one robot and its controller, from the start until the outcome is
// decided.
//
// An episode is resumable: it runs in portions, or step by step for a controller that isn't a C
// function. wg_episode_new allocates all its working memory and wg_episode_free frees it; the arena
// and the settings remain the caller's and must live as long.

#ifndef WG_EPISODE_H
#define WG_EPISODE_H

#include <stdint.h>

#include "wg_sim.h"

// The corners that one move may add to the path of a step, including the end of a wait.
enum { WG_MOST_CORNERS = 4 };

// Parts of a lattice unit in which a car's exact place is known.
enum { WG_OFF_UNIT = 256 };

// Return values of wg_episode_run and wg_episode_step.
enum {
    WG_GOES_ON = 0,  // the steps are done, without a verdict
    WG_OVER = 1,     // WgReport.ending gives the reason; this includes a spent budget
    WG_ACTS = 2,     // the controller must act: only from wg_episode_step
};

// A controller over flat arrays, as compiled by numba. It takes the first 17 numbers of an
// observation, then its beams, the rows of neighbours and the goal's heading if it declares them;
// the memory; and speed, turn rate and whether the random number was used, all zero. A nonzero result means that it failed: the run ends as WG_CRASH.
typedef int64_t (*WgFlatAct)(double *observation, int64_t observation_size, double *memory, int64_t memory_size,
                             double *command);

enum { WG_LONGEST_ERROR = 256 };  // bytes of a controller's message, with its terminating zero

// The memory in which a function from a shared library acts. Whatever such a function may write to
// is here, between words that are compared after each step, and between pages that nobody may
// touch. So a function that writes past its memory fails, instead of changing the run.
//
// The first pages end with a state and the controller's memory; the second pages hold the command,
// its message and copies of what it observes, and end with the beams. See cage.c.
typedef struct WgCage {
    WgAct act;
    double *memory;        // (memory_size,) at the end of the first pages
    int64_t memory_size;
    uint64_t *first;       // the first word of the first pages
    uint64_t *second;      // the same of the second pages
    WgCommand *command;
    double *message;       // (WG_MOST_MESSAGE,)
    WgObservation *observation;
    WgNeighbour *neighbours;  // (neighbour_room,)
    double *beams;         // (beam_room,) at the end of the second pages
    int64_t beam_room;
    int64_t neighbour_room;
    int64_t acts;          // 1 while the function runs
    int64_t rounding;      // how floating point rounds: wg_rounding
    char error[256];       // the function's own message, or what it did wrong
} WgCage;

// The controller. Without a function, the episode stops whenever the controller must act.
typedef struct WgController {
    WgAct act;
    WgFlatAct flat;        // used if act is NULL
    WgCage *cage;          // used if both are NULL
    const double *memory;  // (memory_size,) at reset; may be NULL if there is none
    int64_t memory_size;
} WgController;

// The state of a car, or of a body, besides its WgState; only a car has more than the first two words. It is the end
// of the state; a disc that turns on the spot has none. Between the controller's memory and it, the state of a robot with waypoints has WgRobot.passed.
typedef struct WgCarriage {
    // 1 more than the heading of the direction away from the wall that cut its last turn short; 0 if none did
    int64_t bumped;
    int64_t steering;  // a car's curvature to the left, 2^-30 of the largest
    // How far a car's exact place is from its lattice point, in WG_OFF_UNITths of a lattice unit. Without it, a slow
    // car would drift off its arc by the rounding of each step.
    int64_t off_x;
    int64_t off_y;
} WgCarriage;

// The complete state, with the controller's memory: what a recurrence must repeat, word by word.
typedef struct WgBody {
    WgState state;
    double memory[];
} WgBody;

// The pose as the robot measured it.
typedef struct WgOdometry {
    double x;        // lattice units
    double y;
    double heading;  // heading units
} WgOdometry;

// A robot, and the result of its last step.
typedef struct WgRobot {
    WgBody *body;
    WgOdometry odometry;
    int64_t *passed;       // number of waypoints that it has arrived at, a word of its state; NULL if it has none
    const WgGoal *goal;    // the goal that it must arrive at next
    int64_t meets;         // 1 if its path has met that goal, a waypoint, in this step
    int64_t passed_step;   // step in which it arrived at its last waypoint
    // 1: a disc that turns on the spot and has to touch its target only. Steps ask for this instead of asking what
    // the robot is and what its goal asks for, which takes 2 % fewer instructions in a maze.
    int64_t is_simple;
    WgCarriage *carriage;  // NULL for a disc that turns on the spot
    WgCorner *chain;     // corners of the path of the last step
    int64_t *chain_headings;  // the heading on the way to each corner; NULL for a disc that turns on the spot
    int64_t corners;     // number of corners
    int64_t turned;      // how far a car, or a robot that has to stop, turned in the last step, heading units
    WgNormal contact;    // contact in the last step
    int64_t touched;     // 1 if the step before touched a wall
    int64_t next_event;  // index of the next event
    int64_t next_push;   // the same, of the pushes at times
    WgReport report;
} WgRobot;

// Data exchanged between the robot and its controller.
//
// A controller outside the core finds the observation in `flat`. It changes `command` and its
// memory, or writes both into `answer`: 1, speed, turn rate, whether it used the random number,
// memory.
typedef struct WgWorkspace {
    WgObservation observation;
    WgCommand command;
    double *beams;   // what observation.beams points to
    double *flat;    // (17 + beams,) copy of the observation, for controllers that take flat arrays
    int64_t tail;  // numbers that follow everything else in `flat`: wg_tail
    double *answer;  // (4 + memory,)
    WgNeighbour *neighbours;  // (neighbour_room,) what observation.neighbours points to
    // rows of neighbours that follow the beams in `flat`; 0 for a single robot
    int64_t neighbour_room;
} WgWorkspace;

// Data of the search for a recurrence: see recurrence.h.
typedef struct WgSearch {
    uint64_t *log;     // (log_size,) fingerprint of the state after each step
    int64_t log_size;
    uint64_t *prints;  // fingerprint of each block of the state; then their sum
    uint64_t *known;   // (words,) last state taken into prints; in the proof, the loop's first
    int64_t words;     // words of a complete state
    int64_t next;      // the step whose state is looked up next
} WgSearch;

// Where the steps of an episode are recorded, if anywhere.
typedef struct WgRecording {
    int64_t *rows;        // (row_count, 1 + words): whether a wall was touched, then the state
    int64_t row_count;
    int64_t first_step;   // the step of the first row
    WgPathPoint *path;
    int64_t *path_headings;  // (path_size,) heading on the way to each point; NULL for a disc that turns on the spot
    int64_t path_size;
    int64_t first_point;  // number of points of the path before it
} WgRecording;

typedef struct WgEpisode {
    const WgArena *arena;
    const WgSettings *settings;
    WgController controller;
    WgRobot robot;
    WgWorkspace workspace;
    WgSearch search;
    WgRecording recording;
    int64_t step;    // steps done
    int64_t quiet;   // step of the last event: earlier states prove nothing
    int64_t waits;   // 1 while the controller must act
    int64_t over;    // 1 when the episode has ended
} WgEpisode;

// Creates an episode. Sizes are taken from the arguments: the controller's memory, settings->beams,
// the most events of a step. `log_steps` is the longest run in which a recurrence is searched for;
// 0 for none.
WgStatus wg_episode_new(const WgArena *arena, const WgSettings *settings, const WgController *controller,
                        int64_t log_steps, WgEpisode **made);

void wg_episode_free(WgEpisode *episode);

// Does the same in the caller's memory, which another process may share: first the bytes of a block
// that is all zero, then those of the log, which may contain anything.
WgStatus wg_episode_sizes(const WgArena *arena, const WgSettings *settings, const WgController *controller,
                          int64_t log_steps, int64_t sizes[2]);

// Creates an episode in two such blocks; NULL if a size is out of its range. It need not be freed.
WgEpisode *wg_episode_place(void *block, void *log, const WgArena *arena, const WgSettings *settings,
                            const WgController *controller, int64_t log_steps);

// How floating point rounds in this thread: see rounding.h.
int64_t wg_rounding(void);
void wg_set_rounding(int64_t rounding);

// Prepares a cage whose pages, sizes and function are set: fills the words around everything that
// the function may write to. Returns WG_BAD_SIZE if the pages are too small.
WgStatus wg_cage_begin(WgCage *cage, int64_t first_size, int64_t second_size);

// Bytes that the two parts of a cage need at least.
void wg_cage_sizes(int64_t memory_size, int64_t beams, int64_t neighbours, int64_t sizes[2]);

// Fills the cage's memory by a library's function. Returns 1 if it kept to its memory; otherwise 0,
// and cage->error tells what it did.
int64_t wg_cage_reset(WgCage *cage, WgReset reset);

// Fails in its first step. It acts in place of a controller whose reset has failed.
void wg_failed_reset_act(const WgObservation *observation, double *memory, WgCommand *command);

// Ends an episode as a crash of its controller, in the step in which the controller last had to
// act.
void wg_episode_fail(WgEpisode *episode);

// Puts the robot at its start, its memory reset. The arena must be as it is before the first event.
WgStatus wg_episode_begin(WgEpisode *episode);

// Records `rows` steps starting with the next one, and their path.
WgStatus wg_episode_record(WgEpisode *episode, int64_t *rows, int64_t row_count, WgPathPoint *path,
                           int64_t *path_headings, int64_t path_size);

// Words of the WgCarriage at the end of a robot's state; 0 if it has none.
int64_t wg_carriage_words(const WgSettings *settings);

// Words that follow the controller's memory in a robot's state: the waypoints that it has passed, and its WgCarriage.
int64_t wg_words_after_memory(const WgSettings *settings);

// Returns how many straight moves a step may have: one, or several for a car.
int64_t wg_most_legs(const WgSettings *settings);

// Runs at most this many steps, at least one, and for about a tenth of a second.
int64_t wg_episode_run(WgEpisode *episode, int64_t most_steps);

// For a controller that isn't a C function. Takes its answer, if it had to act; then runs until it
// must act again, WG_ACTS, or the episode ends, WG_OVER.
int64_t wg_episode_step(WgEpisode *episode);

// The first step from which the states repeat, for an episode that ended as WG_LOOP; otherwise -1.
int64_t wg_episode_entry(const WgEpisode *episode);

#endif

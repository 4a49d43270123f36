// Environments for reinforcement learning; see wg_navigate.h.

#include "wg_navigate.h"

#include "fdlibm.h"
#include "step.h"

enum { HALF = WG_UNIT / 2 };  // distance of two neighbouring nodes, lattice units

// Writes the cosine and sine of an angle; returns the position of the next number.
static float *show_direction(double angle, float *shown)
{
    shown[0] = (float)wg_cos(angle);
    shown[1] = (float)wg_sin(angle);
    return shown + 2;
}

// Writes a length as a share of another, -1 to 1.
static float *show_share(double value, double whole, float *shown)
{
    shown[0] = (float)wg_clamp(value / whole, -1.0, 1.0);
    return shown + 1;
}

void wg_show(const WgObservation *seen, const int64_t *sensors, int64_t sensor_count, const WgRules *rules, float *shown)
{
    for (int64_t k = 0; k < sensor_count; k++) {
        switch (sensors[k]) {
        case WG_SHOW_BUMP:
            *shown++ = (float)seen->bump;
            break;
        case WG_SHOW_BUMP_DIRECTION:
            if (seen->bump != 0.0) {
                shown = show_direction(seen->bump_bearing, shown);
            } else {
                *shown++ = 0.0f;
                *shown++ = 0.0f;
            }
            break;
        case WG_SHOW_SIGNAL:
            *shown++ = (float)seen->signal;
            break;
        case WG_SHOW_SIGNAL_DIRECTION:
            shown = show_direction(seen->signal_heading - seen->heading, shown);
            break;
        case WG_SHOW_TARGET_DIRECTION:
            shown = show_direction(seen->target_heading - seen->heading, shown);
            break;
        case WG_SHOW_GOAL_DIRECTION:
            if (!isnan(seen->goal_heading)) {
                shown = show_direction(seen->goal_heading - seen->heading, shown);
            } else {
                *shown++ = 0.0f;
                *shown++ = 0.0f;
            }
            break;
        case WG_SHOW_TILT: {
            double angle = seen->tilt_heading - seen->heading;
            shown = show_share(seen->tilt * wg_cos(angle), seen->top_speed, shown);
            shown = show_share(seen->tilt * wg_sin(angle), seen->top_speed, shown);
            break;
        }
        case WG_SHOW_TARGET_DISTANCE:
            shown = show_share(seen->target_distance, rules->extent, shown);
            break;
        case WG_SHOW_HEADING:
            shown = show_direction(seen->heading, shown);
            break;
        case WG_SHOW_POSITION:
            shown = show_share(seen->x, rules->extent, shown);
            shown = show_share(seen->y, rules->extent, shown);
            break;
        case WG_SHOW_ODOMETRY:
            shown = show_share(seen->odometry_x, rules->extent, shown);
            shown = show_share(seen->odometry_y, rules->extent, shown);
            shown = show_direction(seen->odometry_heading, shown);
            break;
        default:
            for (int64_t beam = 0; beam < seen->beam_count; beam++) {
                shown = show_share(seen->beams[beam], rules->beam_range, shown);
            }
        }
    }
}

int64_t wg_world_of_episode(uint64_t seed, int64_t episode, int64_t count)
{
    return wg_least((int64_t)(wg_random_draw(seed, 2 * episode) * (double)count), count - 1);
}

int64_t wg_run_of_episode(uint64_t seed, int64_t episode)
{
    return (int64_t)(wg_random_draw(seed, 2 * episode + 1) * 0x1p53);
}

// The robot's current surroundings. Visited cells are not needed.
static WgArena arena_of(const WgCrew *crew, int64_t robot)
{
    WgArena arena = crew->places[crew->world[robot]].arena;
    arena.visited = NULL;
    if (crew->cells != NULL) {
        arena.cells = crew->cells + robot * crew->page;
        arena.near = crew->near + robot * crew->page;
    }
    return arena;
}

// The goals of a world, in order; the last one is the target.
static const WgGoal *goal_of(const WgSettings *settings, int64_t number)
{
    return number < settings->waypoint_count ? &settings->waypoints[number] : &settings->target;
}

// The settings of a robot's world, with the robot's own seed. A robot that was copied gets its goal from there, too.
static const WgSettings *settings_of(WgCrew *crew, int64_t robot)
{
    WgSettings *settings = &crew->places[crew->world[robot]].settings;
    settings->seed = (uint64_t)crew->run[robot];
    crew->robots[robot].goal = goal_of(settings, crew->passed[robot]);
    return settings;
}

// Lets a robot sense where it is, with its last contact.
static void sense_at(WgCrew *crew, int64_t robot)
{
    WgArena arena = arena_of(crew, robot);
    wg_sense(&arena, settings_of(crew, robot), &crew->robots[robot], crew->clock[robot], &crew->workspace.observation,
             crew->workspace.beams);
}

// Moves a robot and lets it sense, even at its last pose; returns true if a wall stopped or
// deflected the move.
static bool advance(WgCrew *crew, int64_t robot)
{
    WgArena arena = arena_of(crew, robot);
    WgRobot *driver = &crew->robots[robot];
    crew->clock[robot]++;
    wg_move_and_sense(&arena, settings_of(crew, robot), driver, &crew->workspace, crew->clock[robot]);
    if (driver->report.ending != WG_LIMIT) {
        sense_at(crew, robot);
    }
    return driver->contact.x != 0.0 || driver->contact.y != 0.0;
}

// Returns the length of the path from a place to a goal, m: straight to one of the four nodes around the
// place, then the shortest path; or infinity.
static double length_of_way(const WgPlace *place, int64_t goal, int64_t x, int64_t y)
{
    double best = (double)INFINITY;
    int64_t columns = 2 * place->arena.width;
    int64_t rows = 2 * place->arena.height;
    const float *ways = place->ways + goal * (rows + 1) * (columns + 1);
    for (int corner = 0; corner < 4; corner++) {
        int64_t i = wg_least(wg_floor_div(x, HALF) + (corner & 1), columns);
        int64_t j = wg_least(wg_floor_div(y, HALF) + (corner >> 1), rows);
        int64_t dx = i * HALF - x;
        int64_t dy = j * HALF - y;
        double aside = sqrt((double)(dx * dx + dy * dy)) * place->settings.metres;
        best = wg_lower(best, aside + (double)ways[j * (columns + 1) + i]);
    }
    return best;
}

// Returns the distance from a place to a goal, m: along the shortest path if it is known, otherwise straight.
static double distance_to(const WgPlace *place, int64_t number, int64_t x, int64_t y)
{
    if (place->ways != NULL) {
        double away = length_of_way(place, number, x, y);
        if (away < (double)INFINITY) {
            return away;
        }
    }
    const WgGoal *goal = goal_of(&place->settings, number);
    int64_t dx = goal->x - x;
    int64_t dy = goal->y - y;
    return sqrt((double)(dx * dx + dy * dy)) * place->settings.metres;
}

// Returns the robot's distance to the target, m, through the waypoints that are left.
static double distance_of(const WgCrew *crew, int64_t robot)
{
    const WgPlace *place = &crew->places[crew->world[robot]];
    const WgState *state = &crew->robots[robot].body->state;
    int64_t next = crew->passed[robot];
    double away = distance_to(place, next, state->x, state->y);
    for (int64_t number = next; number < place->settings.waypoint_count; number++) {
        const WgGoal *goal = goal_of(&place->settings, number);
        away += distance_to(place, number + 1, goal->x, goal->y);
    }
    return away;
}

// Shows what a robot has just sensed.
static void observe(WgCrew *crew, int64_t robot, float *observation)
{
    const WgSettings *settings = settings_of(crew, robot);
    WgObservation *seen = &crew->workspace.observation;
    seen->goal_heading = wg_sensed_goal_heading(settings, crew->robots[robot].goal);
    seen->top_speed = settings->top_speed;
    wg_sense_tilt(settings, seen);
    wg_show(seen, crew->sensors, crew->sensor_count, crew->rules, observation);
}

void wg_crew_robots(WgCrew *crew, WgState *states, WgCarriage *carriages, WgCorner *chain)
{
    for (int64_t robot = 0; robot < crew->count; robot++) {
        crew->robots[robot].body = (WgBody *)&states[robot];  // a body without a memory
        crew->robots[robot].carriage = &carriages[robot];
        crew->robots[robot].passed = &crew->passed[robot];
        crew->robots[robot].chain = chain;
    }
}

void wg_crew_begin(WgCrew *crew, int64_t robot, int64_t world, float *observation)
{
    const WgController nobody = {0};
    crew->run[robot] = wg_run_of_episode(crew->seed[robot], crew->episode[robot]);
    crew->world[robot] = world;

    // If worlds change, the robot gets a fresh copy.
    if (crew->cells != NULL) {
        const WgArena *fresh = &crew->places[world].arena;
        size_t size = (size_t)(fresh->width * fresh->height);
        memcpy(crew->cells + robot * crew->page, fresh->cells, size * sizeof *crew->cells);
        memcpy(crew->near + robot * crew->page, fresh->near, size * sizeof *crew->near);
    }
    wg_robot_begin(&crew->robots[robot], settings_of(crew, robot), &nobody);
    crew->clock[robot] = 0;
    crew->elapsed[robot] = 0;

    // Make the first move, at standstill.
    advance(crew, robot);
    observe(crew, robot, observation);
    crew->distance[robot] = distance_of(crew, robot);
    crew->over[robot] = 0;
}

void wg_crew_begin_many(WgCrew *crew, const uint8_t *which, float *observations)
{
    for (int64_t robot = 0; robot < crew->count; robot++) {
        if (which[robot] != 0) {
            int64_t world = wg_world_of_episode(crew->seed[robot], crew->episode[robot], crew->place_count);
            wg_crew_begin(crew, robot, world, observations + robot * crew->size);
        }
    }
}

// Begins the next episode, in a world chosen by the robot's seed.
static void begin_next(WgCrew *crew, int64_t robot, float *observation)
{
    crew->episode[robot]++;
    int64_t world = wg_world_of_episode(crew->seed[robot], crew->episode[robot], crew->place_count);
    wg_crew_begin(crew, robot, world, observation);
}

// Applies an action: shares of the turn rate and of the top speed.
static void command(WgCrew *crew, int64_t robot, double turn, double speed)
{
    const WgRules *rules = crew->rules;
    const WgSettings *settings = settings_of(crew, robot);
    WgCommand wanted = {
        .speed = wg_clamp(speed, rules->slowest, 1.0) * settings->top_speed,
        .turn_rate = wg_clamp(turn, -1.0, 1.0) * rules->turn_rate,
    };
    WgArena arena = arena_of(crew, robot);
    wg_apply_command(&arena, settings, &wanted, crew->clock[robot], &crew->robots[robot]);
}

// Returns the value of a step, and notes the new distance.
static double reward_of(WgCrew *crew, int64_t robot, bool touched)
{
    const WgRules *rules = crew->rules;
    double before = crew->distance[robot];
    double now = distance_of(crew, robot);
    crew->distance[robot] = now;
    double reward = rules->progress * (before - now);
    reward += rules->time * crew->places[crew->world[robot]].settings.time_step;
    if (touched) {
        reward += rules->contact;
    }
    int64_t ending = crew->robots[robot].report.ending;
    if (ending == WG_REACHED) {
        reward += rules->reached;
    } else if (ending == WG_BURNED) {
        reward += rules->burned;
    }
    return reward;
}

// Applies one action of a robot whose episode continues.
static void act(WgCrew *crew, int64_t robot, double turn, double speed, const WgTold *told)
{
    float *observation = told->observation + robot * crew->size;
    const WgReport *report = &crew->robots[robot].report;
    bool touched = false;
    if (report->ending == WG_LIMIT) {
        command(crew, robot, turn, speed);
    }
    if (report->ending == WG_LIMIT) {
        touched = advance(crew, robot);
    } else {
        crew->robots[robot].contact = (WgNormal){0.0, 0.0};
        sense_at(crew, robot);  // it is where episodes end
    }
    observe(crew, robot, observation);
    crew->elapsed[robot]++;
    told->reward[robot] = reward_of(crew, robot, touched);
    told->terminated[robot] = report->ending != WG_LIMIT;
    told->reached[robot] = report->ending == WG_REACHED;
    told->truncated[robot] = crew->rules->limit > 0 && crew->elapsed[robot] >= crew->rules->limit;
    crew->over[robot] = told->terminated[robot] | told->truncated[robot];
    if (crew->over[robot] != 0 && crew->rules->autoreset == WG_SAME_STEP) {
        memcpy(told->last + robot * crew->size, observation, (size_t)crew->size * sizeof *observation);
        begin_next(crew, robot, observation);
        told->began[robot] = 1;
    }
}

WgStatus wg_crew_step(WgCrew *crew, const int64_t *chosen, const float *moves, const WgTold *told)
{
    for (int64_t robot = 0; chosen != NULL && robot < crew->count; robot++) {
        if (chosen[robot] < 0 || chosen[robot] >= crew->choice_count) {
            return WG_BAD_VALUE;
        }
    }
    for (int64_t robot = 0; robot < crew->count; robot++) {
        told->reward[robot] = 0.0;
        told->began[robot] = 0;
        told->reached[robot] = 0;
        told->terminated[robot] = 0;
        told->truncated[robot] = 0;
        if (crew->over[robot] != 0 && crew->rules->autoreset == WG_NEXT_STEP) {
            begin_next(crew, robot, told->observation + robot * crew->size);
            told->began[robot] = 1;
        } else if (chosen != NULL) {
            const double *choice = crew->choices + 2 * chosen[robot];
            act(crew, robot, choice[0], choice[1], told);
        } else {
            act(crew, robot, (double)moves[2 * robot], (double)moves[2 * robot + 1], told);
        }
    }
    return WG_OK;
}

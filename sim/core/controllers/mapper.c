// Mapping: keeps a small coarse map of where it could not pass, and drives the shortest path that
// the map leaves open.
//
// Sources: A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on Robotics and
// Automation 8 (1992); for the proof of arrival and its time bound, S. Koenig, C. Tovey and Y.
// Smirnov, "Performance bounds for planning in unknown terrain",
// Artificial Intelligence 147 (2003).

#include "boundary.h"
#include "directions.h"
#include "lattice_map.h"
#include "library.h"
#include "mapper.h"

static const double START = 0.0;
static const double GO = 1.0;
static const double DOOR = 2.0;
static const double TOUCH = 3.0;
static const double BACK = 4.0;

// fraction of the pitch: within this distance the robot is at a node
static const double THERE = 0.01;
static const double STANDS = 0.02;  // fraction of the pitch: a shorter free step cannot come nearer
static const double ALONG = 0.9;  // minimum progress, in steps, if a wall deflected the step
static const double PROBE = 0.2;  // fraction of the pitch: length of a step that feels for a wall
// after this many deflected steps on the way back, the robot takes the nearest node as its own
static const double MOST_TRIES = 12.0;

typedef struct Point {
    double x;  // m
    double y;
} Point;

static WgNode node_of(const WgMapperMemory *own)
{
    return (WgNode){(int64_t)own->from_x, (int64_t)own->from_y};
}

// Aligns the grid with the start, and moves the window half-way to the target.
static void begin(const WgObservation *seen, WgMapperMemory *own)
{
    own->start_x = seen->x;
    own->start_y = seen->y;
    double far = seen->target_distance / own->grid;
    own->target_x = far * wg_cos(seen->target_heading);
    own->target_y = far * wg_sin(seen->target_heading);
    double half = own->side / 2.0;
    own->window_x = (double)wg_floor(own->target_x / 2.0 - half);
    own->window_y = (double)wg_floor(own->target_y / 2.0 - half);
}

// Commands a step towards a point.
static void drive_to(const WgObservation *seen, WgMapperMemory *own, WgCommand *command, Point to)
{
    double length = wg_lower(seen->top_speed * seen->time_step, wg_distance(seen->x, seen->y, to.x, to.y));
    double turn = wg_wrap(wg_angle_of(to.x - seen->x, to.y - seen->y) - seen->heading);
    wg_steer(seen, command, turn, length / seen->time_step);
    own->x = seen->x;
    own->y = seen->y;
    own->step = length;
}

// Returns true if the robot is at a point, or as near as its steps allow.
static bool has_arrived(const WgObservation *seen, const WgMapperMemory *own, Point at)
{
    double left = wg_distance(seen->x, seen->y, at.x, at.y);
    double moved = wg_distance(seen->x, seen->y, own->x, own->y);
    double near = STANDS * own->grid;
    bool free = seen->bump == 0.0;
    return left < THERE * own->grid || (free && moved < near && left < 2.0 * near);
}

// Returns true if a wall stopped or bent the last step to a point.
static bool is_barred(const WgObservation *seen, const WgMapperMemory *own, Point to)
{
    double before = wg_distance(own->x, own->y, to.x, to.y);
    double after = wg_distance(seen->x, seen->y, to.x, to.y);
    return seen->bump != 0.0 && before - after < ALONG * own->step;
}

// Chooses the next move from the robot's node; returns false if memory for planning runs out.
static bool choose(WgMapperMemory *own)
{
    WgNode here = node_of(own);
    wg_map_move_window(own, here);
    int64_t move = wg_map_next_move(own);
    if (move < 0) {
        WgPlanned planned = wg_map_plan(own, here);
        if (planned == WG_NO_PATH) {
            wg_map_forget(own);  // the records contradict each other
            own->no_room = 0.0;
            planned = wg_map_plan(own, here);
        }
        if (planned == WG_NO_MEMORY) {
            return false;
        }
        move = wg_map_next_move(own);
    }
    own->mode = move < 0 ? DOOR : GO;
    own->move = (double)move;
    return true;
}

// Returns the point that the robot is driving to.
static Point goal_of(const WgObservation *seen, const WgMapperMemory *own)
{
    if (own->mode == DOOR) {
        double far = seen->target_distance;
        double heading = seen->target_heading;
        return (Point){seen->x + far * wg_cos(heading), seen->y + far * wg_sin(heading)};
    }
    if (own->mode == TOUCH) {
        double towards = wg_touched(seen);
        double length = PROBE * own->grid;
        return (Point){seen->x + length * wg_cos(towards), seen->y + length * wg_sin(towards)};
    }
    WgNode node = node_of(own);
    if (own->mode == GO) {
        node = wg_neighbour(node, (int64_t)own->move);
    }
    return (Point){own->start_x + own->grid * (double)node.x, own->start_y + own->grid * (double)node.y};
}

bool wg_mapper_feels(const WgObservation *seen, const WgMapperMemory *own, double *x, double *y)
{
    // The wall is right there only if the robot did not slide.
    bool slid = wg_distance(own->x, own->y, seen->x, seen->y) > STANDS * own->grid;
    if (own->mode != TOUCH || seen->bump == 0.0 || slid) {
        return false;
    }
    double towards = wg_touched(seen);
    *x = seen->x + seen->radius * wg_cos(towards);
    *y = seen->y + seen->radius * wg_sin(towards);
    return true;
}

void wg_mapper_learn(const WgObservation *seen, WgMapperMemory *own, double x, double y, double room)
{
    double at_x = (x - own->start_x) / own->grid;
    double at_y = (y - own->start_y) / own->grid;
    wg_map_block_near(own, at_x, at_y, room * seen->radius / own->grid);
}

// Records what blocked the path, and heads back; returns true if the robot has tried this often
// enough to start again from its position.
static bool turn_back(const WgObservation *seen, WgMapperMemory *own, bool barred)
{
    if (own->mode == GO) {
        wg_map_block(own, node_of(own), (int64_t)own->move);
    } else if (own->mode == DOOR) {
        wg_map_block_door(own, node_of(own));
    }
    own->tries += 1.0;
    own->mode = own->mode != BACK && barred && own->no_room > 0.0 ? TOUCH : BACK;
    if (own->tries < MOST_TRIES) {
        return false;
    }
    own->tries = 0.0;
    own->from_x = (double)wg_floor((seen->x - own->start_x) / own->grid + 0.5);
    own->from_y = (double)wg_floor((seen->y - own->start_y) / own->grid + 0.5);
    own->plan_length = 0.0;
    return true;
}

// Evaluates the last step; returns true if the robot is now at a node and needs a move.
static bool look(const WgObservation *seen, WgMapperMemory *own)
{
    Point goal = goal_of(seen, own);
    bool barred = is_barred(seen, own, goal);
    if (own->mode == TOUCH) {
        double x;
        double y;
        if (wg_mapper_feels(seen, own, &x, &y)) {
            wg_mapper_learn(seen, own, x, y, own->no_room);
        }
        own->mode = BACK;
        return false;
    }
    bool arrived = has_arrived(seen, own, goal);
    if (own->mode != DOOR && arrived) {
        if (own->mode == GO) {
            WgNode there = wg_neighbour(node_of(own), (int64_t)own->move);
            own->from_x = (double)there.x;
            own->from_y = (double)there.y;
        }
        own->tries = 0.0;
        return true;
    }
    if (!barred && !(own->mode == DOOR && arrived)) {
        return false;
    }
    return turn_back(seen, own, barred);
}

void wg_mapper_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgMapperMemory *own = (WgMapperMemory *)memory;
    bool decides = true;
    if (own->mode == START) {
        begin(seen, own);
    } else {
        decides = look(seen, own);
    }
    if (decides && !choose(own)) {
        command->error = "MemoryError: no memory to plan in";
        return;
    }
    drive_to(seen, own, command, goal_of(seen, own));
}

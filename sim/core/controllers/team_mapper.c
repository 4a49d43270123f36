// A team of mappers: each tells the others where it has touched walls, and marks what it hears on its
// own map as if it had touched that wall itself.
//
// A robot passes on what it hears, so a wall becomes known to robots that never meet the one that
// touched it. Only places of walls are told, in the world's frame: each robot decides by its own
// radius what they block. Robots that it touches are not told, because they move.
//
// Source: Wolfram Burgard, Mark Moors, Cyrill Stachniss and Frank E. Schneider, "Coordinated
// multi-robot exploration", IEEE Transactions on Robotics 21 (2005), whose robots merge their maps
// whenever they can communicate.

#include <stdbool.h>

#include "directions.h"
#include "library.h"
#include "mapper.h"

static const double SAME = 0.02;   // m: a place nearer than this to a known one says nothing new
static const double LEFT = 2.0;    // steps: by this much a robot may have left the place where it was touched

static bool is_known(const WgTeamMemory *own, double x, double y)
{
    for (int64_t k = 0; k < (int64_t)own->count; k++) {
        if (fabs(own->points[k][0] - x) < SAME && fabs(own->points[k][1] - y) < SAME) {
            return true;
        }
    }
    return false;
}

static void remember(WgTeamMemory *own, double x, double y)
{
    int64_t at = (int64_t)own->next;
    own->points[at][0] = x;
    own->points[at][1] = y;
    own->next = (double)((at + 1) % WG_TEAM_POINTS);
    own->count = wg_lower(own->count + 1.0, WG_TEAM_POINTS);
}

// Returns true if a place is on a robot that is sensed.
static bool is_robot(const WgObservation *seen, double x, double y)
{
    double along = wg_cos(seen->heading);
    double across = wg_sin(seen->heading);
    double left = LEFT * seen->top_speed * seen->time_step;
    for (int64_t k = 0; k < seen->neighbour_count; k++) {
        const WgNeighbour *other = &seen->neighbours[k];
        double at_x = seen->x + along * other->x - across * other->y;
        double at_y = seen->y + across * other->x + along * other->y;
        if (wg_distance(x, y, at_x, at_y) < other->radius + left) {
            return true;
        }
    }
    return false;
}

// Adds the points that the others send. A pair of zeros is not a point.
static void hear(const WgObservation *seen, WgTeamMemory *own, WgMapperMemory *driver)
{
    for (int64_t k = 0; k < seen->neighbour_count; k++) {
        const double *told = seen->neighbours[k].message;
        for (int64_t at = 0; at + 1 < seen->message_size; at += 2) {
            bool nothing = told[at] == 0.0 && told[at + 1] == 0.0;
            if (nothing || is_known(own, told[at], told[at + 1])) {
                continue;
            }
            remember(own, told[at], told[at + 1]);
            wg_mapper_learn(seen, driver, told[at], told[at + 1], driver->no_room);
        }
    }
}

// Sends as many points as fit into a message, in turn.
static void send_points(const WgObservation *seen, WgTeamMemory *own, WgCommand *command)
{
    int64_t places = wg_least(seen->message_size / 2, (int64_t)own->count);
    for (int64_t k = 0; k < places; k++) {
        int64_t at = (int64_t)own->next_sent % (int64_t)own->count;
        command->message[2 * k] = own->points[at][0];
        command->message[2 * k + 1] = own->points[at][1];
        own->next_sent = (double)(at + 1);
    }
}

void wg_team_mapper_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgTeamMemory *own = (WgTeamMemory *)memory;
    WgMapperMemory *driver = (WgMapperMemory *)(own + 1);
    double x;
    double y;
    if (wg_mapper_feels(seen, driver, &x, &y) && !is_robot(seen, x, y) && !is_known(own, x, y)) {
        remember(own, x, y);
    }
    bool has_map = driver->mode != 0.0;
    if (has_map) {
        hear(seen, own, driver);
    }
    double room = driver->no_room;
    wg_mapper_act(seen, (double *)driver, command);

    // The mapper empties its map where no path remains. In a team that is because a robot stood in
    // the way, so the walls are still where they were.
    if (driver->no_room < room) {
        driver->no_room = room;
        for (int64_t k = 0; k < (int64_t)own->count; k++) {
            wg_mapper_learn(seen, driver, own->points[k][0], own->points[k][1], room);
        }
    }
    send_points(seen, own, command);
}

// Hybrid A*: poses of a car, of which one is kept for each bin of places and headings, joined by
// arcs and lines whose legs are exact.
//
// Three kinds of edges leave a pose. Primitives are a short line and short arcs of the turning
// circle. Shots are the shortest curves to the target. Merges lead onto the line along which the
// body touches the nearest wall, and there the car has as much room as it can have to turn away;
// bends that are only just wide enough need them.
//
// Source: D. Dolgov, S. Thrun, M. Montemerlo and J. Diebel, "Path planning for autonomous vehicles
// in unknown semi-structured environments", The International Journal of Robotics Research 29
// (2010). Merges are our own.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drive.h"
#include "heap.h"

enum {
    PARTS = 3,              // most parts of an edge
    FAR_AWAY = 1 << 28,     // larger than the length of any path, half lu
    QUARTER = WG_TURN / 4,
    MOST_ARC = WG_TURN / 8,  // units of a primitive's arc
};

// How much more a path is worth that is shorter already than one that is likely to be.
static const double GREED = 1.5;
// Factor of the cost of driving backwards.
static const double BACKWARDS = 1.5;
// Shots begin where the target is this near, turning radii; from farther away they are rarer.
static const double NEAR = 6.0;

// A pose that was reached, and how.
typedef struct Node {
    WgCarPose pose;
    double cost;
    int32_t parent;
    int8_t is_along_wall;  // it touches the nearest wall, up to rounding
    int8_t count;
    int8_t backwards;      // the gear of its last part
    int8_t steer[PARTS];
    double amount[PARTS];
} Node;

typedef struct Search {
    WgCar car;
    Node *nodes;
    int64_t count;
    int64_t room;
    WgHeap queue;
    uint64_t *bins;      // hash set of the bins of expanded poses; 0 is empty
    int64_t bin_room;    // a power of two
    int64_t bin_count;
    int32_t *distances;  // of nodes at half cells from the target, half lu
    int64_t rows;
    int64_t columns;
    int64_t last;        // the node that is in the target, or -1
    WgCarRoute shot;     // the curve from there
    bool has_no_room;
} Search;

// The length of the shortest path over half cells for the body's largest disc, from every node.
static WgStatus measure(Search *search)
{
    const WgWalls *walls = search->car.walls;
    const WgCarQuery *asked = search->car.asked;
    search->rows = 2 * walls->height + 1;
    search->columns = 2 * walls->width + 1;
    int64_t stride = search->columns;
    int64_t nodes = search->rows * stride;
    uint8_t *clear = malloc((size_t)nodes);
    uint8_t *middle = malloc((size_t)nodes);
    search->distances = malloc((size_t)nodes * sizeof *search->distances);
    WgHeap heap = {NULL, 0, 0};
    bool fits = clear != NULL && middle != NULL && search->distances != NULL;
    WgStatus status = fits ? wg_disc_rasters(walls->solid, walls->height, walls->width, 2, asked->clear_from,
                                             clear, middle)
                           : WG_OUT_OF_MEMORY;
    for (int64_t node = 0; status == WG_OK && node < nodes; node++) {
        search->distances[node] = FAR_AWAY;
    }

    // Begin at the nodes in the target and right around it.
    const double half = (double)WG_UNIT / 2.0;
    double reach = asked->target_radius + 1.5 * half;
    int64_t top = wg_min(search->rows - 1, (int64_t)floor((asked->target_y + reach) / half));
    int64_t right = wg_min(stride - 1, (int64_t)floor((asked->target_x + reach) / half));
    for (int64_t j = wg_max(0, (int64_t)ceil((asked->target_y - reach) / half)); status == WG_OK && j <= top; j++) {
        for (int64_t i = wg_max(0, (int64_t)ceil((asked->target_x - reach) / half)); i <= right; i++) {
            double dx = (double)i * half - asked->target_x;
            double dy = (double)j * half - asked->target_y;
            double away = fmax(0.0, sqrt(dx * dx + dy * dy) - asked->target_radius);
            int64_t node = j * stride + i;
            if (node < nodes && away <= 1.5 * half && clear[node] != 0) {
                search->distances[node] = (int32_t)(2.0 * away);
                fits = fits && wg_heap_push(&heap, (WgEntry){search->distances[node], node, 0});
            }
        }
    }
    int64_t shifts[8];
    int64_t corners[8];
    wg_eight_steps(stride, shifts, corners);
    while (status == WG_OK && fits && heap.count > 0) {
        WgEntry entry = wg_heap_pop(&heap);
        if (entry.key > search->distances[entry.second]) {
            continue;
        }
        for (int step = 0; step < 8; step++) {
            // The rim of the grid is not clear, so every neighbour exists.
            int64_t next = entry.second + shifts[step];
            bool open = clear[next] != 0 && (step < 4 || middle[entry.second + corners[step]] != 0);
            int64_t distance = entry.key + (step < 4 ? WG_UNIT : 1448);
            if (open && distance < search->distances[next] && distance < FAR_AWAY) {
                search->distances[next] = (int32_t)distance;
                fits = fits && wg_heap_push(&heap, (WgEntry){distance, next, 0});
            }
        }
    }
    free(heap.entries);
    free(clear);
    free(middle);
    return status == WG_OK && !fits ? WG_OUT_OF_MEMORY : status;
}

// An estimate of the length of the path from a pose to the target, lu.
static double estimate(const Search *search, WgCarPose pose)
{
    const double half = (double)WG_UNIT / 2.0;
    int64_t column = (int64_t)floor(pose.x / half);
    int64_t row = (int64_t)floor(pose.y / half);
    double best = INFINITY;
    // A pose that is clear is inside the grid.
    for (int corner = 0; corner < 4; corner++) {
        int64_t i = column + (corner & 1);
        int64_t j = row + (corner >> 1);
        if (i < 0 || j < 0 || i >= search->columns || j >= search->rows) {
            continue;
        }
        int32_t distance = search->distances[j * search->columns + i];
        if (distance < FAR_AWAY) {
            double dx = (double)i * half - pose.x;
            double dy = (double)j * half - pose.y;
            best = fmin(best, 0.5 * (double)distance + sqrt(dx * dx + dy * dy));
        }
    }
    if (best < INFINITY) {
        return best;
    }
    // Half cells are too coarse here: such poses come last.
    double dx = search->car.asked->target_x - pose.x;
    double dy = search->car.asked->target_y - pose.y;
    return sqrt(dx * dx + dy * dy) + (double)FAR_AWAY;
}

// The bin of a pose, above 0.
static uint64_t bin_of(const Search *search, WgCarPose pose, bool is_along_wall)
{
    const WgCarQuery *asked = search->car.asked;
    uint64_t x = (uint64_t)(int64_t)floor(pose.x / asked->bin) & 0xFFFFFF;
    uint64_t y = (uint64_t)(int64_t)floor(pose.y / asked->bin) & 0xFFFFFF;
    uint64_t heading = (uint64_t)((pose.heading * asked->heading_bins + WG_TURN / 2) / WG_TURN);
    heading %= (uint64_t)asked->heading_bins;
    // Places have 24 bits each, headings 14.
    return ((x << 24 | y) << 14 | heading) << 2 | (is_along_wall ? 3U : 1U);
}

static int64_t place_in(const uint64_t *bins, int64_t room, uint64_t bin)
{
    uint64_t hash = (bin ^ bin >> 29) * 0x9E3779B97F4A7C15U;
    int64_t at = (int64_t)((hash ^ hash >> 32) & (uint64_t)(room - 1));
    while (bins[at] != 0 && bins[at] != bin) {
        at = (at + 1) & (room - 1);
    }
    return at;
}

// Adds a bin; returns false if it is there already. Sets ``has_no_room`` if memory runs out.
static bool add_bin(Search *search, uint64_t bin)
{
    if (2 * search->bin_count >= search->bin_room) {
        int64_t room = search->bin_room > 0 ? 2 * search->bin_room : 1 << 14;
        uint64_t *bins = calloc((size_t)room, sizeof *bins);
        if (bins == NULL) {
            search->has_no_room = true;
            return false;
        }
        for (int64_t at = 0; at < search->bin_room; at++) {
            if (search->bins[at] != 0) {
                bins[place_in(bins, room, search->bins[at])] = search->bins[at];
            }
        }
        free(search->bins);
        search->bins = bins;
        search->bin_room = room;
    }
    int64_t at = place_in(search->bins, search->bin_room, bin);
    if (search->bins[at] == bin) {
        return false;
    }
    search->bins[at] = bin;
    search->bin_count++;
    return true;
}

// Keeps a pose. Returns its number, or -1 if memory runs out.
static int64_t append(Search *search, Node node)
{
    if (search->count == search->room) {
        int64_t room = 2 * search->room + 1024;
        Node *nodes = room <= INT32_MAX ? realloc(search->nodes, (size_t)room * sizeof *nodes) : NULL;
        if (nodes == NULL) {
            search->has_no_room = true;
            return -1;
        }
        search->nodes = nodes;
        search->room = room;
    }
    search->nodes[search->count] = node;
    return search->count++;
}

// Returns true if a pose of a bin was expanded.
static bool is_taken(const Search *search, uint64_t bin)
{
    return search->bin_room > 0 && search->bins[place_in(search->bins, search->bin_room, bin)] == bin;
}

// Adds a pose to the queue.
static void push(Search *search, Node node)
{
    double rank = node.cost + GREED * estimate(search, node.pose);
    int64_t added = append(search, node);
    if (added >= 0 && !wg_heap_push(&search->queue, (WgEntry){(int64_t)floor(rank), added, 0})) {
        search->has_no_room = true;
    }
}

// Returns true if parts may lead through the target.
static bool may_arrive(const Search *search, WgCarPose pose, const WgCarPart *parts, int64_t count)
{
    const WgCarQuery *asked = search->car.asked;
    double dx = asked->target_x - pose.x;
    double dy = asked->target_y - pose.y;
    double reach = asked->target_radius + 1.0;
    for (int64_t part = 0; part < count; part++) {
        reach += wg_car_length(&search->car, parts[part]);
    }
    return dx * dx + dy * dy <= reach * reach;
}

// Drives an edge from a node and adds its end. Returns true if it arrived.
static bool follow_edge(Search *search, int64_t from, const WgCarPart *parts, int64_t count, bool is_along_wall)
{
    const Node *before = &search->nodes[from];
    WgCarPose end = wg_car_end(&search->car, before->pose, parts, count);
    // Most edges of a long search end where it has been.
    if (is_taken(search, bin_of(search, end, is_along_wall)) && !may_arrive(search, before->pose, parts, count)) {
        return false;
    }
    Node node = {before->pose, before->cost, (int32_t)from, (int8_t)is_along_wall, (int8_t)count,
                 before->backwards, {0}, {0}};
    WgDriven driven = wg_car_drive(&search->car, &node.pose, parts, count, true, NULL);
    if (driven == WG_HIT) {
        return false;
    }
    for (int64_t part = 0; part < count; part++) {
        node.steer[part] = (int8_t)parts[part].steer;
        node.amount[part] = parts[part].amount;
        int8_t backwards = parts[part].amount < 0.0 ? 1 : 0;
        node.cost += wg_car_length(&search->car, parts[part]) * (backwards ? BACKWARDS : 1.0);
        // Each change of gear costs as much as half a cell.
        node.cost += from > 0 && backwards != node.backwards ? 0.5 * WG_UNIT : 0.0;
        node.backwards = backwards;
    }
    if (driven == WG_ARRIVED) {
        search->last = append(search, node);
        return search->last >= 0;
    }
    push(search, node);
    return false;
}

// Tries curves to the target. Returns true if one arrives.
static bool shoot(Search *search, int64_t from)
{
    const WgCarQuery *asked = search->car.asked;
    WgCarPose pose = search->nodes[from].pose;
    WgCarPose goal = {asked->target_x, asked->target_y, asked->from_heading + asked->headings / 2};
    goal.heading = wg_car_heading(goal.heading);
    double dx = goal.x - pose.x;
    double dy = goal.y - pose.y;
    if (asked->headings == WG_TURN - 1) {
        // Any heading will do: about that of the straight line is one of the shortest.
        double bearing = wg_car_atan2(dy, dx) * (double)WG_TURN / (2.0 * WG_CAR_PI);
        goal.heading = wg_car_heading((int64_t)floor(bearing + 0.5));
    }
    WgCarRoute routes[WG_MOST_CURVES];
    int64_t count = wg_min(wg_car_routes(&search->car, pose, goal, routes), 4);
    for (int64_t r = 0; r < count; r++) {
        WgCarPose end = pose;
        WgDriven driven = wg_car_drive(&search->car, &end, routes[r].parts, routes[r].count, true, NULL);
        if (driven == WG_ARRIVED) {
            search->last = from;
            search->shot = routes[r];
            return true;
        }
    }
    return false;
}

// The distance, lu, from the axle to the face of the nearest wall along an axis; its direction is
// 0 for +x, and then counter-clockwise.
static double face_distance(const WgWalls *walls, WgCarPose pose, int64_t direction)
{
    const int64_t steps_x[4] = {1, 0, -1, 0};
    const int64_t steps_y[4] = {0, 1, 0, -1};
    int64_t ix = wg_cell_of((int64_t)floor(pose.x));
    int64_t iy = wg_cell_of((int64_t)floor(pose.y));
    while (!wg_is_solid(walls, ix, iy)) {
        ix += steps_x[direction];
        iy += steps_y[direction];
    }
    switch (direction) {
        case 0:
            return (double)(ix * WG_UNIT) - pose.x;
        case 1:
            return (double)(iy * WG_UNIT) - pose.y;
        case 2:
            return pose.x - (double)((ix + 1) * WG_UNIT);
        default:
            return pose.y - (double)((iy + 1) * WG_UNIT);
    }
}

// Finds the edge onto the line along a wall: a line and an arc, or two arcs if it is parallel.
// Returns its number of parts; 0 if there is none.
static int64_t merge_onto(const WgCar *car, WgCarPose pose, int64_t wall, int64_t heading, double apart,
                          WgCarPart *parts)
{
    double radius = car->asked->turning_radius;
    int64_t turn = wg_turn_between(pose.heading, heading);
    if (wg_abs(turn) > WG_TURN * 3 / 8) {
        return 0;
    }
    // Where the wall is, seen along the line: 1 to the left, -1 to the right.
    int64_t side = wg_turn_between(heading, wall * QUARTER) > 0 ? 1 : -1;
    if (turn == 0) {
        double cosine = 1.0 - 0.5 * apart / radius;
        if (apart < 1.0 || cosine < 0.0) {
            return 0;
        }
        double units = floor(wg_car_acos(cosine) * (double)WG_TURN / (2.0 * WG_CAR_PI));
        parts[0] = (WgCarPart){side, units};
        parts[1] = (WgCarPart){-side, units};
        return 2;
    }
    // The arc comes nearer to the wall by a known distance; the line makes up the rest.
    WgAngle along = wg_car_direction(pose.heading - wall * QUARTER);
    WgAngle after = wg_car_direction(heading - wall * QUARTER);
    double nearer = radius * (turn > 0 ? after.sine - along.sine : along.sine - after.sine);
    double line = along.cosine > 0.01 ? (apart - nearer) / along.cosine : -1.0;
    if (!(line >= 0.0)) {
        return 0;
    }
    parts[0] = (WgCarPart){0, line};
    parts[1] = (WgCarPart){turn > 0 ? 1 : -1, (double)wg_abs(turn)};
    return 2;
}

// How far the body reaches from the axle to a wall beside it: on its right if ``side`` is 1, on its
// left if it is 3; lu.
static double reach_to(const WgCarQuery *asked, int64_t side)
{
    if (asked->body == NULL) {
        return (double)asked->disc.reach;
    }
    int64_t reach = INT64_MIN;
    for (int64_t corner = 0; corner < asked->body->count; corner++) {
        int64_t left = asked->body->corners[2 * corner + 1];
        reach = wg_max(reach, side == 1 ? -left : left);
    }
    return (double)reach;
}

// Adds the lines along the walls around a pose. Returns true if one arrives.
static bool merge(Search *search, int64_t from)
{
    const WgCar *car = &search->car;
    for (int64_t wall = 0; wall < 4; wall++) {
        WgCarPose pose = search->nodes[from].pose;
        double face = face_distance(car->walls, pose, wall);
        for (int64_t side = 1; side <= 3; side += 2) {
            int64_t heading = wg_car_heading((wall + side) * QUARTER);
            double apart = face - reach_to(car->asked, side);
            WgCarPart parts[PARTS];
            int64_t count = apart >= 0.0 ? merge_onto(car, pose, wall, heading, apart, parts) : 0;
            if (count > 0 && follow_edge(search, from, parts, count, true)) {
                return true;
            }
        }
    }
    return false;
}

// Adds everything that a pose leads to. Returns true if something arrives.
static bool expand(Search *search, int64_t from)
{
    const WgCarQuery *asked = search->car.asked;
    double radius = asked->turning_radius;
    double left = estimate(search, search->nodes[from].pose);
    int64_t every = left < NEAR * radius ? 1 : (int64_t)fmin(64.0, left / (NEAR * radius) * 4.0) + 1;
    if (asked->expanded % every == 0 && shoot(search, from)) {
        return true;
    }
    // A little more than a bin's diagonal leads out of it.
    double length = 1.5 * asked->bin;
    double units = fmin(floor(length / radius * (double)WG_TURN / (2.0 * WG_CAR_PI)), MOST_ARC);
    for (int64_t gear = 1; gear >= (asked->reverse != 0 ? -1 : 1); gear -= 2) {
        for (int64_t steer = -1; steer <= 1; steer++) {
            WgCarPart part = {steer, (double)gear * (steer == 0 ? length : fmax(2.0, units))};
            bool is_along_wall = steer == 0 && search->nodes[from].is_along_wall != 0;
            if (follow_edge(search, from, &part, 1, is_along_wall)) {
                return true;
            }
        }
    }
    return merge(search, from);
}

// Drives the path again and keeps its poses.
static WgStatus retrace(Search *search, WgCarQuery *asked)
{
    int64_t count = 0;
    for (int64_t node = search->last; node > 0; node = search->nodes[node].parent) {
        count++;
    }
    int64_t *order = calloc((size_t)(count + 1), sizeof *order);
    WgCarTrail trail = {malloc(3 * sizeof(int64_t)), 1, 1};
    if (order == NULL || trail.values == NULL) {
        free(order);
        free(trail.values);
        return WG_OUT_OF_MEMORY;
    }
    int64_t at = count;
    for (int64_t node = search->last; node > 0 && at > 0; node = search->nodes[node].parent) {
        order[--at] = node;
    }
    WgCarPose pose = search->nodes[0].pose;
    trail.values[0] = (int64_t)floor(pose.x + 0.5);
    trail.values[1] = (int64_t)floor(pose.y + 0.5);
    trail.values[2] = pose.heading;
    WgDriven driven = WG_DRIVEN;
    for (int64_t k = 0; k < count && driven == WG_DRIVEN; k++) {
        const Node *node = &search->nodes[order[k]];
        WgCarPart parts[PARTS];
        for (int64_t part = 0; part < node->count; part++) {
            parts[part] = (WgCarPart){node->steer[part], node->amount[part]};
        }
        driven = wg_car_drive(&search->car, &pose, parts, node->count, true, &trail);
    }
    if (driven == WG_DRIVEN && search->shot.count > 0) {
        driven = wg_car_drive(&search->car, &pose, search->shot.parts, search->shot.count, true, &trail);
    }
    free(order);
    asked->poses = trail.values;
    asked->count = trail.count;
    return driven == WG_NO_ROOM ? WG_OUT_OF_MEMORY : WG_OK;
}

WgStatus wg_car_search(const WgWalls *walls, WgCarQuery *asked)
{
    bool fits = walls->height > 0 && walls->width > 0 &&
                (asked->body == NULL || wg_body_is_valid(walls, asked->body)) && asked->turning_radius > 0.0 &&
                asked->bin >= 2.0 && asked->heading_bins >= 1 && asked->heading_bins <= 1 << 14 && asked->start_heading >= 0 && asked->start_heading < WG_TURN;
    if (!fits) {
        return WG_BAD_VALUE;
    }
    Search search = {wg_car_of(walls, asked), NULL, 0, 0, {NULL, 0, 0}, NULL, 0, 0, NULL, 0, 0, -1, {0, {{0}}, 0.0},
                     false};
    asked->expanded = 0;
    asked->count = 0;
    asked->poses = NULL;
    WgStatus status = measure(&search);
    if (status == WG_OK) {
        WgCarPose start = {asked->start_x, asked->start_y, asked->start_heading};
        push(&search, (Node){start, 0.0, -1, 0, 0, 0, {0}, {0}});
        search.last = wg_car_is_there(&search.car, start) ? 0 : -1;
        bool found = search.last == 0;
        while (!found && !search.has_no_room && search.queue.count > 0 && asked->expanded < asked->most) {
            int64_t node = wg_heap_pop(&search.queue).second;
            if (add_bin(&search, bin_of(&search, search.nodes[node].pose, search.nodes[node].is_along_wall != 0))) {
                found = expand(&search, node);
                asked->expanded++;
            }
        }
        status = found ? retrace(&search, asked) : search.has_no_room ? WG_OUT_OF_MEMORY : WG_OK;
    }
    free(search.nodes);
    free(search.queue.entries);
    free(search.bins);
    free(search.distances);
    return status;
}

void wg_car_free(WgCarQuery *asked)
{
    free(asked->poses);
    asked->poses = NULL;
    asked->count = 0;
}

// Finds the robots that may meet in a move. A grid with buckets as wide as two robots can approach
// each other makes the cost of a step depend on their number, not on the number of all pairs.

#include "fleet.h"

// The bucket of a place.
static int64_t bucket_of(const WgNear *near, int64_t column, int64_t row)
{
    // Large odd numbers without a pattern spread neighbouring columns and rows over the buckets.
    uint64_t mixed = (uint64_t)column * 0x9E3779B97F4A7C15u + (uint64_t)row * 0xC2B2AE3D27D4EB4Fu;
    return (int64_t)((mixed >> 32) & (uint64_t)(near->buckets - 1));
}

// The root of a robot's cluster, which is a tree.
static int64_t root_of(WgMover *movers, int64_t robot)
{
    while (movers[robot].cluster != robot) {
        movers[robot].cluster = movers[movers[robot].cluster].cluster;
        robot = movers[robot].cluster;
    }
    return robot;
}

// Returns true if a robot may move in this part of the step.
static bool may_move(const WgFleet *fleet, int64_t robot)
{
    return fleet->movers[robot].far > fleet->members[robot]->settings->reach;
}

// Notes a pair that may meet.
static void look_at(WgFleet *fleet, int64_t one, int64_t other)
{
    WgMover *movers = fleet->movers;
    int64_t dx = movers[one].place.x - movers[other].place.x;
    int64_t dy = movers[one].place.y - movers[other].place.y;
    int64_t far = movers[one].far + movers[other].far;
    if (dx * dx + dy * dy >= far * far || (!may_move(fleet, one) && !may_move(fleet, other))) {
        return;
    }
    const WgFleetSettings *settings = fleet->settings;
    int64_t clear_sq = settings->clear_sq[settings->kind[one] * settings->kinds + settings->kind[other]];
    fleet->near->pairs[fleet->near->pair_count++] = (WgPair){one, other, clear_sq, 2.0, -1};
    movers[root_of(movers, one)].cluster = root_of(movers, other);
}

static void look_at_all(WgFleet *fleet)
{
    for (int64_t one = 0; one < fleet->count; one++) {
        for (int64_t other = 0; other < one; other++) {
            look_at(fleet, one, other);
        }
    }
}

// Puts the robots of a fleet into a grid whose cells are `width` lattice units wide.
static void fill_buckets(WgFleet *fleet, int64_t width)
{
    WgNear *near = fleet->near;
    for (int64_t k = 0; k < near->buckets; k++) {
        near->heads[k] = -1;
    }
    for (int64_t k = 0; k < fleet->count; k++) {
        WgMover *mover = &fleet->movers[k];
        mover->column = wg_floor_div(mover->place.x, width);
        mover->row = wg_floor_div(mover->place.y, width);
        int64_t own = bucket_of(near, mover->column, mover->row);
        near->chain[k] = near->heads[own];
        near->heads[own] = k;
    }
}

// Returns the robot, or the next one of its bucket, that is in a cell;
// several cells may share a bucket.
static int64_t one_in(const WgFleet *fleet, int64_t robot, int64_t column, int64_t row)
{
    while (robot >= 0 && (fleet->movers[robot].column != column || fleet->movers[robot].row != row)) {
        robot = fleet->near->chain[robot];
    }
    return robot;
}

// Returns the first robot in a cell, or -1.
static int64_t first_in(const WgFleet *fleet, int64_t column, int64_t row)
{
    return one_in(fleet, fleet->near->heads[bucket_of(fleet->near, column, row)], column, row);
}

// Returns the next robot in the same cell as a robot, or -1.
static int64_t next_in(const WgFleet *fleet, int64_t robot)
{
    const WgMover *mover = &fleet->movers[robot];
    return one_in(fleet, fleet->near->chain[robot], mover->column, mover->row);
}

// For each robot, examines its own cell and four of the eight around it, because each pair of
// neighbouring cells has to be checked only once.
static void look_around(WgFleet *fleet)
{
    static const int64_t OTHER_CELLS[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};
    int64_t furthest = 1;
    for (int64_t k = 0; k < fleet->count; k++) {
        furthest = wg_most(furthest, fleet->movers[k].far);
    }
    fill_buckets(fleet, 2 * furthest);
    for (int64_t k = 0; k < fleet->count; k++) {
        for (int64_t other = next_in(fleet, k); other >= 0; other = next_in(fleet, other)) {
            look_at(fleet, k, other);
        }
        for (int which = 0; which < 4; which++) {
            int64_t column = fleet->movers[k].column + OTHER_CELLS[which][0];
            int64_t row = fleet->movers[k].row + OTHER_CELLS[which][1];
            int64_t other = first_in(fleet, column, row);
            for (; other >= 0; other = next_in(fleet, other)) {
                look_at(fleet, k, other);
            }
        }
    }
}

void wg_find_near(WgFleet *fleet)
{
    WgNear *near = fleet->near;
    WgMover *movers = fleet->movers;
    near->pair_count = 0;
    for (int64_t k = 0; k < fleet->count; k++) {
        movers[k].cluster = k;
        movers[k].next = -1;
        near->first[k] = -1;
        near->first_pair[k] = -1;
    }
    if (fleet->count <= WG_FEW_ROBOTS) {
        look_at_all(fleet);
    } else {
        look_around(fleet);
    }

    // Link the pairs of each cluster, and its robots; a robot that cannot meet another one is not
    // in any cluster.
    for (int64_t k = 0; k < near->pair_count; k++) {
        int64_t root = root_of(movers, near->pairs[k].one);
        near->pairs[k].next = near->first_pair[root];
        near->first_pair[root] = k;
    }
    for (int64_t k = 0; k < fleet->count; k++) {
        int64_t root = root_of(movers, k);
        movers[k].cluster = root;
        if (near->first_pair[root] >= 0) {
            movers[k].next = near->first[root];
            near->first[root] = k;
        }
    }
}

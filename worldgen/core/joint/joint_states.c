// Joint states, which hold the positions of all robots at once, and the functions that every search
// over them needs.

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "joint_states.h"

static uint64_t hash_of_places(const WgJointStates *states, const int32_t *places, int64_t tick)
{
    uint64_t hash = (uint64_t)wg_min(tick, states->joint->ticks - 1);
    for (int64_t robot = 0; robot < states->joint->robots; robot++) {
        hash = (hash ^ (uint64_t)places[robot]) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 31;
    }
    return hash;
}

static bool grow_states_table(WgJointStates *states)
{
    int64_t size = 4 * (states->mask + 1);
    int32_t *table = calloc((size_t)size, sizeof *table);
    if (table == NULL) {
        return false;
    }
    for (int64_t i = 0; i < states->count; i++) {
        uint64_t at = hash_of_places(states, wg_places_of(states, i), states->nodes[i].tick);
        while (table[at & (uint64_t)(size - 1)] != 0) {
            at++;
        }
        table[at & (uint64_t)(size - 1)] = (int32_t)i + 1;
    }
    free(states->table);
    states->table = table;
    states->mask = size - 1;
    return true;
}

WgStatus wg_add_state(WgJointStates *states, const int32_t *places, int64_t tick, int64_t parent, int64_t *index)
{
    int64_t robots = states->joint->robots;
    int64_t moment = wg_min(tick, states->joint->ticks - 1);
    uint64_t at = hash_of_places(states, places, tick);
    *index = -1;
    for (; states->table[at & (uint64_t)states->mask] != 0; at++) {
        int64_t known = states->table[at & (uint64_t)states->mask] - 1;
        assert(known < states->count && states->nodes != NULL);
        if (wg_min(states->nodes[known].tick, states->joint->ticks - 1) == moment &&
            memcmp(wg_places_of(states, known), places, (size_t)robots * sizeof *places) == 0) {
            return WG_OK;
        }
    }
    if (states->count == states->room) {
        int64_t room = 2 * states->room + 256;
        WgJointNode *nodes = realloc(states->nodes, (size_t)room * sizeof *nodes);
        if (nodes == NULL) {
            return WG_OUT_OF_MEMORY;
        }
        states->nodes = nodes;
        int32_t *all = realloc(states->places, (size_t)(room * robots) * sizeof *all);
        if (all == NULL) {
            return WG_OUT_OF_MEMORY;
        }
        states->places = all;
        states->room = room;
    }
    *index = states->count++;
    states->table[at & (uint64_t)states->mask] = (int32_t)*index + 1;
    states->nodes[*index] = (WgJointNode){(int32_t)parent, (int32_t)tick, -1, -1};
    memcpy(states->places + *index * robots, places, (size_t)robots * sizeof *places);
    return 2 * states->count < states->mask || grow_states_table(states) ? WG_OK : WG_OUT_OF_MEMORY;
}

WgStatus wg_begin_states(WgJointStates *states, const WgJoint *joint)
{
    *states = (WgJointStates){.joint = joint, .moves = wg_moves(joint), .mask = 1023};
    states->table = calloc((size_t)states->mask + 1, sizeof *states->table);
    int32_t *places = malloc((size_t)joint->robots * sizeof *places);
    WgStatus status = WG_OUT_OF_MEMORY;
    if (states->table != NULL && places != NULL) {
        for (int64_t robot = 0; robot < joint->robots; robot++) {
            places[robot] = (int32_t)joint->starts[robot];
        }
        int64_t index;
        status = wg_add_state(states, places, 0, -1, &index);
    }
    free(places);
    return status;
}

void wg_end_states(WgJointStates *states)
{
    free(states->nodes);
    free(states->places);
    free(states->table);
}

bool wg_is_end(const WgJointStates *states, int64_t index)
{
    const WgJoint *joint = states->joint;
    const int32_t *places = wg_places_of(states, index);
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        if (wg_distance_of(joint, robot, places[robot]) != 0) {
            return false;
        }
    }
    for (int64_t tick = states->nodes[index].tick; tick < joint->ticks; tick++) {
        for (int64_t robot = 0; robot < joint->robots; robot++) {
            if (joint->clear[wg_raster_at(joint, tick, joint->class_of[robot]) + places[robot]] == 0) {
                return false;
            }
        }
    }
    return true;
}

WgStatus wg_plan_to(const WgJointStates *states, int64_t last, WgJointPlan **made)
{
    int64_t robots = states->joint->robots;
    *made = wg_joint_plan_new(robots, states->nodes[last].tick);
    if (*made == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t i = last; i >= 0; i = states->nodes[i].parent) {
        memcpy((*made)->nodes + states->nodes[i].tick * robots, wg_places_of(states, i),
               (size_t)robots * sizeof(int32_t));
    }
    return WG_OK;
}

bool wg_leads_nowhere(const WgJoint *joint)
{
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        if (wg_distance_of(joint, robot, joint->starts[robot]) < 0) {
            return true;
        }
    }
    return false;
}

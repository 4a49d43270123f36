// Joint plans: checks, plans in memory, and breadth-first distances.

#include <stdlib.h>

#include "joint_states.h"

WgStatus wg_joint_check(const WgJoint *joint)
{
    bool sized = joint->robots >= 1 && joint->robots <= INT16_MAX && joint->classes >= 1 && joint->stride >= 3 &&
                 joint->nodes >= joint->stride && joint->nodes % joint->stride == 0 && joint->nodes < INT32_MAX &&
                 joint->rasters >= 1 && joint->ticks >= 1 && joint->ticks < INT32_MAX / 4 && joint->reach >= 0 &&
                 joint->reach < INT32_MAX / 4;
    if (!sized) {
        return WG_BAD_SIZE;
    }
    for (int64_t tick = 0; tick < joint->ticks; tick++) {
        if (joint->raster_of[tick] < 0 || joint->raster_of[tick] >= joint->rasters) {
            return WG_BAD_VALUE;
        }
    }
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        bool known = joint->class_of[robot] >= 0 && joint->class_of[robot] < joint->classes &&
                     joint->starts[robot] >= 0 && joint->starts[robot] < joint->nodes;
        if (!known) {
            return WG_BAD_VALUE;
        }
    }
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        if (joint->crossed_from[0] != 0 || joint->crossed_from[robot + 1] < joint->crossed_from[robot]) {
            return WG_BAD_VALUE;
        }
    }
    return WG_OK;
}

WgJointPlan *wg_joint_plan_new(int64_t robots, int64_t length)
{
    WgJointPlan *plan = malloc(sizeof *plan);
    if (plan == NULL) {
        return NULL;
    }
    plan->robots = robots;
    plan->length = length;
    plan->nodes = malloc((size_t)((length + 1) * robots) * sizeof *plan->nodes);
    if (plan->nodes == NULL) {
        free(plan);
        return NULL;
    }
    return plan;
}

WgStatus wg_joint_search_advance(WgJointSearch *search, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    *made = NULL;
    return search->advance(search, most, made, progress);
}

void wg_joint_search_free(WgJointSearch *search)
{
    if (search != NULL) {
        search->end(search);
    }
}

int64_t wg_joint_length(const WgJointPlan *plan)
{
    return plan->length;
}

void wg_joint_nodes(const WgJointPlan *plan, int64_t *nodes)
{
    for (int64_t i = 0; i < (plan->length + 1) * plan->robots; i++) {
        nodes[i] = plan->nodes[i];
    }
}

void wg_joint_free(WgJointPlan *plan)
{
    if (plan != NULL) {
        free(plan->nodes);
        free(plan);
    }
}

WgStatus wg_joint_distances(const WgGraph *graph, const uint8_t *goals, int32_t *distances)
{
    int64_t nodes = graph->nodes;
    if (graph->stride < 3 || nodes < graph->stride || nodes % graph->stride != 0 || nodes >= INT32_MAX) {
        return WG_BAD_SIZE;
    }
    int32_t *queue = malloc((size_t)nodes * sizeof *queue);
    if (queue == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t shifts[8];
    int64_t corners[8];
    wg_eight_steps(graph->stride, shifts, corners);
    int64_t count = 0;
    for (int64_t node = 0; node < nodes; node++) {
        bool is_goal = goals[node] != 0 && graph->clear[node] != 0;
        distances[node] = is_goal ? 0 : -1;
        if (is_goal) {
            queue[count++] = (int32_t)node;
        }
    }

    // Clear nodes are never on the rim, so every step from one stays within the raster.
    for (int64_t begin = 0; begin < count; begin++) {
        int64_t node = queue[begin];
        for (int step = 0; step < 8; step++) {
            int64_t next = node + shifts[step];
            bool passes = graph->clear[next] != 0 && (step < 4 || graph->middle[node + corners[step]] != 0);
            if (passes && distances[next] < 0) {
                distances[next] = distances[node] + 1;
                queue[count++] = (int32_t)next;
            }
        }
    }
    free(queue);
    return WG_OK;
}

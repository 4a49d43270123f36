// Decides whether a body can get to its target, by splitting boxes of poses where it matters.
//
// In each round, a search over free and mixed boxes finds the cheapest paths from the start to the target:
// free boxes cost nothing, mixed ones the more the smaller they are. If the cheapest path costs nothing, the
// target can be reached; if there is no path, it cannot. Otherwise the mixed boxes on the cheapest paths are
// split. Soft subdivision: Zhu and others, Planning for a polygonal
// robot (2019); Zhou, Chiang, Yap, Soft subdivision motion planning (2019). For the absence of paths:
// Zhang, Kim, Manocha, Efficient cell labelling and path non-existence computation (2008).

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "boxes.h"
#include "heap.h"
#include "proof.h"

enum {
    MOST_HALVINGS = 64,
    SHARES = 64,  // parts of the cheapest cost
    FEW = 64,     // a round splits too few boxes if it looks at more than this for each
    TIGHT = 16,  // headings of a box that is so small that the body may fit exactly
};
#define NEVER INT64_MAX

typedef struct Rounds {
    WgBoxes *boxes;
    int32_t start;   // the start's box
    int32_t round;
    int64_t slack;   // by how many shares paths may cost more than the cheapest
    int32_t labels;  // of connected free boxes in this round
    bool is_tight;   // paths lead through very small boxes
    bool has_fits;   // places of exact fit were added
    int64_t weights[MOST_HALVINGS + 1];
    WgHeap heap;
    WgNumbers stack;
    WgNumbers reached[2];  // boxes that each search has reached
} Rounds;

// Labels free boxes that are connected, and mixed ones with the label of those that they are reached from.
static void set_label(Rounds *rounds, int from, WgBox *box, int32_t before)
{
    const WgBox *last = before >= 0 ? &rounds->boxes->all[before] : NULL;
    if (box->kind == WG_MIXED) {
        box->label[from] = last != NULL ? last->label[from] : -1;
    } else if (from == WG_FROM_GOAL) {
        bool is_known = box->round[WG_FROM_START] == rounds->round;
        box->label[from] = is_known ? box->label[WG_FROM_START] : -2;
    } else if (last != NULL && last->kind == WG_FREE) {
        box->label[from] = last->label[from];
    } else {
        box->label[from] = rounds->labels++;
    }
}

static bool reach(Rounds *rounds, int from, int32_t number, int32_t before, int64_t cost)
{
    WgBox *box = &rounds->boxes->all[number];
    if (box->kind == WG_MIXED) {
        cost += rounds->weights[box->halvings < MOST_HALVINGS ? box->halvings : MOST_HALVINGS];
    }
    if (box->round[from] == rounds->round && box->cost[from] <= cost) {
        return true;
    }
    bool is_new = box->round[from] != rounds->round;
    box->round[from] = rounds->round;
    box->cost[from] = cost;
    box->before[from] = before;
    set_label(rounds, from, box, before);
    if (is_new && !wg_numbers_add(&rounds->reached[from], number)) {
        return false;
    }
    if (box->kind == WG_FREE) {
        return wg_numbers_add(&rounds->stack, number);
    }
    return wg_heap_push(&rounds->heap, (WgEntry){cost, number, 0});
}

// Goes to the boxes next to one, and forgets those that have been split.
static bool spread(Rounds *rounds, int from, int32_t number)
{
    WgBox *box = &rounds->boxes->all[number];
    int32_t kept = 0;
    for (int32_t at = 0; at < box->near_count; at++) {
        int32_t other = box->near[at];
        if (rounds->boxes->all[other].kind > WG_MIXED) {
            continue;
        }
        box->near[kept++] = other;
        if (!reach(rounds, from, other, number, box->cost[from])) {
            return false;
        }
    }
    box->near_count = kept;
    return true;
}

// Searches for the cheapest paths; ``cost`` receives what they cost.
static bool search(Rounds *rounds, int from, int64_t *cost)
{
    rounds->heap.count = 0;
    rounds->stack.count = 0;
    rounds->reached[from].count = 0;
    int64_t best = *cost;
    if (from == WG_FROM_START) {
        best = NEVER;
        if (!reach(rounds, from, rounds->start, -1, 0)) {
            return false;
        }
    } else {
        for (int64_t k = 0; k < rounds->boxes->count; k++) {
            WgBox *box = &rounds->boxes->all[k];
            if (box->is_goal && box->kind <= WG_MIXED && !reach(rounds, from, (int32_t)k, -1, 0)) {
                return false;
            }
        }
    }
    while (rounds->stack.count > 0 || rounds->heap.count > 0) {
        int32_t number = 0;
        if (rounds->stack.count > 0) {
            number = rounds->stack.all[--rounds->stack.count];
        } else {
            WgEntry entry = wg_heap_pop(&rounds->heap);
            number = (int32_t)entry.second;
            if (entry.key != rounds->boxes->all[number].cost[from]) {
                continue;
            }
            if (best != NEVER && entry.key > best + best / SHARES * rounds->slack) {
                break;
            }
        }
        WgBox *box = &rounds->boxes->all[number];
        bool is_end = from == WG_FROM_START ? box->is_goal : number == rounds->start;
        if (is_end && box->cost[from] < best) {
            best = box->cost[from];
        }
        if (best == 0) {
            break;
        }
        if (!spread(rounds, from, number)) {
            return false;
        }
    }
    *cost = best;
    return true;
}

// Splits the mixed boxes on the cheapest paths, and counts those that it splits.
static WgStatus split_on_paths(Rounds *rounds, int64_t cost, int64_t *count)
{
    *count = 0;
    for (int64_t k = 0; k < rounds->reached[WG_FROM_START].count; k++) {
        int32_t number = rounds->reached[WG_FROM_START].all[k];
        const WgBox *box = &rounds->boxes->all[number];
        if (box->kind != WG_MIXED || box->is_done || box->round[WG_FROM_GOAL] != rounds->round
            || box->label[WG_FROM_START] == box->label[WG_FROM_GOAL]) {
            continue;
        }
        int64_t weight = rounds->weights[box->halvings < MOST_HALVINGS ? box->halvings : MOST_HALVINGS];
        if (box->cost[WG_FROM_START] + box->cost[WG_FROM_GOAL] - weight <= cost + cost / SHARES * rounds->slack) {
            WgStatus status = wg_boxes_split(rounds->boxes, number);
            if (status != WG_OK) {
                return status;
            }
            *count += 1;
            const WgRange *range = &rounds->boxes->all[number].range;
            rounds->is_tight = rounds->is_tight || range->high[WG_HEADING] - range->low[WG_HEADING] <= TIGHT;
        }
    }
    return WG_OK;
}

// Looks at each tile once, with the discs.
static WgStatus begin(WgBoxes *boxes)
{
    for (int64_t tile = 0; tile < boxes->tiles; tile++) {
        WgStatus status = wg_boxes_split(boxes, tile);
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

static void measure(const WgBoxes *boxes, WgBodyQuery *query)
{
    query->boxes = boxes->count;
    query->finest_side = boxes->tile;
    query->finest_turn = WG_TURN;
    for (int64_t k = 0; k < boxes->count; k++) {
        const WgBox *box = &boxes->all[k];
        if (box->kind != WG_MIXED || box->is_thin) {
            continue;
        }
        for (int axis = 0; axis < 2; axis++) {
            query->finest_side = wg_min(query->finest_side, box->range.high[axis] - box->range.low[axis]);
        }
        query->finest_turn = wg_min(query->finest_turn, box->range.high[2] - box->range.low[2]);
    }
}

static WgStatus go_around(Rounds *rounds, WgBodyQuery *query)
{
    WgBoxes *boxes = rounds->boxes;
    query->outcome = WG_BODY_UNDECIDED;
    while (boxes->count < query->most_boxes) {
        rounds->round++;
        rounds->labels = 0;
        int64_t cost = NEVER;
        if (!search(rounds, WG_FROM_START, &cost)) {
            return WG_OUT_OF_MEMORY;
        }
        if (cost == NEVER) {
            query->outcome = WG_BODY_STOPPED;
            return WG_OK;
        }
        if (cost == 0) {
            query->outcome = WG_BODY_REACHED;
            return WG_OK;
        }
        int64_t back = cost;
        int64_t count = 0;
        if (!search(rounds, WG_FROM_GOAL, &back)) {
            return WG_OUT_OF_MEMORY;
        }
        WgStatus status = split_on_paths(rounds, cost, &count);
        int64_t looked = rounds->reached[WG_FROM_START].count + rounds->reached[WG_FROM_GOAL].count;
        bool is_few = count * FEW < looked;
        rounds->slack = is_few ? wg_min(SHARES, 2 * rounds->slack + 1) : rounds->slack / 2;
        if (status != WG_OK || (count == 0 && rounds->has_fits)) {
            return status;
        }
        if ((count == 0 || rounds->is_tight) && !rounds->has_fits) {
            rounds->has_fits = true;
            status = wg_add_exact_fits(boxes, rounds->start, query->start);
            if (status != WG_OK) {
                return status;
            }
        }
    }
    return WG_OK;
}

// Writes down the path or the cut.
static WgStatus prove(Rounds *rounds, WgBodyQuery *query)
{
    if (query->outcome == WG_BODY_REACHED) {
        return wg_write_path(rounds->boxes, rounds->start, query);
    }
    if (query->outcome != WG_BODY_STOPPED) {
        return WG_OK;
    }
    // The side with fewer boxes has the shorter border.
    int64_t cost = NEVER;
    if (!search(rounds, WG_FROM_GOAL, &cost)) {
        return WG_OUT_OF_MEMORY;
    }
    bool from_goal = rounds->reached[WG_FROM_GOAL].count < rounds->reached[WG_FROM_START].count;
    const WgNumbers *side = &rounds->reached[from_goal ? WG_FROM_GOAL : WG_FROM_START];
    return wg_write_cut(rounds->boxes, side, from_goal, query);
}

WgStatus wg_body_decide(const WgWalls *walls, const WgBody *body, WgBodyQuery *query)
{
    if (!wg_body_is_valid(walls, body)) {
        return WG_BAD_VALUE;
    }
    query->rows = NULL;
    query->count = 0;
    if (!wg_clear_at(walls, body, query->start)) {
        query->outcome = WG_BODY_COVERED;
        return WG_OK;
    }
    WgGoal goal = {query->target_x, query->target_y, query->target_radius, query->from_heading, query->headings};
    WgBoxes boxes;
    Rounds rounds = {.boxes = &boxes};
    double weight = 64.0;
    for (int k = 0; k <= MOST_HALVINGS; k++) {
        rounds.weights[k] = (int64_t)weight;
        weight *= 1.25;
    }
    WgStatus status = wg_boxes_make(&boxes, walls, body, goal);
    if (status == WG_OK) {
        status = begin(&boxes);
    }
    if (status == WG_OK) {
        int32_t heading = (int32_t)(query->start.heading % boxes.period);
        WgRange at = {{(int32_t)query->start.x, (int32_t)query->start.y, heading}, {0}};
        memcpy(at.high, at.low, sizeof at.high);
        rounds.start = (int32_t)boxes.count;
        status = wg_boxes_add_thin(&boxes, at);
    }
    if (status == WG_OK) {
        status = go_around(&rounds, query);
        measure(&boxes, query);
    }
    if (status == WG_OK && query->wants_proof != 0) {
        status = prove(&rounds, query);
    }
    free(rounds.heap.entries);
    free(rounds.stack.all);
    free(rounds.reached[0].all);
    free(rounds.reached[1].all);
    wg_boxes_free(&boxes);
    return status;
}

void wg_body_free(WgBodyQuery *query)
{
    free(query->rows);
    query->rows = NULL;
}

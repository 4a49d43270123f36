// Splits boxes of poses.

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "portions.h"

bool wg_numbers_add(WgNumbers *numbers, int32_t number)
{
    if (numbers->count == numbers->room) {
        int64_t room = 2 * numbers->room + 64;
        int32_t *all = realloc(numbers->all, (size_t)room * sizeof *all);
        if (all == NULL) {
            return false;
        }
        numbers->all = all;
        numbers->room = room;
    }
    numbers->all[numbers->count++] = number;
    return true;
}

const WgSpan *wg_boxes_span(WgBoxes *boxes, int64_t heading, int64_t turn, WgStatus *status)
{
    if (turn > WG_BASE_TURN) {
        return NULL;
    }
    int64_t base = WG_TURN / WG_BASE_TURN;
    int64_t ranges = WG_TURN / turn;
    int64_t at = ranges - base + heading / turn;
    if (boxes->spans[at] == NULL) {
        boxes->spans[at] = malloc(sizeof **boxes->spans);
        if (boxes->spans[at] == NULL) {
            *status = WG_OUT_OF_MEMORY;
            return NULL;
        }
        if (!wg_numbers_add(&boxes->made, (int32_t)at)) {
            *status = WG_OUT_OF_MEMORY;
        }
        wg_span_make(boxes->body, heading, turn, boxes->spans[at]);
    }
    return boxes->spans[at];
}

// Returns true if the body looks the same after a part of a turn.
static bool looks_same(const WgBody *body, int64_t parts)
{
    if (body->count % parts != 0) {
        return false;
    }
    for (int64_t k = 0; k < body->count; k++) {
        const int64_t *a = body->corners + 2 * k;
        const int64_t *b = body->corners + 2 * ((k + body->count / parts) % body->count);
        bool is_same = parts == 2 ? b[0] == -a[0] && b[1] == -a[1] : b[0] == -a[1] && b[1] == a[0];
        if (!is_same) {
            return false;
        }
    }
    return true;
}

static double nearest_to(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

// Returns true if a range of headings has one of the target's, and which.
static bool goal_heading(const WgBoxes *boxes, const WgRange *range, int64_t *heading)
{
    const WgGoal *goal = &boxes->goal;
    int64_t low = range->low[WG_HEADING];
    int64_t high = range->high[WG_HEADING];
    if (goal->headings >= WG_TURN - 1 || high - low >= WG_TURN) {
        *heading = goal->headings >= WG_TURN - 1 ? low : goal->heading;
        return true;
    }
    int64_t ahead = (low - goal->heading) & (WG_TURN - 1);
    if (ahead <= goal->headings) {
        *heading = low;
        return true;
    }
    ahead = (goal->heading - low) & (WG_TURN - 1);
    *heading = low + ahead;
    return ahead <= high - low;
}

bool wg_goal_pose(const WgBoxes *boxes, const WgRange *range, WgBodyPose *pose)
{
    const WgGoal *goal = &boxes->goal;
    int64_t heading = 0;
    if (!goal_heading(boxes, range, &heading)) {
        return false;
    }
    double x = nearest_to(floor(goal->x + 0.5), range->low[0], range->high[0]);
    double y = nearest_to(floor(goal->y + 0.5), range->low[1], range->high[1]);
    *pose = (WgBodyPose){(int64_t)x, (int64_t)y, heading & (WG_TURN - 1)};
    double off = hypot(x - goal->x, y - goal->y);
    return off <= goal->radius * (1.0 - 1e-12);
}

// Returns true if a range may have a pose of the target.
static bool may_have_goal(const WgBoxes *boxes, const WgRange *range)
{
    const WgGoal *goal = &boxes->goal;
    int64_t heading = 0;
    double x = nearest_to(goal->x, range->low[0], range->high[0]);
    double y = nearest_to(goal->y, range->low[1], range->high[1]);
    return hypot(x - goal->x, y - goal->y) <= goal->radius + 1e-3 && goal_heading(boxes, range, &heading);
}

static WgBox *add_box(WgBoxes *boxes, WgRange range, WgBoxKind kind)
{
    if (boxes->count == boxes->room) {
        int64_t room = 2 * boxes->room + 1024;
        WgBox *all = realloc(boxes->all, (size_t)room * sizeof *all);
        if (all == NULL) {
            return NULL;
        }
        boxes->all = all;
        boxes->room = room;
    }
    WgBox *box = &boxes->all[boxes->count++];
    *box = (WgBox){.range = range, .kind = (uint8_t)kind};
    WgBodyPose pose;
    box->is_goal = kind == WG_FREE ? wg_goal_pose(boxes, &range, &pose) : may_have_goal(boxes, &range);
    return box;
}

static bool list_solid(WgBoxes *boxes, int32_t number)
{
    if (boxes->list_count == boxes->list_room) {
        int64_t room = 2 * boxes->list_room + 4096;
        int32_t *lists = realloc(boxes->lists, (size_t)room * sizeof *lists);
        if (lists == NULL) {
            return false;
        }
        boxes->lists = lists;
        boxes->list_room = room;
    }
    boxes->lists[boxes->list_count++] = number;
    return true;
}

// Where two ranges of headings are to each other: 1 if they overlap, 0 if they only touch, else -1.
static int meet_turning(const WgBoxes *boxes, const WgRange *a, const WgRange *b)
{
    int32_t low = a->low[2] > b->low[2] ? a->low[2] : b->low[2];
    int32_t high = a->high[2] < b->high[2] ? a->high[2] : b->high[2];
    if (low < high) {
        return 1;
    }
    bool wraps = (a->low[2] == 0 && b->high[2] == boxes->period) || (b->low[2] == 0 && a->high[2] == boxes->period);
    return low == high || wraps ? 0 : -1;
}

static bool is_next_to(const WgBoxes *boxes, const WgBox *a, const WgBox *b)
{
    int faces = 0;
    bool any = a->is_thin || b->is_thin;
    for (int axis = 0; axis < 2; axis++) {
        int32_t low = a->range.low[axis] > b->range.low[axis] ? a->range.low[axis] : b->range.low[axis];
        int32_t high = a->range.high[axis] < b->range.high[axis] ? a->range.high[axis] : b->range.high[axis];
        if (low > high) {
            return false;
        }
        faces += low == high;
    }
    int turning = meet_turning(boxes, &a->range, &b->range);
    if (turning < 0) {
        return false;
    }
    return any || faces + (turning == 0) <= 1;
}

bool wg_boxes_share_face(const WgBoxes *boxes, int64_t a, int64_t b)
{
    return is_next_to(boxes, &boxes->all[a], &boxes->all[b]);
}

static bool add_near(WgBox *box, int64_t number)
{
    if (box->near_count == box->near_room) {
        int32_t room = box->near_room + box->near_room / 2 + 8;
        int32_t *near = realloc(box->near, (size_t)room * sizeof *near);
        if (near == NULL) {
            return false;
        }
        box->near = near;
        box->near_room = room;
    }
    box->near[box->near_count++] = (int32_t)number;
    return true;
}

static bool connect(WgBoxes *boxes, int64_t a, int64_t b)
{
    if (!is_next_to(boxes, &boxes->all[a], &boxes->all[b])) {
        return true;
    }
    return add_near(&boxes->all[a], b) && add_near(&boxes->all[b], a);
}

// Lists the rectangles of a box that matter for a part of it.
static WgStatus list_solids(WgBoxes *boxes, int64_t number, WgBox *part)
{
    WgStatus status = WG_OK;
    int64_t turn = part->range.high[WG_HEADING] - part->range.low[WG_HEADING];
    const WgSpan *span = wg_boxes_span(boxes, part->range.low[WG_HEADING], turn, &status);
    part->first_solid = (int32_t)boxes->list_count;
    for (int64_t k = 0; k < boxes->all[number].solid_count && status == WG_OK; k++) {
        int32_t solid = boxes->lists[boxes->all[number].first_solid + k];
        WgRun run = wg_run_along(boxes->body, span, &boxes->discs, &part->range, &boxes->solids.all[solid], WG_X);
        if (run.may_begin < part->range.high[0] && run.may_end > part->range.low[0] && run.may_begin < run.may_end) {
            status = list_solid(boxes, solid) ? WG_OK : WG_OUT_OF_MEMORY;
        }
    }
    part->solid_count = (int32_t)(boxes->list_count - part->first_solid);
    return status;
}

WgStatus wg_boxes_split(WgBoxes *boxes, int64_t number)
{
    WgPortions portions;
    WgBox *box = &boxes->all[number];
    assert(box->kind == WG_MIXED);
    WgStatus status = wg_portions_of(boxes, box, &portions);
    if (status != WG_OK) {
        return status;
    }
    if (portions.count == 0) {
        box->is_done = true;
        return WG_OK;
    }
    // Make the parts.
    int64_t first = boxes->count;
    for (int64_t k = 0; k < portions.count; k++) {
        WgBox *part = add_box(boxes, portions.all[k].range, portions.all[k].kind);
        if (part == NULL) {
            return WG_OUT_OF_MEMORY;
        }
        part->halvings = (uint8_t)(boxes->all[number].halvings + 1);
        part->first_solid = boxes->all[number].first_solid;
        part->solid_count = boxes->all[number].solid_count;
        if (part->kind == WG_MIXED) {
            WgBox fresh = *part;
            status = list_solids(boxes, number, &fresh);
            boxes->all[boxes->count - 1] = fresh;
            if (status != WG_OK) {
                return status;
            }
        }
    }
    box = &boxes->all[number];
    box->kind = WG_SPLIT;
    box->first_part = (int32_t)first;
    box->part_count = (int32_t)portions.count;
    // Connect them with each other and with those around.
    for (int64_t k = first; k < boxes->count; k++) {
        if (boxes->all[k].kind == WG_FULL) {
            continue;
        }
        for (int64_t other = first; other < k; other++) {
            if (boxes->all[other].kind != WG_FULL && !connect(boxes, k, other)) {
                return WG_OUT_OF_MEMORY;
            }
        }
        for (int64_t at = 0; at < boxes->all[number].near_count; at++) {
            int32_t other = boxes->all[number].near[at];
            if (boxes->all[other].kind <= WG_MIXED && !connect(boxes, k, other)) {
                return WG_OUT_OF_MEMORY;
            }
        }
    }
    free(boxes->all[number].near);
    boxes->all[number].near = NULL;
    boxes->all[number].near_count = 0;
    boxes->all[number].near_room = 0;
    return WG_OK;
}

// Lists the rectangles that a body may meet from each tile.
static WgStatus list_for_tiles(WgBoxes *boxes)
{
    int64_t reach = (int64_t)boxes->discs.outer + 2;
    WgNumbers *lists = calloc((size_t)boxes->tiles, sizeof *lists);
    if (lists == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    WgStatus status = WG_OK;
    for (int64_t k = 0; k < boxes->solids.count && status == WG_OK; k++) {
        const WgSolid *solid = &boxes->solids.all[k];
        int64_t first[2];
        int64_t last[2];
        const int64_t sides[2] = {boxes->columns, boxes->rows};
        for (int axis = 0; axis < 2; axis++) {
            first[axis] = wg_max(0, wg_floor_div(solid->low[axis] - boxes->low - reach, boxes->tile));
            last[axis] = wg_min(sides[axis] - 1, wg_floor_div(solid->high[axis] - boxes->low + reach, boxes->tile));
        }
        for (int64_t row = first[1]; row <= last[1] && status == WG_OK; row++) {
            for (int64_t column = first[0]; column <= last[0] && status == WG_OK; column++) {
                bool is_added = wg_numbers_add(&lists[row * boxes->columns + column], (int32_t)k);
                status = is_added ? WG_OK : WG_OUT_OF_MEMORY;
            }
        }
    }
    for (int64_t tile = 0; tile < boxes->tiles; tile++) {
        boxes->all[tile].first_solid = (int32_t)boxes->list_count;
        boxes->all[tile].solid_count = (int32_t)lists[tile].count;
        for (int64_t k = 0; k < lists[tile].count && status == WG_OK; k++) {
            status = list_solid(boxes, lists[tile].all[k]) ? WG_OK : WG_OUT_OF_MEMORY;
        }
        free(lists[tile].all);
    }
    free(lists);
    return status;
}

WgStatus wg_boxes_make(WgBoxes *boxes, const WgWalls *walls, const WgBody *body, WgGoal goal)
{
    *boxes = (WgBoxes){.walls = walls, .body = body, .goal = goal, .discs = wg_discs_of(body), .period = WG_TURN};
    if (goal.headings >= WG_TURN - 1) {
        boxes->period = looks_same(body, 4) ? WG_TURN / 4 : looks_same(body, 2) ? WG_TURN / 2 : WG_TURN;
    }
    boxes->spans = (WgSpan **)calloc((size_t)2 * WG_TURN, sizeof *boxes->spans);
    if (boxes->spans == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    WgStatus status = wg_solids_make(&boxes->solids, walls);
    if (status != WG_OK) {
        return status;
    }
    boxes->tile = WG_UNIT;
    while (boxes->tile < (int64_t)(boxes->discs.outer * 0.75)) {
        boxes->tile *= 2;
    }
    // An axle outside its body may be outside the grid, too.
    int64_t out = boxes->discs.inner > 0.0 ? 0 : (int64_t)boxes->discs.outer + 1;
    boxes->low = -out;
    boxes->high[0] = walls->width * WG_UNIT + out;
    boxes->high[1] = walls->height * WG_UNIT + out;
    boxes->columns = (boxes->high[0] + out + boxes->tile - 1) / boxes->tile;
    boxes->rows = (boxes->high[1] + out + boxes->tile - 1) / boxes->tile;
    boxes->tiles = boxes->columns * boxes->rows;
    for (int64_t row = 0; row < boxes->rows; row++) {
        for (int64_t column = 0; column < boxes->columns; column++) {
            int64_t x = boxes->low + column * boxes->tile;
            int64_t y = boxes->low + row * boxes->tile;
            WgRange range = {
                {(int32_t)x, (int32_t)y, 0},
                {(int32_t)wg_min(boxes->high[0], x + boxes->tile), (int32_t)wg_min(boxes->high[1], y + boxes->tile),
                 (int32_t)boxes->period},
            };
            if (add_box(boxes, range, WG_MIXED) == NULL) {
                return WG_OUT_OF_MEMORY;
            }
        }
    }
    for (int64_t tile = 0; tile < boxes->tiles; tile++) {
        bool is_last = tile % boxes->columns == boxes->columns - 1;
        bool is_top = tile / boxes->columns == boxes->rows - 1;
        if ((!is_last && !connect(boxes, tile, tile + 1))
            || (!is_top && !connect(boxes, tile, tile + boxes->columns))) {
            return WG_OUT_OF_MEMORY;
        }
    }
    return list_for_tiles(boxes);
}

static bool touches(const WgBoxes *boxes, const WgRange *a, const WgRange *b)
{
    for (int axis = 0; axis < 2; axis++) {
        if (a->low[axis] > b->high[axis] || a->high[axis] < b->low[axis]) {
            return false;
        }
    }
    return meet_turning(boxes, a, b) >= 0;
}

WgStatus wg_boxes_touching(const WgBoxes *boxes, const WgRange *range, unsigned kinds, WgNumbers *found)
{
    int64_t first[2];
    int64_t last[2];
    const int64_t sides[2] = {boxes->columns, boxes->rows};
    for (int axis = 0; axis < 2; axis++) {
        first[axis] = wg_max(0, wg_floor_div(range->low[axis] - boxes->low - 1, boxes->tile));
        last[axis] = wg_min(sides[axis] - 1, wg_floor_div(range->high[axis] - boxes->low, boxes->tile));
    }
    // Go down from the tiles.
    WgNumbers waiting = {0};
    bool is_added = true;
    for (int64_t row = first[1]; row <= last[1]; row++) {
        for (int64_t column = first[0]; column <= last[0] && is_added; column++) {
            is_added = wg_numbers_add(&waiting, (int32_t)(row * boxes->columns + column));
        }
    }
    while (waiting.count > 0 && is_added) {
        int32_t number = waiting.all[--waiting.count];
        const WgBox *box = &boxes->all[number];
        if (!touches(boxes, &box->range, range)) {
            continue;
        }
        if (box->kind != WG_SPLIT) {
            is_added = (kinds >> box->kind & 1) == 0 || wg_numbers_add(found, number);
            continue;
        }
        for (int32_t part = 0; part < box->part_count && is_added; part++) {
            is_added = wg_numbers_add(&waiting, box->first_part + part);
        }
    }
    free(waiting.all);
    return is_added ? WG_OK : WG_OUT_OF_MEMORY;
}

WgStatus wg_boxes_add_thin(WgBoxes *boxes, WgRange range)
{
    WgNumbers found = {0};
    WgStatus status = wg_boxes_touching(boxes, &range, 1U << WG_FREE | 1U << WG_MIXED, &found);
    int64_t number = boxes->count;
    if (status == WG_OK) {
        WgBox *box = add_box(boxes, range, WG_FREE);
        if (box == NULL) {
            status = WG_OUT_OF_MEMORY;
        } else {
            box->is_thin = true;
        }
    }
    for (int64_t k = 0; k < found.count && status == WG_OK; k++) {
        status = connect(boxes, number, found.all[k]) ? WG_OK : WG_OUT_OF_MEMORY;
    }
    free(found.all);
    return status;
}

WgStatus wg_boxes_connect(WgBoxes *boxes, int64_t a, int64_t b)
{
    return connect(boxes, a, b) ? WG_OK : WG_OUT_OF_MEMORY;
}

void wg_boxes_free(WgBoxes *boxes)
{
    for (int64_t k = 0; k < boxes->count; k++) {
        free(boxes->all[k].near);
    }
    // Of the others, whose place would have to be looked at, there are many.
    for (int64_t k = 0; k < boxes->made.count; k++) {
        free(boxes->spans[boxes->made.all[k]]);
    }
    free(boxes->made.all);
    free((void *)boxes->spans);
    free(boxes->all);
    free(boxes->lists);
    wg_solids_free(&boxes->solids);
    *boxes = (WgBoxes){0};
}

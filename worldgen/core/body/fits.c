// Finds where a body just fits.
//
// Where an aisle is exactly as wide as the body, no box of poses is free, but there are poses: on a line,
// at one heading. At a multiple of a quarter turn the body's corners are on the lattice, so the free poses
// at that heading are found exactly, row by row.

#include <math.h>
#include <stdlib.h>

#include "proof.h"

enum { LINES = 3 };

typedef struct Gap {
    int64_t begin;
    int64_t end;
} Gap;

static int compare_gaps(const void *a, const void *b)
{
    const Gap *p = a;
    const Gap *q = b;
    if (p->begin != q->begin) {
        return p->begin < q->begin ? -1 : 1;
    }
    return (p->end > q->end) - (p->end < q->end);
}

static int compare_numbers(const void *a, const void *b)
{
    int64_t p = *(const int64_t *)a;
    int64_t q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

// Adds the free runs of one row of poses at one heading. ``room`` has space for a gap per rectangle.
static WgStatus add_row(WgBoxes *boxes, const WgSpan *span, WgRange row, Gap *room)
{
    int64_t count = 0;
    for (int64_t k = 0; k < boxes->solids.count; k++) {
        const WgSolid *solid = &boxes->solids.all[k];
        if (!solid->in_cover) {
            continue;
        }
        WgRun run = wg_run_along(boxes->body, span, &boxes->discs, &row, solid, WG_X);
        if (run.may_begin < run.may_end) {
            room[count++] = (Gap){run.may_begin, run.may_end};
        }
    }
    qsort(room, (size_t)count, sizeof *room, compare_gaps);
    int64_t from = row.low[0];
    for (int64_t k = 0; k <= count; k++) {
        int64_t to = k < count ? wg_min(room[k].begin, row.high[0]) : row.high[0];
        if (from <= to && from <= row.high[0]) {
            WgRange free = row;
            free.low[0] = (int32_t)from;
            free.high[0] = (int32_t)to;
            WgStatus status = wg_boxes_add_thin(boxes, free);
            if (status != WG_OK) {
                return status;
            }
        }
        from = k < count ? wg_max(from, room[k].end) : from;
    }
    return WG_OK;
}

// Adds the free poses at one heading, by rows between the heights at which it touches borders of cells.
static WgStatus add_heading(WgBoxes *boxes, int64_t heading)
{
    WgSpan span;
    wg_span_make(boxes->body, heading, 0, &span);
    int64_t below = (int64_t)span.outer[2];
    int64_t above = (int64_t)span.outer[3];
    int64_t lines = 2 * (boxes->walls->height + 1);
    int64_t *heights = malloc((size_t)lines * sizeof *heights);
    Gap *room = malloc((size_t)(boxes->solids.count + 1) * sizeof *room);
    WgStatus status = heights != NULL && room != NULL ? WG_OK : WG_OUT_OF_MEMORY;
    if (status == WG_OK) {
        for (int64_t k = 0; k <= boxes->walls->height; k++) {
            heights[2 * k] = k * WG_UNIT + below;
            heights[2 * k + 1] = k * WG_UNIT - above;
        }
        qsort(heights, (size_t)lines, sizeof *heights, compare_numbers);
    }
    int64_t top = boxes->high[1];
    for (int64_t k = 0; k < lines && status == WG_OK; k++) {
        if (heights[k] < boxes->low || heights[k] > top || (k + 1 < lines && heights[k] == heights[k + 1])) {
            continue;
        }
        WgRange row = {
            {(int32_t)boxes->low, (int32_t)heights[k], (int32_t)heading},
            {(int32_t)boxes->high[0], (int32_t)heights[k], (int32_t)heading},
        };
        status = add_row(boxes, &span, row, room);
        if (status == WG_OK && k + 1 < lines && heights[k + 1] <= top) {
            row.high[1] = (int32_t)heights[k + 1];
            status = add_row(boxes, &span, row, room);
        }
    }
    free(heights);
    free(room);
    return status;
}

// How far the body gets from a pose along a direction, by doubling and halving the step.
static int64_t free_along(const WgBoxes *boxes, WgBodyPose pose, const int64_t direction[3], int64_t most)
{
    int64_t far = 0;
    bool grows = true;
    for (int64_t step = 1; step > 0;) {
        int64_t to = far + step;
        bool is_clear = to <= most;
        if (is_clear && direction[2] == 0) {
            is_clear = wg_clear_along(boxes->walls, boxes->body, pose, pose.x + to * direction[0],
                                      pose.y + to * direction[1]);
        } else if (is_clear) {
            is_clear = wg_clear_turning(boxes->walls, boxes->body, pose, to * direction[2]);
        }
        grows = grows && is_clear;
        far = is_clear ? to : far;
        step = grows ? 2 * step : step / 2;
    }
    return far;
}

// Adds the lines through the start along x, y and its heading.
static WgStatus add_lines(WgBoxes *boxes, WgBodyPose start)
{
    int32_t heading = (int32_t)(start.heading % boxes->period);
    for (int axis = 0; axis < LINES; axis++) {
        WgRange line = {{(int32_t)start.x, (int32_t)start.y, heading}, {(int32_t)start.x, (int32_t)start.y, heading}};
        for (int sign = -1; sign <= 1; sign += 2) {
            int64_t direction[3] = {0, 0, 0};
            direction[axis] = sign;
            int64_t at = line.low[axis];
            int64_t low = axis == WG_HEADING ? 0 : boxes->low;
            int64_t high = axis == WG_HEADING ? boxes->period : boxes->high[axis];
            int64_t most = sign < 0 ? at - low : high - at;
            int64_t far = free_along(boxes, start, direction, axis == WG_HEADING ? wg_min(most, WG_TURN / 2) : most);
            *(sign < 0 ? &line.low[axis] : &line.high[axis]) = (int32_t)(at + sign * far);
        }
        WgStatus status = wg_boxes_add_thin(boxes, line);
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

// Connects new thin boxes: three lines and then rows, by heading and from the lowest up.
static WgStatus connect_all(WgBoxes *boxes, int32_t start, int64_t first)
{
    WgStatus status = WG_OK;
    for (int64_t k = first; k < boxes->count && status == WG_OK; k++) {
        status = wg_boxes_connect(boxes, k, start);
        for (int64_t line = first; line < wg_min(k, first + LINES) && status == WG_OK; line++) {
            status = wg_boxes_connect(boxes, k, line);
        }
        for (int64_t row = k - 1; row >= first + LINES && status == WG_OK; row--) {
            const WgRange *lower = &boxes->all[row].range;
            const WgRange *upper = &boxes->all[k].range;
            if (lower->low[2] != upper->low[2] || lower->high[1] < upper->low[1]) {
                break;
            }
            status = wg_boxes_connect(boxes, k, row);
        }
    }
    return status;
}

WgStatus wg_add_exact_fits(WgBoxes *boxes, int32_t start, WgBodyPose pose)
{
    int64_t first = boxes->count;
    WgStatus status = add_lines(boxes, pose);
    for (int64_t heading = 0; heading < boxes->period && status == WG_OK; heading += WG_TURN / 4) {
        status = add_heading(boxes, heading);
    }
    return status == WG_OK ? connect_all(boxes, start, first) : status;
}

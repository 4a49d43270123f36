// Writes the full boxes around a side as rows of a cut.

#include <stdlib.h>
#include <string.h>

#include "proof.h"

typedef struct Rows {
    int64_t *all;
    int64_t count;
    int64_t room;
} Rows;

static bool add_row(Rows *rows, const WgBoxes *boxes, const WgRange *range)
{
    int64_t span = range->high[2] - range->low[2];
    // A body that looks the same after a part of a turn does so in every box.
    int64_t copies = span >= boxes->period ? 1 : WG_TURN / boxes->period;
    for (int64_t copy = 0; copy < copies; copy++) {
        if (rows->count == rows->room) {
            int64_t room = 2 * rows->room + 256;
            int64_t *all = realloc(rows->all, (size_t)(6 * room) * sizeof *all);
            if (all == NULL) {
                return false;
            }
            rows->all = all;
            rows->room = room;
        }
        int64_t *row = rows->all + 6 * rows->count++;
        row[0] = copies == 1 && span >= boxes->period ? 0 : range->low[2] + copy * boxes->period;
        row[1] = span >= boxes->period ? WG_TURN : span;
        row[2] = range->low[1];
        row[3] = range->high[1] - range->low[1];
        row[4] = range->low[0];
        row[5] = range->high[0];
        // Columns 2 and 3 are the side and then y.
        int64_t low = row[2];
        row[2] = row[3];
        row[3] = low;
    }
    return true;
}

// Covers a full box with runs along an axis, in each of which one rectangle is met; false if it cannot.
//
// slack:      lu by which a run may begin later, because floats gave it another end when the box was made.
static bool cover_along(WgBoxes *boxes, const WgBox *box, int axis, int64_t slack, Rows *rows, WgStatus *status)
{
    int64_t turn = box->range.high[2] - box->range.low[2];
    const WgSpan *span = wg_boxes_span(boxes, box->range.low[2], turn, status);
    int64_t at = box->range.low[axis];
    bool is_first = true;
    while (*status == WG_OK && (is_first || at < box->range.high[axis])) {
        int64_t end = is_first ? at - 1 : at;
        for (int64_t k = 0; k < box->solid_count; k++) {
            const WgSolid *solid = &boxes->solids.all[boxes->lists[box->first_solid + k]];
            WgRun run = wg_run_along(boxes->body, span, &boxes->discs, &box->range, solid, axis);
            if (run.must_begin <= at + slack && run.must_end > end) {
                end = run.must_end;
            }
        }
        end = end == box->range.high[axis] - slack ? box->range.high[axis] : end;
        if (end <= at && !(is_first && end == at && at == box->range.high[axis])) {
            return false;
        }
        WgRange range = box->range;
        range.low[axis] = (int32_t)at;
        range.high[axis] = (int32_t)wg_min(end, box->range.high[axis]);
        if (!add_row(rows, boxes, &range)) {
            *status = WG_OUT_OF_MEMORY;
        }
        at = end;
        is_first = false;
    }
    return *status == WG_OK;
}

static WgStatus add_box(WgBoxes *boxes, const WgBox *box, Rows *rows)
{
    WgStatus status = WG_OK;
    int64_t count = rows->count;
    for (int64_t slack = 0; slack <= 1; slack++) {
        for (int axis = WG_X; axis <= WG_Y; axis++) {
            rows->count = count;
            if (cover_along(boxes, box, axis, slack, rows, &status) || status != WG_OK) {
                return status;
            }
        }
    }
    // Floats choose between two runs of equal length in one way here and in another when the box was
    // made; then one row has to do.
    rows->count = count;
    return add_row(rows, boxes, &box->range) ? WG_OK : WG_OUT_OF_MEMORY;
}

WgStatus wg_write_cut(WgBoxes *boxes, const WgNumbers *side, bool from_goal, WgBodyQuery *query)
{
    Rows rows = {0};
    WgNumbers found = {0};
    WgStatus status = WG_OK;
    bool *is_listed = calloc((size_t)boxes->count, sizeof *is_listed);
    if (is_listed == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    // The full boxes that touch the side, and those in the target.
    for (int64_t k = 0; k < side->count && status == WG_OK; k++) {
        found.count = 0;
        status = wg_boxes_touching(boxes, &boxes->all[side->all[k]].range, 1U << WG_FULL, &found);
        for (int64_t at = 0; at < found.count; at++) {
            // Where boxes only share an edge, others share a face.
            int32_t full = found.all[at];
            is_listed[full] = is_listed[full] || wg_boxes_share_face(boxes, side->all[k], full);
        }
    }
    for (int64_t k = 0; k < boxes->count && status == WG_OK; k++) {
        const WgBox *box = &boxes->all[k];
        if (box->kind == WG_FULL && (is_listed[k] || (from_goal && box->is_goal))) {
            status = add_box(boxes, box, &rows);
        }
    }
    free(is_listed);
    free(found.all);
    query->rows = rows.all;
    query->count = rows.count;
    return status;
}

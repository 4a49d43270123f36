// Chooses how to split a box of poses.

#include "portions.h"

enum { MOST_RUNS = 256 };

// Cuts a range along an axis into portions that are free, full or mixed; ``runs`` are those of the solids.
static void cut_up(const WgRange *range, int axis, const WgRun *runs, const bool *covers, int64_t count, int64_t most,
                   WgPortions *portions)
{
    int64_t low = range->low[axis];
    int64_t high = range->high[axis];
    int64_t begin = portions->count;
    double free = 0.0;
    double full = 0.0;
    for (int64_t at = low; at < high;) {
        // The farthest that full runs lead from here, and the nearest begin of another.
        int64_t end = at;
        int64_t next = high;
        for (int64_t again = 1; again > 0;) {
            again = 0;
            for (int64_t k = 0; k < count; k++) {
                if (runs[k].must_begin <= end && runs[k].must_end > end) {
                    end = runs[k].must_end;
                    again = 1;
                }
            }
        }
        WgBoxKind kind = WG_FULL;
        if (end == at) {
            for (int64_t k = 0; k < count; k++) {
                if (runs[k].must_begin > at && runs[k].must_end > runs[k].must_begin) {
                    next = wg_min(next, runs[k].must_begin);
                }
            }
            // Up to there it is mixed as far as runs of overlaps go, or free up to the next.
            kind = WG_FREE;
            end = next;
            for (int64_t k = 0; k < count; k++) {
                if (!covers[k] || runs[k].may_end <= runs[k].may_begin) {
                    continue;
                }
                if (runs[k].may_begin <= at && runs[k].may_end > at) {
                    kind = WG_MIXED;
                } else if (runs[k].may_begin > at) {
                    end = wg_min(end, runs[k].may_begin);
                }
            }
            if (kind == WG_MIXED) {
                end = at;
                for (int64_t again = 1; again > 0;) {
                    again = 0;
                    for (int64_t k = 0; k < count; k++) {
                        if (covers[k] && runs[k].may_begin <= end && runs[k].may_end > end && end < next) {
                            end = wg_min(runs[k].may_end, next);
                            again = 1;
                        }
                    }
                }
            }
        }
        end = wg_min(end, high);
        // Too many portions become one.
        if (portions->count - begin == most) {
            portions->all[portions->count - 1].range.high[axis] = (int32_t)high;
            portions->all[portions->count - 1].kind = WG_MIXED;
            break;
        }
        WgPortion *portion = &portions->all[portions->count++];
        *portion = (WgPortion){*range, kind};
        portion->range.low[axis] = (int32_t)at;
        portion->range.high[axis] = (int32_t)end;
        free += kind == WG_FREE ? (double)(end - at) : 0.0;
        full += kind == WG_FULL ? (double)(end - at) : 0.0;
        at = end;
    }
    portions->decided += (free + full) / (double)(high - low);
}

static WgStatus cut_along(WgBoxes *boxes, const WgBox *box, const WgRange *range, int axis, int64_t most,
                          WgPortions *portions)
{
    WgRun runs[MOST_RUNS];
    bool covers[MOST_RUNS];
    WgStatus status = WG_OK;
    int64_t turn = range->high[WG_HEADING] - range->low[WG_HEADING];
    const WgSpan *span = wg_boxes_span(boxes, range->low[WG_HEADING], turn, &status);
    if (status != WG_OK) {
        return status;
    }
    int64_t count = 0;
    for (int64_t k = 0; k < box->solid_count; k++) {
        const WgSolid *solid = &boxes->solids.all[boxes->lists[box->first_solid + k]];
        WgRun run = wg_run_along(boxes->body, span, &boxes->discs, range, solid, axis);
        if (run.may_end <= run.may_begin && run.must_end <= run.must_begin) {
            continue;
        }
        if (count == MOST_RUNS) {
            // What more there is only adds to what is mixed.
            runs[MOST_RUNS - 1] = (WgRun){range->low[axis], range->high[axis], 1, 0};
            covers[MOST_RUNS - 1] = true;
            break;
        }
        runs[count] = run;
        covers[count] = solid->in_cover;
        count++;
    }
    cut_up(range, axis, runs, covers, count, most, portions);
    return WG_OK;
}

// Halves a range along one axis, and cuts each half along another.
static WgStatus try_halves(WgBoxes *boxes, const WgBox *box, int halved, int axis, WgPortions *portions)
{
    portions->count = 0;
    portions->decided = 0.0;
    int32_t low = box->range.low[halved];
    int32_t high = box->range.high[halved];
    for (int half = 0; half < 2; half++) {
        WgRange range = box->range;
        int32_t middle = low + (high - low) / 2;
        range.low[halved] = half == 0 ? low : middle;
        range.high[halved] = half == 0 ? middle : high;
        WgStatus status = cut_along(boxes, box, &range, axis, WG_MOST_PORTIONS / 2, portions);
        if (status != WG_OK) {
            return status;
        }
    }
    portions->decided /= 2.0;
    return WG_OK;
}

// Chooses how to split a box: where most of it is decided; long sides come first.
static WgStatus choose_split(WgBoxes *boxes, const WgBox *box, WgPortions *best)
{
    static const int choices[4][2] = {{WG_HEADING, WG_X}, {WG_HEADING, WG_Y}, {WG_Y, WG_X}, {WG_X, WG_Y}};
    const WgRange *range = &box->range;
    double lengths[3];
    double longest = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        lengths[axis] = range->high[axis] - range->low[axis];
        if (axis == WG_HEADING) {
            lengths[axis] *= boxes->discs.outer * WG_RADIANS;
        }
        longest = lengths[axis] > longest ? lengths[axis] : longest;
    }
    double score = -1.0;
    WgPortions tried;
    for (int k = 0; k < 4; k++) {
        int halved = choices[k][0];
        if (range->high[halved] - range->low[halved] < 2) {
            continue;
        }
        WgStatus status = try_halves(boxes, box, halved, choices[k][1], &tried);
        if (status != WG_OK) {
            return status;
        }
        double worth = tried.decided + 0.1 * lengths[halved] / longest;
        if (worth > score) {
            score = worth;
            *best = tried;
        }
    }
    if (score < 0.0) {
        best->count = 0;
    }
    return WG_OK;
}

// Splits a tile of all headings: along x by the discs, or into ranges of headings.
static WgStatus split_turn(WgBoxes *boxes, const WgBox *box, WgPortions *portions)
{
    portions->count = 0;
    portions->decided = 0.0;
    if (box->halvings == 0) {
        return cut_along(boxes, box, &box->range, WG_X, WG_MOST_PORTIONS, portions);
    }
    for (int64_t heading = 0; heading < boxes->period; heading += WG_BASE_TURN) {
        WgRange range = box->range;
        range.low[WG_HEADING] = (int32_t)heading;
        range.high[WG_HEADING] = (int32_t)(heading + WG_BASE_TURN);
        WgStatus status = cut_along(boxes, box, &range, WG_X, WG_MOST_PORTIONS / (WG_TURN / WG_BASE_TURN), portions);
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

WgStatus wg_portions_of(WgBoxes *boxes, const WgBox *box, WgPortions *portions)
{
    bool is_around = box->range.high[WG_HEADING] - box->range.low[WG_HEADING] > WG_BASE_TURN;
    return is_around ? split_turn(boxes, box, portions) : choose_split(boxes, box, portions);
}

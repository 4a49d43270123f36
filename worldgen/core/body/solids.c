// Finds the rectangles of solid cells.

#include <stdlib.h>
#include <string.h>

#include "solids.h"

// How far the outside extends, lu: more than any box and body.
#define FAR ((int64_t)1 << 22)

// Solid cells with a ring of them around the grid.
typedef struct Padded {
    uint8_t *solid;
    int64_t size[2];  // columns, rows
    int64_t step[2];  // from a cell to the next one, by axis
    int32_t *back;    // how many solid cells follow without a gap, from a cell on, down an axis
    int32_t *ahead;   // and up
} Padded;

static bool add(WgSolids *solids, WgSolid solid)
{
    if (solids->count == solids->room) {
        int64_t room = 2 * solids->room + 64;
        WgSolid *all = realloc(solids->all, (size_t)room * sizeof *all);
        if (all == NULL) {
            return false;
        }
        solids->all = all;
        solids->room = room;
    }
    solids->all[solids->count++] = solid;
    return true;
}

// Counts the solid cells around each cell along an axis.
static void count_along(Padded *padded, int axis)
{
    int64_t step = padded->step[axis];
    for (int64_t line = 0; line < padded->size[1 - axis]; line++) {
        int64_t base = line * padded->step[1 - axis];
        int32_t run = 0;
        for (int64_t k = 0; k < padded->size[axis]; k++) {
            run = padded->solid[base + k * step] != 0 ? run + 1 : 0;
            padded->back[base + k * step] = run;
        }
        run = 0;
        for (int64_t k = padded->size[axis] - 1; k >= 0; k--) {
            run = padded->solid[base + k * step] != 0 ? run + 1 : 0;
            padded->ahead[base + k * step] = run;
        }
    }
}

// Lists the rectangles that hold the runs along an axis.
static bool list_runs(WgSolids *solids, Padded *padded, int axis)
{
    int other = 1 - axis;
    count_along(padded, other);
    int64_t step = padded->step[axis];
    for (int64_t line = 0; line < padded->size[other]; line++) {
        int64_t base = line * padded->step[other];
        for (int64_t begin = 0; begin < padded->size[axis];) {
            if (padded->solid[base + begin * step] == 0) {
                begin++;
                continue;
            }
            int32_t back = INT32_MAX;
            int32_t ahead = INT32_MAX;
            int64_t end = begin;
            for (; end < padded->size[axis] && padded->solid[base + end * step] != 0; end++) {
                back = padded->back[base + end * step] < back ? padded->back[base + end * step] : back;
                ahead = padded->ahead[base + end * step] < ahead ? padded->ahead[base + end * step] : ahead;
            }
            // The first of its runs stands for a rectangle.
            int64_t bottom = line - back + 1;
            bool is_first = true;
            for (int64_t below = bottom; below < line && is_first; below++) {
                int64_t at = below * padded->step[other];
                bool opens = begin == 0 || padded->solid[at + (begin - 1) * step] == 0;
                bool closes = end == padded->size[axis] || padded->solid[at + end * step] == 0;
                is_first = !(opens && closes);
            }
            // Such a rectangle of a column may be one of a row, too.
            for (int64_t at = begin; axis == 1 && at < end && is_first; at++) {
                int64_t cell = at * step;
                bool opens = bottom == 0 || padded->solid[cell + (bottom - 1) * padded->step[other]] == 0;
                int64_t top = line + ahead;
                bool closes = top == padded->size[other] || padded->solid[cell + top * padded->step[other]] == 0;
                is_first = !(opens && closes);
            }
            if (is_first) {
                WgSolid solid = {.in_cover = axis == 0};
                const int64_t low[2] = {begin - 1, bottom - 1};
                const int64_t high[2] = {end - 1, line + ahead - 1};
                for (int which = 0; which < 2; which++) {
                    int along = which == 0 ? axis : other;
                    solid.low[along] = low[which] * WG_UNIT - (low[which] < 0 ? FAR : 0);
                    bool is_out = high[which] == padded->size[along] - 1;
                    solid.high[along] = high[which] * WG_UNIT + (is_out ? FAR : 0);
                }
                if (!add(solids, solid)) {
                    return false;
                }
            }
            begin = end;
        }
    }
    return true;
}

WgStatus wg_solids_make(WgSolids *solids, const WgWalls *walls)
{
    *solids = (WgSolids){0};
    int64_t width = walls->width + 2;
    int64_t height = walls->height + 2;
    size_t cells = (size_t)(width * height);
    Padded padded = {
        .solid = malloc(cells),
        .size = {width, height},
        .step = {1, width},
        .back = malloc(cells * sizeof(int32_t)),
        .ahead = malloc(cells * sizeof(int32_t)),
    };
    WgStatus status = WG_OUT_OF_MEMORY;
    if (padded.solid != NULL && padded.back != NULL && padded.ahead != NULL) {
        memset(padded.solid, 1, cells);
        for (int64_t row = 0; row < walls->height; row++) {
            memcpy(padded.solid + (row + 1) * width + 1, walls->solid + row * walls->width, (size_t)walls->width);
        }
        bool is_done = list_runs(solids, &padded, 0) && list_runs(solids, &padded, 1);
        status = is_done ? WG_OK : WG_OUT_OF_MEMORY;
    }
    free(padded.solid);
    free(padded.back);
    free(padded.ahead);
    return status;
}

void wg_solids_free(WgSolids *solids)
{
    free(solids->all);
    *solids = (WgSolids){0};
}

// A whole decision about a still world, from its cells to the timed path, for starts and targets on the pose lattice.
//
// What it leaves open (nothing was found, or only fractions could tell) its caller asks step by step.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reach_internal.h"

enum {
    HALF = WG_UNIT / 2,    // the graph has nodes at multiples of half a cell
    MOST_LINKS = 16,       // nodes around a point
    LOOK = 32,             // a node is expanded in the time in which a flood fills so many
    PATIENCE = 6,          // corners in a row that may be out of sight before a straight line ends
    MOST_TESTS = 6000,     // straight lines that may fail on one path; on long paths there is less patience
    MOST_CELLS = 1 << 18,  // so that a call ends in a fraction of a second
};

static const double WHOLE = 9007199254740992.0;  // 2^53: floats below it hold every whole number

// What a decision works on; everything is released at once.
typedef struct Work {
    const WgStill *asked;
    WgWalls walls;
    WgGraph graph;
    uint8_t *rasters;  // (2 nodes,) clear, then middle
    uint8_t *seen;
    WgSearch *search;
    int64_t *nodes;
    int64_t *kept;
    int64_t sources[MOST_LINKS];
    int64_t source_count;
    int64_t ends[MOST_LINKS];
    int64_t end_count;
    bool sure;
} Work;

static bool is_clear(Work *work, int64_t x, int64_t y)
{
    if (x % HALF == 0 && y % HALF == 0) {
        return work->graph.clear[y / HALF * work->graph.stride + x / HALF] != 0;
    }
    WgAnswer answer = wg_sweep(&work->walls, (WgPiece){x, y, x, y}, &work->asked->disc);
    return answer == WG_CLEAR;
}

// Clear nodes near a point to which the disc may go straight; the node itself where the point is one.
static int64_t list_links(Work *work, const WgDisc *disc, int64_t x, int64_t y, int64_t *nodes)
{
    const WgGraph *graph = &work->graph;
    if (x % HALF == 0 && y % HALF == 0) {
        nodes[0] = y / HALF * graph->stride + x / HALF;
        return graph->clear[nodes[0]] != 0 ? 1 : 0;
    }
    int64_t count = 0;
    int64_t rows = graph->nodes / graph->stride;
    for (int64_t j = wg_max(y / HALF - 1, 0); j < wg_min(y / HALF + 3, rows); j++) {
        for (int64_t i = wg_max(x / HALF - 1, 0); i < wg_min(x / HALF + 3, graph->stride); i++) {
            if (graph->clear[j * graph->stride + i] == 0) {
                continue;
            }
            WgAnswer answer = wg_sweep(&work->walls, (WgPiece){x, y, i * HALF, j * HALF}, disc);
            work->sure = work->sure && answer != WG_UNSURE;
            if (answer == WG_CLEAR) {
                nodes[count++] = j * graph->stride + i;
            }
        }
    }
    return count;
}

// Whether an end is joined to a source.
static WgStatus look(Work *work, bool *joined)
{
    const WgGraph *graph = &work->graph;
    work->seen = calloc((size_t)graph->nodes, 1);
    if (work->seen == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    WgStatus status = wg_flood(graph->clear, graph->middle, graph->nodes, graph->stride, work->sources,
                               work->source_count, work->ends, work->end_count, work->seen);
    *joined = false;
    for (int64_t i = 0; i < work->end_count; i++) {
        *joined = *joined || work->seen[work->ends[i]] != 0;
    }
    return status;
}

// Searches for the path, unless a look shows that there is none.
static WgStatus search_path(Work *work, bool *found)
{
    *found = false;
    WgStatus status = wg_search_new(&work->graph, work->sources, work->source_count, work->ends, work->end_count,
                                    NULL, 0, work->asked->toward_x, work->asked->toward_y, NULL, 0, &work->search);
    if (status != WG_OK) {
        return status;
    }
    WgProgress progress;
    status = wg_search_advance(work->search, work->graph.nodes / LOOK + 1, &progress);
    if (status == WG_OK && progress == WG_GOING) {
        bool joined;
        status = look(work, &joined);
        if (status != WG_OK || !joined) {
            return status;
        }
        status = wg_search_advance(work->search, work->graph.nodes, &progress);
    }
    *found = status == WG_OK && progress == WG_FOUND;
    return status;
}

// Leaves out repeated points and points in the middle of a straight line; returns how many are left.
static int64_t merge_straight(int64_t *x, int64_t *y, int64_t count)
{
    int64_t kept = 0;
    int64_t ux = 0;
    int64_t uy = 0;  // the last step
    for (int64_t i = 0; i < count; i++) {
        int64_t vx = kept > 0 ? x[i] - x[kept - 1] : 1;
        int64_t vy = kept > 0 ? y[i] - y[kept - 1] : 1;
        if (vx == 0 && vy == 0) {
            continue;
        }
        while (kept > 1 && ux * vy == uy * vx && ux * vx + uy * vy > 0) {
            kept--;
            vx = x[i] - x[kept - 1];
            vy = y[i] - y[kept - 1];
            if (kept > 1) {
                ux = x[kept - 1] - x[kept - 2];
                uy = y[kept - 1] - y[kept - 2];
            }
        }
        x[kept] = x[i];
        y[kept] = y[i];
        kept++;
        ux = vx;
        uy = vy;
    }
    return kept;
}

// The corners of the path, straightened as far as the disc may sweep.
static WgStatus straighten(Work *work, WgStill *still)
{
    int64_t length = wg_search_path_length(work->search);
    int64_t room = length + 2;
    work->nodes = malloc((size_t)room * sizeof *work->nodes);
    work->kept = calloc((size_t)room, sizeof *work->kept);
    // One block each for whole numbers and for floats, in four and three parts.
    still->points = malloc((size_t)(4 * room) * sizeof *still->points);
    still->metres = malloc((size_t)(3 * room) * sizeof *still->metres);
    uint8_t *whole = malloc((size_t)room);
    if (work->nodes == NULL || work->kept == NULL || still->points == NULL || still->metres == NULL ||
        whole == NULL) {
        free(whole);
        return WG_OUT_OF_MEMORY;
    }
    still->room = room;
    int64_t *x = still->points;
    int64_t *y = still->points + room;
    wg_search_path(work->search, work->nodes);
    x[0] = still->start_x;
    y[0] = still->start_y;
    for (int64_t i = 0; i < length; i++) {
        x[i + 1] = work->nodes[i] % work->graph.stride * HALF;
        y[i + 1] = work->nodes[i] / work->graph.stride * HALF;
    }
    x[room - 1] = still->goal_x;
    y[room - 1] = still->goal_y;
    int64_t count = merge_straight(x, y, room);

    memset(whole, 1, (size_t)room);
    int64_t state[5] = {0, 1, 2, 1, WG_UNSURE};
    int64_t done;
    WgStatus status = wg_shorten(&work->walls, &still->disc, x, y, whole, count,
                                 wg_max(1, wg_min(PATIENCE, MOST_TESTS / count)), state, work->kept, &done);
    free(whole);
    work->sure = work->sure && done != 0;
    for (int64_t i = 0; i < state[3]; i++) {
        x[i] = x[work->kept[i]];
        y[i] = y[work->kept[i]];
    }
    still->count = merge_straight(x, y, state[3]);
    return status;
}

// How near the path comes to solid cells: the least whole square, and candidates among corners.
static WgStatus measure(Work *work, WgStill *still)
{
    int64_t *x = still->points;
    int64_t *y = still->points + still->room;
    int64_t *sides = still->points + 2 * still->room;
    int64_t *lengths_sq = still->points + 3 * still->room;
    int64_t reach = 2 * still->disc.reach;
    while (work->sure) {
        if (reach > INT32_MAX) {
            work->sure = false;
            break;
        }
        WgStatus status = wg_sweep_least(&work->walls, x, y, still->count, reach, sides, lengths_sq, &still->corners,
                                         &still->least);
        if (status != WG_OK) {
            return status;
        }
        if (still->least < reach * reach) {
            break;
        }
        // Nothing that is surely within reach: look farther.
        if (still->corners > 0) {
            double square = (double)sides[0] * (double)sides[0] / (double)lengths_sq[0];
            work->sure = square < (double)(reach * reach) * (1.0 - 1e-9);
            break;
        }
        reach *= 2;
    }
    return WG_OK;
}

// The least whole number of ticks for a piece: the root, rounded up, of its squared length times a fraction.
static bool ticks_of(int64_t dx, int64_t dy, const WgPace *pace, int64_t *ticks)
{
    unsigned __int128 over = (unsigned __int128)(uint64_t)(dx * dx + dy * dy) * (uint64_t)pace->tick_over;
    unsigned __int128 square = over / (uint64_t)pace->tick_under;
    if (square >= (unsigned __int128)1 << 61) {
        return false;
    }
    int64_t least = wg_root_floor((int64_t)square);
    bool enough = (unsigned __int128)(uint64_t)(least * least) * (uint64_t)pace->tick_under >= over;
    *ticks = enough ? least : least + 1;
    return true;
}

// Points in metres and times in seconds, each rounded once.
static void convert(Work *work, WgStill *still)
{
    const int64_t *from[2] = {still->points, still->points + still->room};
    double under = (double)still->pace.metre_under;
    for (int64_t axis = 0; axis < 2; axis++) {
        for (int64_t i = 0; i < still->count; i++) {
            double over = (double)from[axis][i] * (double)still->pace.metre_over;
            work->sure = work->sure && over < WHOLE;
            still->metres[axis * still->room + i] = over / under;
        }
    }
    double *seconds = still->metres + 2 * still->room;
    int64_t now = 0;
    for (int64_t i = 0; i < still->count && work->sure; i++) {
        int64_t takes = 0;
        if (i > 0) {
            int64_t dx = from[0][i] - from[0][i - 1];
            int64_t dy = from[1][i] - from[1][i - 1];
            work->sure = ticks_of(dx, dy, &still->pace, &takes);
        }
        now += takes;
        work->sure = work->sure && now < (int64_t)WHOLE;
        seconds[i] = (double)now / (double)still->pace.ticks;
    }
}

// Finds the path, and says in ``still`` what was found.
static WgStatus decide(Work *work, WgStill *still)
{
    int64_t height = work->walls.height;
    int64_t width = work->walls.width;
    WgGraph *graph = &work->graph;
    graph->stride = 2 * width + 1;
    graph->nodes = graph->stride * (2 * height + 1);
    work->rasters = malloc((size_t)(2 * graph->nodes));
    if (work->rasters == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    graph->clear = work->rasters;
    graph->middle = work->rasters + graph->nodes;
    WgStatus status = wg_disc_rasters(work->walls.solid, height, width, 2, still->clear_from, work->rasters,
                                      work->rasters + graph->nodes);
    if (status != WG_OK || !is_clear(work, still->start_x, still->start_y) ||
        !is_clear(work, still->goal_x, still->goal_y)) {
        return status;
    }
    work->source_count = list_links(work, &still->disc, still->start_x, still->start_y, work->sources);
    work->end_count = list_links(work, &still->goal_disc, still->goal_x, still->goal_y, work->ends);
    if (!work->sure || work->source_count == 0 || work->end_count == 0) {
        return WG_OK;
    }

    // Without the path, it is enough to know that there is one.
    bool found;
    status = still->wants_path != 0 ? search_path(work, &found) : look(work, &found);
    if (status != WG_OK || !found) {
        return status;
    }
    if (still->wants_path != 0) {
        status = straighten(work, still);
        if (status == WG_OK) {
            status = measure(work, still);
        }
        if (status != WG_OK || !work->sure) {
            return status;
        }
        convert(work, still);
    }
    still->reachable = work->sure;
    return WG_OK;
}

WgStatus wg_still_decide(const WgWalls *walls, WgStill *still)
{
    still->reachable = 0;
    still->points = NULL;
    still->metres = NULL;
    if (walls->height < 1 || walls->width < 1 || walls->height > 20000 || walls->width > 20000) {
        return WG_BAD_SIZE;
    }
    int64_t right = walls->width * WG_UNIT;
    int64_t top = walls->height * WG_UNIT;
    bool inside = still->start_x >= 0 && still->start_x <= right && still->start_y >= 0 && still->start_y <= top &&
                  still->goal_x >= 0 && still->goal_x <= right && still->goal_y >= 0 && still->goal_y <= top;
    const WgPace *pace = &still->pace;
    if (!inside || still->disc.reach < 0 || still->disc.reach > top + right || pace->metre_under < 1 ||
        pace->metre_under >= (int64_t)WHOLE || pace->metre_over < 1 || pace->tick_under < 1 ||
        pace->tick_over < 1 || pace->ticks < 1 || pace->ticks >= (int64_t)WHOLE) {
        return WG_BAD_VALUE;
    }
    if (walls->height * walls->width > MOST_CELLS) {
        return WG_OK;
    }
    Work work = {.asked = still, .walls = *walls, .sure = true};
    WgStatus status = decide(&work, still);
    free(work.rasters);
    free(work.seen);
    free(work.nodes);
    free(work.kept);
    wg_search_free(work.search);
    if (still->reachable == 0) {
        wg_still_free(still);
    }
    return status;
}

void wg_still_free(WgStill *still)
{
    free(still->points);
    free(still->metres);
    still->points = NULL;
    still->metres = NULL;
}

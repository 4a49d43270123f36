// Decides a static world completely, from its cells to the timed path,
// for starts and targets on the pose lattice.
//
// If the result is inconclusive (nothing was found, or only fractions can decide),
// the caller continues step by step.

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "parted.h"
#include "wide.h"
#include "reach_internal.h"

enum {
    HALF = WG_UNIT / 2,    // the graph has nodes at multiples of half a cell
    MOST_LINKS = 16,       // nodes around a point
    LOOK = 32,             // a node is expanded in the time in which a flood fills this many
    PATIENCE = 6,          // limit on consecutive hidden corners before a straight line ends
    MOST_TESTS = 6000,     // limit on failed straight lines per path; lower for long paths
    MOST_CELLS = 1 << 18,  // so that a call ends in a fraction of a second
};

static const double WHOLE = 9007199254740992.0;  // 2^53: floats represent every integer below it

// The working memory of a decision, all released together.
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
    int64_t *spare;  // clear nodes in the target's disc
    int64_t spare_count;
    bool sure;
    bool knows_spare;
} Work;

static bool is_clear(Work *work, int64_t x, int64_t y)
{
    if (x % HALF == 0 && y % HALF == 0) {
        return work->graph.clear[y / HALF * work->graph.stride + x / HALF] != 0;
    }
    WgAnswer answer = wg_sweep(&work->walls, (WgPiece){x, y, x, y}, &work->asked->disc);
    return answer == WG_CLEAR;
}

// Lists clear nodes near a point that the disc can reach in a straight line;
// if the point is a node, only that.
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
            int64_t node = j * graph->stride + i;
            assert(node < graph->nodes);
            if (graph->clear[node] == 0) {
                continue;
            }
            WgAnswer answer = wg_sweep(&work->walls, (WgPiece){x, y, i * HALF, j * HALF}, disc);
            work->sure = work->sure && answer != WG_UNSURE;
            if (answer == WG_CLEAR) {
                nodes[count++] = node;
            }
        }
    }
    return count;
}

// Returns true if a node is in the target's disc.
static bool is_in_target(Work *work, int64_t i, int64_t j)
{
    const WgTarget *target = &work->asked->target;
    double across = (double)i / 2.0 - target->centre_x;
    double up = (double)j / 2.0 - target->centre_y;
    double apart = sqrt(across * across + up * up);
    if (fabs(apart - target->disc_radius) > 1e-9 * (1.0 + target->disc_radius)) {
        return apart < target->disc_radius;
    }
    // Otherwise only integers can decide.
    if (target->scale == 0 || target->radius < 0) {
        work->knows_spare = false;
        return false;
    }
    WgInt128 radius = 2 * (WgInt128)target->radius;
    WgInt128 dx = (WgInt128)i * target->scale - 2 * (WgInt128)target->x;
    WgInt128 dy = (WgInt128)j * target->scale - 2 * (WgInt128)target->y;
    return dx * dx + dy * dy <= radius * radius;
}

// Lists the clear nodes in the target's disc.
static WgStatus list_spare(Work *work)
{
    const WgGraph *graph = &work->graph;
    const WgTarget *target = &work->asked->target;
    int64_t rows = graph->nodes / graph->stride;
    int64_t low_x = wg_max(0, (int64_t)floor(2.0 * (target->centre_x - target->disc_radius)) - 1);
    int64_t low_y = wg_max(0, (int64_t)floor(2.0 * (target->centre_y - target->disc_radius)) - 1);
    int64_t high_x = wg_min(graph->stride, (int64_t)ceil(2.0 * (target->centre_x + target->disc_radius)) + 2);
    int64_t high_y = wg_min(rows, (int64_t)ceil(2.0 * (target->centre_y + target->disc_radius)) + 2);
    int64_t room = wg_max(0, high_x - low_x) * wg_max(0, high_y - low_y);
    work->spare = malloc((size_t)(room + 1) * sizeof *work->spare);
    if (work->spare == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t j = low_y; j < high_y; j++) {
        for (int64_t i = low_x; i < high_x; i++) {
            if (graph->clear[j * graph->stride + i] != 0 && is_in_target(work, i, j)) {
                assert(work->spare_count < room);
                work->spare[work->spare_count++] = j * graph->stride + i;
            }
        }
    }
    return WG_OK;
}

// Returns true if an end, or else a spare end, is connected to a source.
static WgStatus look(Work *work, bool *joined)
{
    const WgGraph *graph = &work->graph;
    free(work->seen);
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
    for (int64_t i = 0; i < work->spare_count; i++) {
        *joined = *joined || work->seen[work->spare[i]] != 0;
    }
    return status;
}

// Searches for the path, unless a check shows that there is none.
static WgStatus search_path(Work *work, bool *found)
{
    *found = false;
    wg_search_free(work->search);
    work->search = NULL;
    WgStatus status =
        wg_search_new(&work->graph, work->sources, work->source_count, work->ends, work->end_count, work->spare,
                      work->spare_count, work->asked->toward_x, work->asked->toward_y, NULL, 0, &work->search);
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
        // Spare ends are tried if no other can be reached, so the first one is enough.
        if (work->spare_count > 0) {
            wg_search_be_content(work->search);
        }
        status = wg_search_advance(work->search, work->graph.nodes, &progress);
    }
    *found = status == WG_OK && progress == WG_FOUND;
    return status;
}

// Looks for a path to the goal, and then to any clear node of the target; returns the path,
// or only its existence.
static WgStatus find_way(Work *work, bool *found)
{
    *found = false;
    if (work->source_count == 0) {
        return WG_OK;
    }
    WgStatus status = WG_OK;
    bool wants_path = work->asked->wants_path != 0;
    if (work->end_count > 0) {
        status = wants_path ? search_path(work, found) : look(work, found);
    }
    if (status != WG_OK || *found) {
        return status;
    }
    status = list_spare(work);
    if (status != WG_OK || work->spare_count == 0 || !work->knows_spare) {
        return status;
    }
    return wants_path ? search_path(work, found) : look(work, found);
}

static WgFinePose fine_pose(int64_t x, int64_t y, uint32_t rest[2])
{
    int64_t column = wg_floor_div(x, HALF);
    int64_t row = wg_floor_div(y, HALF);
    rest[0] = (uint32_t)(x - column * HALF) << 23;
    rest[1] = (uint32_t)(y - row * HALF) << 23;
    return (WgFinePose){column, row, rest, rest + 1, 1};
}

enum { MOST_AT_ONCE = 64 };  // poses whose chains are searched together

// Returns true if chains separate the start from each of the poses
// that are sufficient for the target.
static WgStatus look_for_chains(Work *work, bool *parted)
{
    const WgStill *asked = work->asked;
    WgFinePose poses[MOST_AT_ONCE + 1];
    uint32_t rests[2 * (MOST_AT_ONCE + 1)];
    poses[0] = fine_pose(asked->start_x, asked->start_y, rests);
    *parted = false;

    // If the robot may be anywhere in the target, every pose in it is equivalent to the goal.
    WgPiece goal = {asked->goal_x, asked->goal_y, asked->goal_x, asked->goal_y};
    if (asked->goal_clear != 0 && wg_sweep(&work->walls, goal, &asked->both) == WG_CLEAR) {
        poses[1] = fine_pose(asked->goal_x, asked->goal_y, rests + 2);
        return wg_all_parted(&work->walls, asked->limit, poses, 2, parted);
    }
    WgPoses *listed_poses;
    WgListed listed;
    WgStatus status = wg_poses_new(&work->walls, &asked->target, &listed_poses, &listed);
    if (status != WG_OK || listed != WG_LISTED) {
        return status;
    }
    *parted = true;
    int64_t count = wg_poses_count(listed_poses);
    for (int64_t begin = 0; begin < count && *parted && status == WG_OK; begin += MOST_AT_ONCE) {
        int64_t now = wg_min(count - begin, MOST_AT_ONCE);
        for (int64_t i = 0; i < now; i++) {
            int64_t x;
            int64_t y;
            wg_poses_round(listed_poses, begin + i, &x, &y);
            poses[i + 1] = fine_pose(x, y, rests + 2 * (i + 1));
        }
        status = wg_all_parted(&work->walls, asked->limit, poses, now + 1, parted);
    }
    wg_poses_free(listed_poses);
    return status;
}

// Removes repeated points and points in the middle of a straight line;
// returns the number of those left.
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

// Finds the corners of the path, straightened as far as the disc may sweep.
static WgStatus straighten(Work *work, WgStill *still)
{
    int64_t length = wg_search_path_length(work->search);
    int64_t room = length + 2;
    work->nodes = malloc((size_t)room * sizeof *work->nodes);
    work->kept = calloc((size_t)room, sizeof *work->kept);
    // Allocate one block of four parts for integers and one of three parts for floats.
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
    // From a spare end there is nowhere to go.
    int64_t count = length + 1;
    for (int64_t i = 0; i < work->end_count && count < room; i++) {
        if (work->nodes[length - 1] == work->ends[i]) {
            x[count] = still->goal_x;
            y[count] = still->goal_y;
            count++;
        }
    }
    count = merge_straight(x, y, count);
    assert(count >= 1);  // the start stays

    memset(whole, 1, (size_t)room);
    int64_t state[5] = {0, 1, 2, 1, WG_UNSURE};
    int64_t done;
    WgStatus status = wg_shorten(&work->walls, &still->disc, x, y, whole, count,
                                 wg_max(1, wg_min(PATIENCE, MOST_TESTS / count)), state, work->kept, &done);
    free(whole);
    work->sure = work->sure && done != 0;
    assert(state[3] >= 1 && state[3] <= count && count <= room);
    for (int64_t i = 0; i < state[3]; i++) {
        x[i] = x[work->kept[i]];
        y[i] = y[work->kept[i]];
    }
    still->count = merge_straight(x, y, state[3]);
    return status;
}

// Measures how near the path comes to solid cells: the smallest integer square,
// and candidates among corners.
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
        // Nothing is certainly within reach: look farther.
        if (still->corners > 0) {
            double square = (double)sides[0] * (double)sides[0] / (double)lengths_sq[0];
            work->sure = square < (double)(reach * reach) * (1.0 - 1e-9);
            break;
        }
        reach *= 2;
    }
    return WG_OK;
}

// Returns the smallest integer number of ticks for a piece: the root, rounded up, of its squared
// length times a fraction.
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

// Converts points to metres and times to seconds, each rounded once.
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

// Finds the path or its absence, and records it in ``still``.
static WgStatus decide(Work *work, WgStill *still)
{
    WgPiece start = {still->start_x, still->start_y, still->start_x, still->start_y};
    if (wg_sweep(&work->walls, start, &still->start_disc) != WG_CLEAR) {
        bool covered = wg_sweep(&work->walls, start, &still->start_core) == WG_MEETS;
        still->outcome = covered ? WG_START_COVERED : WG_OPEN;
        return WG_OK;
    }
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
    if (status != WG_OK) {
        return status;
    }
    still->goal_clear = still->has_goal != 0 && is_clear(work, still->goal_x, still->goal_y);
    work->source_count = list_links(work, &still->disc, still->start_x, still->start_y, work->sources);
    if (still->goal_clear != 0) {
        work->end_count = list_links(work, &still->goal_disc, still->goal_x, still->goal_y, work->ends);
    }
    if (!work->sure) {
        return WG_OK;
    }

    // Without the path, it is enough to know that one exists.
    bool found;
    status = find_way(work, &found);
    if (status != WG_OK) {
        return status;
    }
    if (!found) {
        bool parted = false;
        if (!work->knows_spare) {
            return WG_OK;
        }
        if (still->wants_cut == 0 && still->limit > 0 && still->target.scale > 0) {
            status = look_for_chains(work, &parted);
        }
        still->outcome = parted ? WG_PARTED : WG_NO_PATH;
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
    still->outcome = work->sure ? WG_REACHED : WG_OPEN;
    return WG_OK;
}

WgStatus wg_still_decide(const WgWalls *walls, WgStill *still)
{
    still->outcome = WG_OPEN;
    still->goal_clear = 0;
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
    const WgTarget *target = &still->target;
    int64_t longest = (int64_t)1 << 62;
    bool has_sane_target = target->scale >= 0 && target->scale < longest && wg_abs(target->x) < longest &&
                           wg_abs(target->y) < longest && target->reach < longest && target->radius < longest && target->disc_radius >= 0.0 && target->disc_radius <= 40000.0 &&
                           target->centre_x >= -1.0 && target->centre_x <= 20001.0 && target->centre_y >= -1.0 &&
                           target->centre_y <= 20001.0 && still->both.reach <= INT32_MAX && still->start_disc.reach <= INT32_MAX &&
                           still->start_core.reach >= 0 && still->start_core.reach <= INT32_MAX;
    if (!inside || !has_sane_target || still->disc.reach < 0 || pace->metre_under < 1 ||
        pace->metre_under >= (int64_t)WHOLE || pace->metre_over < 1 || pace->tick_under < 1 ||
        pace->tick_over < 1 || pace->ticks < 1 || pace->ticks >= (int64_t)WHOLE) {
        return WG_BAD_VALUE;
    }
    if (walls->height * walls->width > MOST_CELLS) {
        return WG_OK;
    }
    // Such a disc has no room anywhere.
    if (still->disc.reach > top + right) {
        still->outcome = WG_START_COVERED;
        return WG_OK;
    }
    Work work = {.asked = still, .walls = *walls, .sure = true, .knows_spare = true};
    WgStatus status = decide(&work, still);
    free(work.rasters);
    free(work.seen);
    free(work.nodes);
    free(work.kept);
    free(work.spare);
    wg_search_free(work.search);
    if (still->outcome != WG_REACHED) {
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

// Finds the shortest path over the eight neighbours of a graph's nodes,
// with buckets and bits instead of a heap.
//
// The search takes the node with the lowest estimate; ties go to the lowest number. Estimates
// never fall, and a step raises one by at most 198. So waiting nodes are in a ring of buckets, one
// for each estimate, and those with the current estimate are bits in a tree of words, 64 to a word,
// which yields the lowest in a few steps. A heap took two to four times as long on open ground.
//
// Hart, Nilsson, Raphael, "A Formal Basis for the Heuristic Determination of Minimum Cost Paths"
// (1968). Dial, "Algorithm 360: Shortest-Path Forest with Topological Ordering" (1969),
// for the buckets.

#include <stdlib.h>
#include <string.h>

#include "reach_internal.h"

// A node's state: by which step it was reached, and two marks. 99/70 is sqrt(2) to 7e-5.
enum {
    AXIS_COST = 70,
    DIAGONAL_COST = 99,
    // the bits of the step: 0 if not reached, 1 to 8 for a step, or one of the next two
    REACHED = 15,
    BY_BRIDGE = 9,
    AT_SOURCE = 10,
    CLOSED = 16,  // finished, or not clear
    IS_END = 32,
    IS_SPARE = 64,
};

enum { LEAST_RING = 1024, MOST_LEVELS = 6, NO_NODE = -1 };

// A waiting node, and the next one in its bucket.
typedef struct Waiting {
    int32_t node;
    int32_t next;
} Waiting;

struct WgSearch {
    WgGraph graph;
    int64_t toward_x;
    int64_t toward_y;
    int64_t shifts[8];   // offset of each step in node numbers, four along the axes first
    int64_t corners[8];  // offset of the middle of a diagonal step

    uint8_t *state;      // (nodes,)
    // (nodes,) of reached nodes, modulo 2^32: the estimates of waiting nodes differ by less
    uint32_t *estimate;

    // The ring, with a bit for each bucket that isn't empty.
    int32_t *first;
    uint64_t *filled;
    int64_t ring;
    Waiting *waiting;
    int64_t waiting_room;
    int64_t waiting_used;
    int64_t waiting_count;
    int32_t unused;

    // The nodes with the current estimate: a bit for each node, then one for each word of those,
    // and so on.
    uint64_t *bits;
    int64_t begins[MOST_LEVELS];
    int64_t levels;

    int64_t level;   // the current estimate; -1 while the sources are processed, by number
    int64_t lowest;  // lowest estimate that the sources lead to
    int64_t end;
    bool content;  // whether a spare end is acceptable, because no other can be reached
    bool done;

    const int64_t *bridges;  // (bridge_count, 2)
    int64_t bridge_count;
    int64_t *crossed;  // (crossed_count, 2) nodes reached by a bridge, and from where
    int64_t crossed_count;
};

static int64_t heuristic(const WgSearch *search, int64_t node)
{
    int64_t dx = wg_abs(node % search->graph.stride - search->toward_x);
    int64_t dy = wg_abs(node / search->graph.stride - search->toward_y);
    return dx > dy ? AXIS_COST * dx + (DIAGONAL_COST - AXIS_COST) * dy
                   : AXIS_COST * dy + (DIAGONAL_COST - AXIS_COST) * dx;
}

static void set_bit(WgSearch *search, int64_t node)
{
    for (int64_t rung = 0; rung < search->levels; rung++) {
        uint64_t *word = search->bits + search->begins[rung] + (node >> 6);
        uint64_t before = *word;
        *word = before | (uint64_t)1 << (node & 63);
        if (before != 0) {
            break;
        }
        node >>= 6;
    }
}

// Removes and returns the lowest node of the current estimate, which must exist.
static int64_t take_least(WgSearch *search)
{
    int64_t node = 0;
    for (int64_t rung = search->levels - 1; rung >= 0; rung--) {
        node = node << 6 | __builtin_ctzll(search->bits[search->begins[rung] + node]);
    }
    int64_t at = node;
    for (int64_t rung = 0; rung < search->levels; rung++) {
        uint64_t *word = search->bits + search->begins[rung] + (at >> 6);
        *word &= *word - 1;
        if (*word != 0) {
            break;
        }
        at >>= 6;
    }
    return node;
}

static bool has_present(const WgSearch *search)
{
    return search->bits[search->begins[search->levels - 1]] != 0;
}

// Advances to the lowest estimate of a waiting node, and makes its bucket the current nodes.
static void next_level(WgSearch *search)
{
    int64_t mask = search->ring - 1;
    search->level = search->level < 0 ? search->lowest : search->level;
    uint64_t word = search->filled[(search->level & mask) >> 6] >> (search->level & 63);
    while (word == 0) {
        search->level = (search->level | 63) + 1;
        word = search->filled[(search->level & mask) >> 6];
    }
    search->level += __builtin_ctzll(word);
}

static void empty_bucket(WgSearch *search)
{
    int64_t bucket = search->level & (search->ring - 1);
    int32_t entry = search->first[bucket];
    while (entry >= 0) {
        Waiting *here = search->waiting + entry;
        int32_t next = here->next;
        if ((search->state[here->node] & CLOSED) == 0) {
            set_bit(search, here->node);
        }
        here->next = search->unused;
        search->unused = entry;
        search->waiting_count--;
        entry = next;
    }
    search->first[bucket] = NO_NODE;
    search->filled[bucket >> 6] &= ~((uint64_t)1 << (bucket & 63));
}

static bool put_into_bucket(WgSearch *search, int64_t node, int64_t estimate)
{
    int32_t entry = search->unused;
    if (entry >= 0) {
        search->unused = search->waiting[entry].next;
    } else {
        if (search->waiting_used == search->waiting_room) {
            int64_t room = 2 * search->waiting_room;
            if (room > INT32_MAX) {
                return false;
            }
            Waiting *waiting = realloc(search->waiting, (size_t)room * sizeof *waiting);
            if (waiting == NULL) {
                return false;
            }
            search->waiting = waiting;
            search->waiting_room = room;
        }
        entry = (int32_t)search->waiting_used++;
    }
    int64_t bucket = estimate & (search->ring - 1);
    search->waiting[entry] = (Waiting){(int32_t)node, search->first[bucket]};
    search->first[bucket] = entry;
    search->filled[bucket >> 6] |= (uint64_t)1 << (bucket & 63);
    search->waiting_count++;
    return true;
}

// Ensures that the ring has room for all estimates of the sources.
static bool widen_ring(WgSearch *search, int64_t spread)
{
    int64_t ring = search->ring == 0 ? LEAST_RING : search->ring;
    while (ring < spread + 4 * DIAGONAL_COST) {
        ring *= 2;
    }
    if (ring == search->ring) {
        return true;
    }
    // Nothing is waiting now, so nothing has to be moved.
    free(search->first);
    free(search->filled);
    search->ring = 0;
    search->first = malloc((size_t)ring * sizeof *search->first);
    search->filled = calloc((size_t)(ring / 64), sizeof *search->filled);
    if (search->first == NULL || search->filled == NULL) {
        return false;
    }
    memset(search->first, 0xff, (size_t)ring * sizeof *search->first);
    search->ring = ring;
    return true;
}

// Starts or restarts the search at nodes of cost 0, which are ``step`` apart in the list.
static bool begin_at(WgSearch *search, const int64_t *sources, int64_t count, int64_t step, uint8_t how)
{
    int64_t least = INT64_MAX;
    int64_t most = 0;
    for (int64_t i = 0; i < count; i++) {
        int64_t node = sources[step * i];
        int64_t estimate = heuristic(search, node);
        least = wg_min(least, estimate);
        most = wg_max(most, estimate);
        search->state[node] = (uint8_t)((search->state[node] & ~REACHED) | how);
        search->estimate[node] = (uint32_t)estimate;
        set_bit(search, node);
    }
    search->level = -1;
    search->lowest = INT64_MAX;
    return widen_ring(search, count > 0 ? most - least : 0);
}

static bool in_graph(const WgGraph *graph, const int64_t *nodes, int64_t count)
{
    for (int64_t i = 0; i < count; i++) {
        if (nodes[i] < 0 || nodes[i] >= graph->nodes || graph->clear[nodes[i]] == 0) {
            return false;
        }
    }
    return true;
}

// Lays out the levels of bits; returns the number of words they take.
static int64_t lay_out_bits(WgSearch *search)
{
    int64_t words = 0;
    int64_t count = search->graph.nodes;
    do {
        count = (count + 63) >> 6;
        search->begins[search->levels++] = words;
        words += count;
    } while (count > 1);
    return words;
}

WgStatus wg_search_new(const WgGraph *graph, const int64_t *sources, int64_t source_count, const int64_t *ends,
                       int64_t end_count, const int64_t *spare, int64_t spare_count, int64_t toward_x,
                       int64_t toward_y, const int64_t *bridges, int64_t bridge_count, WgSearch **made)
{
    *made = NULL;
    int64_t stride = graph->stride;
    if (stride < 2 || graph->nodes < stride || graph->nodes > INT32_MAX || graph->nodes % stride != 0) {
        return WG_BAD_SIZE;
    }
    bool good = in_graph(graph, sources, source_count) && in_graph(graph, ends, end_count) &&
                in_graph(graph, spare, spare_count) && in_graph(graph, bridges, 2 * bridge_count);
    // No estimate may reach 2^62.
    if (!good || wg_abs(toward_x) > INT32_MAX || wg_abs(toward_y) > INT32_MAX) {
        return WG_BAD_VALUE;
    }
    WgSearch *search = calloc(1, sizeof *search);
    if (search == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    search->graph = *graph;
    search->toward_x = toward_x;
    search->toward_y = toward_y;
    wg_eight_steps(stride, search->shifts, search->corners);
    search->unused = NO_NODE;
    search->end = NO_NODE;
    search->content = end_count == 0;
    search->bridges = bridges;
    search->bridge_count = bridge_count;

    // Memory: estimates are set only when their nodes are reached, so untouched pages cost nothing.
    int64_t words = lay_out_bits(search);
    search->state = malloc((size_t)graph->nodes);
    search->estimate = malloc((size_t)graph->nodes * sizeof *search->estimate);
    search->bits = calloc((size_t)words, sizeof *search->bits);
    search->waiting_room = 1024;
    search->waiting = malloc((size_t)search->waiting_room * sizeof *search->waiting);
    search->crossed = malloc((size_t)(2 * bridge_count + 1) * 2 * sizeof *search->crossed);
    if (search->state == NULL || search->estimate == NULL || search->bits == NULL || search->waiting == NULL ||
        search->crossed == NULL) {
        wg_search_free(search);
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t i = 0; i < graph->nodes; i++) {
        search->state[i] = graph->clear[i] != 0 ? 0 : CLOSED;
    }
    for (int64_t i = 0; i < spare_count; i++) {
        search->state[spare[i]] = IS_SPARE;
    }
    for (int64_t i = 0; i < end_count; i++) {
        search->state[ends[i]] = IS_END;
    }
    if (!begin_at(search, sources, source_count, 1, AT_SOURCE)) {
        wg_search_free(search);
        return WG_OUT_OF_MEMORY;
    }
    *made = search;
    return WG_OK;
}

// Restarts on the far sides of all bridges that the search has reached;
// returns true if there are any.
static bool cross_bridges(WgSearch *search, bool *has_room)
{
    int64_t *crossed = search->crossed + 2 * search->crossed_count;
    int64_t count = 0;
    for (int64_t i = 0; i < 2 * search->bridge_count; i++) {
        const int64_t *pair = search->bridges + 2 * (i % search->bridge_count);
        bool forth = i < search->bridge_count;
        int64_t from = forth ? pair[0] : pair[1];
        int64_t onto = forth ? pair[1] : pair[0];
        if ((search->state[from] & CLOSED) == 0 || (search->state[onto] & CLOSED) != 0) {
            continue;
        }
        // If several bridges lead to one node, the last one counts.
        if ((search->state[onto] & REACHED) == BY_BRIDGE) {
            int64_t known = 0;
            while (crossed[2 * known] != onto) {
                known++;
            }
            crossed[2 * known + 1] = from;
            continue;
        }
        search->state[onto] |= BY_BRIDGE;
        crossed[2 * count] = onto;
        crossed[2 * count + 1] = from;
        count++;
    }
    search->crossed_count += count;
    *has_room = begin_at(search, crossed, count, 2, BY_BRIDGE);
    return count > 0;
}

// Examines the eight neighbours of a node.
static bool expand(WgSearch *search, int64_t node)
{
    const WgGraph *graph = &search->graph;
    int64_t here = search->level >= 0 ? search->level : (int64_t)search->estimate[node];
    int64_t across = node % graph->stride - search->toward_x;
    int64_t up = node / graph->stride - search->toward_y;
    int64_t before = wg_abs(across) > wg_abs(up) ? AXIS_COST * wg_abs(across) + 29 * wg_abs(up)
                                                 : AXIS_COST * wg_abs(up) + 29 * wg_abs(across);
    static const int8_t steps_x[8] = {1, -1, 0, 0, 1, -1, -1, 1};
    static const int8_t steps_y[8] = {0, 0, 1, -1, 1, -1, 1, -1};
    for (int direction = 0; direction < 8; direction++) {
        int64_t other = node + search->shifts[direction];
        uint8_t known = search->state[other];
        if ((known & CLOSED) != 0) {
            continue;
        }
        if (direction > 3 && graph->middle[node + search->corners[direction]] == 0) {
            continue;
        }
        int64_t dx = wg_abs(across + steps_x[direction]);
        int64_t dy = wg_abs(up + steps_y[direction]);
        int64_t left = dx > dy ? AXIS_COST * dx + 29 * dy : AXIS_COST * dy + 29 * dx;
        int64_t estimate = here - before + (direction < 4 ? AXIS_COST : DIAGONAL_COST) + left;
        if ((known & REACHED) != 0 && (int32_t)((uint32_t)estimate - search->estimate[other]) >= 0) {
            continue;
        }
        search->state[other] = (uint8_t)((known & ~REACHED) | (direction + 1));
        search->estimate[other] = (uint32_t)estimate;
        search->lowest = wg_min(search->lowest, estimate);
        if (!put_into_bucket(search, other, estimate)) {
            return false;
        }
    }
    return true;
}

WgStatus wg_search_advance(WgSearch *search, int64_t most, WgProgress *progress)
{
    while (!search->done) {
        if (!has_present(search)) {
            if (search->waiting_count == 0) {
                bool has_room = true;
                if (search->end >= 0 || !cross_bridges(search, &has_room)) {
                    search->done = true;
                }
                if (!has_room) {
                    return WG_OUT_OF_MEMORY;
                }
                continue;
            }
            next_level(search);
        }
        // Steps within one estimate put nodes into its bucket again.
        if (search->level >= 0) {
            empty_bucket(search);
            if (!has_present(search)) {
                continue;
            }
        }
        if (most == 0) {
            *progress = WG_GOING;
            return WG_OK;
        }
        most--;
        int64_t node = take_least(search);
        uint8_t known = search->state[node];
        if ((known & IS_END) != 0 || ((known & IS_SPARE) != 0 && search->end < 0)) {
            search->end = node;
            search->done = (known & IS_END) != 0 || search->content;
            if (search->done) {
                break;
            }
        }
        search->state[node] = known | CLOSED;
        if (!expand(search, node)) {
            return WG_OUT_OF_MEMORY;
        }
    }
    *progress = search->end >= 0 ? WG_FOUND : WG_EXHAUSTED;
    return WG_OK;
}

void wg_search_be_content(WgSearch *search)
{
    search->content = true;
    search->done = search->done || search->end >= 0;
}

// Returns the node before another on the path, or NO_NODE; ``how`` is the step between them.
static int64_t node_before(const WgSearch *search, int64_t node, uint8_t *how)
{
    *how = search->state[node] & REACHED;
    if (*how == AT_SOURCE) {
        return NO_NODE;
    }
    if (*how < BY_BRIDGE) {
        return node - search->shifts[*how - 1];
    }
    int64_t known = search->crossed_count - 1;
    while (search->crossed[2 * known] != node) {
        known--;
    }
    return search->crossed[2 * known + 1];
}

// Walks back along the path; fills in its corners from the last one down if ``nodes`` is given.
static int64_t walk_back(const WgSearch *search, int64_t *nodes, int64_t count)
{
    int64_t found = 0;
    int64_t node = search->end;
    int64_t shift = 0;  // shift of the next step from the node; 0 at the end
    while (node >= 0) {
        uint8_t how;
        int64_t before = node_before(search, node, &how);
        if (before < 0 || shift == 0 || node - before != shift) {
            found++;
            if (nodes != NULL) {
                nodes[count - found] = node;
            }
        }
        shift = before < 0 ? 0 : node - before;
        node = before;
    }
    return found;
}

int64_t wg_search_path_length(const WgSearch *search)
{
    return walk_back(search, NULL, 0);
}

void wg_search_path(const WgSearch *search, int64_t *nodes)
{
    walk_back(search, nodes, wg_search_path_length(search));
}

void wg_search_free(WgSearch *search)
{
    if (search == NULL) {
        return;
    }
    free(search->state);
    free(search->estimate);
    free(search->first);
    free(search->filled);
    free(search->waiting);
    free(search->bits);
    free(search->crossed);
    free(search);
}

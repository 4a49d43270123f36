// The map of nodes and blocked edges, and A* on it; lattice_map.h describes it.

#include "lattice_map.h"

#include <math.h>
#include <stdlib.h>

#include "directions.h"

enum {
    MOVES_A_WORD = 16,  // numbers of 3 bits: 48 bits, which a double holds exactly
    NODES_A_WORD = 12,  // 4 bits each
    MOST_MOVES = MOVES_A_WORD * 64,
    STRAIGHT = 5,  // costs of a move, nearly in the ratio of 1 to the root of 2
    DIAGONAL = 7,
    REACH = 2,  // nodes at most this far from the target, along each axis, are next to it
};

static const int64_t UNKNOWN = (int64_t)1 << 40;

// Position of an edge's bit: the index of a number of the map, and the bit in it.
typedef struct Bit {
    double *word;
    int64_t shift;
} Bit;

// The working memory of a search; numbered by the nodes of the window, row by row.
typedef struct Search {
    int32_t *cost;  // cost of the best path to each node so far; INT32_MAX: none
    int8_t *move;   // by which that path came there; -1: none
    int64_t *heap;  // bound << 32 | node, smallest first
    int64_t count;  // entries in the heap
    int64_t room;   // capacity of the heap
} Search;

WgNode wg_neighbour(WgNode node, int64_t move)
{
    static const int dx[8] = {1, 1, 0, -1, -1, -1, 0, 1};
    static const int dy[8] = {0, 1, 1, 1, 0, -1, -1, -1};
    return (WgNode){node.x + dx[move & 7], node.y + dy[move & 7]};
}

static int64_t side_of(const WgMapperMemory *map)
{
    return (int64_t)map->side;
}

static Bit bit_of(WgMapperMemory *map, WgNode node, int64_t move)
{
    if (move >= 4) {
        node = wg_neighbour(node, move);
        move -= 4;
    }
    int64_t side = side_of(map);
    int64_t number = wg_floor_mod(node.y, side) * side + wg_floor_mod(node.x, side);
    return (Bit){&map->nodes[number / NODES_A_WORD], 4 * (number % NODES_A_WORD) + move};
}

static bool is_blocked(WgMapperMemory *map, WgNode node, int64_t move)
{
    Bit bit = bit_of(map, node, move);
    return (((int64_t)*bit.word >> bit.shift) & 1) != 0;
}

static void set_bit(WgMapperMemory *map, WgNode node, int64_t move)
{
    Bit bit = bit_of(map, node, move);
    *bit.word = (double)((int64_t)*bit.word | ((int64_t)1 << bit.shift));
}

void wg_map_block(WgMapperMemory *map, WgNode node, int64_t move)
{
    set_bit(map, node, move);
    map->plan_length = 0.0;
}

void wg_map_block_near(WgMapperMemory *map, double x, double y, double radius)
{
    int64_t reach = wg_floor(radius) + 2;
    int64_t low_x = (int64_t)map->window_x;
    int64_t low_y = (int64_t)map->window_y;
    int64_t side = side_of(map);

    // The nodes around the point, inside the border of the window.
    int64_t first_x = wg_floor(x) - reach > low_x + 1 ? wg_floor(x) - reach : low_x + 1;
    int64_t first_y = wg_floor(y) - reach > low_y + 1 ? wg_floor(y) - reach : low_y + 1;
    int64_t last_x = wg_floor(x) + reach + 1 < low_x + side - 2 ? wg_floor(x) + reach + 1 : low_x + side - 2;
    int64_t last_y = wg_floor(y) + reach + 1 < low_y + side - 2 ? wg_floor(y) + reach + 1 : low_y + side - 2;
    for (int64_t j = first_y; j <= last_y; j++) {
        for (int64_t i = first_x; i <= last_x; i++) {
            for (int64_t move = 0; move < 4; move++) {
                WgNode node = {i, j};
                WgNode to = wg_neighbour(node, move);
                if (!is_blocked(map, node, move) &&
                    wg_distance_to_path(x, y, (double)i, (double)j, (double)to.x, (double)to.y) < radius) {
                    set_bit(map, node, move);
                    map->plan_length = 0.0;
                }
            }
        }
    }
}

// Number of a node among those next to the target; -1 for other nodes.
static int64_t door_of(const WgMapperMemory *map, WgNode node)
{
    int64_t i = node.x - wg_floor(map->target_x) + REACH - 1;
    int64_t j = node.y - wg_floor(map->target_y) + REACH - 1;
    return 0 <= i && i < 2 * REACH && 0 <= j && j < 2 * REACH ? j * 2 * REACH + i : -1;
}

// Returns true if a node is next to the target, and the path between them isn't known to be
// blocked.
static bool has_door(const WgMapperMemory *map, WgNode node)
{
    int64_t number = door_of(map, node);
    return number >= 0 && (((int64_t)map->doors >> number) & 1) == 0;
}

void wg_map_block_door(WgMapperMemory *map, WgNode node)
{
    int64_t number = door_of(map, node);
    map->doors = (double)((int64_t)map->doors | ((int64_t)1 << (number > 0 ? number : 0)));
    map->plan_length = 0.0;
}

int64_t wg_map_words(const WgMapperMemory *map)
{
    return (side_of(map) * side_of(map) + NODES_A_WORD - 1) / NODES_A_WORD;
}

void wg_map_forget(WgMapperMemory *map)
{
    int64_t words = wg_map_words(map);
    for (int64_t word = 0; word < words; word++) {
        map->nodes[word] = 0.0;
    }
    map->doors = 0.0;
    map->plan_length = 0.0;
}

// Forgets the nodes of a column or a row.
static void forget_line(WgMapperMemory *map, int64_t place, bool column)
{
    int64_t side = side_of(map);
    for (int64_t k = 0; k < side; k++) {
        WgNode node = {column ? place : k, column ? k : place};
        for (int64_t move = 0; move < 4; move++) {
            Bit bit = bit_of(map, node, move);
            *bit.word = (double)((int64_t)*bit.word & ~((int64_t)1 << bit.shift));
        }
    }
}

// Moves the window along an axis until a place has a quarter of it on each side.
static void move_along(WgMapperMemory *map, double *low, int64_t place, bool columns)
{
    int64_t side = side_of(map);
    int64_t before = (int64_t)*low;
    int64_t after = before;
    if (place < before + side / 4) {
        after = place - side / 4;
    } else if (place > before + side - 1 - side / 4) {
        after = place - side + 1 + side / 4;
    }
    if (after != before) {
        int64_t first = wg_least(before, after);
        // A window that moves further than its own side forgets every line once.
        int64_t last = first + wg_least(wg_abs(after - before), side);
        for (int64_t line = first; line < last; line++) {
            forget_line(map, line, columns);
        }
        *low = (double)after;
        map->plan_length = 0.0;
    }
}

void wg_map_move_window(WgMapperMemory *map, WgNode node)
{
    move_along(map, &map->window_x, node.x, true);
    move_along(map, &map->window_y, node.y, false);
}

int64_t wg_map_next_move(WgMapperMemory *map)
{
    int64_t at = (int64_t)map->plan_at;
    if (at >= (int64_t)map->plan_length) {
        return -1;
    }
    map->plan_at += 1.0;
    return ((int64_t)map->plan[at / MOVES_A_WORD] >> (3 * (at % MOVES_A_WORD))) & 7;
}

// Adds an item to the heap.
static void push(Search *search, int64_t item)
{
    if (search->count >= search->room) {
        return;  // each node is entered from its eight neighbours, so there is room
    }
    int64_t at = search->count;
    while (at > 0 && search->heap[(at - 1) / 2] > item) {
        search->heap[at] = search->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    search->heap[at] = item;
    search->count++;
}

// Removes the smallest item from the heap.
static int64_t pop(Search *search)
{
    int64_t *heap = search->heap;
    int64_t least = heap[0];
    int64_t count = --search->count;
    int64_t item = heap[count];
    int64_t at = 0;
    while (2 * at + 1 < count) {
        int64_t child = 2 * at + 1;
        if (child + 1 < count && heap[child + 1] < heap[child]) {
            child++;
        }
        if (heap[child] >= item) {
            break;
        }
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = item;
    return least;
}

// Returns a lower bound of the cost from a node to the target.
static int64_t at_least(const WgMapperMemory *map, WgNode node)
{
    double dx = fabs((double)node.x - map->target_x);
    double dy = fabs((double)node.y - map->target_y);
    return wg_floor((double)STRAIGHT * wg_higher(dx, dy) + (double)(DIAGONAL - STRAIGHT) * wg_lower(dx, dy));
}

// Searches from a node by A*; returns the number of the window's node where the plan ends,
// -1 if there is no path.
//
// A plan ends next to the target. It may also end at the edge of the window; that costs the
// remaining distance plus a charge that makes it the last resort.
static int64_t find(WgMapperMemory *map, WgNode start, Search *search)
{
    int64_t side = side_of(map);
    int64_t low_x = (int64_t)map->window_x;
    int64_t low_y = (int64_t)map->window_y;
    int64_t first = (start.y - low_y) * side + start.x - low_x;
    search->cost[first] = 0;
    push(search, at_least(map, start) << 32 | first);
    int64_t out = -1;
    int64_t out_cost = UNKNOWN;
    while (search->count > 0) {
        int64_t item = pop(search);
        int64_t number = item & 0xFFFFFFFF;
        int64_t bound = item >> 32;
        if (bound >= out_cost) {
            return out;
        }
        WgNode node = {low_x + number % side, low_y + number / side};
        if (bound > search->cost[number] + at_least(map, node)) {
            continue;  // a better path to this node was found since
        }
        if (has_door(map, node)) {
            return number;
        }

        // The border of the window is a last resort, because nothing is known beyond it.
        int64_t column = number % side;
        int64_t row = number / side;
        if ((column == 0 || column == side - 1 || row == 0 || row == side - 1) && number != first) {
            if (bound + 2 * DIAGONAL * side < out_cost) {
                out = number;
                out_cost = bound + 2 * DIAGONAL * side;
            }
            continue;
        }
        for (int64_t move = 0; move < 8; move++) {
            if (is_blocked(map, node, move)) {
                continue;
            }
            WgNode to = wg_neighbour(node, move);
            int64_t there = (to.y - low_y) * side + to.x - low_x;
            int32_t cost = search->cost[number] + (move % 2 != 0 ? DIAGONAL : STRAIGHT);
            if (cost < search->cost[there]) {
                search->cost[there] = cost;
                search->move[there] = (int8_t)move;
                push(search, (cost + at_least(map, to)) << 32 | there);
            }
        }
    }
    return out;
}

// Packs the moves that lead to a node into the memory; moves beyond MOST_MOVES are dropped.
static void keep_plan(WgMapperMemory *map, Search *search, int64_t last)
{
    // Go backwards; the heap is unused by now and holds the moves.
    int64_t side = side_of(map);
    int64_t count = 0;
    while (search->move[last] >= 0) {
        int64_t move = search->move[last];
        WgNode step = wg_neighbour((WgNode){0, 0}, move);
        search->heap[count++] = move;
        last -= step.y * side + step.x;
    }
    int64_t kept = count < MOST_MOVES ? count : MOST_MOVES;
    for (int64_t k = 0; k < kept; k++) {
        int64_t shift = 3 * (k % MOVES_A_WORD);
        double *word = &map->plan[k / MOVES_A_WORD];
        int64_t before = shift == 0 ? 0 : (int64_t)*word;
        *word = (double)(before | search->heap[count - 1 - k] << shift);
    }
    map->plan_length = (double)kept;
}

WgPlanned wg_map_plan(WgMapperMemory *map, WgNode from)
{
    // A plan is made about every hundred steps, and needs up to 77 bytes per node,
    // too much to keep for each robot.
    int64_t nodes = side_of(map) * side_of(map);
    Search search = {.room = 8 * nodes + 1};
    search.heap = malloc((size_t)search.room * sizeof *search.heap);
    search.cost = malloc((size_t)nodes * sizeof *search.cost);
    search.move = malloc((size_t)nodes * sizeof *search.move);
    WgPlanned result = WG_NO_MEMORY;
    if (search.heap != NULL && search.cost != NULL && search.move != NULL) {
        for (int64_t node = 0; node < nodes; node++) {
            search.cost[node] = INT32_MAX;
            search.move[node] = -1;
        }
        int64_t last = find(map, from, &search);
        map->plan_at = 0.0;
        map->plan_length = 0.0;
        if (last >= 0) {
            keep_plan(map, &search, last);
        }
        result = last >= 0 ? WG_PLANNED : WG_NO_PATH;
    }
    free(search.heap);
    free(search.cost);
    free(search.move);
    return result;
}

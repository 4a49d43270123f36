// Shortest octile paths by jump points with tables ("JPS+"), and landmarks for hard questions.
//
// Harabor and Grastien, "The JPS pathfinding system", SoCS 2012; Rabin and Sturtevant, "Combining bounding boxes and
// JPS to prune grid pathfinding", AAAI 2016.

#include <math.h>
#include <stdlib.h>

#include "grid.h"
#include "wg_making.h"

enum { PLACES_A_CALL = 1 << 20 };

static const double ROOT_TWO = 1.4142135623730951;

static void eighths(int64_t stride, int64_t steps[8])
{
    steps[0] = 1;
    steps[1] = 1 + stride;
    steps[2] = stride;
    steps[3] = stride - 1;
    steps[4] = -1;
    steps[5] = -1 - stride;
    steps[6] = -stride;
    steps[7] = 1 - stride;
}

// Straight on, a path may have to turn where a side becomes free that was not; diagonally, where one of the two
// straight directions leads to such a place.
WgStatus wg_octile_jumps(const uint8_t *free_cells, int64_t size, int64_t stride, int16_t *jumps)
{
    if (!wg_rim_is_closed(free_cells, size, stride) || stride > INT16_MAX || size / stride > INT16_MAX) {
        return WG_BAD_SIZE;
    }
    int64_t steps[8];
    eighths(stride, steps);
    for (int64_t i = 0; i < 8 * size; i++) {
        jumps[i] = 0;
    }
    for (int turn = 0; turn < 8; turn++) {
        // The straight ones first: the diagonal ones look at their tables.
        int direction = turn * 2 % 8 + turn / 4;
        bool is_straight = direction % 2 == 0;
        int64_t ahead = steps[direction];
        int64_t left = steps[(direction + 2) & 7];
        int64_t right = steps[(direction + 6) & 7];
        int64_t one = steps[(direction + 1) & 7];
        int64_t other = steps[(direction + 7) & 7];
        int16_t *table = jumps + direction * size;
        const int16_t *one_table = jumps + ((direction + 1) & 7) * size;
        const int16_t *other_table = jumps + ((direction + 7) & 7) * size;
        for (int64_t count = 0; count < size; count++) {
            // What is ahead comes first.
            int64_t cell = ahead > 0 ? size - 1 - count : count;
            if (free_cells[cell] == 0 || free_cells[cell + ahead] == 0) {
                continue;
            }
            int64_t after = cell + ahead;
            bool turns = false;
            if (is_straight) {
                turns = (free_cells[cell + left] == 0 && free_cells[after + left] != 0) ||
                        (free_cells[cell + right] == 0 && free_cells[after + right] != 0);
            } else {
                if (free_cells[cell + one] == 0 || free_cells[cell + other] == 0) {
                    continue;
                }
                turns = one_table[after] > 0 || other_table[after] > 0;
            }
            int further = table[after];
            int distance = further > 0 ? further + 1 : further - 1;
            table[cell] = (int16_t)(turns ? 1 : distance);
        }
    }
    return WG_OK;
}

// A waiting cell and the least length of a path through it.
typedef struct Waiting {
    double key;
    int64_t cell;
} Waiting;

typedef struct Heap {
    Waiting *items;
    int64_t count;
    int64_t room;
} Heap;

static bool heap_reserve(Heap *heap, int64_t more)
{
    if (heap->count + more <= heap->room) {
        return true;
    }
    int64_t room = 2 * (heap->count + more);
    Waiting *items = realloc(heap->items, (size_t)room * sizeof *items);
    if (items == NULL) {
        return false;
    }
    heap->items = items;
    heap->room = room;
    return true;
}

static void heap_push(Heap *heap, Waiting item)
{
    int64_t at = heap->count;
    heap->count++;
    while (at > 0) {
        int64_t above = (at - 1) / 2;
        if (heap->items[above].key <= item.key) {
            break;
        }
        heap->items[at] = heap->items[above];
        at = above;
    }
    heap->items[at] = item;
}

static void heap_drop_first(Heap *heap)
{
    heap->count--;
    int64_t last = heap->count;
    Waiting item = heap->items[last];
    int64_t at = 0;
    for (;;) {
        int64_t below = 2 * at + 1;
        if (below >= last) {
            break;
        }
        if (below + 1 < last && heap->items[below + 1].key < heap->items[below].key) {
            below++;
        }
        if (item.key <= heap->items[below].key) {
            break;
        }
        heap->items[at] = heap->items[below];
        at = below;
    }
    heap->items[at] = item;
}

// What is known of a cell in one question.
typedef struct Cell {
    int32_t question;  // counted from 1, in which the rest is of use
    int32_t straight;  // moves of the shortest path to it so far
    int32_t diagonal;
    uint8_t asked;  // directions, a bit each, in which it is to be expanded
    uint8_t done;   // and those in which it has been
} Cell;

// The directions, as bits, in which a path that came in one may continue: half a circle, diagonally a quarter.
static int ways_on(int direction)
{
    int ways = 1 << direction | 1 << ((direction + 1) & 7) | 1 << ((direction + 7) & 7);
    if (direction % 2 == 0) {
        ways |= 1 << ((direction + 2) & 7) | 1 << ((direction + 6) & 7);
    }
    return ways;
}

// How many moves to go in a direction: to the goal, to its row or column, or to where to turn; 0 for none.
static int64_t jump_length(int jump, int direction, int64_t across, int64_t up)
{
    static const int toward_x[8] = {1, 1, 0, -1, -1, -1, 0, 1};
    static const int toward_y[8] = {0, 1, 1, 1, 0, -1, -1, -1};
    int64_t x = across * toward_x[direction];
    int64_t y = up * toward_y[direction];
    int64_t distance = 0;
    if (direction % 2 == 1) {
        distance = x < y ? x : y;
    } else if (across * toward_y[direction] == 0 && up * toward_x[direction] == 0) {
        distance = x + y;  // the goal is in line, on this side or the other
    }
    if (distance > 0 && distance <= abs(jump)) {
        return distance;
    }
    return jump > 0 ? jump : 0;
}

// All that one call needs.
typedef struct Search {
    const WgOctile *asked;
    const int16_t *jumps;
    const double *distances;
    int64_t steps[8];
    Cell *cells;
    Heap heap;
} Search;

// A lower bound of the length of a path through a cell.
static double bound_of(const Search *search, int64_t cell, int64_t goal, int64_t straight, int64_t diagonal)
{
    int64_t stride = search->asked->stride;
    int64_t over = llabs(goal % stride - cell % stride);
    int64_t rise = llabs(goal / stride - cell / stride);
    int64_t least = over < rise ? over : rise;
    double key = (double)(straight + llabs(over - rise)) + (double)(diagonal + least) * ROOT_TWO;
    int64_t marks = search->asked->marks;
    for (int64_t mark = 0; mark < marks; mark++) {
        double apart = fabs(search->distances[goal * marks + mark] - search->distances[cell * marks + mark]);
        double further = (double)straight + (double)diagonal * ROOT_TWO + (apart - search->asked->slack);
        key = further > key ? further : key;
    }
    return key;
}

// Expands a cell in some directions. A cell that is reached at equal cost from several directions is later expanded in
// all that these allow.
static void expand(Search *search, int64_t cell, int ways, int64_t goal, int32_t question)
{
    int64_t stride = search->asked->stride;
    int64_t across = goal % stride - cell % stride;
    int64_t up = goal / stride - cell / stride;
    for (int direction = 0; direction < 8; direction++) {
        if ((ways >> direction & 1) == 0) {
            continue;
        }
        int jump = search->jumps[direction * search->asked->size + cell];
        int64_t length = jump_length(jump, direction, across, up);
        if (length == 0) {
            continue;
        }
        int64_t after = cell + length * search->steps[direction];
        const Cell *from = &search->cells[cell];
        Cell *to = &search->cells[after];
        int64_t straight = from->straight + (direction % 2 == 0 ? length : 0);
        int64_t diagonal = from->diagonal + (direction % 2 == 1 ? length : 0);
        int new_ways = ways_on(direction);
        if (to->question == question) {
            double longer = (double)(straight - to->straight) + (double)(diagonal - to->diagonal) * ROOT_TWO;
            if (longer > 0.0 || (longer == 0.0 && (new_ways & ~to->asked) == 0)) {
                continue;
            }
            if (longer == 0.0) {
                new_ways |= to->asked;
            } else {
                to->done = 0;
            }
        } else {
            to->question = question;
            to->done = 0;
        }
        to->asked = (uint8_t)new_ways;
        to->straight = (int32_t)straight;
        to->diagonal = (int32_t)diagonal;
        heap_push(&search->heap, (Waiting){bound_of(search, after, goal, straight, diagonal), after});
    }
}

// A* over jump points. Returns how many places were looked at; -1 without memory, -2 if there is no path.
static int64_t answer(Search *search, int64_t start, int64_t goal, int32_t question)
{
    search->heap.count = 0;
    search->cells[start] = (Cell){question, 0, 0, 255, 0};
    heap_push(&search->heap, (Waiting){0.0, start});
    int64_t looked = 0;
    while (search->heap.count > 0) {
        int64_t at = search->heap.items[0].cell;
        if (at == goal) {
            return looked;
        }
        heap_drop_first(&search->heap);
        looked++;
        if (!heap_reserve(&search->heap, 8)) {
            return -1;
        }
        Cell *cell = &search->cells[at];
        int ways = cell->asked & ~cell->done;
        cell->done |= cell->asked;
        expand(search, at, ways, goal, question);
    }
    return -2;
}

WgStatus wg_octile_search(WgOctile *asked, const int16_t *jumps, const double *distances, const int64_t *starts,
                          const int64_t *goals, int64_t *answers)
{
    if (asked->stride < 1 || asked->size < 1 || asked->size > INT32_MAX || asked->marks < 0 ||
        asked->questions > INT32_MAX - 1 || asked->answered < 0) {
        return WG_BAD_SIZE;
    }
    Search search = {.asked = asked, .jumps = jumps, .distances = distances};
    eighths(asked->stride, search.steps);
    search.cells = calloc((size_t)asked->size, sizeof *search.cells);
    if (search.cells == NULL || !heap_reserve(&search.heap, 1024)) {
        free(search.cells);
        return WG_OUT_OF_MEMORY;
    }
    WgStatus status = WG_OK;
    int64_t most = asked->looked + PLACES_A_CALL;
    while (asked->answered < asked->questions && asked->looked < most) {
        int64_t row = asked->answered;
        int64_t start = starts[row];
        int64_t goal = goals[row];
        if (start < 0 || start >= asked->size || goal < 0 || goal >= asked->size) {
            status = WG_BAD_VALUE;
            break;
        }
        int64_t looked = answer(&search, start, goal, (int32_t)(row + 1));
        if (looked < 0) {
            status = looked == -1 ? WG_OUT_OF_MEMORY : WG_BAD_VALUE;
            break;
        }
        answers[2 * row] = search.cells[goal].straight;
        answers[2 * row + 1] = search.cells[goal].diagonal;
        asked->looked += looked;
        asked->answered++;
    }
    free(search.cells);
    free(search.heap.items);
    return status;
}

// Mazes by choosing edges or chambers: Kruskal's and Prim's algorithms, and the growing tree.
//
// Kruskal's and Prim's algorithms find the tree of least total weight, where each edge of the
// lattice has a random weight of 32 bits. Equal weights, one pair in four billion, are ordered by
// the edge's number. So both find the same tree from the same words,
// but grow it in a different order.
//
// A key is a weight, then the number of an edge, in 63 bits; an edge's number is twice the place of
// its lower or left chamber, and one more if it leads north.

#include "maze.h"

#include <assert.h>
#include <stdbool.h>

enum { EDGES_A_CALL = 1 << 20, CHAMBERS_A_CALL = 1 << 18 };  // some tenths of a second

static const int64_t EDGE = ((int64_t)1 << 31) - 1;  // the edge's number in a key
static const uint64_t LOW_HALF = 0xFFFFFFFF;

static inline int64_t edge_key(const uint64_t *words, int64_t low, int64_t north)
{
    int64_t weight = (int64_t)(words[low] >> (32 * north) & LOW_HALF);
    return weight << 31 | (2 * low + north);
}

WgStatus wg_maze_edge_keys(const WgMaze *maze, const uint64_t *words, const int8_t *board, int64_t places,
                           int64_t *keys, int64_t *returned)
{
    int64_t stride = maze->columns + 2;
    if (wg_maze_work_bytes(maze) < 0 || places != stride * (maze->rows + 2)) {
        return WG_BAD_SIZE;
    }
    int64_t count = 0;
    for (int64_t at = stride + 1; at < places - stride; at++) {
        for (int64_t north = 0; north < 2; north++) {
            int64_t other = at + (north != 0 ? stride : 1);
            if (board[at] == WG_FREE && board[other] == WG_FREE) {
                keys[count++] = edge_key(words, at, north);
            }
        }
    }
    *returned = count;
    return WG_OK;
}

// Takes the edges in order of weight, and keeps those that join separate parts. Joseph B. Kruskal,
// "On the shortest spanning subtree of a graph and the traveling salesman problem", Proceedings of
// the American Mathematical Society, 1956; the sets are M. Rem's, in Edsger W. Dijkstra, "A
// Discipline of Programming", 1976, chapter 23: two searches climb together and splice.
WgStatus wg_maze_kruskal(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    // the sets: each place points to a place of its set with a lower number, or to itself
    int32_t *above = growth->work;
    int64_t edge = maze->edge;
    if (edge == 0) {
        for (int64_t at = 0; at < growth->places; at++) {
            board[at] = 0;
            above[at] = (int32_t)at;
        }
    }
    int64_t most = growth->word_count - edge < EDGES_A_CALL ? growth->word_count : edge + EDGES_A_CALL;
    while (maze->left > 0 && edge < most) {
        int64_t number = (int64_t)growth->words[edge] & EDGE;
        edge++;
        int64_t low = number >> 1;
        int64_t first = low;
        int64_t second = low + ((number & 1) != 0 ? growth->stride : 1);
        if (second >= growth->places) {
            return WG_BAD_VALUE;
        }
        int32_t up = above[first];
        int32_t beside = above[second];
        while (up != beside) {
            if (up < beside) {
                int64_t place = first;
                first = second;
                second = place;
                int32_t higher = up;
                up = beside;
                beside = higher;
            }
            above[first] = beside;
            if (first == up) {
                board[low] = (int8_t)(board[low] + ((number & 1) != 0 ? WG_NORTH : WG_EAST));
                maze->left--;
                break;
            }
            first = up;
            up = above[up];
        }
    }
    maze->edge = edge;
    bool stuck = maze->left > 0 && edge == growth->word_count;
    return stuck ? WG_BAD_VALUE : WG_OK;
}

// Pushes a key onto a heap with four children per node.
static void heap_push(int64_t *heap, int64_t size, int64_t key)
{
    int64_t hole = size;
    while (hole > 0 && heap[(hole - 1) >> 2] > key) {
        heap[hole] = heap[(hole - 1) >> 2];
        hole = (hole - 1) >> 2;
    }
    heap[hole] = key;
}

// Replaces the smallest key with another one.
static void heap_replace(int64_t *heap, int64_t size, int64_t key)
{
    int64_t hole = 0;
    while (4 * hole + 1 < size) {
        int64_t child = 4 * hole + 1;
        int64_t end = child + 4 < size ? child + 4 : size;
        for (int64_t other = child + 1; other < end; other++) {
            if (heap[other] < heap[child]) {
                child = other;
            }
        }
        if (heap[child] >= key) {
            break;
        }
        heap[hole] = heap[child];
        hole = child;
    }
    heap[hole] = key;
}

// Grows the maze from one chamber, always by the lightest edge that leads out of it. Robert C.
// Prim, "Shortest connection networks and some generalizations", Bell System Technical Journal,
// 1957; the heap: Donald B. Johnson, "Priority queues with update and finding minimum spanning
// trees", Information Processing Letters, 1975.
WgStatus wg_maze_prim(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    int64_t *heap = growth->work;
    int64_t stride = growth->stride;
    int64_t at = maze->at;
    int64_t size = maze->waiting;
    int64_t stop = maze->left > CHAMBERS_A_CALL ? maze->left - CHAMBERS_A_CALL : 0;
    while (maze->left > stop) {
        // The edges that lead out of the newest chamber are added to the rim.
        for (int64_t direction = 0; direction < 4; direction++) {
            int64_t beyond = at + wg_maze_step(direction, stride);
            if (board[beyond] == WG_FREE) {
                heap_push(heap, size, edge_key(growth->words, direction < 2 ? at : beyond, direction & 1));
                size++;
            }
        }
        // Take the lightest edge that still leads out; drop edges whose ends are both in the maze
        // by now.
        bool grown = false;
        while (!grown) {
            if (size == 0) {
                return WG_BAD_VALUE;
            }
            int64_t number = heap[0] & EDGE;
            size--;
            heap_replace(heap, size, heap[size]);
            int64_t low = number >> 1;
            int64_t north = number & 1;
            int64_t high = low + (north != 0 ? stride : 1);
            if (board[high] == WG_FREE) {
                at = high;
                board[at] = (int8_t)(2 + north);
                grown = true;
            } else if (board[low] == WG_FREE) {
                at = low;
                board[at] = (int8_t)north;
                grown = true;
            }
        }
        maze->left--;
    }
    maze->at = at;
    maze->waiting = size;
    return WG_OK;
}

// Digs from the newest, the oldest or any chamber of a list;
// a chamber without free neighbours is removed.
//
// Each word is one try: 16 bits choose the rule, 16 the neighbour, 32 the entry. A number that
// would bias a choice, and an entry that has left the list, are drawn again with the next word.
//
// Jamis Buck, "Mazes for Programmers", 2015, "The Growing Tree Algorithm".
void wg_maze_growing_tree(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    int32_t *list = growth->work;  // chambers in order of age; -1 where one was removed
    int64_t stride = growth->stride;
    int64_t newest = maze->newest;
    int64_t oldest = maze->newest + maze->oldest;
    int64_t head = maze->head;
    int64_t tail = maze->tail;
    for (int64_t used = 0; used < growth->word_count && maze->left > 0; used++) {
        // Choose the entry of the list.
        uint64_t word = growth->words[used];
        int64_t rule = (int64_t)(word & 0xFFFF);
        int64_t lot = (int64_t)(word >> 16 & 0xFFFF);
        int64_t entry = tail - 1;
        if (maze->again == 0 && newest <= rule && rule < oldest) {
            entry = head;
        } else if (maze->again != 0 || rule >= oldest) {
            assert(tail > head);  // chambers are left, and all are connected
            uint64_t length = (uint64_t)(tail - head);
            uint64_t scaled = (word >> 32) * length;
            entry = head + (int64_t)(scaled >> 32);
            maze->again = 1;
            if ((scaled & LOW_HALF) < ((uint64_t)1 << 32) % length || list[entry] < 0) {
                continue;
            }
        }
        // 12 divides 65532, so the choice among 1, 2, 3 and 4 neighbours is unbiased
        if (lot >= 65532) {
            continue;
        }
        maze->again = 0;

        // Dig to one of its free neighbours.
        int64_t at = list[entry];
        int64_t ways = (board[at + 1] >> 3) + (board[at + stride] >> 3) + (board[at - 1] >> 3) +
                       (board[at - stride] >> 3);
        if (ways > 0) {
            lot = lot % ways;
            int64_t direction = 0;
            int64_t beyond = at + 1;
            while (board[beyond] != WG_FREE || lot > 0) {
                lot -= board[beyond] >> 3;
                direction++;
                beyond = at + wg_maze_step(direction, stride);
            }
            board[beyond] = (int8_t)(direction ^ 2);
            list[tail] = (int32_t)beyond;
            tail++;
            maze->alive++;
            maze->left--;
            continue;
        }

        // It has none, so remove it. The list is compacted often enough
        // that half of all random draws hit an entry.
        list[entry] = -1;
        maze->alive--;
        while (list[tail - 1] < 0) {
            tail--;
        }
        while (list[head] < 0) {
            head++;
        }
        if (2 * maze->alive < tail - head) {
            int64_t kept = head;
            for (int64_t each = head; each < tail; each++) {
                if (list[each] >= 0) {
                    list[kept] = list[each];
                    kept++;
                }
            }
            tail = kept;
        }
    }
    maze->head = head;
    maze->tail = tail;
}

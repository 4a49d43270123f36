// Mazes: setting one up, and choosing the function that grows it.

#include "maze.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CHAMBERS = 1 << 29 };  // a place fits into 31 bits

static bool is_tree_of_parents(WgMazeAlgorithm algorithm)
{
    switch (algorithm) {
    case WG_WILSON:
    case WG_ALDOUS_BRODER:
    case WG_BACKTRACKER:
    case WG_HUNT_AND_KILL:
    case WG_PRIM:
    case WG_GROWING_TREE:
        return true;
    default:
        return false;
    }
}

static int64_t places_of(const WgMaze *maze)
{
    return (maze->columns + 2) * (maze->rows + 2);
}

int64_t wg_maze_work_bytes(const WgMaze *maze)
{
    int64_t columns = maze->columns;
    int64_t rows = maze->rows;
    if (columns < 1 || rows < 1 || columns > MOST_CHAMBERS || rows > MOST_CHAMBERS / columns) {
        return -1;
    }
    switch (maze->algorithm) {
    case WG_WILSON:
    case WG_ALDOUS_BRODER:
    case WG_BACKTRACKER:
    case WG_HUNT_AND_KILL:
    case WG_SIDEWINDER:
    case WG_BINARY_TREE:
        return 0;
    case WG_KRUSKAL:
        return places_of(maze) * (int64_t)sizeof(int32_t);
    case WG_PRIM:
        return 2 * columns * rows * (int64_t)sizeof(int64_t);
    case WG_GROWING_TREE:
        return columns * rows * (int64_t)sizeof(int32_t);
    case WG_ELLER:
        return (2 * columns + 2) * (int64_t)sizeof(int32_t);
    case WG_RECURSIVE_DIVISION: {
        // Each waiting rectangle takes four numbers; the number that wait is at most the number of
        // bits of the maze's size.
        int64_t bits = 0;
        while (columns * rows >> bits != 0) {
            bits++;
        }
        return 4 * (bits + 2) * (int64_t)sizeof(int32_t);
    }
    default:
        return -1;
    }
}

static bool sizes_fit(const WgMaze *maze, int64_t places, int64_t work_bytes)
{
    int64_t needed = wg_maze_work_bytes(maze);
    return needed >= 0 && work_bytes >= needed && places == places_of(maze);
}

// Finds the place of a chamber counted row by row, and the number of chambers; -1 if there are
// fewer.
static int64_t place_of(const WgMaze *maze, const uint8_t *mask, int64_t number, int64_t *chambers)
{
    int64_t found = -1;
    int64_t count = 0;
    for (int64_t row = 0; row < maze->rows; row++) {
        const uint8_t *line = mask + row * maze->columns;
        int64_t in_row = 0;
        for (int64_t column = 0; column < maze->columns; column++) {
            in_row += line[column] != 0;
        }
        if (number >= count && number < count + in_row) {
            int64_t column = -1;
            for (int64_t left = number - count; left >= 0; left -= line[column] != 0) {
                column++;
            }
            found = (row + 1) * (maze->columns + 2) + column + 1;
        }
        count += in_row;
    }
    *chambers = count;
    return found;
}

// Checks that all chambers can be reached from one of them; otherwise an algorithm would never end.
static WgStatus check_connected(int8_t *board, int64_t stride, int64_t root, int64_t chambers)
{
    int32_t *queue = malloc((size_t)chambers * sizeof *queue);
    if (queue == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t tail = 0;
    queue[tail++] = (int32_t)root;
    board[root] = WG_ROOT;
    for (int64_t head = 0; head < tail; head++) {
        for (int64_t direction = 0; direction < 4; direction++) {
            int64_t beyond = queue[head] + wg_maze_step(direction, stride);
            if (board[beyond] == WG_FREE) {
                assert(tail < chambers);
                board[beyond] = WG_ROOT;
                queue[tail++] = (int32_t)beyond;
            }
        }
    }
    for (int64_t i = 0; i < tail; i++) {
        board[queue[i]] = WG_FREE;
    }
    free(queue);
    return tail == chambers ? WG_OK : WG_BAD_VALUE;
}

WgStatus wg_maze_begin(WgMaze *maze, const uint8_t *mask, int64_t number, int8_t *board, int64_t places, void *work,
                       int64_t work_bytes)
{
    if (!sizes_fit(maze, places, work_bytes)) {
        return WG_BAD_SIZE;
    }
    int64_t columns = maze->columns;
    int64_t rows = maze->rows;
    int64_t stride = columns + 2;
    int64_t first = stride + 1;
    int64_t chambers = 0;
    int64_t root = place_of(maze, mask, number, &chambers);
    bool any_shape = is_tree_of_parents(maze->algorithm) || maze->algorithm == WG_KRUSKAL;
    if (root < 0 || (!any_shape && chambers != columns * rows)) {
        return WG_BAD_VALUE;
    }

    // Algorithms that work row by row write links, and never read the ring.
    memset(board, any_shape ? WG_OUTSIDE : 0, (size_t)places);
    for (int64_t row = 0; any_shape && row < rows; row++) {
        int8_t *line = board + (row + 1) * stride + 1;
        for (int64_t column = 0; column < columns; column++) {
            line[column] = mask[row * columns + column] != 0 ? WG_FREE : WG_OUTSIDE;
        }
    }

    if (chambers < columns * rows) {
        WgStatus status = check_connected(board, stride, root, chambers);
        if (status != WG_OK) {
            return status;
        }
    }

    maze->left = chambers - 1;
    maze->at = first;
    maze->first = first;
    maze->lowest = root;
    maze->column = 0;
    maze->edge = 0;
    maze->head = 0;
    maze->tail = 0;
    maze->alive = 0;
    maze->again = 0;
    maze->waiting = 0;
    if (is_tree_of_parents(maze->algorithm)) {
        board[root] = WG_ROOT;
        maze->at = maze->algorithm == WG_WILSON ? first : root;
    }
    int32_t *list = work;
    if (maze->algorithm == WG_GROWING_TREE) {
        list[0] = (int32_t)root;
        maze->tail = 1;
        maze->alive = 1;
    } else if (maze->algorithm == WG_RECURSIVE_DIVISION) {
        list[0] = (int32_t)first;
        list[1] = (int32_t)columns;
        list[2] = (int32_t)rows;
        list[3] = 0;
        maze->waiting = 1;
    }
    return WG_OK;
}

WgStatus wg_maze_grow(WgMaze *maze, const uint64_t *words, int64_t word_count, int8_t *board, int64_t places,
                      void *work, int64_t work_bytes)
{
    if (!sizes_fit(maze, places, work_bytes)) {
        return WG_BAD_SIZE;
    }
    if (maze->left <= 0) {
        return WG_OK;
    }
    Growth growth = {maze, words, word_count, board, maze->columns + 2, places, work};
    switch (maze->algorithm) {
    case WG_WILSON:
        wg_maze_wilson(&growth);
        return WG_OK;
    case WG_ALDOUS_BRODER:
        wg_maze_aldous_broder(&growth);
        return WG_OK;
    case WG_BACKTRACKER:
        wg_maze_backtracker(&growth);
        return WG_OK;
    case WG_HUNT_AND_KILL:
        wg_maze_hunt_and_kill(&growth);
        return WG_OK;
    case WG_KRUSKAL:
        return wg_maze_kruskal(&growth);
    case WG_PRIM:
        if (word_count < places) {
            return WG_BAD_SIZE;
        }
        return wg_maze_prim(&growth);
    case WG_GROWING_TREE:
        wg_maze_growing_tree(&growth);
        return WG_OK;
    case WG_ELLER:
        if (word_count < maze->rows * ((maze->columns + 31) / 32)) {
            return WG_BAD_SIZE;
        }
        wg_maze_eller(&growth);
        return WG_OK;
    case WG_SIDEWINDER:
        wg_maze_sidewinder(&growth);
        return WG_OK;
    case WG_BINARY_TREE:
        if (word_count < maze->rows * ((maze->columns + 63) / 64)) {
            return WG_BAD_SIZE;
        }
        wg_maze_binary_tree(&growth);
        return WG_OK;
    case WG_RECURSIVE_DIVISION:
        wg_maze_recursive_division(&growth);
        return WG_OK;
    default:
        return WG_BAD_VALUE;
    }
}

// Mazes of whole rectangles: Eller's algorithm, sidewinder, binary tree, recursive division.
//
// They go through the rows in order without looking at neighbours above, or split rectangles, so no
// chamber may be missing. Each writes links directly onto the board.

#include "maze.h"

#include <stdbool.h>

// Joins neighbours in a row at random unless they are already joined, then goes up at least once
// from each set.
//
// Two bits per chamber: whether to join it to the next, and whether to go up. The sets of a row
// never cross, so each is a ring in column order, and the next column is in the same set if it
// comes next in the ring.
//
// Marlin Eller's algorithm of 1982, as described in Jamis Buck, "Mazes for Programmers", 2015; the
// rings are John Tromp's, in Don Libes, "Obfuscated C and Other Mysteries", 1993.
void wg_maze_eller(Growth *growth)
{
    int8_t *board = growth->board;
    int64_t stride = growth->stride;
    int64_t columns = growth->maze->columns;
    int64_t rows = growth->maze->rows;
    int32_t *next = growth->work;            // the next chamber of each in its ring
    int32_t *previous = next + columns + 1;  // and the previous one
    // The last entry isn't a chamber; it is only overwritten with its own value.
    for (int64_t column = 0; column <= columns; column++) {
        next[column] = (int32_t)column;
        previous[column] = (int32_t)column;
    }
    int64_t words_a_row = (columns + 31) >> 5;
    for (int64_t row = 0; row < rows - 1; row++) {
        int64_t base = (row + 1) * stride + 1;
        const uint64_t *words = growth->words + row * words_a_row;
        for (int32_t column = 0; column < columns; column++) {
            int64_t bits = (int64_t)(words[column >> 5] >> (2 * (column & 31))) & 3;
            int32_t beside = column + 1;

            // Join it to the next. All four are written either way, because a branch on a random
            // bit is mispredicted half the time; measured 1.8 times as fast.
            int32_t after = next[column];
            int32_t far = previous[beside];
            bool joined = (bits & 1) != 0 && after != beside && beside != columns;
            next[far] = joined ? after : beside;
            previous[after] = joined ? far : column;
            next[column] = joined ? beside : after;
            previous[beside] = joined ? column : far;

            // Go up, or leave the ring, in which case the chamber above is alone.
            after = next[column];
            int32_t before = previous[column];
            bool up = before == column || bits >> 1 != 0;
            next[before] = up ? column : after;
            previous[after] = up ? column : before;
            next[column] = up ? after : column;
            previous[column] = up ? before : column;
            board[base + column] = (int8_t)((joined ? WG_EAST : 0) + (up ? WG_NORTH : 0));
        }
    }

    // In the last row, everything that isn't joined yet is joined.
    int64_t base = rows * stride + 1;
    for (int32_t column = 0; column < columns - 1; column++) {
        int32_t beside = column + 1;
        int32_t after = next[column];
        int32_t far = previous[beside];
        board[base + column] = 0;
        if (after != beside) {
            next[far] = after;
            previous[after] = far;
            next[column] = beside;
            previous[beside] = column;
            board[base + column] = WG_EAST;
        }
    }
    growth->maze->left = 0;
}

// Cuts each row into runs and opens one chamber of each run upwards; the last row is one run.
//
// Each word is one run: after each chamber a bit decides whether the run ends, and the upper half
// chooses where it goes up, unbiased to one part in ten million. A run of 32 chambers always ends.
//
// Jamis Buck, "Mazes for Programmers", 2015, chapter 1.
void wg_maze_sidewinder(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    int64_t columns = maze->columns;
    int64_t base = maze->at;
    int64_t column = maze->column;
    int64_t last_row = growth->places - 2 * growth->stride + 1;
    for (int64_t used = 0; used < growth->word_count && base < last_row; used++) {
        uint64_t word = growth->words[used];
        int64_t begin = column;
        int64_t end = column;
        while (end + 1 < columns && end < begin + 31 && (word >> (end - begin) & 1) == 0) {
            board[base + end] = WG_EAST;
            end++;
        }
        board[base + end] = 0;
        int64_t chosen = (int64_t)((word >> 32) * (uint64_t)(end + 1 - begin) >> 32);
        board[base + begin + chosen] = (int8_t)(board[base + begin + chosen] + WG_NORTH);
        column = end + 1;
        if (column == columns) {
            base += growth->stride;
            column = 0;
        }
    }
    maze->at = base;
    maze->column = column;
    if (base >= last_row) {
        for (column = 0; column < columns; column++) {
            board[last_row + column] = column + 1 < columns ? WG_EAST : 0;
        }
        maze->left = 0;
    }
}

// Opens each chamber to the east or upwards with equal probability; one bit per chamber. Jamis
// Buck, "Mazes for Programmers", 2015, chapter 1.
void wg_maze_binary_tree(Growth *growth)
{
    int8_t *board = growth->board;
    int64_t columns = growth->maze->columns;
    int64_t rows = growth->maze->rows;
    int64_t words_a_row = (columns + 63) >> 6;
    for (int64_t row = 0; row < rows; row++) {
        int64_t base = (row + 1) * growth->stride + 1;
        bool is_last = row == rows - 1;
        for (int64_t column = 0; column < columns; column++) {
            uint64_t word = is_last ? 0 : growth->words[row * words_a_row + (column >> 6)];
            board[base + column] = (int8_t)(WG_EAST + (int)(word >> (column & 63) & 1));
        }
        board[base + columns - 1] = is_last ? 0 : WG_NORTH;
    }
    growth->maze->left = 0;
}

typedef struct Rectangle {
    int32_t base;  // place of its first chamber
    int32_t columns;
    int32_t rows;
    int32_t unused;
} Rectangle;

// Cuts a rectangle in two by a wall with one door, across its longer side, and then each part in
// the same way.
//
// A rectangle one chamber wide is a corridor. Each word is one cut: a bit for the side, if the
// sides are equal, 31 bits for the wall, 32 for the door; numbers that would bias a choice are
// drawn again. The smaller part goes first, so the number of waiting rectangles is at most the
// number of bits of the maze's size.
//
// Jamis Buck, "Mazes for Programmers", 2015, "Recursive Division".
void wg_maze_recursive_division(Growth *growth)
{
    WgMaze *maze = growth->maze;
    int8_t *board = growth->board;
    Rectangle *stack = growth->work;
    int32_t stride = (int32_t)growth->stride;
    int64_t used = 0;
    while (maze->waiting > 0) {
        Rectangle *top = &stack[maze->waiting - 1];
        Rectangle cut = *top;
        if (cut.columns == 1 || cut.rows == 1) {
            int8_t along = cut.columns == 1 ? WG_NORTH : WG_EAST;
            int32_t step = cut.columns == 1 ? stride : 1;
            for (int32_t number = 0; number < cut.columns * cut.rows - 1; number++) {
                board[cut.base + number * step] = (int8_t)(board[cut.base + number * step] | along);
            }
            maze->waiting--;
            continue;
        }
        if (used == growth->word_count) {
            break;
        }

        // Place the wall and its door.
        uint64_t word = growth->words[used];
        used++;
        bool upright = cut.columns > cut.rows || (cut.columns == cut.rows && (word & 1) == 1);
        int32_t length = upright ? cut.columns : cut.rows;
        uint64_t wall_places = (uint64_t)(length - 1);
        uint64_t door_places = (uint64_t)(upright ? cut.rows : cut.columns);
        uint64_t wall = (word >> 1 & 0x7FFFFFFF) * wall_places;
        uint64_t door = (word >> 32) * door_places;
        if ((wall & 0x7FFFFFFF) < ((uint64_t)1 << 31) % wall_places ||
            (door & 0xFFFFFFFF) < ((uint64_t)1 << 32) % door_places) {
            continue;
        }
        int32_t first = (int32_t)(wall >> 31) + 1;  // chambers on this side of the wall
        int32_t door_at = (int32_t)(door >> 32);
        int32_t across = upright ? 1 : stride;
        int32_t along = upright ? stride : 1;
        board[cut.base + (first - 1) * across + door_at * along] |= upright ? WG_EAST : WG_NORTH;

        // The larger part waits below the smaller one.
        int32_t rest = length - first;
        Rectangle near_part = {cut.base, upright ? first : cut.columns, upright ? cut.rows : first, 0};
        Rectangle far_part = {cut.base + first * across, upright ? rest : cut.columns, upright ? cut.rows : rest, 0};
        bool near_waits = first >= rest;
        top[0] = near_waits ? near_part : far_part;
        top[1] = near_waits ? far_part : near_part;
        maze->waiting++;
    }
    if (maze->waiting == 0) {
        maze->left = 0;
    }
}

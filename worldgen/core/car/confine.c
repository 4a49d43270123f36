// Finds where a car that never reverses can get: a set of boxes of poses that it cannot leave.
//
// Boxes of a heading are bits, those of a row in the same words. Most steps end in boxes that were reached before, and
// a few words show that.

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "reach_internal.h"
#include "wg_car.h"

typedef struct Flood {
    WgCarFlood *asked;
    int64_t words;       // of a row
    double *gaps;        // (rows, columns) squares of distances from walls, cells
    uint64_t *room;      // (rows, words) places where the disc about the axle may be
    uint64_t *near;      // (rows, words) those of them from which the car may arrive
    uint64_t *is_free;   // (headings or 1, rows, words) boxes where the body may be
    uint64_t *reached;   // (headings, rows, words)
    int64_t *waiting;    // (count,) boxes whose successors have not been reached yet
    int64_t count;
    int64_t capacity;
    int64_t row;         // of the box whose steps are tried
    int64_t column;
    bool escapes;
    bool has_no_memory;
} Flood;

// A rectangle of boxes; empty if a side is negative.
typedef struct Rectangle {
    int64_t left;
    int64_t right;
    int64_t low;
    int64_t high;
} Rectangle;

static Rectangle around_box(const Flood *flood, const int32_t *place)
{
    return (Rectangle){
        wg_max(flood->column + place[0], 0),
        wg_min(flood->column + place[1], flood->asked->columns - 1),
        wg_max(flood->row + place[2], 0),
        wg_min(flood->row + place[3], flood->asked->rows - 1),
    };
}

// The bits from left to right in a word of a row.
static uint64_t mask_of(int64_t word, int64_t left, int64_t right)
{
    uint64_t mask = ~(uint64_t)0;
    if (word == left >> 6) {
        mask &= ~(uint64_t)0 << (left & 63);
    }
    if (word == right >> 6) {
        mask &= ~(uint64_t)0 >> (63 - (right & 63));
    }
    return mask;
}

static bool has_any(const Flood *flood, const uint64_t *bits, Rectangle among)
{
    if (among.left > among.right) {
        return false;
    }
    for (int64_t row = among.low; row <= among.high; row++) {
        for (int64_t word = among.left >> 6; word <= among.right >> 6; word++) {
            if ((bits[row * flood->words + word] & mask_of(word, among.left, among.right)) != 0) {
                return true;
            }
        }
    }
    return false;
}

static void push(Flood *flood, int64_t box)
{
    if (flood->count == flood->capacity) {
        int64_t capacity = 2 * flood->capacity + 4096;
        int64_t *waiting = realloc(flood->waiting, (size_t)capacity * sizeof *waiting);
        if (waiting == NULL) {
            flood->has_no_memory = true;
            return;
        }
        flood->waiting = waiting;
        flood->capacity = capacity;
    }
    flood->waiting[flood->count++] = box;
}

static int64_t lowest_bit(uint64_t bits)
{
    return __builtin_ctzll(bits);
}

// Adds the boxes of a rectangle in which the body may be, or only tells whether there are any.
static bool reach(Flood *flood, int64_t heading, Rectangle among, bool adds)
{
    const WgCarFlood *asked = flood->asked;
    int64_t layer = asked->rows * flood->words;
    const uint64_t *is_free = flood->is_free + (asked->discs > 1 ? heading * layer : 0);
    uint64_t *reached = flood->reached + heading * layer;
    int64_t last = among.left > among.right ? -1 : among.right >> 6;
    for (int64_t row = among.low; row <= among.high; row++) {
        for (int64_t word = among.left >> 6; word <= last; word++) {
            int64_t at = row * flood->words + word;
            uint64_t fresh = is_free[at] & mask_of(word, among.left, among.right) & ~reached[at];
            if (!adds && fresh != 0) {
                return true;
            }
            reached[at] |= fresh;
            for (; fresh != 0; fresh &= fresh - 1) {
                int64_t column = word * 64 + lowest_bit(fresh);
                push(flood, (heading * asked->rows + row) * asked->columns + column);
            }
        }
    }
    return false;
}

// Returns true if the middle of a box is no farther from the target than ``reach``.
static bool is_near(const WgCarFlood *asked, int64_t column, int64_t row, double reach)
{
    double dx = ((double)column + 0.5) * asked->side - asked->target_x;
    double dy = ((double)row + 0.5) * asked->side - asked->target_y;
    return dx * dx + dy * dy <= reach * reach;
}

// Takes all steps from a box.
static void reach_from(Flood *flood, int64_t box)
{
    WgCarFlood *asked = flood->asked;
    flood->column = box % asked->columns;
    flood->row = box / asked->columns % asked->rows;
    int64_t heading = box / asked->columns / asked->rows;
    double reach_of_step = asked->target_reach + asked->step;
    bool may_pass_target = is_near(asked, flood->column, flood->row, reach_of_step);
    int64_t turns = 2 * asked->most_turn + 1;
    asked->tried += turns;
    for (int64_t turn = 0; turn < turns; turn++) {
        const int32_t *places = asked->steps + (heading * turns + turn) * asked->parts * 4;
        const uint8_t *may_arrive = asked->may_arrive + (heading * turns + turn) * asked->parts;
        Rectangle end = around_box(flood, places + 4 * (asked->parts - 1));
        int64_t next = (heading + turn - asked->most_turn + asked->headings) % asked->headings;
        // Four of five steps lead nowhere new.
        if (!may_pass_target && !reach(flood, next, end, false)) {
            continue;
        }
        bool passes = true;
        for (int64_t part = 0; part < asked->parts && passes; part++) {
            Rectangle place = around_box(flood, places + 4 * part);
            passes = has_any(flood, flood->room, place);
            if (passes && may_arrive[part] != 0 && has_any(flood, flood->near, place)) {
                flood->escapes = true;
                return;
            }
        }
        if (passes) {
            reach(flood, next, end, true);
        }
    }
}

// For each cell, the nearest solid ones in its row: (height, width, 2) left and right of it, or itself.
static int32_t *nearest_in_rows(const WgWalls *walls)
{
    int32_t *nearest = malloc((size_t)(2 * walls->height * walls->width) * sizeof *nearest);
    for (int64_t iy = 0; nearest != NULL && iy < walls->height; iy++) {
        const uint8_t *row = walls->solid + iy * walls->width;
        int32_t *found = nearest + 2 * iy * walls->width;
        int32_t last = -1;
        for (int64_t ix = 0; ix < walls->width; ix++) {
            last = row[ix] != 0 ? (int32_t)ix : last;
            found[2 * ix] = last;
        }
        last = (int32_t)walls->width;
        for (int64_t ix = walls->width - 1; ix >= 0; ix--) {
            last = row[ix] != 0 ? (int32_t)ix : last;
            found[2 * ix + 1] = last;
        }
    }
    return nearest;
}

// The lower envelope of parabolas in a column: each is lowest from a begin to the next one's.
typedef struct Envelope {
    double *weights;  // (height + 1,) of the parabola whose lowest point is between two rows of cells
    double *begins;
    int64_t *lowest;
    int64_t count;
} Envelope;

// Where a parabola gets lower than one before it.
static double crossing(const Envelope *envelope, int64_t before, int64_t after)
{
    double one = envelope->weights[before] + (double)(before * before);
    double other = envelope->weights[after] + (double)(after * after);
    return (other - one) / (2.0 * (double)(after - before));
}

// Pedro Felzenszwalb and Daniel Huttenlocher, "Distance Transforms of Sampled Functions" (2012), algorithm 1.
static void find_envelope(Envelope *envelope, int64_t count)
{
    envelope->count = 0;
    for (int64_t next = 0; next < count; next++) {
        double begin = -INFINITY;
        while (envelope->count > 0) {
            begin = crossing(envelope, envelope->lowest[envelope->count - 1], next);
            if (begin > envelope->begins[envelope->count - 1]) {
                break;
            }
            envelope->count--;
        }
        envelope->begins[envelope->count] = envelope->count > 0 ? begin : -INFINITY;
        envelope->lowest[envelope->count++] = next;
    }
}

// Squares of how far a place is, along its row, from the solid cells in a row of cells, or from outside.
static double across_sq(const WgWalls *walls, const int32_t *nearest, int64_t iy, double x)
{
    const int32_t *found = nearest + 2 * (iy * walls->width + wg_min(walls->width - 1, (int64_t)x));
    double dx = fmax(0.0, fmin(x - (double)found[0] - 1.0, (double)found[1] - x));
    return dx * dx;
}

// Writes (rows, columns) squares of the distances of places from the nearest solid cell, or from outside.
static void measure_gaps(const WgCarFlood *asked, const WgWalls *walls, const int32_t *nearest, Envelope *envelope,
                         double *gaps)
{
    for (int64_t column = 0; column < asked->columns; column++) {
        double x = ((double)column + 0.5) * asked->side;
        // A row of cells is the nearer of its two borders away, or it holds the place.
        envelope->weights[0] = 0.0;
        envelope->weights[walls->height] = 0.0;
        double below = INFINITY;
        for (int64_t iy = 0; iy < walls->height; iy++) {
            double here = across_sq(walls, nearest, iy, x);
            if (iy > 0) {
                envelope->weights[iy] = fmin(below, here);
            }
            below = here;
        }
        find_envelope(envelope, walls->height + 1);
        int64_t at = 0;
        for (int64_t row = 0; row < asked->rows; row++) {
            double y = ((double)row + 0.5) * asked->side;
            int64_t iy = wg_min(walls->height - 1, (int64_t)y);
            while (at + 1 < envelope->count && envelope->begins[at + 1] <= y) {
                at++;
            }
            double dy = y - (double)envelope->lowest[at];
            double gap = fmin(dy * dy + envelope->weights[envelope->lowest[at]], across_sq(walls, nearest, iy, x));
            bool is_outside = x >= (double)walls->width || y >= (double)walls->height;
            gaps[row * asked->columns + column] = is_outside ? 0.0 : gap;
        }
    }
}

// Marks the places that are not too near to a wall: (rows, words).
static void mark_room(const Flood *flood, double reach, uint64_t *room)
{
    const WgCarFlood *asked = flood->asked;
    memset(room, 0, (size_t)(asked->rows * flood->words) * sizeof *room);
    for (int64_t row = 0; row < asked->rows; row++) {
        for (int64_t column = 0; column < asked->columns; column++) {
            if (reach <= 0.0 || flood->gaps[row * asked->columns + column] >= reach * reach) {
                room[row * flood->words + (column >> 6)] |= (uint64_t)1 << (column & 63);
            }
        }
    }
}

// Keeps those boxes of a heading from which a disc ahead of the axle has room.
static void keep_where(const Flood *flood, const uint64_t *room, int64_t right, int64_t up, uint64_t *kept)
{
    int64_t rows = flood->asked->rows;
    int64_t words = flood->words;
    int64_t skip = right >> 6;
    int64_t bits = right & 63;
    for (int64_t row = 0; row < rows; row++) {
        bool is_inside = row + up >= 0 && row + up < rows;
        for (int64_t word = 0; word < words; word++) {
            uint64_t found = 0;
            for (int64_t part = 0; is_inside && part < (bits != 0 ? 2 : 1); part++) {
                int64_t from = word + skip + part;
                if (from >= 0 && from < words) {
                    uint64_t there = room[(row + up) * words + from];
                    found |= part == 0 ? there >> bits : there << (64 - bits);
                }
            }
            kept[row * words + word] &= found;
        }
    }
}

// Measures how far all places are from walls; returns false if memory runs out.
static bool find_gaps(Flood *flood, const WgWalls *walls)
{
    const WgCarFlood *asked = flood->asked;
    size_t borders = (size_t)walls->height + 1;
    int32_t *nearest = nearest_in_rows(walls);
    Envelope envelope = {
        malloc(borders * sizeof *envelope.weights),
        malloc(borders * sizeof *envelope.begins),
        malloc(borders * sizeof *envelope.lowest),
        0,
    };
    flood->gaps = malloc((size_t)(asked->rows * asked->columns) * sizeof *flood->gaps);
    bool fits = nearest != NULL && flood->gaps != NULL && envelope.weights != NULL && envelope.begins != NULL &&
                envelope.lowest != NULL;
    if (fits) {
        measure_gaps(asked, walls, nearest, &envelope, flood->gaps);
    }
    free(nearest);
    free(envelope.weights);
    free(envelope.begins);
    free(envelope.lowest);
    return fits;
}

// Marks where the axle's disc, and the whole body, may be, and from where the car may arrive.
static bool mark_places(Flood *flood, const WgWalls *walls)
{
    const WgCarFlood *asked = flood->asked;
    int64_t layer = asked->rows * flood->words;
    uint64_t *room = malloc((size_t)layer * sizeof *room);
    if (room == NULL || !find_gaps(flood, walls)) {
        free(room);
        return false;
    }
    mark_room(flood, asked->reaches[0], flood->room);
    for (int64_t heading = 0; heading < (asked->discs > 1 ? asked->headings : 1); heading++) {
        memcpy(flood->is_free + heading * layer, flood->room, (size_t)layer * sizeof *room);
    }
    for (int64_t disc = 1; disc < asked->discs; disc++) {
        mark_room(flood, asked->reaches[disc], room);
        for (int64_t heading = 0; heading < asked->headings; heading++) {
            const int32_t *shift = asked->shifts + 2 * (heading * asked->discs + disc);
            keep_where(flood, room, shift[0], shift[1], flood->is_free + heading * layer);
        }
    }
    for (int64_t row = 0; row < asked->rows; row++) {
        for (int64_t column = 0; column < asked->columns; column++) {
            if (is_near(asked, column, row, asked->target_reach)) {
                int64_t at = row * flood->words + (column >> 6);
                flood->near[at] |= flood->room[at] & (uint64_t)1 << (column & 63);
            }
        }
    }
    free(room);
    return true;
}

// Writes runs of boxes if there is room for them; returns their number.
static int64_t list_runs(const Flood *flood, int64_t *runs)
{
    const WgCarFlood *asked = flood->asked;
    int64_t count = 0;
    for (int64_t row = 0; row < asked->headings * asked->rows; row++) {
        const uint64_t *bits = flood->reached + row * flood->words;
        int64_t column = 0;
        while (column < asked->columns) {
            uint64_t left = bits[column >> 6] >> (column & 63);
            if (left == 0) {
                column = (column / 64 + 1) * 64;
                continue;
            }
            column += lowest_bit(left);
            int64_t first = column;
            while (column < asked->columns && (bits[column >> 6] >> (column & 63) & 1) != 0) {
                column++;
            }
            if (runs != NULL) {
                int64_t *run = runs + 4 * count;
                run[0] = row / asked->rows;
                run[1] = row % asked->rows;
                run[2] = first;
                run[3] = column - 1;
            }
            count++;
        }
    }
    return count;
}

// Floods from the boxes of the start; returns false if memory runs out.
static bool fill(Flood *flood)
{
    WgCarFlood *asked = flood->asked;
    for (int64_t number = 0; number < asked->starts; number++) {
        const int64_t *box = asked->start + 3 * number;
        Rectangle place = {box[2], box[2], box[1], box[1]};
        flood->escapes = flood->escapes || (asked->start_arrives != 0 && has_any(flood, flood->near, place));
        reach(flood, box[0], place, true);
    }
    while (flood->count > 0 && !flood->escapes && !flood->has_no_memory && asked->tried < asked->most) {
        reach_from(flood, flood->waiting[--flood->count]);
    }
    asked->outcome = flood->escapes ? WG_CAR_ESCAPES : flood->count > 0 ? WG_CAR_UNKNOWN : WG_CAR_CONFINED;
    if (asked->outcome == WG_CAR_CONFINED && !flood->has_no_memory) {
        asked->count = list_runs(flood, NULL);
        asked->runs = malloc((size_t)wg_max(1, 4 * asked->count) * sizeof *asked->runs);
        flood->has_no_memory = asked->runs == NULL;
        if (asked->runs != NULL) {
            list_runs(flood, asked->runs);
        }
    }
    return !flood->has_no_memory;
}

WgStatus wg_car_flood(const WgWalls *walls, WgCarFlood *asked)
{
    asked->tried = 0;
    asked->count = 0;
    asked->runs = NULL;
    if (walls->height <= 0 || walls->width <= 0 || asked->columns <= 0 || asked->rows <= 0 || asked->discs <= 0 ||
        asked->headings <= 0 || asked->most_turn <= 0 || asked->most_turn >= asked->headings || asked->parts <= 0 || !(asked->side > 0.0)) {
        return WG_BAD_VALUE;
    }
    Flood flood = {.asked = asked};
    flood.words = (asked->columns + 63) / 64;
    size_t layer = (size_t)(asked->rows * flood.words);
    flood.room = calloc(layer, sizeof(uint64_t));
    flood.near = calloc(layer, sizeof(uint64_t));
    flood.is_free = calloc(layer * (size_t)(asked->discs > 1 ? asked->headings : 1), sizeof(uint64_t));
    flood.reached = calloc(layer * (size_t)asked->headings, sizeof(uint64_t));
    bool fits = flood.room != NULL && flood.near != NULL && flood.is_free != NULL && flood.reached != NULL;
    fits = fits && mark_places(&flood, walls) && fill(&flood);
    free(flood.gaps);
    free(flood.room);
    free(flood.near);
    free(flood.is_free);
    free(flood.reached);
    free(flood.waiting);
    return fits ? WG_OK : WG_OUT_OF_MEMORY;
}

void wg_car_flood_free(WgCarFlood *asked)
{
    free(asked->runs);
    asked->runs = NULL;
    asked->count = 0;
}

// Open ground: where windows are free, which places are connected, how far apart they are, and what
// must be dug between them.

#include <stdlib.h>
#include <string.h>

#include "grid.h"
#include "wg_making.h"

WgStatus wg_free_windows(const uint8_t *walls, int64_t rows, int64_t columns, int64_t width, int64_t height,
                         uint8_t *windows)
{
    if (rows < 0 || columns < 0 || width < 1 || height < 1) {
        return WG_BAD_VALUE;
    }
    int64_t *tall = calloc((size_t)columns + 1, sizeof *tall);
    if (tall == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    // Going up from the last row, counts for each cell the rows in which the width has room.
    for (int64_t row = rows - 1; row >= 0; row--) {
        int64_t run = 0;
        for (int64_t column = columns - 1; column >= 0; column--) {
            int64_t at = row * columns + column;
            run = walls[at] != 0 ? 0 : run + 1;
            tall[column] = run >= width ? tall[column] + 1 : 0;
            windows[at] = tall[column] >= height;
        }
    }
    free(tall);
    return WG_OK;
}

// The four neighbours, in the order in which every search here visits them.
static void four_steps(int64_t stride, int64_t steps[4])
{
    steps[0] = 1;
    steps[1] = stride;
    steps[2] = -1;
    steps[3] = -stride;
}

static void fill(int32_t *array, int64_t size, int32_t value)
{
    for (int64_t i = 0; i < size; i++) {
        array[i] = value;
    }
}

WgStatus wg_shortest_path(const uint8_t *windows, int64_t size, int64_t stride, int64_t start, int64_t goal,
                          int32_t *came, int32_t *path, int64_t *length)
{
    if (!wg_rim_is_closed(windows, size, stride)) {
        return WG_BAD_SIZE;
    }
    *length = 0;
    if (start < 0 || start >= size || goal < 0 || goal >= size || windows[start] == 0) {
        return WG_BAD_VALUE;
    }
    int64_t steps[4];
    four_steps(stride, steps);

    // Searches breadth first; the path's array holds the queue.
    int32_t *queue = path;
    fill(came, size, -1);
    came[start] = (int32_t)start;
    queue[0] = (int32_t)start;
    int64_t tail = 1;
    for (int64_t head = 0; head < tail && came[goal] < 0; head++) {
        int64_t at = queue[head];
        for (int direction = 0; direction < 4; direction++) {
            int64_t there = at + steps[direction];
            if (windows[there] != 0 && came[there] < 0) {
                came[there] = (int32_t)at;
                queue[tail] = (int32_t)there;
                tail++;
            }
        }
    }
    if (came[goal] < 0) {
        return WG_OK;
    }

    // Follow the path back from its end, then reverse it.
    int64_t count = 0;
    for (int32_t at = (int32_t)goal; at != start; at = came[at]) {
        path[count] = at;
        count++;
    }
    path[count] = (int32_t)start;
    count++;
    for (int64_t low = 0, high = count - 1; low < high; low++, high--) {
        int32_t place = path[low];
        path[low] = path[high];
        path[high] = place;
    }
    *length = count;
    return WG_OK;
}

WgStatus wg_steps_from(const uint8_t *windows, int64_t size, int64_t stride, int64_t start, int32_t *steps,
                       int32_t *order, int64_t *reached)
{
    if (!wg_rim_is_closed(windows, size, stride)) {
        return WG_BAD_SIZE;
    }
    if (start < 0 || start >= size || windows[start] == 0) {
        return WG_BAD_VALUE;
    }
    int64_t shifts[4];
    four_steps(stride, shifts);
    fill(steps, size, -1);
    steps[start] = 0;
    order[0] = (int32_t)start;
    int64_t tail = 1;
    for (int64_t head = 0; head < tail; head++) {
        int64_t at = order[head];
        for (int direction = 0; direction < 4; direction++) {
            int64_t there = at + shifts[direction];
            if (windows[there] != 0 && steps[there] < 0) {
                steps[there] = steps[at] + 1;
                order[tail] = (int32_t)there;
                tail++;
            }
        }
    }
    *reached = tail;
    return WG_OK;
}

WgStatus wg_components(const uint8_t *windows, int64_t size, int64_t stride, int32_t *owner, int32_t *queue,
                       int64_t *found)
{
    if (!wg_rim_is_closed(windows, size, stride)) {
        return WG_BAD_SIZE;
    }
    int64_t shifts[4];
    four_steps(stride, shifts);
    fill(owner, size, -1);
    int32_t number = 0;
    for (int64_t begin = 0; begin < size; begin++) {
        if (windows[begin] == 0 || owner[begin] >= 0) {
            continue;
        }
        owner[begin] = number;
        queue[0] = (int32_t)begin;
        int64_t tail = 1;
        for (int64_t head = 0; head < tail; head++) {
            for (int direction = 0; direction < 4; direction++) {
                int64_t there = queue[head] + shifts[direction];
                if (windows[there] != 0 && owner[there] < 0) {
                    owner[there] = number;
                    queue[tail] = (int32_t)there;
                    tail++;
                }
            }
        }
        number++;
    }
    *found = number;
    return WG_OK;
}

WgStatus wg_dig(uint8_t *waits, int64_t size, int64_t stride, int32_t *owner, int32_t *came, int32_t *depth,
                int32_t *queue)
{
    if (!wg_rim_is_closed(waits, size, stride)) {
        return WG_BAD_SIZE;
    }
    int64_t shifts[4];
    four_steps(stride, shifts);

    // All owned places start, in their order. Crossing an owned place takes one round, however hard
    // the place is.
    int64_t tail = 0;
    for (int64_t at = 0; at < size; at++) {
        bool begins = owner[at] >= 0;
        came[at] = begins ? (int32_t)at : -1;
        depth[at] = 0;
        if (!begins) {
            continue;
        }
        bool on_rim = at < stride || at >= size - stride || at % stride == 0 || at % stride == stride - 1;
        if (on_rim) {
            return WG_BAD_VALUE;
        }
        waits[at] = 1;
        queue[tail] = (int32_t)at;
        tail++;
    }

    // The queue is a ring; a place is in it at most once.
    int64_t head = 0;
    int64_t waiting = tail;
    tail = tail == size ? 0 : tail;
    while (waiting > 0) {
        int64_t at = queue[head];
        head = head + 1 == size ? 0 : head + 1;
        waiting--;
        if (waits[at] > 1) {
            waits[at]--;
            queue[tail] = (int32_t)at;
            tail = tail + 1 == size ? 0 : tail + 1;
            waiting++;
            continue;
        }
        for (int direction = 0; direction < 4; direction++) {
            int64_t there = at + shifts[direction];
            if (waits[there] != 0 && owner[there] < 0) {
                owner[there] = owner[at];
                came[there] = (int32_t)at;
                depth[there] = depth[at] + waits[there];
                queue[tail] = (int32_t)there;
                tail = tail + 1 == size ? 0 : tail + 1;
                waiting++;
            }
        }
    }
    return WG_OK;
}

WgStatus wg_regions(const uint8_t *clear, int64_t size, int64_t stride, int64_t first, int64_t last, uint8_t stamp,
                    uint8_t *seen, int32_t *queue, WgRegions *found)
{
    if (!wg_rim_is_closed(clear, size, stride)) {
        return WG_BAD_SIZE;
    }
    if (first < 0 || last > size) {
        return WG_BAD_VALUE;
    }
    int64_t shifts[4];
    four_steps(stride, shifts);
    WgRegions all = {-1, 0, 0, 0};
    for (int64_t root = first; root < last; root++) {
        if (clear[root] == 0 || seen[root] == stamp) {
            continue;
        }
        seen[root] = stamp;
        queue[0] = (int32_t)root;
        int64_t tail = 1;
        for (int64_t head = 0; head < tail; head++) {
            for (int direction = 0; direction < 4; direction++) {
                int64_t there = queue[head] + shifts[direction];
                if (clear[there] != 0 && seen[there] != stamp) {
                    seen[there] = stamp;
                    queue[tail] = (int32_t)there;
                    tail++;
                }
            }
        }
        all.regions++;
        all.places += tail;
        if (tail > all.largest) {
            all.root = root;
            all.largest = tail;
        }
    }
    *found = all;
    return WG_OK;
}

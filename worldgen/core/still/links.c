// The cells and links that may form a cut, listed for one query.

#include <stdlib.h>
#include <string.h>

#include "links.h"

enum { MOST_SIDE = 20000, MOST_POSES = 65 };

// Returns true if the line of a link crosses the ray upwards from a pose an odd number of times.
static inline bool crosses_ray(const WgFinePose *pose, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    // The line never turns back, so it crosses the ray's column once if its ends are on different
    // sides, which is rare.
    if ((2 * ax + 1 <= pose->x) == (2 * bx + 1 <= pose->x)) {
        return false;
    }
    // The whole line may be above the pose, or below it.
    if (2 * wg_min(ay, by) + 1 > pose->y) {
        return true;
    }
    if (2 * wg_max(ay, by) + 1 <= pose->y) {
        return false;
    }
    WgPiece line[3];
    wg_link_line(ax, ay, bx, by, line);
    bool odd = wg_crosses_ray(pose, line[0]) != wg_crosses_ray(pose, line[1]);
    return odd != wg_crosses_ray(pose, line[2]);
}

uint64_t wg_link_bits(const WgFinePose *poses, int64_t count, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    uint64_t bits = 0;
    for (int64_t k = 0; k < count; k++) {
        if (crosses_ray(&poses[k], ax, ay, bx, by)) {
            bits ^= k == 0 ? UINT64_MAX >> (65 - count) : (uint64_t)1 << (k - 1);
        }
    }
    return bits;
}

// Marks solid cells that have a free cell among their eight neighbours, including the ring outside,
// with 1 in a padded raster.
static int64_t mark_rim(const WgWalls *walls, int64_t pad, int64_t stride, uint8_t *flat, uint8_t *free_near)
{
    int64_t width = walls->width;
    int64_t found = 0;
    for (int64_t iy = -1; iy <= walls->height; iy++) {
        // Marks the columns with a free cell, level with the row or next to it.
        memset(free_near, 0, (size_t)(width + 4));
        for (int64_t level = wg_max(iy - 1, 0); level <= wg_min(iy + 1, walls->height - 1); level++) {
            const uint8_t *row = walls->solid + level * width;
            for (int64_t ix = 0; ix < width; ix++) {
                free_near[ix + 2] |= row[ix] == 0;
            }
        }
        bool in_grid = iy >= 0 && iy < walls->height;
        uint8_t *rim = flat + (iy + 1 + pad) * stride + pad;
        for (int64_t i = 0; i < width + 2; i++) {
            rim[i] = free_near[i] | free_near[i + 1] | free_near[i + 2];
        }
        if (in_grid) {
            const uint8_t *row = walls->solid + iy * width;
            for (int64_t ix = 0; ix < width; ix++) {
                rim[ix + 1] &= row[ix] != 0;
            }
        }
        for (int64_t i = 0; i < width + 2; i++) {
            found += rim[i];
        }
    }
    return found;
}

// Numbers the cells by rows.
static WgStatus list_cells(WgLinks *links, const WgWalls *walls)
{
    int64_t reach = links->reach;
    links->stride = walls->width + 2 + 2 * reach;
    int64_t size = links->stride * (walls->height + 2 + 2 * reach);
    if (size >= INT32_MAX) {
        return WG_BAD_VALUE;
    }
    uint8_t *flat = calloc((size_t)(size + walls->width + 4), 1);
    links->rank = malloc((size_t)(size + 1) * sizeof *links->rank);
    if (flat == NULL || links->rank == NULL) {
        free(flat);
        return WG_OUT_OF_MEMORY;
    }
    links->cells = mark_rim(walls, reach, links->stride, flat, flat + size);
    size_t room = (size_t)(links->cells + 1);
    links->column = calloc(room, sizeof *links->column);
    links->row = calloc(room, sizeof *links->row);
    links->place = malloc(room * sizeof *links->place);
    links->slot = malloc(room * sizeof *links->slot);
    if (links->column == NULL || links->row == NULL || links->place == NULL || links->slot == NULL) {
        free(flat);
        return WG_OUT_OF_MEMORY;
    }
    // Every position is written to the next free slot, so no branch depends on the walls.
    int32_t count = 0;
    int64_t place = 0;
    for (int64_t iy = -1 - reach; place < size; iy++) {
        for (int64_t ix = -1 - reach; ix < walls->width + 1 + reach; ix++) {
            links->rank[place] = count;
            links->column[count] = (int32_t)ix;
            links->row[count] = (int32_t)iy;
            links->place[count] = (int32_t)place;
            count += flat[place];
            place++;
        }
    }
    links->rank[size] = count;
    free(flat);
    return WG_OK;
}

static bool lay_out_rows(WgLinks *links, int64_t limit)
{
    int64_t rows = 2 * links->reach + 1;
    links->shift = malloc((size_t)rows * sizeof *links->shift);
    links->wide = malloc((size_t)rows * sizeof *links->wide);
    if (links->shift == NULL || links->wide == NULL) {
        return false;
    }
    for (int64_t i = 0; i < rows; i++) {
        int64_t up = i - links->reach;
        int64_t apart = wg_max(wg_abs(up) - 1, 0);
        links->shift[i] = up * links->stride;
        links->wide[i] = 1 + wg_root_floor(limit - 1 - apart * apart);
    }
    return true;
}

static bool make_room(WgLinks *links, int64_t used)
{
    if (used < links->link_room) {
        return true;
    }
    int64_t room = 2 * links->link_room + 256;
    int32_t *ends = realloc(links->ends, (size_t)room * sizeof *ends);
    if (ends == NULL) {
        return false;
    }
    links->ends = ends;
    uint64_t *odd = realloc(links->odd, (size_t)room * sizeof *odd);
    if (odd == NULL) {
        return false;
    }
    links->odd = odd;
    links->link_room = room;
    return true;
}

// Returns true if a link of a cell may cross the ray from some pose: it has to be next to the ray
// and not all below.
static bool is_near_a_ray(const WgLinks *links, const int64_t *columns, const int64_t *rows, int64_t count, int64_t cell)
{
    for (int64_t k = 0; k < count; k++) {
        int64_t beside = wg_abs(links->column[cell] - columns[k]);
        if (beside <= links->reach + 1 && links->row[cell] >= rows[k] - links->reach - 1) {
            return true;
        }
    }
    return false;
}

// Appends the links of a cell; removes them again if none has bits.
static bool list_links_of(WgLinks *links, const WgFinePose *poses, int64_t count, int64_t cell, int64_t *used)
{
    int64_t begin = *used;
    int64_t now = begin;
    uint64_t any = 0;
    for (int64_t i = 0; i <= 2 * links->reach; i++) {
        int64_t at = links->place[cell] + links->shift[i];
        int32_t last = links->rank[at + links->wide[i] + 1];
        for (int32_t other = links->rank[at - links->wide[i]]; other < last; other++) {
            if (other == cell) {
                continue;
            }
            if (!make_room(links, now)) {
                return false;
            }
            links->ends[now] = other;
            links->odd[now] = wg_link_bits(poses, count, links->column[cell], links->row[cell],
                                           links->column[other], links->row[other]);
            any |= links->odd[now];
            now++;
        }
    }
    links->slot[cell] = -1;
    if (any != 0) {
        links->slot[cell] = (int32_t)links->slots;
        links->begins[links->slots++] = begin;
        *used = now;
    }
    return true;
}

WgStatus wg_links_make(WgLinks *links, const WgWalls *walls, int64_t limit, const WgFinePose *poses, int64_t count)
{
    *links = (WgLinks){.bits = count - 1};
    if (walls->height < 1 || walls->width < 1 || walls->height > MOST_SIDE || walls->width > MOST_SIDE) {
        return WG_BAD_SIZE;
    }
    if (limit < 1 || limit > (int64_t)4 * MOST_SIDE * MOST_SIDE || count < 2 || count > MOST_POSES) {
        return WG_BAD_VALUE;
    }
    links->reach = wg_root_floor(limit - 1) + 1;
    WgStatus status = list_cells(links, walls);
    if (status != WG_OK) {
        return status;
    }
    links->begins = malloc((size_t)(links->cells + 1) * sizeof *links->begins);
    if (links->begins == NULL || !lay_out_rows(links, limit)) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t columns[MOST_POSES];
    int64_t rows[MOST_POSES];
    for (int64_t k = 0; k < count; k++) {
        columns[k] = wg_floor_div(poses[k].x, 2);
        rows[k] = wg_floor_div(poses[k].y, 2);
    }
    int64_t used = 0;
    for (int64_t cell = 0; cell < links->cells; cell++) {
        links->slot[cell] = -1;
        if (is_near_a_ray(links, columns, rows, count, cell) && !list_links_of(links, poses, count, cell, &used)) {
            return WG_OUT_OF_MEMORY;
        }
    }
    links->begins[links->slots] = used;
    return WG_OK;
}

void wg_links_free(WgLinks *links)
{
    free(links->column);
    free(links->row);
    free(links->rank);
    free(links->place);
    free(links->shift);
    free(links->wide);
    free(links->slot);
    free(links->begins);
    free(links->ends);
    free(links->odd);
}

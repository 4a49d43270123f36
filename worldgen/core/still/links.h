// The solid cells that a cut may have, the links between them, and how links wind around poses.
//
// Two cells are linked if the gap between them is below the disc's diameter. The line of a link
// goes from one centre to that cell's closest point, to the other cell's closest point, and to its
// centre; all are multiples of half a cell.

#ifndef WG_LINKS_H
#define WG_LINKS_H

#include "reach_internal.h"

// The bits of a link: one for the start and one for each target; each is 1 if its line crosses the
// ray upwards from there.
typedef struct WgLinks {
    int64_t bits;  // targets; a link has a bit for each: the start's crossing xor the target's
    int64_t cells;
    int64_t reach;      // how far a linked cell is away, across or up
    int64_t stride;     // row stride of the raster
    int32_t *column;    // (cells,) ix
    int32_t *row;       // (cells,) iy
    int32_t *rank;      // number of cells before a position of the raster
    int32_t *place;     // (cells,) position of a cell in the raster
    int64_t *shift;     // (2 reach + 1,) offset to add to a position for the row of a link
    int64_t *wide;      // (2 reach + 1,) how far to either side the cells of that row are linked
    int32_t *slot;      // (cells,) number of a cell with a link that has bits, else -1
    int64_t slots;      // number of these cells
    int64_t *begins;    // (slots + 1,) where their links begin
    int32_t *ends;      // cells that they lead to
    uint64_t *odd;      // bits of these links
    int64_t link_room;  // capacity of the last two
} WgLinks;

// Lists cells and links; call wg_links_free whatever this returns.
//
// limit:      least squared gap, cells, at which two cells are not linked.
// poses:      (poses,) the start, then the targets: at most 65.
WgStatus wg_links_make(WgLinks *links, const WgWalls *walls, int64_t limit, const WgFinePose *poses, int64_t count);

void wg_links_free(WgLinks *links);

// Returns the sign of across * x + up * y + whole for a pose (x, y) in half cells.
static inline int wg_side_of(const WgFinePose *pose, int64_t across, int64_t up, int64_t whole)
{
    // Go limb by limb from the lowest up; carries are rounded down.
    int64_t carried = 0;
    bool is_whole = true;
    for (int64_t limb = pose->limbs - 1; limb >= 0; limb--) {
        int64_t sum = across * (int64_t)pose->rest_x[limb] + up * (int64_t)pose->rest_y[limb] + carried;
        is_whole = is_whole && (sum & UINT32_MAX) == 0;
        carried = wg_floor_div(sum, (int64_t)1 << 32);
    }
    int64_t total = across * pose->x + up * pose->y + whole + carried;
    if (total == 0) {
        return is_whole ? 0 : 1;
    }
    return total > 0 ? 1 : -1;
}

// Returns true if the piece from p to q (half cells) crosses the ray upwards from a pose.
static inline bool wg_crosses_ray(const WgFinePose *pose, WgPiece piece)
{
    if ((piece.px <= pose->x) == (piece.qx <= pose->x)) {
        return false;
    }
    int64_t ex = piece.qx - piece.px;
    int64_t ey = piece.qy - piece.py;
    int above = wg_side_of(pose, ey, -ex, piece.py * ex - ey * piece.px);
    return above != 0 && (above > 0) == (ex > 0);
}

static inline int64_t wg_sign(int64_t value)
{
    return (value > 0) - (value < 0);
}

// The three pieces of the line of a link, half cells.
static inline void wg_link_line(int64_t ax, int64_t ay, int64_t bx, int64_t by, WgPiece line[3])
{
    int64_t toward_x = wg_sign(bx - ax);
    int64_t toward_y = wg_sign(by - ay);
    WgPiece ends = {2 * ax + 1, 2 * ay + 1, 2 * bx + 1, 2 * by + 1};
    int64_t leave_x = ends.px + toward_x;
    int64_t leave_y = ends.py + toward_y;
    int64_t arrive_x = ends.qx - toward_x;
    int64_t arrive_y = ends.qy - toward_y;
    line[0] = (WgPiece){ends.px, ends.py, leave_x, leave_y};
    line[1] = (WgPiece){leave_x, leave_y, arrive_x, arrive_y};
    line[2] = (WgPiece){arrive_x, arrive_y, ends.qx, ends.qy};
}

// The bits of the link between two cells.
uint64_t wg_link_bits(const WgFinePose *poses, int64_t count, int64_t ax, int64_t ay, int64_t bx, int64_t by);

#endif

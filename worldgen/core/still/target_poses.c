// Lists finitely many clear poses of the target's disc that decide exactly for all of them.
//
// Every connected part of the clear poses in the disc has a pose nearest to the disc's centre. That
// pose is the centre itself, the foot of a perpendicular from it on the edge of one cell's
// neighbourhood, or an intersection of the edges of two neighbourhoods
// (docs/explanation/reachability.md). Such edges are straight lines and circles, so each coordinate
// is an integer plus another integer times a root, over a common factor above 0. Floats select the
// doubtful cases, which are then compared in integers.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "parted.h"
#include "wide.h"

enum {
    // limit near the disc; with more, the disc is too large to examine each pose
    MOST_CORNERS = 3000,
    MOST_WORK = 100000000,  // the same limit for pairs of a pose and a cell
    MOST_BITS = 60,  // limit on a length, which keeps everything below under 2^127
};

// cells; the error of floats is far smaller when they select what to examine
static const double SLACK = 1e-6;
static const double DOUBT = 1e-10;   // relative difference above which floats are trusted

// A pose: each coordinate is (whole + factor root) / (under_whole + under_factor root),
// from the base cell's corner.
typedef struct ExactPose {
    double x;  // cells, from the base cell's corner
    double y;
    int64_t times;  // its lengths are multiples of 1/(scale times) cell
    WgInt128 whole_x;
    WgInt128 whole_y;
    int64_t factor_x;
    int64_t factor_y;
    int64_t under_whole;
    int64_t under_factor;
    WgUint128 square;  // square of the root
    WgPoseOf of;
} ExactPose;

struct WgPoses {
    WgWalls walls;
    WgTarget target;
    int64_t base_x;  // the cell that the centre is in
    int64_t base_y;
    int64_t x;  // the centre from there, 1/scale cell
    int64_t y;
    ExactPose *list;
    int64_t count;
    int64_t room;
    int64_t inside;  // candidates in the disc or next to it
    bool is_doubtful;
};

// The parts of the edges of neighbourhoods, from the base cell's corner.
typedef struct Edges {
    int64_t *columns;  // lines x = ..., 1/scale cell, sorted
    int64_t *rows;     // lines y = ...
    int64_t column_count;
    int64_t row_count;
    int64_t *corners;  // (corner_count, 2) cells, sorted by x, then by y
    int64_t corner_count;
} Edges;

static bool is_on_rim(const WgWalls *walls, int64_t ix, int64_t iy)
{
    if (!wg_is_solid(walls, ix, iy)) {
        return false;
    }
    for (int64_t dy = -1; dy <= 1; dy++) {
        for (int64_t dx = -1; dx <= 1; dx++) {
            if (!wg_is_solid(walls, ix + dx, iy + dy)) {
                return true;
            }
        }
    }
    return false;
}

static int by_size(const void *a, const void *b)
{
    int64_t one = *(const int64_t *)a;
    int64_t two = *(const int64_t *)b;
    return one < two ? -1 : one > two;
}

static int by_place(const void *a, const void *b)
{
    const int64_t *one = a;
    const int64_t *two = b;
    return one[0] != two[0] ? by_size(one, two) : by_size(one + 1, two + 1);
}

// Lists the two lines next to each cell, for one coordinate; returns their number.
static int64_t list_lines(const WgPoses *poses, const int64_t *cells, int64_t count, int64_t *lines)
{
    int64_t scale = poses->target.scale;
    int64_t reach = poses->target.reach;
    for (int64_t i = 0; i < count; i++) {
        lines[2 * i] = cells[2 * i] * scale - reach;
        lines[2 * i + 1] = (cells[2 * i] + 1) * scale + reach;
    }
    qsort(lines, (size_t)(2 * count), sizeof *lines, by_size);
    int64_t kept = 0;
    for (int64_t i = 0; i < 2 * count; i++) {
        if (kept == 0 || lines[kept - 1] != lines[i]) {
            lines[kept++] = lines[i];
        }
    }
    return kept;
}

// Lists the corners of cells, each once; returns their number.
static int64_t list_corners(const int64_t *cells, int64_t count, int64_t *corners)
{
    for (int64_t i = 0; i < 4 * count; i++) {
        corners[2 * i] = cells[2 * (i / 4)] + i % 2;
        corners[2 * i + 1] = cells[2 * (i / 4) + 1] + i / 2 % 2;
    }
    qsort(corners, (size_t)(4 * count), 2 * sizeof *corners, by_place);
    int64_t kept = 0;
    for (int64_t i = 0; i < 4 * count; i++) {
        if (kept == 0 || by_place(corners + 2 * (kept - 1), corners + 2 * i) != 0) {
            memmove(corners + 2 * kept, corners + 2 * i, 2 * sizeof *corners);
            kept++;
        }
    }
    return kept;
}

// Lists the cells near the disc that have a free neighbour, relative to the base cell;
// at most MOST_CORNERS + 1.
static int64_t list_cells(const WgPoses *poses, int64_t *cells)
{
    const WgTarget *target = &poses->target;
    const WgWalls *walls = &poses->walls;
    double far = target->disc_radius + target->robot_radius + SLACK;
    int64_t around = (int64_t)ceil(far) + 1;
    int64_t count = 0;
    // Outside the grid, the ring of cells next to it is enough.
    int64_t high_x = wg_min(walls->width, poses->base_x + around);
    int64_t high_y = wg_min(walls->height, poses->base_y + around);
    for (int64_t iy = wg_max(-1, poses->base_y - around); iy <= high_y; iy++) {
        double dy = fmax(fmax((double)iy - target->centre_y, target->centre_y - (double)iy - 1.0), 0.0);
        for (int64_t ix = wg_max(-1, poses->base_x - around); ix <= high_x; ix++) {
            double dx = fmax(fmax((double)ix - target->centre_x, target->centre_x - (double)ix - 1.0), 0.0);
            if (sqrt(dx * dx + dy * dy) > far || !is_on_rim(walls, ix, iy)) {
                continue;
            }
            cells[2 * count] = ix - poses->base_x;
            cells[2 * count + 1] = iy - poses->base_y;
            count++;
            if (count > MOST_CORNERS) {
                return count;
            }
        }
    }
    return count;
}

// Finds the edges near the disc; cells all of whose neighbours are solid add none.
static WgStatus find_edges(const WgPoses *poses, Edges *edges)
{
    int64_t *cells = malloc((size_t)(2 * (MOST_CORNERS + 1)) * sizeof *cells);
    if (cells == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t count = list_cells(poses, cells);
    size_t room = (size_t)(2 * count + 1);
    edges->columns = malloc(room * sizeof *edges->columns);
    edges->rows = malloc(room * sizeof *edges->rows);
    edges->corners = malloc(4 * room * sizeof *edges->corners);
    bool has_room = edges->columns != NULL && edges->rows != NULL && edges->corners != NULL;
    // There are at least as many corners as cells, so too many cells end it here.
    edges->corner_count = count;
    if (has_room && count <= MOST_CORNERS) {
        edges->column_count = list_lines(poses, cells, count, edges->columns);
        edges->row_count = list_lines(poses, cells + 1, count, edges->rows);
        edges->corner_count = list_corners(cells, count, edges->corners);
    }
    free(cells);
    return has_room ? WG_OK : WG_OUT_OF_MEMORY;
}

static void free_edges(Edges *edges)
{
    free(edges->columns);
    free(edges->rows);
    free(edges->corners);
}

// Returns the sign of across x + up y + whole, all integers, for a pose.
static int side_of(const ExactPose *pose, int64_t across, int64_t up, int64_t whole)
{
    double terms[3] = {(double)across * pose->x, (double)up * pose->y, (double)whole};
    double sum = terms[0] + terms[1] + terms[2];
    double size = fabs(terms[0]) + fabs(terms[1]) + fabs(terms[2]);
    if (fabs(sum) > DOUBT * (size + (double)wg_abs(across) + (double)wg_abs(up))) {
        return sum > 0.0 ? 1 : -1;
    }
    WgInt128 u = (WgInt128)across * pose->whole_x + (WgInt128)up * pose->whole_y +
                 (WgInt128)whole * pose->under_whole;
    WgInt128 v = (WgInt128)across * pose->factor_x + (WgInt128)up * pose->factor_y +
                 (WgInt128)whole * pose->under_factor;
    return wg_sign_of_sum(u, v, pose->square);
}

static bool is_on_ray(const ExactPose *pose)
{
    return pose->under_factor != 0;
}

// Returns true if a pose is in the closed disc.
static bool is_in_disc(WgPoses *poses, const ExactPose *pose)
{
    const WgTarget *target = &poses->target;
    double dx = pose->x - (target->centre_x - (double)poses->base_x);
    double dy = pose->y - (target->centre_y - (double)poses->base_y);
    double apart = sqrt(dx * dx + dy * dy);
    double doubt = DOUBT * (apart + target->disc_radius + 1.0);
    if (fabs(apart - target->disc_radius) > doubt) {
        return apart < target->disc_radius;
    }
    // Otherwise only integers can decide.
    if (target->radius < 0) {
        poses->is_doubtful = true;
        return false;
    }
    if (is_on_ray(pose)) {
        // It is |sqrt(square) - reach| away from the centre.
        WgInt128 high = (WgInt128)target->reach + target->radius;
        WgInt128 low = (WgInt128)target->reach - target->radius;
        bool not_beyond = pose->square <= (WgUint128)(high * high);
        return not_beyond && (low <= 0 || pose->square >= (WgUint128)(low * low));
    }
    WgInt128 ux = pose->whole_x - (WgInt128)poses->x * pose->times;
    WgInt128 uy = pose->whole_y - (WgInt128)poses->y * pose->times;
    WgInt128 vx = pose->factor_x;
    WgInt128 vy = pose->factor_y;
    WgInt128 limit = (WgInt128)target->radius * pose->times;
    WgInt128 whole = ux * ux + uy * uy + (vx * vx + vy * vy) * (WgInt128)pose->square - limit * limit;
    return wg_sign_of_sum(whole, 2 * (ux * vx + uy * vy), pose->square) <= 0;
}

// The side on which a coordinate is beyond a cell's interval: -1 below, 1 above, 0 inside.
static int beyond(const ExactPose *pose, bool across, int64_t cell)
{
    if (side_of(pose, across ? 1 : 0, across ? 0 : 1, -cell) < 0) {
        return -1;
    }
    return side_of(pose, across ? 1 : 0, across ? 0 : 1, -cell - 1) > 0 ? 1 : 0;
}

// Returns true if a pose is nearer to a cell (from the base cell) than the robot's radius, in
// integers.
static bool is_nearer(const WgPoses *poses, const ExactPose *pose, int64_t ix, int64_t iy)
{
    int way_x = beyond(pose, true, ix);
    int way_y = beyond(pose, false, iy);
    if (way_x == 0 && way_y == 0) {
        return true;
    }
    int64_t edge_x = way_x > 0 ? ix + 1 : ix;  // the side of the cell that is nearest
    int64_t edge_y = way_y > 0 ? iy + 1 : iy;
    WgInt128 reach = poses->target.reach;
    if (is_on_ray(pose)) {
        // Everything is divided by scale sqrt(square), where possible.
        int64_t scale = poses->target.scale;
        WgInt128 kx = pose->of.x - edge_x;
        WgInt128 ky = pose->of.y - edge_y;
        if (way_x != 0 && way_y != 0) {
            WgInt128 cx = pose->whole_x / reach;  // the centre minus the corner
            WgInt128 cy = pose->whole_y / reach;
            return wg_sign_of_sum(2 * reach * (kx * cx + ky * cy), (kx * kx + ky * ky) * scale, pose->square) < 0;
        }
        WgInt128 whole = way_x != 0 ? way_x * pose->whole_x : way_y * pose->whole_y;
        WgInt128 factor = (way_x != 0 ? way_x * kx : way_y * ky) * scale - reach;
        return wg_sign_of_sum(whole, factor, pose->square) < 0;
    }
    WgInt128 under = pose->under_whole;
    WgInt128 ux = way_x == 0 ? 0 : pose->whole_x - edge_x * under;
    WgInt128 uy = way_y == 0 ? 0 : pose->whole_y - edge_y * under;
    WgInt128 vx = way_x == 0 ? 0 : pose->factor_x;
    WgInt128 vy = way_y == 0 ? 0 : pose->factor_y;
    WgInt128 limit = reach * pose->times;
    WgInt128 whole = ux * ux + uy * uy + (vx * vx + vy * vy) * (WgInt128)pose->square - limit * limit;
    return wg_sign_of_sum(whole, 2 * (ux * vx + uy * vy), pose->square) < 0;
}

// Returns true if a pose is at least the radius from every solid cell.
static bool is_clear(const WgPoses *poses, const ExactPose *pose)
{
    double radius = poses->target.robot_radius;
    double radius_sq = radius * radius;
    int64_t reach = (int64_t)ceil(radius) + 1;
    int64_t column = (int64_t)floor(pose->x);
    int64_t row = (int64_t)floor(pose->y);
    for (int64_t iy = row - reach; iy <= row + reach; iy++) {
        double dy = fmax(fmax((double)iy - pose->y, pose->y - (double)iy - 1.0), 0.0);
        for (int64_t ix = column - reach; ix <= column + reach; ix++) {
            double dx = fmax(fmax((double)ix - pose->x, pose->x - (double)ix - 1.0), 0.0);
            double apart_sq = dx * dx + dy * dy;
            if (apart_sq > radius_sq + DOUBT * (1.0 + radius_sq) ||
                !wg_is_solid(&poses->walls, poses->base_x + ix, poses->base_y + iy)) {
                continue;
            }
            if (apart_sq < radius_sq - DOUBT * (1.0 + radius_sq) || is_nearer(poses, pose, ix, iy)) {
                return false;
            }
        }
    }
    return true;
}

// Examines a candidate, and keeps it if it is a clear pose of the disc.
static WgStatus look_at(WgPoses *poses, const ExactPose *pose)
{
    double dx = pose->x - (poses->target.centre_x - (double)poses->base_x);
    double dy = pose->y - (poses->target.centre_y - (double)poses->base_y);
    if (sqrt(dx * dx + dy * dy) > poses->target.disc_radius + SLACK) {
        return WG_OK;
    }
    poses->inside++;
    if (poses->list == NULL || !is_in_disc(poses, pose) || !is_clear(poses, pose)) {
        return WG_OK;
    }
    if (poses->count == poses->room) {
        int64_t room = 2 * poses->room;
        ExactPose *list = realloc(poses->list, (size_t)room * sizeof *list);
        if (list == NULL) {
            return WG_OUT_OF_MEMORY;
        }
        poses->list = list;
        poses->room = room;
    }
    poses->list[poses->count++] = *pose;
    return WG_OK;
}

// A pose with whole coordinates.
static WgStatus look_at_plain(WgPoses *poses, int64_t x, int64_t y)
{
    int64_t scale = poses->target.scale;
    ExactPose pose = {
        .x = (double)x / (double)scale,
        .y = (double)y / (double)scale,
        .times = 1,
        .whole_x = x,
        .whole_y = y,
        .under_whole = scale,
        .of = {.kind = WG_PLAIN, .x = x, .y = y},
    };
    return look_at(poses, &pose);
}

// Adds the point of the circle around a corner that is nearest to the centre.
static WgStatus look_along_ray(WgPoses *poses, int64_t qx, int64_t qy)
{
    int64_t scale = poses->target.scale;
    int64_t cx = poses->x - qx * scale;
    int64_t cy = poses->y - qy * scale;
    if (cx == 0 && cy == 0) {
        return WG_OK;
    }
    int64_t reach = poses->target.reach;
    WgUint128 square = (WgUint128)((WgInt128)cx * cx + (WgInt128)cy * cy);
    double length = sqrt((double)square);
    // (q scale root + reach (centre - q)) / (scale root)
    ExactPose pose = {
        .x = (double)qx + poses->target.robot_radius * ((double)cx / length),
        .y = (double)qy + poses->target.robot_radius * ((double)cy / length),
        .times = 1,
        .whole_x = (WgInt128)reach * cx,
        .whole_y = (WgInt128)reach * cy,
        .factor_x = qx * scale,
        .factor_y = qy * scale,
        .under_factor = scale,
        .square = square,
        .of = {.kind = WG_ON_RAY, .x = qx, .y = qy},
    };
    return look_at(poses, &pose);
}

// Where a line meets the circle around a corner: at two points.
static WgStatus look_at_circle(WgPoses *poses, int64_t qx, int64_t qy, int64_t line, bool is_row)
{
    int64_t scale = poses->target.scale;
    int64_t reach = poses->target.reach;
    int64_t away = line - (is_row ? qy : qx) * scale;
    if (wg_abs(away) > reach) {
        return WG_OK;
    }
    WgUint128 square = (WgUint128)((WgInt128)(reach - away) * (reach + away));
    double root = sqrt((double)square) / (double)scale;
    for (int64_t side = 1; side >= -1; side -= 2) {
        double along = (double)(is_row ? qx : qy) + (double)side * root;
        double level = (double)line / (double)scale;
        ExactPose pose = {
            .x = is_row ? along : level,
            .y = is_row ? level : along,
            .times = 1,
            .whole_x = is_row ? qx * scale : line,
            .whole_y = is_row ? line : qy * scale,
            .factor_x = is_row ? side : 0,
            .factor_y = is_row ? 0 : side,
            .under_whole = scale,
            .square = square,
            .of = {.kind = is_row ? WG_ON_ROW : WG_ON_COLUMN, .x = qx, .y = qy, .level = line, .side = side},
        };
        WgStatus status = look_at(poses, &pose);
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

// Where the circles around two corners meet.
static WgStatus look_between(WgPoses *poses, int64_t px, int64_t py, int64_t dx, int64_t dy)
{
    int64_t scale = poses->target.scale;
    int64_t apart_sq = dx * dx + dy * dy;
    WgInt128 wide_sq = (WgInt128)(2 * poses->target.reach) * (2 * poses->target.reach);
    WgUint128 square = (WgUint128)(wide_sq - (WgInt128)scale * scale * apart_sq) * (WgUint128)apart_sq;
    int64_t under = 2 * scale * apart_sq;
    double root = sqrt((double)square) / (double)under;
    for (int64_t side = 1; side >= -1; side -= 2) {
        ExactPose pose = {
            .x = (double)px + 0.5 * (double)dx - (double)(side * dy) * root,
            .y = (double)py + 0.5 * (double)dy + (double)(side * dx) * root,
            .times = 2 * apart_sq,
            .whole_x = (WgInt128)(2 * px + dx) * scale * apart_sq,
            .whole_y = (WgInt128)(2 * py + dy) * scale * apart_sq,
            .factor_x = -side * dy,
            .factor_y = side * dx,
            .under_whole = under,
            .square = square,
            .of = {.kind = WG_BETWEEN, .x = px, .y = py, .dx = dx, .dy = dy, .side = side},
        };
        WgStatus status = look_at(poses, &pose);
        if (status != WG_OK) {
            return status;
        }
    }
    return WG_OK;
}

// Pairs of corners whose circles meet.
static WgStatus look_between_corners(WgPoses *poses, const Edges *edges)
{
    const WgTarget *target = &poses->target;
    WgInt128 wide_sq = (WgInt128)(2 * target->reach) * (2 * target->reach);
    int64_t widest_sq = (int64_t)(wide_sq / ((WgInt128)target->scale * target->scale));
    int64_t reach = wg_root_floor(widest_sq);
    WgStatus status = WG_OK;
    for (int64_t corner = 0; corner < edges->corner_count && status == WG_OK; corner++) {
        int64_t px = edges->corners[2 * corner];
        int64_t py = edges->corners[2 * corner + 1];
        // All others are listed after it, by x and then by y.
        for (int64_t other = corner + 1; other < edges->corner_count && status == WG_OK; other++) {
            int64_t dx = edges->corners[2 * other] - px;
            int64_t dy = edges->corners[2 * other + 1] - py;
            if (dx > reach) {
                break;
            }
            if (dx * dx + dy * dy <= widest_sq) {
                status = look_between(poses, px, py, dx, dy);
            }
        }
    }
    return status;
}

// Examines the centre, its feet on the edges, and the intersections of edges, including points
// beyond an edge's end.
static WgStatus look_at_all(WgPoses *poses, const Edges *edges)
{
    WgStatus status = look_at_plain(poses, poses->x, poses->y);
    for (int64_t j = 0; j < edges->row_count && status == WG_OK; j++) {
        status = look_at_plain(poses, poses->x, edges->rows[j]);
    }
    for (int64_t i = 0; i < edges->column_count && status == WG_OK; i++) {
        status = look_at_plain(poses, edges->columns[i], poses->y);
    }
    for (int64_t i = 0; i < edges->column_count && status == WG_OK; i++) {
        for (int64_t j = 0; j < edges->row_count && status == WG_OK; j++) {
            status = look_at_plain(poses, edges->columns[i], edges->rows[j]);
        }
    }
    for (int64_t corner = 0; corner < edges->corner_count && status == WG_OK; corner++) {
        int64_t qx = edges->corners[2 * corner];
        int64_t qy = edges->corners[2 * corner + 1];
        status = look_along_ray(poses, qx, qy);
        for (int64_t j = 0; j < edges->row_count && status == WG_OK; j++) {
            status = look_at_circle(poses, qx, qy, edges->rows[j], true);
        }
        for (int64_t i = 0; i < edges->column_count && status == WG_OK; i++) {
            status = look_at_circle(poses, qx, qy, edges->columns[i], false);
        }
    }
    return status == WG_OK ? look_between_corners(poses, edges) : status;
}

// Returns true if every length and product stays within its bounds.
static bool are_short(const WgTarget *target)
{
    double farthest = 2.0 * (target->disc_radius + 2.0 * target->robot_radius + 6.0);
    double wide_sq = fmax(1.0, 4.0 * target->robot_radius * target->robot_radius);
    return farthest * (double)target->scale * wide_sq < (double)((int64_t)1 << MOST_BITS);
}

static WgStatus list_poses(WgPoses *poses, const Edges *edges, WgListed *listed)
{
    // Count them first only if there may be too many.
    int64_t around = 2 * (int64_t)ceil(poses->target.robot_radius) + 5;
    int64_t lines = edges->row_count + edges->column_count;
    int64_t bound = 1 + lines + edges->row_count * edges->column_count +
                    edges->corner_count * (1 + 2 * lines + 2 * around * around);
    WgStatus status = WG_OK;
    if (bound > MOST_WORK / (around * around)) {
        status = look_at_all(poses, edges);
        if (status == WG_OK && poses->inside > MOST_WORK / (around * around)) {
            *listed = WG_TOO_MANY;
            return WG_OK;
        }
    }
    poses->room = 16;
    poses->list = malloc((size_t)poses->room * sizeof *poses->list);
    if (status != WG_OK || poses->list == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    status = look_at_all(poses, edges);
    if (poses->is_doubtful) {
        *listed = WG_TOO_LONG;
    }
    return status;
}

WgStatus wg_poses_new(const WgWalls *walls, const WgTarget *target, WgPoses **made, WgListed *listed)
{
    *made = NULL;
    *listed = WG_LISTED;
    if (walls->height < 1 || walls->width < 1 || walls->height > 20000 || walls->width > 20000) {
        return WG_BAD_SIZE;
    }
    int64_t longest = (int64_t)1 << 62;
    bool sane = target->scale >= 1 && target->reach >= 1 && target->scale < longest && target->reach < longest &&
                target->radius < longest && wg_abs(target->x) < longest && wg_abs(target->y) < longest && target->robot_radius > 0.0 &&
                target->robot_radius <= 20000.0 && target->disc_radius >= 0.0 && target->disc_radius <= 40000.0 &&
                target->centre_x >= -1.0 && target->centre_x <= 20001.0 && target->centre_y >= -1.0 &&
                target->centre_y <= 20001.0;
    if (!sane) {
        return WG_BAD_VALUE;
    }
    if (!are_short(target)) {
        *listed = WG_TOO_LONG;
        return WG_OK;
    }
    WgPoses *poses = calloc(1, sizeof *poses);
    if (poses == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    poses->walls = *walls;
    poses->target = *target;
    poses->base_x = wg_floor_div(target->x, target->scale);
    poses->base_y = wg_floor_div(target->y, target->scale);
    poses->x = target->x - poses->base_x * target->scale;
    poses->y = target->y - poses->base_y * target->scale;
    Edges edges = {0};
    WgStatus status = find_edges(poses, &edges);
    if (status == WG_OK && edges.corner_count > MOST_CORNERS) {
        *listed = WG_TOO_MANY;
    } else if (status == WG_OK) {
        status = list_poses(poses, &edges, listed);
    }
    free_edges(&edges);
    if (status != WG_OK || *listed != WG_LISTED) {
        wg_poses_free(poses);
        return status;
    }
    *made = poses;
    return WG_OK;
}

int64_t wg_poses_count(const WgPoses *poses)
{
    return poses->count;
}

void wg_poses_round(const WgPoses *poses, int64_t index, int64_t *x, int64_t *y)
{
    const ExactPose *pose = &poses->list[index];
    *x = poses->base_x * WG_UNIT + (int64_t)floor(pose->x * (double)WG_UNIT + 0.5);
    *y = poses->base_y * WG_UNIT + (int64_t)floor(pose->y * (double)WG_UNIT + 0.5);
}

void wg_poses_describe(const WgPoses *poses, int64_t index, WgPoseOf *described)
{
    *described = poses->list[index].of;
    // Lengths and corners are relative to the base cell.
    int64_t scale = poses->target.scale;
    int64_t unit = described->kind == WG_PLAIN ? scale : 1;
    described->x += poses->base_x * unit;
    described->y += poses->base_y * unit;
    described->level += (described->kind == WG_ON_ROW ? poses->base_y : poses->base_x) * scale;
}

// Returns true if a chain winds around a pose an odd number of times.
static bool winds_around(const WgPoses *poses, const ExactPose *pose, const int64_t *cells, int64_t count)
{
    bool odd = false;
    for (int64_t i = 0; i < count; i++) {
        int64_t next = i + 1 == count ? 0 : i + 1;
        WgPiece line[3];
        wg_link_line(cells[2 * i] - poses->base_x, cells[2 * i + 1] - poses->base_y, cells[2 * next] - poses->base_x,
                     cells[2 * next + 1] - poses->base_y, line);
        for (int part = 0; part < 3; part++) {
            // The pieces are in half cells, the pose in cells.
            WgPiece piece = line[part];
            bool before = side_of(pose, 2, 0, -piece.px) >= 0;
            if (before == (side_of(pose, 2, 0, -piece.qx) >= 0)) {
                continue;
            }
            int64_t ex = piece.qx - piece.px;
            int64_t ey = piece.qy - piece.py;
            int above = side_of(pose, 2 * ey, -2 * ex, piece.py * ex - ey * piece.px);
            odd = odd != (above != 0 && (above > 0) == (ex > 0));
        }
    }
    return odd;
}

int64_t wg_poses_next(const WgPoses *poses, const int64_t *cells, int64_t count, int64_t winds, int64_t begin)
{
    int64_t index = begin;
    while (index < poses->count && winds_around(poses, &poses->list[index], cells, count) != (winds != 0)) {
        index++;
    }
    return index;
}

void wg_poses_free(WgPoses *poses)
{
    if (poses != NULL) {
        free(poses->list);
        free(poses);
    }
}

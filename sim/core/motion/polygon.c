// Exact tests of a convex polygonal body against square cells; see polygon.h.
//
// Two convex shapes keep apart if and only if a line along an edge of one of them separates them:
// separating axes, Gottschalk, Lin and Manocha, "OBBTree" (1996). The edges of a body that moves
// along a segment are its own, and the segment.

#include "polygon.h"

#include <math.h>
#include <string.h>

// A number of lattice units times 2^30, which is whole for all that is tested here.
static const double SCALE = 0x1p30;

// Angle between two headings of the table, rad, a little more.
static const double HEADING_STEP = 6.283185307179587 / WG_TURN * (1.0 + 1e-9);

// Lattice units. A corner of a body of 256 cells is at most 2^-12 away from where the exact cosine
// and sine would put it. Distances below this are not used.
static const double SLACK = 1.0 / 1024.0;

// A body on a straight move, relative to the axle's place at the beginning.
typedef struct Hull {
    const WgPolygon *polygon;
    double dx;
    double dy;
    bool moves;
} Hull;

// The cells that an open box of lattice coordinates meets, without the ring around the grid's ring.
typedef struct Cells {
    int64_t left;
    int64_t right;
    int64_t low;
    int64_t high;
    bool is_outside;  // part of the box is outside the grid
} Cells;

// A cell's corner nearest to the far side of a direction: the lowest one in it.
typedef struct Point {
    double x;
    double y;
} Point;

void wg_polygon_turned(const int64_t *headings, const WgFootprint *footprint, int64_t heading, WgPolygon *polygon)
{
    int64_t along = headings[heading];
    int64_t across = headings[(heading - WG_TURN / 4) & (WG_TURN - 1)];
    polygon->count = footprint->count;
    for (int64_t k = 0; k < footprint->count; k++) {
        // The products are below 2^49, and their sums are exact.
        polygon->x[k] = (double)(footprint->x[k] * along - footprint->y[k] * across) / SCALE;
        polygon->y[k] = (double)(footprint->x[k] * across + footprint->y[k] * along) / SCALE;
    }
    polygon->left = polygon->low = INFINITY;
    polygon->right = polygon->high = -INFINITY;
    for (int64_t k = 0; k < polygon->count; k++) {
        int64_t next = k + 1 < polygon->count ? k + 1 : 0;
        polygon->out_x[k] = polygon->y[next] - polygon->y[k];
        polygon->out_y[k] = polygon->x[k] - polygon->x[next];
        polygon->left = wg_lower(polygon->left, polygon->x[k]);
        polygon->right = wg_higher(polygon->right, polygon->x[k]);
        polygon->low = wg_lower(polygon->low, polygon->y[k]);
        polygon->high = wg_higher(polygon->high, polygon->y[k]);
    }
}

static int64_t scaled(double value)
{
    return (int64_t)(value * SCALE);
}

// Returns true if a dot product is not negative, exactly. All four numbers are multiples of 2^-30
// below 2^23.
static inline bool is_beyond(double nx, double ny, double x, double y)
{
    double a = nx * x;
    double b = ny * y;
    double sum = a + b;
    double error = (fabs(a) + fabs(b)) * 0x1p-51;
    if (sum > error) {
        return true;
    }
    if (sum < -error) {
        return false;
    }
    return (__int128)scaled(nx) * scaled(x) + (__int128)scaled(ny) * scaled(y) >= 0;
}

// The corner of a cell that is lowest in a direction.
static inline Point lowest(double left, double low, double nx, double ny)
{
    return (Point){nx > 0.0 ? left : left + WG_UNIT, ny > 0.0 ? low : low + WG_UNIT};
}

// Returns true if a line along one of its slanted edges, or along its move, keeps a hull apart from
// a cell whose box meets the hull's.
static bool is_apart(const Hull *hull, double left, double low)
{
    const WgPolygon *polygon = hull->polygon;
    for (int64_t k = 0; k < polygon->count; k++) {
        double nx = polygon->out_x[k];
        double ny = polygon->out_y[k];
        Point nearest = lowest(left, low, nx, ny);
        double x = nearest.x - polygon->x[k];
        double y = nearest.y - polygon->y[k];
        if (is_beyond(nx, ny, x, y) && (!hull->moves || is_beyond(nx, ny, x - hull->dx, y - hull->dy))) {
            return true;
        }
    }
    if (!hull->moves) {
        return false;
    }

    // To the left of the move, and to the right of it.
    for (int side = 0; side < 2; side++) {
        double nx = side == 0 ? -hull->dy : hull->dy;
        double ny = side == 0 ? hull->dx : -hull->dx;
        Point nearest = lowest(left, low, nx, ny);
        bool apart = true;
        for (int64_t k = 0; k < polygon->count && apart; k++) {
            apart = is_beyond(nx, ny, nearest.x - polygon->x[k], nearest.y - polygon->y[k]);
        }
        if (apart) {
            return true;
        }
    }
    return false;
}

// The cells of a box around a place, given by its bounds relative to it.
static Cells cells_of(WgGrid grid, int64_t x, int64_t y, double left, double right, double low, double high)
{
    int64_t first_x = x + wg_floor(left);
    int64_t last_x = x + wg_ceil(right);
    int64_t first_y = y + wg_floor(low);
    int64_t last_y = y + wg_ceil(high);
    return (Cells){
        .left = wg_most(wg_cell_of(first_x), -1),
        .right = wg_least(wg_cell_of(last_x - 1), grid.width),
        .low = wg_most(wg_cell_of(first_y), -1),
        .high = wg_least(wg_cell_of(last_y - 1), grid.height),
        .is_outside = first_x < 0 || first_y < 0 || last_x > grid.width * WG_UNIT || last_y > grid.height * WG_UNIT,
    };
}

static Hull hull_of(const WgPolygon *polygon, int64_t dx, int64_t dy)
{
    return (Hull){polygon, (double)dx, (double)dy, dx != 0 || dy != 0};
}

static Cells cells_of_hull(WgGrid grid, int64_t x, int64_t y, const Hull *hull)
{
    const WgPolygon *polygon = hull->polygon;
    return cells_of(grid, x, y, polygon->left + wg_lower(0.0, hull->dx), polygon->right + wg_higher(0.0, hull->dx),
                    polygon->low + wg_lower(0.0, hull->dy), polygon->high + wg_higher(0.0, hull->dy));
}

// Returns the next cell of a row that is not free, from `ix` to `last`; last + 1 if there is none. It looks at
// eight cells at a time.
static inline int64_t next_taken(WgGrid grid, int64_t ix, int64_t last, int64_t iy)
{
    if ((uint64_t)iy >= (uint64_t)grid.height) {
        return ix;
    }
    const uint8_t *row = grid.cells + iy * grid.width;
    while (ix <= last) {
        if (ix >= 0 && ix + 8 <= grid.width) {
            uint64_t eight;
            memcpy(&eight, row + ix, sizeof eight);
            if (eight == 0) {
                ix += 8;
                continue;
            }
        }
        if (wg_cell_state(grid, ix, iy) != WG_FREE) {
            return ix;
        }
        ix++;
    }
    return last + 1;
}

static double relative(int64_t index, int64_t place)
{
    return (double)(index * WG_UNIT - place);
}

WgFound wg_polygon_first_not_clear(WgGrid grid, int state, const WgPolygon *polygon, WgSegment way)
{
    Hull hull = hull_of(polygon, way.qx - way.px, way.qy - way.py);
    Cells cells = cells_of_hull(grid, way.px, way.py, &hull);
    for (int64_t iy = cells.low; iy <= cells.high; iy++) {
        for (int64_t ix = next_taken(grid, cells.left, cells.right, iy); ix <= cells.right;
             ix = next_taken(grid, ix + 1, cells.right, iy)) {
            if (wg_cell_state(grid, ix, iy) == state
                && !is_apart(&hull, relative(ix, way.px), relative(iy, way.py))) {
                return (WgFound){true, ix, iy};
            }
        }
    }
    // A body that is far outside the grid meets no cell of the ring around it.
    if (cells.is_outside && state == WG_SOLID) {
        int64_t ix = wg_least(wg_most(wg_cell_of(way.qx), -1), grid.width);
        int64_t iy = wg_least(wg_most(wg_cell_of(way.qy), -1), grid.height);
        return (WgFound){true, ix, iy};
    }
    return (WgFound){false, 0, 0};
}

WgFound wg_body_first_not_clear(WgGrid grid, int state, const int64_t *headings, const WgFootprint *footprint,
                                WgSegment way, int64_t heading)
{
    WgPolygon polygon;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    return wg_polygon_first_not_clear(grid, state, &polygon, way);
}

bool wg_body_is_clear(WgGrid grid, int state, const int64_t *headings, const WgFootprint *footprint, int64_t x,
                      int64_t y, int64_t heading)
{
    return !wg_body_first_not_clear(grid, state, headings, footprint, (WgSegment){x, y, x, y}, heading).found;
}

bool wg_robot_is_clear(WgGrid grid, int state, const int64_t *headings, const WgSettings *settings, int64_t x,
                       int64_t y, int64_t heading)
{
    if (settings->footprint.count > 0) {
        return wg_body_is_clear(grid, state, headings, &settings->footprint, x, y, heading);
    }
    return wg_disc_is_clear(grid, state, wg_disc(settings), x, y);
}

WgFound wg_robot_first_not_clear(WgGrid grid, int state, const int64_t *headings, const WgSettings *settings,
                                 WgSegment way, int64_t heading)
{
    if (settings->footprint.count > 0) {
        return wg_body_first_not_clear(grid, state, headings, &settings->footprint, way, heading);
    }
    return wg_first_not_clear(grid, state, wg_disc(settings), way);
}

// The widest gap between a body and a cell along an axis, and that axis, away from the cell. It is at most
// the distance between them; negative if they overlap, and then no smaller shift parts them.
static double widest_gap(const WgPolygon *polygon, double left, double low, WgNormal *away)
{
    double gap = left - polygon->right;
    *away = (WgNormal){-1.0, 0.0};
    double others[3] = {polygon->left - left - WG_UNIT, low - polygon->high, polygon->low - low - WG_UNIT};
    static const WgNormal FACES[3] = {{1.0, 0.0}, {0.0, -1.0}, {0.0, 1.0}};
    for (int k = 0; k < 3; k++) {
        if (others[k] > gap) {
            gap = others[k];
            *away = FACES[k];
        }
    }
    for (int64_t k = 0; k < polygon->count; k++) {
        double nx = polygon->out_x[k];
        double ny = polygon->out_y[k];
        Point nearest = lowest(left, low, nx, ny);
        double beyond = nx * (nearest.x - polygon->x[k]) + ny * (nearest.y - polygon->y[k]);
        beyond /= sqrt(nx * nx + ny * ny);
        if (beyond > gap) {
            gap = beyond;
            *away = (WgNormal){-nx, -ny};
        }
    }
    return gap;
}

double wg_body_gap(const int64_t *headings, const WgFootprint *footprint, int64_t x, int64_t y, int64_t heading,
                   int64_t ix, int64_t iy)
{
    WgPolygon polygon;
    WgNormal away;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    return widest_gap(&polygon, relative(ix, x), relative(iy, y), &away);
}

// Returns true if some axis shows that a cell is farther away from a body than a distance. Most cells are, and no
// root and no division is needed for them, which saves a fifth of the time of a turn.
static inline bool is_farther(const WgPolygon *polygon, double left, double low, double distance)
{
    if (left - polygon->right > distance || polygon->left - left - WG_UNIT > distance
        || low - polygon->high > distance || polygon->low - low - WG_UNIT > distance) {
        return true;
    }
    double distance_sq = distance * distance * (1.0 + 1e-9);
    for (int64_t k = 0; k < polygon->count; k++) {
        double nx = polygon->out_x[k];
        double ny = polygon->out_y[k];
        Point nearest = lowest(left, low, nx, ny);
        double beyond = nx * (nearest.x - polygon->x[k]) + ny * (nearest.y - polygon->y[k]);
        if (beyond > 0.0 && beyond * beyond > distance_sq * (nx * nx + ny * ny)) {
            return true;
        }
    }
    return false;
}

double wg_body_depth(const int64_t *headings, const WgFootprint *footprint, WgSegment way, int64_t heading, int64_t ix,
                     int64_t iy)
{
    WgPolygon polygon;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    Hull hull = hull_of(&polygon, way.qx - way.px, way.qy - way.py);
    double left = relative(ix, way.px);
    double low = relative(iy, way.py);

    // The least overlap along any axis that could separate them.
    double depth = wg_lower(polygon.right + wg_higher(0.0, hull.dx) - left,
                            left + WG_UNIT - polygon.left - wg_lower(0.0, hull.dx));
    depth = wg_lower(depth, polygon.high + wg_higher(0.0, hull.dy) - low);
    depth = wg_lower(depth, low + WG_UNIT - polygon.low - wg_lower(0.0, hull.dy));
    for (int64_t k = 0; k < polygon.count; k++) {
        double nx = polygon.out_x[k];
        double ny = polygon.out_y[k];
        Point nearest = lowest(left, low, nx, ny);
        double beyond = nx * (nearest.x - polygon.x[k]) + ny * (nearest.y - polygon.y[k]);
        beyond -= wg_higher(0.0, nx * hull.dx + ny * hull.dy);
        depth = wg_lower(depth, -beyond / sqrt(nx * nx + ny * ny));
    }
    for (int side = 0; side < 2 && hull.moves; side++) {
        double nx = side == 0 ? -hull.dy : hull.dy;
        double ny = side == 0 ? hull.dx : -hull.dx;
        Point nearest = lowest(left, low, nx, ny);
        double beyond = INFINITY;
        for (int64_t k = 0; k < polygon.count; k++) {
            beyond = wg_lower(beyond, nx * (nearest.x - polygon.x[k]) + ny * (nearest.y - polygon.y[k]));
        }
        depth = wg_lower(depth, -beyond / sqrt(nx * nx + ny * ny));
    }
    return wg_higher(0.0, depth);
}

WgFound wg_body_stopping_cell(WgGrid grid, const int64_t *headings, const WgFootprint *footprint, int64_t x, int64_t y,
                              WgSegment way, int64_t heading)
{
    WgPolygon polygon;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    Hull hull = hull_of(&polygon, way.qx - way.px, way.qy - way.py);
    Cells cells = cells_of_hull(grid, way.px, way.py, &hull);
    WgFound found = {false, 0, 0};
    double nearest = INFINITY;
    for (int64_t iy = cells.low; iy <= cells.high; iy++) {
        for (int64_t ix = next_taken(grid, cells.left, cells.right, iy); ix <= cells.right;
             ix = next_taken(grid, ix + 1, cells.right, iy)) {
            // A wall that the body moves along touches it, but does not cut it.
            bool cuts = wg_cell_state(grid, ix, iy) == WG_SOLID
                        && wg_body_depth(headings, footprint, way, heading, ix, iy) > 1e-6;
            WgNormal away;
            double gap = cuts ? widest_gap(&polygon, relative(ix, x), relative(iy, y), &away) : INFINITY;
            if (gap < nearest) {
                nearest = gap;
                found = (WgFound){true, ix, iy};
            }
        }
    }
    return found;
}

// A linear function of the time of a move: the gap between a body and a cell along an axis.
typedef struct Gap {
    double now;
    double closing;  // how fast it closes
    WgNormal away;
} Gap;

// When a move first and last makes all gaps negative.
typedef struct Overlap {
    double enter;
    double leave;
    Gap last;  // the one that closes last
} Overlap;

static inline void close_gap(Overlap *overlap, double now, double closing, double nx, double ny)
{
    if (now >= -1e-9 * (fabs(nx) + fabs(ny))) {
        // It is open, and must close.
        double time = closing > 0.0 ? wg_higher(now, 0.0) / closing : 2.0;
        if (time >= overlap->enter) {
            overlap->enter = time;
            overlap->last = (Gap){now, closing, {nx, ny}};
        }
    } else if (closing < 0.0) {
        overlap->leave = wg_lower(overlap->leave, now / closing);
    }
}

static Overlap overlap_of(const Hull *hull, double left, double low)
{
    const WgPolygon *polygon = hull->polygon;
    Overlap overlap = {-1.0, 2.0, {0.0, 0.0, {-hull->dx, -hull->dy}}};
    close_gap(&overlap, left - polygon->right, hull->dx, -1.0, 0.0);
    close_gap(&overlap, polygon->left - left - WG_UNIT, -hull->dx, 1.0, 0.0);
    close_gap(&overlap, low - polygon->high, hull->dy, 0.0, -1.0);
    close_gap(&overlap, polygon->low - low - WG_UNIT, -hull->dy, 0.0, 1.0);
    for (int64_t k = 0; k < polygon->count; k++) {
        double nx = polygon->out_x[k];
        double ny = polygon->out_y[k];
        Point nearest = lowest(left, low, nx, ny);
        double now = nx * (nearest.x - polygon->x[k]) + ny * (nearest.y - polygon->y[k]);
        close_gap(&overlap, now, nx * hull->dx + ny * hull->dy, -nx, -ny);
    }
    return overlap;
}

WgContact wg_polygon_contact(WgGrid grid, const WgPolygon *polygon, WgPlace from, WgVector by, double graze)
{
    WgContact best = {2.0, {0.0, 0.0}};
    Hull hull = hull_of(polygon, by.x, by.y);
    Cells cells = cells_of_hull(grid, from.x, from.y, &hull);
    for (int64_t iy = cells.low; iy <= cells.high; iy++) {
        for (int64_t ix = next_taken(grid, cells.left, cells.right, iy); ix <= cells.right;
             ix = next_taken(grid, ix + 1, cells.right, iy)) {
            if (wg_cell_state(grid, ix, iy) != WG_SOLID) {
                continue;
            }
            Overlap overlap = overlap_of(&hull, relative(ix, from.x), relative(iy, from.y));
            double leave = wg_lower(overlap.leave, 1.0);
            if (overlap.enter >= best.time || overlap.enter > 1.0 || overlap.enter > leave) {
                continue;
            }
            WgNormal away = overlap.last.away;
            double deep = (leave - overlap.enter) * overlap.last.closing;
            if (graze > 0.0 && deep < graze * sqrt(away.x * away.x + away.y * away.y)) {
                continue;
            }
            best = (WgContact){wg_higher(overlap.enter, 0.0), away};
        }
    }
    return best;
}

// A body on a turn.
typedef struct Turn {
    const int64_t *headings;
    const WgFootprint *footprint;
    const WgPolygon *first;  // at its first heading
    int64_t heading;
    int64_t side;   // 1 to the left, -1 to the right
    double reach;  // distance of the farthest corner from the axle
} Turn;

static double farthest_of(const WgFootprint *footprint)
{
    int64_t farthest_sq = 0;
    for (int64_t k = 0; k < footprint->count; k++) {
        int64_t sq = footprint->x[k] * footprint->x[k] + footprint->y[k] * footprint->y[k];
        farthest_sq = wg_most(farthest_sq, sq);
    }
    return sqrt((double)farthest_sq) + SLACK;
}

// Returns how far a body turns, at most, before a cell stops it.
//
// Between two headings no point of the body, or of the cell as the body sees it, moves more than the angle times
// its distance from the axle. So a gap proves that the next headings are clear, and only the one after them is
// tested: conservative advancement, Mirtich, "Impulse-based dynamic simulation" (1996), section 2.3.
static int64_t clear_of_cell(const Turn *turn, double left, double low, int64_t most)
{
    double across = wg_higher(fabs(left), fabs(left + WG_UNIT));
    double along = wg_higher(fabs(low), fabs(low + WG_UNIT));
    double farthest = wg_lower(turn->reach, sqrt(across * across + along * along) + SLACK);
    if (is_farther(turn->first, left, low, farthest * HEADING_STEP * (double)most + SLACK)) {
        return most;
    }
    WgNormal away;
    int64_t done = 0;
    double gap = widest_gap(turn->first, left, low, &away);
    for (;;) {
        WgPolygon polygon;
        double free = (gap - SLACK) / (farthest * HEADING_STEP);
        done += free > 0.0 ? (int64_t)wg_lower(free, (double)WG_TURN) : 0;
        if (done >= most) {
            return most;
        }
        int64_t heading = (turn->heading + turn->side * (done + 1)) & (WG_TURN - 1);
        wg_polygon_turned(turn->headings, turn->footprint, heading, &polygon);
        gap = widest_gap(&polygon, left, low, &away);
        if (gap < SLACK) {
            bool boxes_meet = left < polygon.right && polygon.left < left + WG_UNIT && low < polygon.high
                              && polygon.low < low + WG_UNIT;
            Hull hull = hull_of(&polygon, 0, 0);
            if (boxes_meet && !is_apart(&hull, left, low)) {
                return done;
            }
        }
        done++;
    }
}

int64_t wg_clear_turn(WgGrid grid, int state, const int64_t *headings, const WgFootprint *footprint, int64_t x,
                      int64_t y, int64_t heading, int64_t turn, WgStopped *stopped)
{
    WgPolygon polygon;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    Turn by = {headings, footprint, &polygon, heading, turn < 0 ? -1 : 1, farthest_of(footprint)};
    int64_t most = wg_abs(turn);

    // The box of all that the body may meet: no point moves farther than this, nor farther away than the reach.
    double sweep = by.reach * (double)most * HEADING_STEP + SLACK;
    Cells cells = cells_of(grid, x, y, wg_higher(polygon.left - sweep, -by.reach),
                           wg_lower(polygon.right + sweep, by.reach), wg_higher(polygon.low - sweep, -by.reach),
                           wg_lower(polygon.high + sweep, by.reach));
    for (int64_t iy = cells.low; iy <= cells.high && most > 0; iy++) {
        for (int64_t ix = next_taken(grid, cells.left, cells.right, iy); ix <= cells.right;
             ix = next_taken(grid, ix + 1, cells.right, iy)) {
            if (wg_cell_state(grid, ix, iy) != state) {
                continue;
            }
            int64_t clear = clear_of_cell(&by, relative(ix, x), relative(iy, y), most);
            if (clear < most) {
                most = clear;
                stopped->cell = (WgFound){true, ix, iy};
            }
        }
    }
    if (most < wg_abs(turn)) {
        wg_polygon_turned(headings, footprint, (heading + by.side * most) & (WG_TURN - 1), &polygon);
        (void)widest_gap(&polygon, relative(stopped->cell.ix, x), relative(stopped->cell.iy, y), &stopped->away);
    }
    return by.side * most;
}
